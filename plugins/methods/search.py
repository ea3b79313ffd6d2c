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
from dataclasses import Field, fields
from typing import Any, Final

from quickreturn.engines.base import AnyEngine
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.plugins.methods.fronts import CRITERIA, paced
from quickreturn.plugins.methods.row import Row
from quickreturn.reference_model.mechanism import Mechanism

#: Runs of a combination at most, and the sum of their solve times, s, with which this project's engines take five minutes in run 24. A run
#: may take a share of what is left of that.
RUNS: Final = 40
SECONDS: Final = 12.0
SHARE: Final = 0.5
#: Least exponent with which the cost grows as the error falls: elements of order 4, whose right-hand side costs the square of their number.
LEAST_COST: Final = 0.5
#: Real numbers that are axes: those of the integration's error, which are cheaper the larger they are, and those that may help either way.
TIME_ERRORS: Final = ("tolerance", "newton_tolerance", "step")
OTHERS: Final = ("slowed_to", "joint_inertia", "stiffness", "damping")
#: Factors of a step along an axis of real and of whole numbers, coarse to fine.
STEPS: Final = ((10.0, 1.5), (10.0**0.5, 1.25), (10.0**0.25, 1.1))
#: First value along an axis that is off, which is 0: the number of a mode, and the inertia (kg) that slows 1e6 N/m to some 500 Hz.
FIRST: Final = {"slowed_to": 4, "joint_inertia": 0.1}
#: Errors that differ by no more than this factor count as equal while a level is missed.
ALIKE: Final = 1.05


def choices_of(engine: AnyEngine) -> dict[str, tuple[str, ...]]:
    """The settings of an engine that are a choice among texts, with what they accept, the default first."""
    chosen = {each.name: each for each in fields(engine.settings_type) if each.metadata.get("choices")}
    return {name: tuple(sorted(each.metadata["choices"], key=lambda text: text != each.default)) for name, each in chosen.items()}


def variant_of(engine: AnyEngine, settings: Settings) -> str:
    """The choices in which settings differ from the engine's defaults: "hermite"."""
    given = {name: (str(getattr(settings, name)), usual) for name, (usual, *_) in choices_of(engine).items()}
    return ", ".join(text for text, usual in given.values() if text != usual)


def combinations(engine: AnyEngine, mechanism: Mechanism) -> list[dict[str, str]]:
    """An engine's usual choices for a mechanism, by its default accuracy, and those that differ from them in one."""
    choices, own = choices_of(engine), engine.settings_for(engine.default_accuracy, mechanism)
    usual = {name: str(getattr(own, name)) for name in choices}
    return [usual, *({**usual, name: text} for name, texts in choices.items() for text in texts if text != usual[name])]


def seeds(engine: AnyEngine, choices: Mapping[str, str], levels: Sequence[float], mechanism: Mechanism) -> list[Settings]:
    """What the engine takes for each level of the error and for three times that, with the choices of a combination; one of each size.

    An engine's own choice leaves room for its estimate of the error, which is often several times the error.
    """
    found = dict[Any, Settings]()
    for settings in (engine.settings_for(factor * level, mechanism).with_texts(dict(choices)) for level in levels for factor in (3.0, 1.0)):
        found.setdefault(tuple(value for value in settings.as_dict().values() if isinstance(value, int)), settings)
    return list(found.values())


