"""The constants of a scene by their symbols, for the equations of motion of any model (DERIVATION.md, section 1), SI."""

import math
from typing import Any, Final

import numpy as np

from quickreturn.reference_model.drive import over_angle
from quickreturn.reference_model.mechanism import Drive, MotorCurve, PrescribedMotion, Scene, TorqueDrive
from quickreturn.reference_model.rigid import slow_speed
from quickreturn.reference_model.table import TURN, pieces
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


def _of_drive(scene: Scene) -> dict[str, Any]:
    if scene.crank is None:
        spin_up = {"base_speed": scene.spin_up.speed, "base_time": scene.spin_up.time}
        return {**dict.fromkeys(_OF_CRANK, 0.0), **drive_constants(None), **spin_up}
    drive = scene.crank.drive
    torque = drive.torque if isinstance(drive, TorqueDrive) else 0.0
    turning = (scene.crank_mass, scene.crank_inertia, scene.crank_moment)
    values = (scene.pivot_distance, scene.crank.length, *turning, torque, drive.damping, scene.slider.inertia)
    return {**dict(zip(_OF_CRANK, values, strict=True)), **drive_constants(drive), "base_speed": 0.0, "base_time": 0.0}


def drive_constants(drive: Drive | None) -> dict[str, Any]:
    """The constants of the drive's table by their symbols; `drive_table`, as of `pieces`, is (0, 5) without one.

    It gives the speed at the angle q1, at the point `drive_way` (q1 - `drive_begin`) modulo `drive_period`, which is 0 for a speed over
    time; or with a `drive_way` of 0 the torque at the speed of a free crank.
    """
    match drive:
        case MotorCurve(torque_table=table):
            values = (0.0, 0.0, 0.0, pieces(table))
        case PrescribedMotion(speed_table=table) if table.over_turn:
            values = (table.points[0], 1.0, TURN, pieces(table))
        case PrescribedMotion(speed_table=table, begins_at=angle):
            values = (angle, math.copysign(1.0, table.values[0][0]), 0.0, over_angle(table))
        case _:
            values = (0.0, 0.0, 0.0, np.zeros((0, 5)))
    return dict(zip(("drive_begin", "drive_way", "drive_period", "drive_table"), values, strict=True))


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
