"""Checks of an engine's ladder and settings: it gets finer, ends, its estimates hold; each setting has an effect.

The stated errors of a `SimpleEngine` are the measured ones.
"""

import contextlib
import dataclasses
import itertools
import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from quickreturn.cases.case_file import load_case
from quickreturn.cases.conformance.bench import Bench, Motion, Truth, solution, truth
from quickreturn.cases.conformance.checks import Check, Fault, Unjudged, check_by
from quickreturn.cases.conformance.motion import MistakesInMildScene, mistakes_in_mild_scene
from quickreturn.cases.conformance.quantities import everything
from quickreturn.cases.conformance.scenes import OUTPUT_STEP
from quickreturn.cases.jobs.tally import span
from quickreturn.engines.base import Comparison, EngineFailure
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.relative import relative_error, rms
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.engines.simple import SimpleEngine, SimpleSettings
from quickreturn.reference_model.mechanism import Mechanism

#: Largest number of rungs of a ladder.
_MOST_RUNGS: Final = 200
#: Accuracy of coarse settings, or the engine's default if that is coarser.
_COARSE: Final = 0.05
#: Number of rungs that are run, and solve time (s) of a run after which no finer one is run.
_RUN: Final = 3
_SLOW: Final = 5.0
#: The same for further rungs, which are run while none is better: they decide whether the check fails, so that they may take longer.
_FURTHER: Final = 2
_SLOW_FURTHER: Final = 30.0
#: Largest ratio of an error to its estimate in the mild scene, by what the estimate covers: errors of an integration with adaptive steps
#: scatter.
_MISSED: Final = {"total": 1.5, "integration": 2.5}
#: Largest ratio of a finer rung's error to a coarser one's: some rungs are better than expected by chance.
_WORSE: Final = 1.1
#: Largest ratio of the finest rung's error to the coarsest one's.
_BETTER: Final = 0.9
#: Smaller relative errors of the tip deflection are not compared: they are errors of the integration.
_NOISE: Final = 5e-5
#: An order or factor is as stated within this factor.
_ABOUT: Final = 2.5

#: Duration of the runs that compare settings, s: 50 rows.
_DURATION: Final = 0.05
#: Factors by which a number is changed until it has an effect; zero becomes the part `_OF_ZERO` of the largest accepted value.
_FACTORS: Final = (0.5, 2.0, 0.01, 100.0)
_OF_ZERO: Final = 0.1
#: Least ratio of run times that counts as a change; each is the shortest of `_TIMED` runs.
_COST: Final = 1.5
_TIMED: Final = 3
#: Case and duration (s) for which the errors of a `SimpleEngine` are stated.
_MEASURED_IN: Final = "thesis-24"
_MEASURED_OVER: Final = 2.0
#: Longest wall time, s, for the measurement of one of them.
_AFFORDABLE: Final = 60.0
#: Largest ratio of a measured error to the stated one.
_UNDERSTATED: Final = 1.5


def resolution(bench: Bench) -> Iterator[Check]:
    """All checks of the ladder."""
    coarse, default = bench.engine.settings_for(max(_COARSE, bench.engine.default_accuracy), bench.scene), bench.settings(bench.scene)
    yield check_by("ladder: ends", _ends, bench, coarse)
    try:
        wrong, right = mistakes_in_mild_scene(bench), _truth(bench)
        (errors, ended), (above, _) = _climb(bench, right, coarse, _RUN, _FURTHER), _climb(bench, right, default, 2)
        finer = _error(bench, bench.engine.settings_for(min(_COARSE, bench.engine.default_accuracy), bench.scene), right)
    except EngineFailure as failure:
        yield Check("ladder: gets finer", "failed", f"a rung breaks down in the mild scene: {failure.cause}", failure.advice)
        return
    yield check_by("ladder: gets finer", _gets_finer, errors, above, wrong, ended)
    yield check_by("ladder: a smaller accuracy is finer", _smaller_accuracy, bench, errors[0], finer)
    for words, chosen in {"coarse settings": coarse, "default settings": default}.items():
        if words == "default settings" or chosen != default:
            yield check_by(f"estimates hold, {words}", _estimates, bench, chosen, wrong)
    yield from settings_at_work(bench)
    if isinstance(bench.engine, SimpleEngine):
        yield check_by("ladder: stated errors", stated_errors, bench.engine, bench.seconds)


