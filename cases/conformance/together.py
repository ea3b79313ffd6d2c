"""Check of all accepted quantities in one scene: quantities that are right one by one may be wrong in pairs."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

from quickreturn.cases.conformance.bench import Bench, Motion
from quickreturn.cases.conformance.checks import Check, Fault, Unjudged, check_by, some
from quickreturn.cases.conformance.motion import MistakesInMildScene, findings
from quickreturn.cases.mistakes import share_of
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import changed

#: Duration of the motion, s: three quarters of a turn.
_DURATION: Final = 0.4
#: Output step, s: an engine may integrate powers over its rows, and the pivot's damper slows the light base at a rate of 1 over 0.6 ms.
_OUTPUT_STEP: Final = 5e-4
#: Optional features of a scene: name -> values. Each is added if the engine accepts it.
PARTS: Final[Mapping[str, Mapping[str, Any]]] = {
    "crank.initial_angle": {"crank.initial_angle": 2.3},
    "mechanism.gravity": {"mechanism.gravity": (5.0, -7.0)},
    "base.damping": {"base.damping": 0.03},
    "follower.damping": {"follower.damping": 2.0},
    "tip.center_of_mass": {"tip.center_of_mass": 0.06, "tip.inertia": 4e-4},
    "tip.force": {"tip.force": (-1.0, 1.5), "tip.force_from": 3.3, "tip.force_to": 5.3},
    "slider.mass": {"slider.mass": 0.3},
    "slider.inertia": {"slider.inertia": 1e-3},
    "slider.joint_stiffness": {"slider.joint_stiffness": 2e4},
    "slider.joint_damping": {"slider.joint_damping": 40.0},
    "slider.joint_stiffness_minus": {
        "slider.joint_stiffness": math.inf, "slider.joint_stiffness_plus": 2e4, "slider.joint_stiffness_minus": 8e3
    },
    "slider.preload": {"slider.preload": 1.0},
    "slider.contact_damping": {"slider.contact_damping": 2.0},
    "slider.friction": {"slider.friction": 0.2, "slider.friction_speed": 0.1},
    "slider.friction_force": {"slider.friction_force": 0.5, "slider.friction_speed": 0.1},
    "base.friction_torque": {"base.friction_torque": 0.03},
    "follower.material_damping": {"follower.material_damping": 1e-3},
}  # fmt: skip
#: Largest part of an error that remains if a quantity that causes it is left out of the scene.
_VANISHES: Final = 0.3
_NAME: Final = "quantities together"


def together(bench: Bench, wrong: MistakesInMildScene) -> Iterator[Check]:
    """Check the scene with everything: its columns, and the quantities that are wrong together."""
    if wrong.motion:
        yield Check(_NAME, "not judged", "the motion in the mild scene is wrong already", "mend that first")
    else:
        yield check_by(_NAME, _look, bench, wrong)


def _look(bench: Bench, wrong: MistakesInMildScene) -> str:
    scene, parts = everything(bench)
    motion = Motion(scene, _DURATION, _OUTPUT_STEP)
    try:
        wrong_columns = findings(bench, motion, wrong.columns)
    except EngineFailure as failure:
        raise Fault(f"with {', '.join(parts)} at once the run breaks down: {failure.cause}", failure.advice) from failure
    if not wrong_columns:
        return f"{len(parts)} at once: {', '.join(parts)}"
    if len(wrong_columns) <= 2 and all(finding.explained for finding in wrong_columns.values()):
        raise Fault("; ".join(finding.cause for finding in wrong_columns.values()), next(iter(wrong_columns.values())).advice)
    off = bench.errors(motion)
    worst = max(wrong_columns, key=lambda name: off[name])
    told = f"with everything at once {worst} is off by {share_of(off[worst])}"
    if not (concerned := [name for name in parts if _vanishes_without(bench, name, parts, worst, off[worst])]):
        raise Fault(f"{told}; no single quantity is to blame ({', '.join(parts)})", "leave out one after the other")
    names = " and ".join(concerned) if len(concerned) <= 2 else some(concerned)
    raise Fault(f"{told}; it is not without {names.replace(' and ', ', nor without ')}", f"look where {names} act together")


def everything(bench: Bench) -> tuple[Mechanism, list[str]]:
    """The scene, and its optional features. Raises Unjudged if the engine accepts none."""
    scene, parts = bench.scene, list[str]()
    for name in PARTS:
        try:
            other = changed(scene, PARTS[name])
            bench.engine.check(other)
        except (Refusal, ImpossibleMechanism):  # or a part of a joint that the engine does not have
            continue
        scene, parts = other, [*parts, name]
    if len(parts) < 2:
        raise Unjudged("the engine accepts nothing beside what the mild scene has")
    return scene, parts


def _vanishes_without(bench: Bench, name: str, parts: list[str], column: str, off: float) -> bool:
    """Whether a column is right in the scene without one of its parts."""
    scene = bench.scene
    try:
        for other in parts:
            if other != name:
                scene = changed(scene, PARTS[other])
        bench.engine.check(scene)
        return bench.errors(Motion(scene, _DURATION, _OUTPUT_STEP)).get(column, 0.0) <= _VANISHES * off
    except (Refusal, EngineFailure, ImpossibleMechanism):  # a damper needs its spring
        return False
