"""Checks of how an engine fails, and that its answer depends on the scene and nothing else: no earlier scene, process or second call.

Answers are compared from separate processes with one thread each: sums in a different order of threads differ in the last digits, which is
not a mistake.
"""

import math
import pickle
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.running.display import answers
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.processes import LocalProcesses
from quickreturn.engines.base import AnyEngine, EngineFailure
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.relative import rms
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.conform.bench import Array, Bench, Check, Fault, Motion, Unjudged, check_by, compared_columns, engine_from
from quickreturn.reference_model.scene_values import changed

#: Changes of the mild scene, SI: a slack follower whose bent end the slider reaches at the farthest place; and the duration, s.
_PUSHED_OFF: Final = {"crank.length": 0.1795, "crank.initial_angle": 0.5, "follower.bending_stiffness": 10.0, "tip.mass": 0.1}
_UNTIL: Final = 0.4
#: Allowed relative error of the time at which the slider leaves.
_TIME_ERROR: Final = 0.3
_RAISE: Final = "raise engines.base.EngineFailure(time, cause, advice, partial)"
#: Words in the cause of a failure that the engine did not report itself.
_UNSAID: Final = ("the engine raised", "the engine returned", "no longer a finite number")


def failures(bench: Bench) -> Iterator[Check]:
    """All checks of failures."""
    yield check_by("failures: the slider leaves the follower", _leaves, bench)
    yield check_by("failures: a start that cannot be", _impossible_start, bench)
    yield check_by("failures: a step that explodes", _explodes, bench)


def _attempt(bench: Bench, motion: Motion) -> Trajectory | EngineFailure:
    """The engine's trajectory, or the failure that it reports. Fault: it fails without a report."""
    try:
        return motion.by(bench.engine, bench.settings(bench.scene))  # those for the mild scene, like a fixed step
    except EngineFailure as failure:
        if any(words in failure.cause for words in _UNSAID):
            raise Fault(f"the engine does not say that the run cannot go on: {failure.cause}", _RAISE) from failure
        return failure


def _leaves(bench: Bench) -> str:
    """Check a motion in which the slider leaves the follower's end."""
    motion, reference = Motion(changed(bench.scene, _PUSHED_OFF), _UNTIL), ReferenceEngine()
    length = motion.scene.follower.length
    try:
        motion.by(reference, reference.settings_for(1e-3, motion.scene))
    except EngineFailure as failure:
        right_time = failure.time
    else:
        raise Unjudged("the slider stays on the follower in this scene")
    result = _attempt(bench, motion)
    if isinstance(result, Trajectory):
        furthest = float(result["slider_position"].max())
        if furthest <= length * 1.001 and not bench.claims:
            return "coarse: it stays on in this model"
        raise Fault(f"the run goes on as if nothing had happened; the slider is at {furthest:.4g} m of {length:.4g} m", _RAISE)
    if abs(result.time - right_time) > _TIME_ERROR * right_time and bench.claims:
        cause = f"it is said for t = {result.time:.4g} s, in reference the slider leaves at {right_time:.4g} s"
        raise Fault(cause, "`time` is that of the last good row, from the start of the simulation")
    if result.partial is not None and result.partial["slider_position"].max() > 1.01 * length:
        raise Fault("rows behind the follower's end are kept in `partial`", "cut them where the slider leaves")
    return ""


def _impossible_start(bench: Bench) -> str:
    """Check a start with a follower that is bent so much that it does not reach the crank's tip."""
    length = bench.scene.follower.length
    x = np.linspace(0.0, length, 65)
    scene = changed(bench.scene, {"crank.length": length - bench.scene.pivot_distance - 1e-3})
    start = Start(math.pi, standard_start(scene).crank_speed, CubicSpline(x, 0.45 * length * (x / length) ** 2))
    result = _attempt(bench, Motion(scene, duration=0.01, start=start))
    if isinstance(result, Trajectory):
        cause = "a follower that is bent too much to reach the slider is simulated all the same"
        raise Fault(cause, "begin with engines.start_state.reconstruct, which raises EngineFailure")
    if result.time != 0.0:
        raise Fault(f"it fails at t = {result.time:g} s, not at 0", "raise EngineFailure in `prepare`, at time 0")
    return ""


def _explodes(bench: Bench) -> str:
    """Check a follower a thousand times as stiff, with settings for a soft one: a fixed step is unstable there."""
    scene = changed(bench.scene, {"follower.bending_stiffness": 2e4})
    result = _attempt(bench, Motion(scene, duration=0.1))
    if isinstance(result, EngineFailure):
        return f"said: {result.cause}"
    largest = float(np.abs(result["tip_deflection"]).max())
    if largest > 0.1 * scene.follower.length:
        raise Fault(f"a follower a thousand times as stiff bends by {largest:.3g} m, in silence", f"watch the size of the state: {_RAISE}")
    return ""


