"""Which effect would make each statement of the thesis true: its published model is the simulation, a changed machine the experiment.

A statement compares simulation and experiment, and the experiment is lost. So each effect of the study (`thesis.finding`) takes its
place: it is compared with the single cubic as published, by the readings of the statements in `statements.toml`. Nothing is adjusted to
the words; every set is given with its number of choices.
"""

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from quickreturn.cases.comparison.engines import REFERENCE
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.plugins.thesis.conclusions import ACCURATE
from quickreturn.plugins.thesis.experiment import Statement, axis_labels, statements
from quickreturn.plugins.thesis.finding.effects import PUBLISHED, Effect, effects, name_of
from quickreturn.plugins.thesis.finding.study import EXAMPLE, Row

#: The row of the thesis' own model, which is the simulation.
SIMULATION: Final = ("cubic", "1 element")
#: Least amplitude of a visible vibration in a printed figure, as a part of the axis' range.
VISIBLE: Final = 0.01
#: Error of a frequency that is read at the return, Hz: half of 1 / 63 ms, the resolution in a sixth of a turn of run 24.
RESOLUTION: Final = 8.0
#: Statements that do not depend on the joint: one follows from the geometry, the other from the cubic elements alone.
OF_NO_JOINT: Final = ("frequency-depends-on-crank", "more-elements")
#: Share of the half cycles in which a frequency must be accurate for the word "typically".
TYPICALLY: Final = 0.75

Share = Callable[[Statement, Row, Row], float | None]


@dataclass(frozen=True)
class Trial:
    """A row of the study in the experiment's place."""

    row: Row
    choices: tuple[str, ...]  # unpublished choices that its effect contains
    shares: Mapping[str, float | None]  # statement's id -> share of the runs, or of other counted items, that shows it; None: unknown
    shown: Mapping[str, bool]  # statement's id -> whether that share is as large as the words require

    @property
    def words(self) -> str:
        """The effect and its strength."""
        return f"{name_of(self.row.effect)}: {self.row.strength}" if self.row.effect != PUBLISHED.id else self.row.strength


@dataclass(frozen=True)
class Split:
    """An effect that makes the halves differ as the words require."""

    effect: Effect
    strength: str  # the weakest strength that does
    pre: float  # relative change of the first-mode frequency before the return, median over the runs
    post: float  # the same after the return
    posts: tuple[float, ...] = ()  # the same for every strength tried

    @property
    def one_sided(self) -> bool:
        """Whether it makes the roller that carries after the return softer than the other."""
        return "slider.joint_stiffness_plus" in (self.effect.set, *self.effect.also)


@dataclass(frozen=True)
class Sufficiency:
    """The verdict on a statement."""

    statement: Statement
    sets: Sequence[Trial]  # those that show it
    choices: int | None  # least number of choices in one of these; None without any
    best: Trial | None  # the set with the greatest share, whether it shows the statement or not


def splits(rows: Sequence[Row]) -> list[Split]:
    """Effects that make the halves differ as the words require, those with the fewest choices first."""
    excess = next(statement.low for statement in statements() if statement.id == "post-excess")
    splits_ = list[Split]()
    for effect in effects():
        of_effect = [row for row in rows if row.effect == effect.id and row.engine == effect.engine]
        if row := next((row for row in of_effect if row.tells_halves_apart and (row.apart or 0.0) <= 1.0 / excess - 1.0), None):
            pre, post = (statistics.median(row.changes(f"{half}_frequency").values()) for half in HALVES)
            posts = tuple(statistics.median(changes) for each in of_effect if (changes := each.changes("post_frequency").values()))
            splits_.append(Split(effect, row.strength, pre, post, posts))
    return sorted(splits_, key=lambda split: len(split.effect.choices))