def neighbours(settings: Settings, step: tuple[float, float], finer: bool, longest: float = math.inf) -> Iterator[Settings]:
    """Settings one step away: finer ones or cheaper ones along each axis, both ways where the axis does not tell; and trades.

    A trade makes a whole number finer and an error of the integration cheaper, or the other way round. Where finer settings are needed, the
    first comes before all others. No time step becomes longer than `longest` (s), the one of the rows.
    """
    moves = {each.name: _moves(each, getattr(settings, each.name), step, longest) for each in fields(settings)}
    along = [{name: value} for name, (cheap, fine) in moves.items() for value in (fine if finer else cheap)]
    sizes = [name for name, (cheap, fine) in moves.items() if type(getattr(settings, name)) is int and name not in OTHERS]
    errors = [name for name in moves if name in TIME_ERRORS]
    pairs = list(zip(sizes[:1], errors[:1], strict=False))
    up, down = (
        [{size: one, error: other} for size, error in pairs for one in moves[size][way] for other in moves[error][1 - way]]
        for way in (1, 0)
    )
    for change in [*up, *along, *down] if finer else [*along, *up, *down]:
        with suppress(SettingError):  # what the settings refuse together
            yield settings.replaced(**change)


def _moves(field: "Field[Any]", value: Any, step: tuple[float, float], longest: float) -> tuple[list[Any], list[Any]]:
    """Cheaper and finer values one step away along a field; none if it is no axis, and the same ones if it does not tell."""
    if isinstance(value, bool):
        return [not value], [not value]
    low, high = field.metadata.get("low", -math.inf), field.metadata.get("high", math.inf)
    if value == 0 and low <= (first := FIRST.get(field.name, -math.inf)) <= high:  # what is off may be on
        return [first], [first]
    if isinstance(value, int):
        apart = max(1, round(value * (step[1] - 1.0)))
        return [each for each in [value - apart] if each >= low], [each for each in [value + apart] if each <= high]
    if not isinstance(value, float) or field.name not in (*TIME_ERRORS, *OTHERS) or not 0.0 < value < math.inf:
        return [], []
    if field.metadata.get("unit") == "s":
        high = min(high, max(longest, value))
    up, down = ([each] if (each := min(max(float(f"{value * by:.2g}"), low), high)) != value else [] for by in (step[0], 1.0 / step[0]))
    return (up, down) if field.name in TIME_ERRORS else (down + up, down + up)


def search(
    first: Sequence[Settings], levels: Sequence[float], runs: int, run: Callable[[Settings, float], Row], longest: float = math.inf
) -> list[Row]:
    """At most `runs` rows: `run` makes one from settings and a limit of its solve time (s). Every level has its turn, by each criterion.

    `longest`: see `neighbours`.
    """
    tried: dict[Settings, Row] = {}

    def make(settings: Settings) -> bool:
        left = SECONDS - sum(row.solve_seconds or 0.0 for row in tried.values())
        if left > 0.0 and len(tried) < runs:
            tried[settings] = run(settings, SHARE * left)
        return settings in tried

    for settings in first:
        make(settings)
    goals = {(level, by): 0 for level in levels for by in CRITERIA}  # -> number of the step
    while goals:
        for (level, by), number in list(goals.items()):
            seconds, error, best = _best(tried, level, by)
            hopeless = error > level and seconds * (error / level) ** LEAST_COST > SHARE * SECONDS
            new = next((each for each in neighbours(best, STEPS[number], error > level, longest) if each not in tried), None)
            if hopeless or (new is None and number + 1 == len(STEPS)):
                del goals[level, by]
            elif new is None:
                goals[level, by] = number + 1
            elif not make(new):
                return list(tried.values())
    return list(tried.values())


def _best(tried: dict[Settings, Row], level: float, by: str) -> tuple[float, float, Settings]:
    """Seconds, error and settings of the fastest run below a level, or of the most accurate one.

    Where none has a result yet, those of the last one with an error of 0: cheaper settings are needed.
    """
    rows = zip(tried, paced(list(tried.values())), strict=True)
    known = [(row.seconds, error, settings) for settings, row in rows if (error := CRITERIA[by](row)) is not None]
    least = min((error for _, error, _ in known), default=0.0)
    # what is hardly more accurate and takes longer leads nowhere
    wanted = [each for each in known if each[1] <= (level if least <= level else ALIKE * least)]
    return min(wanted, key=lambda each: each[0], default=(0.0, 0.0, next(reversed(tried))))