_DURATION: Final = 0.1  # s
#: Relative difference that is allowed in a column.
_SAME: Final = 1e-6
#: Allowed difference as a part of the engine's own error, by what its estimate covers. With different last digits a step size control takes
#: other steps, so that the integration's error has another value of the same size, which is a small part of the total error.
_OF_ERROR: Final = {"total": 0.02, "integration": 1.0, "unverified": 0.02}
#: Part of a scene -> its change, which reveals a kept state.
PARTS: Final[Mapping[str, Mapping[str, Any]]] = {
    "crank": {"crank.length": 0.09, "crank.inertia": 4e-3},
    "tip": {"tip.mass": 0.1},
    "follower": {"follower.bending_stiffness": 9.0, "follower.mass_per_length": 0.5},
}
#: Scenes that one process computes one after the other, and those that have a process each; names that are no part's are the mild scene.
IN_TURN: Final = ("first", "the second time", *PARTS, "behind other scenes")
ALONE: Final = ("in another process", *PARTS)

#: Scene -> its columns.
Results = Mapping[str, Mapping[str, Array]]


def columns_of(engine: AnyEngine | str, names: tuple[str, ...]) -> Results:
    """Columns of scenes, one after the other in this process: with one of `PARTS` changed, or of the mild scene for any other name."""
    tested = engine_from(engine)
    bench, found = Bench(tested), dict[str, dict[str, Array]]()
    for name in names:
        run = Motion(changed(bench.scene, PARTS.get(name, {})), _DURATION).by(tested, bench.settings(bench.scene))
        found[name] = {column: run[column] for column in compared_columns(run)}
    return found


def elsewhere(engine: AnyEngine | str) -> tuple[Results, Results] | str:
    """Results of the engine in one process for all scenes and in a process for each; or why there are none."""
    try:
        pickle.dumps(engine)
    except Exception as error:  # of whatever kind pickle makes it
        return f"pickle raised {type(error).__name__}: {error}"
    if engine_from(engine).compiles:  # compiled and loaded code may differ in the last digits: all processes shall load it
        answers(LocalProcesses(1), [Job("compiling", columns_of, (engine, IN_TURN[:1]))], "other processes")
    jobs = [Job("scenes in turn", columns_of, (engine, IN_TURN)), *(Job(name, columns_of, (engine, (name,))) for name in ALONE)]
    outcomes = answers(LocalProcesses(2), jobs, "other processes")
    in_turn, *alone = (outcome.value or {} for outcome in outcomes)
    for outcome in outcomes:
        if outcome.value is None:
            return outcome.explanation
    return in_turn, {name: columns for of_process in alone for name, columns in of_process.items()}


def repetition(bench: Bench, other: tuple[Results, Results] | str) -> Iterator[Check]:
    """Checks of the same scene again, after other scenes, and in another process; `other`: as `elsewhere` gives it."""
    # a class that exists in this process alone: its last digits may depend on threads, which its own error covers
    in_turn, alone = other if not isinstance(other, str) else (columns_of(bench.engine, IN_TURN), {})
    for name in (IN_TURN[1], IN_TURN[-1]):
        yield check_by(f"the same {name}", _same, bench, in_turn[IN_TURN[0]], in_turn[name])
    if isinstance(other, str):
        advice = "give the engine's class a module of its own and announce it as an entry point"
        yield Check("the same in other processes", "not judged", other, advice)
        return
    yield check_by("the same in another process", _same, bench, in_turn[IN_TURN[0]], alone[ALONE[0]])
    for part in PARTS:
        yield check_by(f"nothing kept of an earlier {part}", _same, bench, alone[part], in_turn[part])


def _same(bench: Bench, first: Mapping[str, Array], second: Mapping[str, Array]) -> None:
    """Fault if a column differs by more than rounding, and by more than a small part of the engine's own error."""
    part, errors = _OF_ERROR[bench.engine.estimates], None
    for name, values in first.items():
        off = rms(values - second[name])
        if off <= _SAME * (rms(values) + 1e-12):
            continue
        errors = errors or bench.estimates(Motion(bench.scene, _DURATION)) or {}  # only if needed, because that takes time
        if off > part * errors.get(name, 0.0):
            raise Fault(
                f"{name} comes out another way", "keep nothing between runs: no class attribute, module variable, random number or clock"
            )
