"""The rigid quick-return mechanism in closed form: kinematics and kinetostatics (DERIVATION.md, section 9).

Everything is vectorised over the crank angle. It is the limit of infinite bending stiffness, and the start of every case.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Base, Mechanism, MotorCurve, PrescribedMotion, PrescribedSpeed, Scene, TorqueDrive
from quickreturn.reference_model.spring import pull_of, spring_stiffness
from quickreturn.reference_model.tip import slide_friction, tip_force


@dataclass(frozen=True)
class RigidMotion:
    """Slider and follower for given crank angle, speed and acceleration; each array of the crank angle's shape."""

    slider_position: Array  # m, |PC|
    slider_speed: Array  # m/s
    slider_acceleration: Array  # m/s^2, second derivative of the arc length
    follower_angle: Array  # rad, see `follower_angle`
    follower_speed: Array  # rad/s
    follower_acceleration: Array  # rad/s^2


def follower_angle(mechanism: Mechanism, crank_angle: Array) -> Array:
    """Direction from P to the slider, rad: continuous over the crank's angle, and equal to it where that is 180 deg (equation 9.1).

    It is within 90 deg of 180 deg for a follower that swings, and within 90 deg of the crank's angle for one that turns fully.
    """
    d, LA, cosine, sine = mechanism.pivot_distance, mechanism.crank.length, np.cos(crank_angle), np.sin(crank_angle)
    if mechanism.turns_fully:
        return np.asarray(crank_angle + np.arctan2(d * sine, LA - d * cosine))
    return np.asarray(np.pi + np.arctan2(-LA * sine, d - LA * cosine))


def rigid_motion(
    mechanism: Mechanism, crank_angle: Array, crank_speed: Array | float, crank_acceleration: Array | float = 0.0
) -> RigidMotion:
    """Kinematics of the rigid mechanism, equations 9.1 to 9.5.

    Args:
        mechanism: gives d and LA.
        crank_angle: q1, rad.
        crank_speed: rad/s.
        crank_acceleration: rad/s^2.
    """
    d, LA = mechanism.pivot_distance, mechanism.crank.length
    q1 = np.asarray(crank_angle, dtype=float)
    v1, v2 = LA * np.cos(q1) - d, LA * np.sin(q1)  # P to C
    s = np.hypot(v1, v2)
    q2 = follower_angle(mechanism, q1)
    # crank tip velocity and acceleration along and across the follower: phi is the crank's angle relative to the follower
    along, across = np.cos(q1 - q2), np.sin(q1 - q2)
    s_rate = -LA * crank_speed * across
    q2_rate = LA * crank_speed * along / s
    radial = -LA * (crank_acceleration * across + np.square(crank_speed) * along)
    transverse = LA * (crank_acceleration * along - np.square(crank_speed) * across)
    return RigidMotion(s, s_rate, radial + s * q2_rate**2, q2, q2_rate, (transverse - 2.0 * s_rate * q2_rate) / s)


def follower_inertia(mechanism: Mechanism) -> tuple[float, float]:
    """Rigid follower with base block and tip body: moment of inertia about P (kg m^2) and first moment (kg m), equation 9.6."""
    beam = mechanism.follower
    tip = mechanism.tip_body
    arm = beam.length + tip.center_of_mass
    inertia = mechanism.base.inertia + beam.mass_per_length * beam.length**3 / 3.0 + tip.inertia + tip.mass * arm**2
    return inertia, 0.5 * beam.mass_per_length * beam.length**2 + tip.mass * arm


def pivot_torque(base: Base, rate: Array) -> Array:
    """Torque (N m) of the damping and friction in the pivot P against a follower that turns at `rate` (rad/s), equation 4.7."""
    return np.asarray(base.damping * rate + base.friction_torque * np.tanh(rate / base.friction_rate))


def crank_pace(mechanism: Mechanism) -> float:
    """Scale of the crank's speed, rad/s, not negative: the larger of the initial speed and that which its drive leads to, or gives it."""
    drive = mechanism.crank.drive
    if isinstance(drive, TorqueDrive | MotorCurve):
        return max(abs(drive.initial_speed), abs(drive.balanced_speed) if math.isfinite(drive.balanced_speed) else 0.0)
    return drive.speed_table.largest if isinstance(drive, PrescribedMotion) else abs(drive.speed)


#: Crank speed that counts as slow, over the speed of the start or of what the loads make of it: 1 rad/s in run 24.
SLOW: Final = 1.0 / 16.0


