"""The settings that are tried: for each combination of an engine's choices as many runs as for any other, and no rung chosen by hand.

A combination is an engine with one text for each of its settings that are a choice (family of shapes, constraint, integrator, joint): its
usual ones, or one of them changed. Its axes are what its settings class declares: whole numbers (modes, shapes, elements, links), switches,
and the real numbers below; an axis that an engine does not have falls away. The search begins with what the engine itself would take for
each level of the error. From the fastest run below a level, or the most accurate one if there is none, it goes along one axis at a time, by
steps that become smaller.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import Field, dataclass, fields
from typing import Any, Final

from quickreturn.engines.base import AnyEngine
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.plugins.methods.fronts import CRITERIA, paced
from quickreturn.plugins.methods.row import Row, choices_of
from quickreturn.reference_model.mechanism import Mechanism

#: Runs of a combination at most.
RUNS: Final = 40
#: Real numbers that are axes: those of the integration's error, which are cheaper the larger they are, and those that may help either way.
TIME_ERRORS: Final = ("tolerance", "newton_tolerance", "step")
OTHERS: Final = ("slowed_to", "joint_inertia", "stiffness", "damping")
#: Factors of a step along an axis of real and of whole numbers, coarse to fine.
STEPS: Final = ((10.0, 1.5), (10.0**0.5, 1.25), (10.0**0.25, 1.1))
#: First value along an axis that is off, which is 0: the number of a mode, and the inertia (kg) that slows 1e6 N/m to some 500 Hz.
FIRST: Final = {"slowed_to": 4, "joint_inertia": 0.1}
#: Errors that differ by no more than this factor count as equal while a level is missed.
ALIKE: Final = 1.05


@dataclass(frozen=True)
class Combination:
    """An engine with fixed choices."""

    engine: AnyEngine
    choices: Mapping[str, str]  # setting -> text

    def seeds(self, levels: Sequence[float], mechanism: Mechanism) -> list[Settings]:
        """What the engine takes for each level of the error and for three times that, with the choices of this combination.

        An engine's own choice leaves room for its estimate of the error, which is often several times the error.
        """
        wanted = (factor * level for level in levels for factor in (3.0, 1.0))
        found = (self.engine.settings_for(level, mechanism).with_texts(dict(self.choices)) for level in wanted)
        return list(dict.fromkeys(found))


def combinations(engine: AnyEngine, mechanism: Mechanism) -> list[Combination]:
    """An engine's usual choices for a mechanism, by its default accuracy, and those that differ from them in one."""
    choices, own = choices_of(engine), engine.settings_for(engine.default_accuracy, mechanism)
    usual = {name: str(getattr(own, name)) for name in choices}
    others = [{**usual, name: text} for name, texts in choices.items() for text in texts if text != usual[name]]
    return [Combination(engine, each) for each in (usual, *others)]


def neighbours(settings: Settings, step: tuple[float, float], finer: bool, longest: float = math.inf) -> Iterator[Settings]:
    """Settings one step away: finer ones or cheaper ones along each axis, both ways where the axis does not tell; then trades.

    No time step becomes longer than `longest` (s), the one of the rows.

    A trade makes a whole number finer and an error of the integration cheaper, or the other way round.
    """
    axes = [(field.name, moves) for field in fields(settings) if (moves := _moves(field, getattr(settings, field.name), step, longest))]
    changes = [{name: value} for name, moves in axes for value in (moves.finer if finer else moves.cheaper)]
    whole, real = (next(((name, moves) for name, moves in axes if moves.kind is kind), None) for kind in (int, float))
    if whole and real:
        ways = ((whole[1].finer, real[1].cheaper), (whole[1].cheaper, real[1].finer))
        changes += [{whole[0]: one, real[0]: other} for ones, others in ways for one in ones for other in others]
    for change in changes:
        with suppress(SettingError):  # what the settings refuse together
            yield settings.replaced(**change)


@dataclass(frozen=True)
class _Moves:
    """Values one step away along an axis."""

    kind: type
    cheaper: Sequence[Any]
    finer: Sequence[Any]


def _moves(field: "Field[Any]", value: Any, step: tuple[float, float], longest: float) -> _Moves | None:
    """The moves along a field; None if it is no axis."""
    if isinstance(value, bool):
        return _Moves(bool, [not value], [not value])
    low, high = field.metadata.get("low", -math.inf), field.metadata.get("high", math.inf)
    if value == 0 and low <= (first := FIRST.get(field.name, -math.inf)) <= high:  # what is off may be on
        return _Moves(object, [first], [first])
    if isinstance(value, int):
        apart = max(1, round(value * (step[1] - 1.0)))
        return _Moves(int, [each for each in [value - apart] if each >= low], [each for each in [value + apart] if each <= high])
    if not isinstance(value, float) or field.name not in (*TIME_ERRORS, *OTHERS) or not 0.0 < value < math.inf:
        return None
    if field.metadata.get("unit") == "s":
        high = min(high, max(longest, value))
    up, down = ([each] if (each := min(max(float(f"{value * by:.2g}"), low), high)) != value else [] for by in (step[0], 1.0 / step[0]))
    return _Moves(float, up, down) if field.name in TIME_ERRORS else _Moves(object, down + up, down + up)


def search(
    seeds: Sequence[Settings], levels: Sequence[float], runs: int, run: Callable[[Settings], Row], longest: float = math.inf
) -> list[Row]:
    """At most `runs` rows: `run` makes one from settings. Every level has its turn, for each of the `CRITERIA`.

    `longest`: see `neighbours`.
    """
    tried: dict[Settings, Row] = {}
    for settings in reversed(seeds[:runs]):
        tried[settings] = run(settings)
    goals = {(level, by): 0 for level in levels for by in CRITERIA}  # -> number of the step
    while goals and len(tried) < runs:
        for (level, by), number in list(goals.items()):
            best, finer = _best(tried, level, by)
            new = best and next((each for each in neighbours(best, STEPS[number], finer, longest) if each not in tried), None)
            if new is not None and len(tried) < runs:
                tried[new] = run(new)
            elif best is None or number + 1 == len(STEPS):
                del goals[level, by]
            else:
                goals[level, by] = number + 1
    return list(tried.values())


def _best(tried: dict[Settings, Row], level: float, by: str) -> tuple[Settings | None, bool]:
    """The settings of the fastest run below a level, or of the most accurate one, and whether finer ones are needed.

    Where none has a result yet, cheaper settings than the last ones are needed; None: nothing was tried.
    """
    rows = zip(tried, paced(list(tried.values())), strict=True)
    known = [(row.seconds, error, settings) for settings, row in rows if (error := CRITERIA[by](row)) is not None]
    below = [each for each in known if each[1] <= level]
    if below:
        return min(below, key=lambda each: each[0])[2], False
    least = min((error for _, error, _ in known), default=0.0)
    nearly = [each for each in known if each[1] <= ALIKE * least]  # what is hardly better and takes longer leads nowhere
    return (min(nearly, key=lambda each: each[0])[2], True) if nearly else (next(reversed(tried), None), False)
