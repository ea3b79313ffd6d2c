"""The constants of a scene by their symbols, for the equations of motion of any model (DERIVATION.md, section 1), SI."""

import math
from typing import Any, Final

import numpy as np

from quickreturn.reference_model.mechanism import Scene, TorqueDrive
from quickreturn.reference_model.rigid import slow_speed
from quickreturn.reference_model.tip import tool_constants

#: `pace` over the slow speed of a crank, at least: it is then six times the crank's own speed.
PACE_OF_CRANK: Final = 96.0

_OF_CRANK = ("d", "LA", "crank_mass", "crank_inertia", "crank_moment", "torque", "crank_damping", "slider_inertia")


def constants(scene: Scene) -> dict[str, Any]:
    """Symbol -> value. Those of crank and slider are zero for a follower alone, torque and damping for a prescribed crank speed."""
    follower, tip = scene.follower, scene.tip_body
    return {
        **_of_drive(scene),
        "L": follower.length,
        "base_inertia": scene.base.inertia,
        "base_damping": scene.base.damping,
        "rhoA": follower.mass_per_length,
        "beam_damping": follower.damping,
        "tip_mass": tip.mass,
        "tip_inertia": tip.inertia,
        "tip_offset": tip.center_of_mass,
        **tool_constants(tip),
        "gravity_1": scene.gravity[0],
        "gravity_2": scene.gravity[1],
        "extreme_fibre": follower.extreme_fibre,
        "gauges": np.array(follower.strain_gauges, dtype=float),
    }


def _of_drive(scene: Scene) -> dict[str, float]:
    if scene.crank is None:
        return {**dict.fromkeys(_OF_CRANK, 0.0), "base_speed": scene.spin_up.speed, "base_time": scene.spin_up.time}
    drive = scene.crank.drive
    torque, damping = (drive.torque, drive.damping) if isinstance(drive, TorqueDrive) else (0.0, 0.0)
    turning = (scene.crank_mass, scene.crank_inertia, scene.crank_moment)
    values = (scene.pivot_distance, scene.crank.length, *turning, torque, damping, scene.slider.inertia)
    return {**dict(zip(_OF_CRANK, values, strict=True)), "base_speed": 0.0, "base_time": 0.0}


def characteristic_frequency(scene: Scene, shapes: int) -> float:
    """Frequency (1/s) for the sizes of rates: near that of the first bending mode; `slow_speed` for a follower without shapes."""
    follower = scene.follower
    if shapes and follower.mass_per_length > 0.0:
        return 10.0 * math.sqrt(follower.bending_stiffness / follower.mass_per_length) / follower.length**2
    return slow_speed(scene)


def pace(scene: Scene, shapes: int) -> float:
    """Rate (1/s) of the quicker of bending and crank, for the integrator's smallest steps and the slider's feedback (equation 5.8)."""
    of_crank = 0.0 if scene.crank is None else PACE_OF_CRANK * slow_speed(scene)
    return max(characteristic_frequency(scene, shapes), of_crank)


def crank_speed_scale(scene: Scene, crank_speed: float) -> float:
    """Size of the crank's speed (rad/s), to which the relative tolerance refers: a tenth, also of a crank that has almost stopped."""
    return 0.1 * max(abs(crank_speed), slow_speed(scene))


def unslowed(modes: int) -> int:
    """How many of `modes` modes the added inertia leaves unslowed: half of them and one, at least three (equation 5.15)."""
    return min(modes, max(modes // 2 + 1, 3))