def slow_speed(scene: Scene) -> float:
    """Crank speed (rad/s, positive) that counts as slow: a part of the speed at the start, or of the speed that loads give within a radian.

    Where nothing moves, and for a follower alone, it is 1: its size does not matter.
    """
    if scene.crank is None:
        return 1.0
    drive, arm = scene.crank.drive, scene.crank.length
    torque = (drive.largest_torque if isinstance(drive, TorqueDrive | MotorCurve) else 0.0) + scene.tip_body.largest_force * arm
    if scene.acting_spring is not None:
        torque += abs(float(spring_across(scene, rigid_motion(scene, np.array(scene.crank.initial_angle), 0.0)))) * arm
    inertia = scene.crank_inertia + scene.follower.mass * arm**2
    loads = (torque / inertia if inertia > 0.0 else 0.0) + math.hypot(*scene.gravity) / scene.pivot_distance
    return SLOW * max(abs(drive.initial_speed), math.sqrt(loads)) or 1.0


@lru_cache(maxsize=64)
def mean_crank_speed(mechanism: Mechanism) -> float:
    """Mean speed (rad/s) of the crank in the periodic motion of the rigid mechanism, with all its loads and losses (equation 9.12).

    It is the initial speed where no torque drives the crank, the last speed that is prescribed over time, and 0 where the torque has no
    such motion: the crank stops on its way, or becomes faster for ever.
    """
    drive = mechanism.crank.drive
    if isinstance(drive, PrescribedMotion):
        table, turn = drive.speed_table, np.linspace(0.0, 2.0 * np.pi, 4096, endpoint=False)
        return 1.0 / float(np.mean(1.0 / table.at(turn))) if table.over_turn else table.values[0][-1]
    if isinstance(drive, PrescribedSpeed) or drive.largest_torque == 0.0:
        return drive.initial_speed
    way, at = math.copysign(1.0, drive.balanced_speed), np.arange(TURN_ANGLES)
    angle, apart = np.asarray(way * 2.0 * math.pi / TURN_ANGLES * at, dtype=np.float64), np.subtract.outer(at, at)
    slope = 0.5 * (-1.0) ** apart / np.sin(np.pi * apart / TURN_ANGLES + (apart == 0)) * (apart != 0)  # of a trigonometric polynomial

    def excess(speed: Array, acceleration: Array) -> Array:
        torque = drive.torque if isinstance(drive, TorqueDrive) else drive.torque_table.at(way * speed)
        return way * (torque - rigid_kinetostatics(mechanism, angle, way * speed, way * acceleration)[1])

    square = np.full(TURN_ANGLES, 0.5 * (crank_pace(mechanism) or slow_speed(mechanism)) ** 2)  # half the square of the speed
    for _ in range(MOST_STEPS):
        speed, acceleration = np.sqrt(2.0 * square), slope @ square
        left, small = excess(speed, acceleration), 1e-6 * speed
        by_speed = (excess(speed + small, acceleration) - excess(speed - small, acceleration)) / (2.0 * small)
        by_acceleration = excess(speed, acceleration + 1.0) - left
        try:
            step = np.linalg.solve(np.diag(by_speed / speed) + by_acceleration[:, None] * slope, -left)
        except np.linalg.LinAlgError:
            return 0.0
        if np.all(np.abs(step) < 1e-9 * square):
            return float(way / np.mean(1.0 / speed))
        square = np.maximum(square + step, 0.1 * square)
    return 0.0


#: Number of crank angles in a turn of the rigid mechanism, odd; with twice as many the mean speed of a machine whose tool begins and ends
#: its work in 20 degrees changes by 1e-7.
TURN_ANGLES: Final = 181
#: Largest number of Newton's steps to its periodic motion; random machines take up to twelve.
MOST_STEPS: Final = 25

#: Scale of the deflection, as a fraction of the follower's length, in scenes that deflect as much as the thesis' runs or more ...
USUAL_SCALE: Final = 0.01
#: ... and as a multiple of `static_deflection` in scenes that deflect less.
STATIC_SCALE: Final = 3.0


def deflection_scale(scene: Scene) -> float:
    """Scale (m) to which tolerances of the deflection refer (equation 5.10).

    It is `STATIC_SCALE` static deflections, at most `USUAL_SCALE` lengths; the latter for a rigid follower or a follower alone.
    """
    usual = USUAL_SCALE * scene.follower.length
    if scene.crank is None or scene.follower.is_rigid:
        return usual
    static = STATIC_SCALE * static_deflection(scene, crank_pace(scene))
    return min(usual, max(static, 1e-12 * usual)) if static > 0.0 else usual