def _ends(bench: Bench, settings: Settings) -> str:
    seen = [settings]
    while len(seen) < _MOST_RUNGS:
        finer = bench.finer(bench.scene, seen[-1])
        if finer is None:
            return f"after {len(seen)} rungs" if len(seen) > 1 else "no rung above the coarsest"
        if finer in seen:
            cause = "`finer` gives back the settings that it was given" if finer == seen[-1] else "`finer` goes round in circles"
            raise Fault(f"{cause}: {finer}", "return finer settings, or None at the end of the ladder")
        seen.append(finer)
    raise Fault(f"`finer` has gone on for {_MOST_RUNGS} rungs, to {seen[-1]}", "return None where a finer rung is not affordable")


def _truth(bench: Bench) -> Truth:
    """The solution of the scene; for an engine whose discretization is its model, the solution of its own equations."""
    if bench.engine.estimates != "integration":
        return truth(bench.mild)
    settings = bench.settings(bench.scene)
    for _ in range(_RUN):
        settings = bench.finer(bench.scene, settings) or settings
    return Truth(bench.run(bench.mild, settings).columns, {})


def _error(bench: Bench, settings: Settings, right: Truth) -> float:
    """Relative error of the tip deflection."""
    deflection = right.columns["tip_deflection"]
    return rms(bench.run(bench.mild, settings)["tip_deflection"] - deflection) / (rms(deflection) or 1.0)


def _climb(bench: Bench, right: Truth, settings: Settings, most: int, further: int = 0) -> tuple[list[float], bool]:
    """Errors of the tip deflection from rung to rung, of at most `most` rungs, and whether a rung that takes long ended it.

    Where the last of them is no better than the first, up to `further` more are run: two neighbouring rungs may be equally good by chance.
    """
    errors = [_error(bench, settings, right)]
    while len(errors) < most + (0 if _better(errors) else further):
        finer = bench.finer(bench.scene, settings)
        if finer is None:
            break
        decides = further > 0 and len(errors) > 1 and not _better(errors)
        if bench.run(bench.mild, settings).solve_seconds > (_SLOW_FURTHER if decides else _SLOW):
            return errors, True
        settings = finer
        errors.append(_error(bench, settings, right))
    return errors, False


def _better(errors: list[float]) -> bool:
    """Whether the finest rung is better than the coarsest, or that is too good to be improved."""
    return errors[-1] <= _BETTER * errors[0] or errors[0] <= _NOISE


def _gets_finer(errors: list[float], above: list[float], wrong: MistakesInMildScene, ended: bool) -> str:
    """Check that errors fall from the coarsest rung on, and above the default; `ended`: the next rung from the coarsest one takes long."""
    for rungs in (errors, above):
        if any(after > max(_WORSE * before, 0.3 * errors[0], _NOISE) for before, after in itertools.pairwise(rungs)):
            cause = f"`finer` makes it coarser: errors of the tip deflection from rung to rung are {_listed(rungs)}"
            raise Fault(cause, "return settings with a smaller error; look at the direction of steps and sizes")
    if len(errors) == 1:
        raise Unjudged("there is no rung above the coarsest, or it takes long")
    if not _better(errors):
        cause = f"finer rungs are no better: errors of the tip deflection are {_listed(errors)}"
        if wrong.motion or "tip_deflection" in wrong.columns:
            raise Unjudged(f"{cause}, and it is wrong already", "mend that first")
        if ended:
            raise Unjudged(f"{cause}, and the next one takes long")
        raise Fault(cause, "the error is not that of the resolution; compare a fine run with reference")
    return f"errors {_listed(errors)}"


def _listed(errors: list[float]) -> str:
    return ", ".join(f"{error:.2g}" for error in errors)


def _smaller_accuracy(bench: Bench, coarse: float, picked: float) -> str:
    if picked > max(_WORSE * coarse, _NOISE):
        smaller, larger = sorted((_COARSE, bench.engine.default_accuracy))
        asked = f"{smaller:g} than for {larger:g}"
        cause = f"`settings_for` gives coarser settings for {asked}: errors {picked:.2g}, {coarse:.2g}"
        raise Fault(cause, "look at the direction of the table behind settings_for")
    return f"errors {coarse:.2g} and {picked:.2g}"