def trials(rows: Sequence[Row]) -> list[Trial]:
    """Every row that the reference computed, in the experiment's place; empty if the study lacks the simulation."""
    simulation = next((row for row in rows if (row.effect, row.strength) == SIMULATION), None)
    choices = {effect.id: effect.choices for effect in effects()}
    own = [row for row in rows if row.engine == REFERENCE]
    return [_trial(row, simulation, choices.get(row.effect, ())) for row in own] if simulation else []


def sufficiency(sets: Sequence[Trial]) -> list[Sufficiency]:
    """One per statement, in the order of the thesis."""
    verdicts = []
    for statement in statements():
        shown = [trial for trial in sets if trial.shown.get(statement.id)]
        judged = [trial for trial in sets if trial.shares.get(statement.id) is not None]
        best = max(judged, key=lambda trial: trial.shares[statement.id] or 0.0, default=None)
        verdicts.append(Sufficiency(statement, shown, min((len(trial.choices) for trial in shown), default=None), best))
    return verdicts


def _trial(row: Row, simulation: Row, choices: tuple[str, ...]) -> Trial:
    shares = {each.id: _SHARES.get(each.id, _relation)(each, simulation, row) for each in statements() if each.id not in OF_NO_JOINT}
    required = {each.id: each.share if each.kind in ("relation", "frequency") else TYPICALLY for each in statements()}
    required["joint-cause"] = required["post-excess"]
    return Trial(row, choices, shares, {name: share is not None and share >= required[name] for name, share in shares.items()})


def _relation(statement: Statement, simulation: Row, row: Row) -> float | None:
    if statement.quantity == "post_over_pre_frequency" and not row.tells_halves_apart:
        return 0.0  # an excess within the uncertainty of the measurement
    return statement.share_of(ratios(statement.quantity, simulation, row))


def ratios(quantity: str, simulation: Row, row: Row) -> dict[int, float]:
    """Run -> ratio simulation / experiment of a quantity that statements name."""
    if quantity == "post_over_pre_frequency":
        before, after = (ratios(f"{half}_frequency", simulation, row) for half in HALVES)
        return {run: after[run] / before[run] for run in before if run in after}
    simulated, changed = simulation.changes(quantity), row.changes(quantity)
    return {run: (1.0 + simulated[run]) / (1.0 + changed[run]) for run in simulated if run in changed}


def _cause(_: Statement, simulation: Row, row: Row) -> float | None:
    """The share of the excess after the return: the cause that the thesis names would show there."""
    excess = next(each for each in statements() if each.id == "post-excess")
    return _relation(excess, simulation, row)


def _first_mode(statement: Statement, _: Row, row: Row) -> float | None:
    means = [mean for mean in row.example[:2] if mean]
    return sum(statement.low <= mean <= statement.high for mean in means) / len(means) if means else None


def _is_seen(row: Row) -> bool:
    """Whether the vibration at the return would be seen in the figure of the run that the thesis shows."""
    printed = next(axis.range for axis in axis_labels(EXAMPLE) if axis.channel == "tip_acceleration")
    return bool(row.example) and math.sqrt(2.0) * row.example[2] >= VISIBLE * (printed[1] - printed[0])


def _second_mode(statement: Statement, _: Row, row: Row) -> float | None:
    return float(_is_seen(row) and abs(row.example[3] - statement.low) <= RESOLUTION) if row.example else None


def _signs(_: Statement, __: Row, row: Row) -> float | None:
    return float(_is_seen(row) and row.example[4] < 0.0 < row.example[5]) if row.example else None


def _two_modes(_: Statement, simulation: Row, row: Row) -> float | None:
    both_halves = [ratio for half in HALVES for ratio in ratios(f"{half}_frequency", simulation, row).values()]
    return sum(ACCURATE[0] <= ratio <= ACCURATE[1] for ratio in both_halves) / len(both_halves) if both_halves else None


_SHARES: Final[Mapping[str, Share]] = {
    "first-mode-range": _first_mode,
    "second-mode": _second_mode,
    "second-mode-signs": _signs,
    "joint-cause": _cause,
    "two-modes": _two_modes,
}
