"""How an engine fails: what cannot go on must be said, and when."""

import math
from collections.abc import Iterator
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from cases.conformance.bench import Bench
from cases.conformance.checks import Check
from cases.conformance.scenes import OUTPUT_STEP
from engines.accurate import run_once
from engines.base import EngineFailure, Refusal
from engines.own.reference import ReferenceEngine
from engines.start import Start, standard_start
from engines.trajectory import Trajectory
from reference_model.mechanism import Mechanism, changed

#: A slack follower whose bent end the slider reaches when it comes to its farthest place.
_PUSHED_OFF: Final = {"crank.length": 0.1795, "crank.initial_angle": 0.5, "follower.bending_stiffness": 10.0, "tip.mass": 0.1}
_UNTIL: Final = 0.4  # s
#: Part of the time until the slider leaves by which a coarse engine may be off.
_WHEN: Final = 0.3
_RAISE: Final = "raise engines.base.EngineFailure(time, cause, advice, partial)"


def failures(bench: Bench) -> Iterator[Check]:
    """All checks of failures."""
    yield _leaves(bench)
    yield _impossible_start(bench)
    yield _explodes(bench)


def _attempt(bench: Bench, scene: Mechanism, start: Start, duration: float) -> Trajectory | EngineFailure | Refusal:
    settings = bench.settings(bench.scene)  # made for the mild scene, as a fixed step would be
    try:
        bench.engine.check(scene)
        return run_once(bench.engine, scene, start, duration, OUTPUT_STEP, settings)[0]
    except (EngineFailure, Refusal) as failure:
        return failure


def _said(name: str, failure: EngineFailure) -> Check | None:
    """A failure that no adapter raised on purpose."""
    if failure.cause.startswith("the engine raised"):
        return Check(name, "failed", failure.cause, f"where a run cannot go on, {_RAISE}")
    if failure.cause.startswith("the engine returned"):
        return Check(name, "failed", f"it is not said: {failure.cause}", f"do not return rows that are not there: {_RAISE}")
    if "no longer a finite number" in failure.cause:
        return Check(name, "failed", f"it is not said: {failure.cause}", f"check the state: {_RAISE}")
    return None


def _leaves(bench: Bench) -> Check:
    """The slider leaves the follower's end."""
    name, scene = "failures: the slider leaves the follower", changed(bench.scene, _PUSHED_OFF)
    try:
        run_once(ReferenceEngine(), scene, standard_start(scene), _UNTIL, OUTPUT_STEP, ReferenceEngine().settings_for(1e-3, scene))
    except EngineFailure as failure:
        known = failure.time
    else:
        return Check(name, "not judged", "the slider stays on the follower in this scene", "")
    found = _attempt(bench, scene, standard_start(scene), _UNTIL)
    if isinstance(found, Refusal):
        return Check(name, "passed", f"refused: {found}")
    if isinstance(found, Trajectory):
        furthest = float(found["slider_position"].max())
        if furthest <= scene.follower.length * 1.001 and not bench.claims:
            return Check(name, "passed", "coarse: it stays on in this model")
        cause = f"the run goes on as if nothing had happened; the slider is at {furthest:.4g} m of {scene.follower.length:.4g} m"
        return Check(name, "failed", cause, f"watch the slider's place: where it passes the length, {_RAISE}")
    wrong = _said(name, found)
    if wrong is not None:
        return wrong
    if abs(found.time - known) > _WHEN * known and bench.claims:
        cause = f"it is said for t = {found.time:.4g} s, in reference the slider leaves at {known:.4g} s"
        return Check(name, "failed", cause, "`time` is that of the last good row, from the start of the simulation")
    if found.partial is not None and found.partial["slider_position"].max() > 1.01 * scene.follower.length:
        return Check(name, "failed", "rows behind the follower's end are kept in `partial`", "cut them where the slider leaves")
    return Check(name, "passed")


def _impossible_start(bench: Bench) -> Check:
    """A follower bent so much that it does not reach the crank's tip."""
    name, length = "failures: a start that cannot be", bench.scene.follower.length
    x = np.linspace(0.0, length, 65)
    bent = CubicSpline(x, 0.45 * length * (x / length) ** 2)
    scene = changed(bench.scene, {"crank.length": length - bench.scene.pivot_distance - 1e-3})
    found = _attempt(bench, scene, Start(math.pi, standard_start(scene).crank_speed, bent), 0.01)
    if isinstance(found, Trajectory):
        cause = "a follower that is bent too much to reach the slider is simulated all the same"
        return Check(name, "failed", cause, "begin with engines.start_state.reconstruct, which raises EngineFailure")
    if isinstance(found, EngineFailure):
        wrong = _said(name, found)
        if wrong is not None:
            return wrong
        if found.time != 0.0:
            return Check(name, "failed", f"it fails at t = {found.time:g} s, not at 0", "raise EngineFailure in `prepare`, at time 0")
    return Check(name, "passed")


def _explodes(bench: Bench) -> Check:
    """A follower a thousand times as stiff, with settings for a soft one: a fixed step is unstable there."""
    name = "failures: a step that explodes"
    scene = changed(bench.scene, {"follower.bending_stiffness": 2e4})
    found = _attempt(bench, scene, standard_start(scene), 0.1)
    if isinstance(found, EngineFailure):
        return _said(name, found) or Check(name, "passed", f"said: {found.cause}")
    if isinstance(found, Refusal):
        return Check(name, "passed", f"refused: {found}")
    largest = float(np.abs(found["tip_deflection"]).max())
    if largest > 0.1 * scene.follower.length:
        cause = f"a follower a thousand times as stiff bends by {largest:.3g} m, in silence"
        return Check(name, "failed", cause, f"watch the size of the state: {_RAISE}")
    return Check(name, "passed")