def _estimates(bench: Bench, settings: Settings, wrong: MistakesInMildScene) -> str:
    of = bench.engine.estimates
    if of == "unverified":
        raise Unjudged("the engine states that its estimates are not verified")
    pairs = bench.engine.comparisons(settings, bench.scene, OUTPUT_STEP)
    estimates = bench.estimates(bench.mild, settings)
    if estimates is None:
        raise Unjudged(f"no estimate can be made of {settings}", "let `comparisons` name a run that is not the same and completes")
    right, run = _truth(bench), bench.run(bench.mild, settings)
    if of == "integration" and _error(bench, settings, right) < _NOISE:
        return "the integration's error is too small to be measured"
    missed, allowed = {}, _MISSED[of]
    for column in (name for name in ESTIMATED if name not in wrong.columns):
        size = rms(right.columns[column])
        error, estimate = rms(run[column] - right.columns[column]), estimates[column]
        if size > 0.0 and error > allowed * estimate + 3.0 * right.uncertainty.get(column, 0.0) and error > _NOISE * size:
            missed[column] = (error / max(estimate, 1e-300), error / size, estimate / size)
    single = _factor_shown(bench, pairs, right) if len(pairs) == 1 else None
    stated = pairs[0].factor if len(pairs) == 1 else math.nan
    if single is not None and (single > 1.0) != (stated > 1.0) and not 1.0 / _ABOUT < single < _ABOUT:
        cause = f"the factor of `comparisons` is upside down, overclaimed if above 1: {stated:g}, the errors' ratio is {single:.3g}"
        raise Fault(cause, "factor is the error of `other` over that of `run`: below 1 where `other` is the finer one")
    if missed and wrong.motion:
        raise Unjudged("the motion is wrong already", "mend that first")
    if missed:
        worst = max(missed, key=lambda column: missed[column][0])
        times, error, estimate = missed[worst]
        others = f", and {len(missed) - 1} of the others" if len(missed) > 1 else ""
        cause = f"the estimate is too small: {worst} is {error:.2g} off where it says {estimate:.2g}, {times:.1f} times as much{others}"
        if single is not None and abs(stated - 1.0) > allowed * abs(single - 1.0):
            cause = f"the factor {stated:g} of `comparisons` is overclaimed: the errors' ratio is {single:.3g}; {cause}"
        advice = "state the factor that runs show: error of `other` over that of `run`, on the safe side; or compare with a finer run"
        raise Fault(cause, advice)
    relative = estimates["tip_deflection"] / (rms(right.columns["tip_deflection"]) or 1.0)
    return f"error {_error(bench, settings, right):.2g}, estimate {relative:.2g}"


def _factor_shown(bench: Bench, pairs: tuple[Comparison, ...], right: Truth) -> float | None:
    """Ratio of the other run's error to the run's, for the tip deflection; None if one of them is within the noise."""
    try:
        error, other = (_error(bench, settings, right) for settings in (pairs[0].run, pairs[0].other))
    except EngineFailure:
        return None
    return other / error if error > 0.2 * _NOISE else None


def settings_at_work(bench: Bench) -> Iterator[Check]:
    """A check for each setting."""
    for field in dataclasses.fields(bench.engine.settings_type):
        yield check_by(f"setting {field.name}", does_something, bench, field)


def does_something(bench: Bench, field: "dataclasses.Field[Any]") -> str:
    """Check that another value of a setting changes the motion or its cost."""
    tried = list[Any]()
    for scene, settings in _where_it_may_act(bench, field):
        motion = Motion(scene, _DURATION)
        try:
            plain = bench.run(motion, settings)
        except (SettingError, EngineFailure):
            continue  # that is due to the other setting
        for value in _others(field, getattr(settings, field.name)):
            try:
                changed = settings.replaced(**{field.name: value})
                other = bench.run(motion, changed)
            except (SettingError, EngineFailure):
                return ""  # if it fails or is refused, the engine reads the setting
            tried.append(value)
            if any(not np.array_equal(values, other[name]) for name, values in plain.columns.items()):
                return ""
            if _costs_otherwise(bench, motion, (settings, changed)):
                return "it changes what a run costs"
    if not tried:
        raise Unjudged("no other value is accepted")
    words = ", ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in dict.fromkeys(tried))
    raise Fault(f"{field.name} does nothing: with {words} neither the motion nor its cost is another", "use it, or leave it out")


