"""Checks of failures: an engine must report that it cannot go on, and at what time."""

import math
from collections.abc import Iterator
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.conformance.bench import Bench, Motion
from quickreturn.cases.conformance.checks import Check, Fault, Unjudged, check_by
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.scene import check_scene
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.scene_values import changed

#: Changes of the mild scene, SI: a slack follower whose bent end the slider reaches at the farthest place.
_PUSHED_OFF: Final = {"crank.length": 0.1795, "crank.initial_angle": 0.5, "follower.bending_stiffness": 10.0, "tip.mass": 0.1}
_UNTIL: Final = 0.4  # s, duration of this motion
#: Allowed relative error of the time at which the slider leaves.
_TIME_ERROR: Final = 0.3
_RAISE: Final = "raise engines.base.EngineFailure(time, cause, advice, partial)"
#: Words in the cause of an unintended failure -> what is wrong, and the advice.
_UNSAID: Final = {
    "the engine raised": ("", f"where a run cannot go on, {_RAISE}"),
    "the engine returned": ("it is not said: ", f"do not return rows that are not there: {_RAISE}"),
    "no longer a finite number": ("it is not said: ", f"check the state: {_RAISE}"),
}


def failures(bench: Bench) -> Iterator[Check]:
    """All checks of failures."""
    for name, look in {
        "the slider leaves the follower": _leaves,
        "a start that cannot be": _impossible_start,
        "a step that explodes": _explodes,
    }.items():
        yield check_by(f"failures: {name}", look, bench)


def _attempt(bench: Bench, motion: Motion) -> Trajectory | EngineFailure:
    """The engine's trajectory, or the failure that it reports. Fault: it fails without a report."""
    check_scene(bench.engine, motion.scene)
    try:
        return motion.by(bench.engine, bench.settings(bench.scene))  # those for the mild scene, like a fixed step
    except EngineFailure as failure:
        for words, (wrong, advice) in _UNSAID.items():
            if words in failure.cause:
                raise Fault(f"{wrong}{failure.cause}", advice) from failure
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
        cause = f"the run goes on as if nothing had happened; the slider is at {furthest:.4g} m of {length:.4g} m"
        raise Fault(cause, f"watch the slider's place: where it passes the length, {_RAISE}")
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
    bent = CubicSpline(x, 0.45 * length * (x / length) ** 2)
    scene = changed(bench.scene, {"crank.length": length - bench.scene.pivot_distance - 1e-3})
    start = Start(math.pi, standard_start(scene).crank_speed, bent)
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
