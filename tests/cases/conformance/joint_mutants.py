"""Mistakes with the slider's joint, with friction and with the material's damping, and the change of the scene that finds them."""

import math
from typing import Any

from quickreturn.reference_model.mechanism import Mechanism
from tests.cases.conformance.mutants import Mutant, of_scene
from tests.cases.conformance.third_mutants import of_pair


def _exchanged(m: Mechanism) -> dict[str, Any]:
    plus, minus = m.slider.joint_stiffness_plus, m.slider.joint_stiffness_minus
    return {"slider.joint_stiffness_plus": minus, "slider.joint_stiffness_minus": plus}


def _same_way_always(m: Mechanism) -> dict[str, Any]:
    """Friction that does not turn round with the slider: a start on the way out finds it driving."""
    outwards = m.slider.has_friction and 0.0 < m.crank.initial_angle < math.pi
    return {"slider.friction_speed": -m.slider.friction_speed} if outwards else {}


def _softer_of_both(m: Mechanism) -> dict[str, Any]:
    softer = min(m.slider.joint_stiffness_plus, m.slider.joint_stiffness_minus)
    return {"slider.joint_stiffness_plus": softer, "slider.joint_stiffness_minus": softer}


#: Name -> the engine, a regular expression that the cause must match, and the change in which it is found.
JOINT: dict[str, tuple[type[Mutant], str, str]] = {
    "rollers exchanged, plus": (of_pair(_exchanged), "two rollers is exchanged", "slider.joint_stiffness_plus"),
    "rollers exchanged, minus": (of_pair(_exchanged), "two rollers is exchanged", "slider.joint_stiffness_minus"),
    "softer roller on either side": (of_pair(_softer_of_both), "joint_stiffness_minus is not followed", "slider.joint_stiffness_minus"),
    "clearance doubled": (of_scene(slider__clearance=lambda x: 2.0 * x), "clearance acts .*twice", "slider.clearance"),
    "clearance ignored": (of_scene(slider__clearance=0.0), "clearance is ignored", "slider.clearance"),
    "preload ignored": (of_scene(slider__preload=0.0), "preload is ignored", "slider.preload"),
    "contact damping halved": (of_scene(slider__contact_damping=lambda x: 0.5 * x), "acts .*half", "slider.contact_damping"),
    "friction ignored": (of_scene(slider__friction=0.0), "moving outwards is ignored", "slider.friction, the slider moving outwards"),
    "friction without sign": (
        of_pair(_same_way_always),
        "outwards acts with the wrong sign",
        "slider.friction, the slider moving outwards",
    ),
    "drag twice": (of_scene(slider__friction_force=lambda x: 2.0 * x), "friction_force acts .*twice", "slider.friction_force"),
    "pivot without friction": (of_scene(base__friction_torque=0.0), "friction_torque is ignored", "base.friction_torque"),
    "material twice as damped": (
        of_scene(follower__material_damping=lambda x: 2.0 * x),
        "material_damping acts .*twice",
        "follower.material_damping",
    ),
}