def static_deflection(mechanism: Mechanism, crank_speed: float, angles: int = 48) -> float:
    """RMS over a turn of the tip deflection (m) that the loads of the rigid motion cause if applied statically, equation 9.9.

    Args:
        mechanism: the scene; the deflection of a rigid follower is 0.
        crank_speed: rad/s, constant.
        angles: number of crank angles at which the deflection is computed, evenly spaced.
    """
    beam, tip = mechanism.follower, mechanism.tip_body
    L, rhoA, EI = beam.length, beam.mass_per_length, beam.bending_stiffness
    q1: Array = np.linspace(0.0, 2.0 * np.pi, angles, endpoint=False)
    motion = rigid_motion(mechanism, q1, crank_speed)
    force = rigid_kinetostatics(mechanism, q1, crank_speed)[0]
    s, q2, alpha = motion.slider_position, motion.follower_angle, motion.follower_acceleration
    across = np.cos(q2) * mechanism.gravity[1] - np.sin(q2) * mechanism.gravity[0]
    at_tip = tip.mass * (across - (L + tip.center_of_mass) * alpha)
    tool = tool_across(mechanism, q1, motion)
    deflection = force * s**2 * (3.0 * L - s) / 6.0
    if (spring := mechanism.acting_spring) is not None:
        place = spring.place_on(L)
        deflection += spring_across(mechanism, motion) * place**2 * (3.0 * L - place) / 6.0
    deflection += rhoA * L**4 * (across / 8.0 - 11.0 * L * alpha / 120.0)
    deflection += (at_tip + tool) * L**3 / 3.0 + (at_tip * tip.center_of_mass - tip.inertia * alpha) * L**2 / 2.0
    return float(np.sqrt(np.mean((deflection / EI) ** 2)))


def rigid_kinetostatics(
    mechanism: Mechanism, crank_angle: Array, crank_speed: Array | float, crank_acceleration: Array | float = 0.0
) -> tuple[Array, Array]:
    """Slider force on the follower (N, along its normal) and drive torque on the crank (N m) for a given motion, equations 9.7 and 9.8.

    The drive torque is all that the motor must give, the crank's viscous damping included (a prescribed speed has none). The bending
    stiffness is not used. Arguments as of `rigid_motion`.
    """
    motion = rigid_motion(mechanism, crank_angle, crank_speed, crank_acceleration)
    inertia, moment = follower_inertia(mechanism)
    slider, crank = mechanism.slider, mechanism.crank
    g1, g2 = mechanism.gravity
    q1, q2 = np.asarray(crank_angle, dtype=float), motion.follower_angle
    inertia += slider.inertia  # the slider turns with the follower
    about_P = inertia * motion.follower_acceleration + pivot_torque(mechanism.base, motion.follower_speed)
    about_P -= moment * (np.cos(q2) * g2 - np.sin(q2) * g1) + mechanism.follower.length * tool_across(mechanism, q1, motion)
    if (spring := mechanism.acting_spring) is not None:
        about_P -= spring.place_on(mechanism.follower.length) * spring_across(mechanism, motion)
    force = about_P / motion.slider_position
    about_O = mechanism.crank_inertia * np.asarray(crank_acceleration) + crank.drive.damping * np.asarray(crank_speed)
    about_O -= mechanism.crank_moment * (np.cos(q1) * g2 - np.sin(q1) * g1)
    rubbing = (slider.friction * np.abs(force) + slider.friction_force) * np.tanh(motion.slider_speed / slider.friction_speed)
    # the follower pushes back on the crank tip with -force along its normal, and rubs along itself
    return force, about_O + crank.length * (force * np.cos(q1 - q2) - rubbing * np.sin(q1 - q2))


def tool_across(mechanism: Mechanism, crank_angle: Array, motion: RigidMotion) -> Array:
    """Force on the tip along the follower's normal, N, with the friction of the tool's slide."""
    tip, q2 = mechanism.tip_body, motion.follower_angle
    force = tip_force(tip, crank_angle, q2)
    rubbing = slide_friction(tip, mechanism.follower.length * motion.follower_speed + 0j)
    return np.asarray(np.cos(q2) * force.imag - np.sin(q2) * force.real + rubbing.real)


def spring_across(mechanism: Mechanism, motion: RigidMotion) -> Array:
    """Force of an acting spring on a rigid follower along its normal, N (equation 4.13)."""
    spring = mechanism.acting_spring
    assert spring is not None
    along = np.exp(1j * motion.follower_angle)
    place = spring.place_on(mechanism.follower.length) * along
    pull = pull_of(spring, mechanism.pivot_distance + place, 1j * motion.follower_speed * place)
    return np.asarray((pull.force / along).imag)


def stiffness_across(mechanism: Mechanism, crank_angle: float) -> float:
    """Stiffness of the spring (N/m) against small deflections across the straight follower (equation 7.2); 0 without one.

    It is that of spring and stops at their length there. Their force at that length is left out, as gravity is.
    """
    if (spring := mechanism.acting_spring) is None:
        return 0.0
    along = np.exp(1j * rigid_motion(mechanism, np.array(crank_angle), 0.0).follower_angle)
    place = mechanism.pivot_distance + spring.place_on(mechanism.follower.length) * along
    pull = pull_of(spring, place, 0.0 * place)
    return spring_stiffness(float(pull.length), spring.law) * float((pull.direction / along).imag) ** 2