def _where_it_may_act(bench: Bench, field: "dataclasses.Field[Any]") -> Iterator[tuple[Mechanism, Settings]]:
    """Scenes with settings: a setting may act only on what a scene has, or only where others are fine."""
    yield bench.scene, bench.settings(bench.scene)
    with contextlib.suppress(Unjudged):
        scene = everything(bench)[0]
        yield scene, bench.settings(scene)
    yield bench.scene, bench.engine.ladder(bench.scene)[-1]
    settings = bench.settings(bench.scene)
    numbers = {name: value for name, value in settings.as_dict().items() if isinstance(value, (int, float)) and not isinstance(value, bool)}
    fields = [other for other in dataclasses.fields(settings) if other.name in numbers and other.name != field.name]
    # where another number differs, whole ones first: an inertia of the higher modes needs some, rows within a step need a long one
    for other in sorted(fields, key=lambda other: isinstance(numbers[other.name], float)):
        for value in _others(other, numbers[other.name]):
            with contextlib.suppress(SettingError):
                yield bench.scene, settings.replaced(**{other.name: value})


def _costs_otherwise(bench: Bench, motion: Motion, settings: tuple[Settings, Settings]) -> bool:
    """Whether two runs differ in cost: by the counts of their solvers, or by their times if these count nothing."""
    statistics = (bench.run(motion, each).statistics for each in settings)
    counts = [{key: value for key, value in of_run.items() if not key.endswith("seconds")} for of_run in statistics]
    if any(counts):
        return counts[0] != counts[1]
    plain, other = (min(motion.by(bench.engine, each).solve_seconds for _ in range(_TIMED)) for each in settings)
    return not 1.0 / _COST < other / plain < _COST


def _others(field: "dataclasses.Field[Any]", present: Any) -> Iterator[Any]:
    """Other accepted values of a setting."""
    accepted: Mapping[str, Any] = field.metadata
    if isinstance(present, bool):
        yield not present
    elif isinstance(present, (int, float)):
        low, high = accepted.get("low", -np.inf), accepted.get("high", np.inf)
        candidates = [factor * present for factor in _FACTORS] if present else [_OF_ZERO * high, _OF_ZERO**2 * high]
        within = [min(max(value, low), high) for value in candidates if np.isfinite(value)]
        kind = type(present)
        yield from (value for value in dict.fromkeys(kind(value) for value in within) if value != present)
    else:
        yield from (choice for choice in accepted.get("choices", ()) if choice != present)


def stated_errors(engine: SimpleEngine, seconds: float | None) -> str:
    """Check the stated error of the coarsest resolution, in run 24 over two seconds as `SimpleEngine.errors` are defined."""
    resolution, stated = min(engine.errors.items())
    scene = load_case(_MEASURED_IN).mechanism
    engine.check(scene)
    tolerance = engine.settings_for(stated, scene).tolerance
    settings = SimpleSettings(resolution=resolution, tolerance=tolerance)
    motion, began = Motion(scene, _MEASURED_OVER), time.monotonic()
    replace(motion, duration=0.05 * _MEASURED_OVER).by(engine, settings)
    ahead, affordable = 20.0 * (time.monotonic() - began), _AFFORDABLE if seconds is None else 0.2 * seconds
    if ahead > affordable:
        raise Unjudged(f"left out: to measure one takes about {span(ahead)}", "measure them as docs/engine.md does")
    measured = relative_error(motion.by(engine, settings)["tip_deflection"], solution(motion)["tip_deflection"])
    if measured > _UNDERSTATED * stated:
        cause = f"`errors` states {stated:.2g} for resolution {resolution}, measured in {_MEASURED_IN} it is {measured:.2g}"
        raise Fault(f"{cause}, {measured / stated:.2g} times as much", "measure `errors` as docs/engine.md does, all of them")
    return f"resolution {resolution}: {stated:.2g} is stated, {measured:.2g} measured"
