"""Checks of an engine's settings: each has an effect; and the stated errors of a `SimpleEngine` are the measured ones."""

import contextlib
import dataclasses
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from quickreturn.cases.case_file import load_case
from quickreturn.cases.conformance.bench import Bench, Motion, solution
from quickreturn.cases.conformance.checks import Check, Fault, Unjudged, check_by
from quickreturn.cases.conformance.together import everything
from quickreturn.cases.jobs.tally import span
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.relative import relative_error
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.engines.simple import SimpleEngine, SimpleSettings
from quickreturn.reference_model.mechanism import Mechanism

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


def settings_at_work(bench: Bench) -> Iterator[Check]:
    """A check for each setting."""
    for field in dataclasses.fields(bench.engine.settings_type):
        yield check_by(f"setting {field.name}", does_something, bench, field)


def does_something(bench: Bench, field: "dataclasses.Field[Any]") -> str:
    """Check that another value of a setting changes the motion or its cost."""
    tried = list[Any]()
    for scene, settings in _where_it_may_act(bench, field):
        motion = Motion(scene, _DURATION)
        for value in _others(field, getattr(settings, field.name)):
            try:
                changed = settings.replaced(**{field.name: value})
                plain, other = bench.run(motion, settings), bench.run(motion, changed)
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
    for other in dataclasses.fields(settings):  # where another setting is larger: an inertia of the higher modes needs some
        if other.name != field.name and isinstance(present := getattr(settings, other.name), int) and not isinstance(present, bool):
            for value in _others(other, present):
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
