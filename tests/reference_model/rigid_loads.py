"""Loads on the rigid mechanism in closed form (reference_model/DERIVATION.md, section 9): a witness of the models' internal forces."""

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import follower_inertia, rigid_kinetostatics, rigid_motion, spring_across, tool_across
from quickreturn.reference_model.spring import pull_of
from quickreturn.reference_model.tip import tip_force


def rigid_bearing_forces(
    mechanism: Mechanism, crank_angle: Array, crank_speed: Array | float, crank_acceleration: Array | float = 0.0
) -> tuple[Array, Array]:
    """Forces (N, along n1 and n2) of the ground on the follower's base at P and on the crank at O for a given motion, equation 9.10."""
    motion = rigid_motion(mechanism, crank_angle, crank_speed, crank_acceleration)
    force = rigid_kinetostatics(mechanism, crank_angle, crank_speed, crank_acceleration)[0]
    q1, gravity = np.asarray(crank_angle, dtype=float), complex(*mechanism.gravity)
    along, arm = np.exp(1j * motion.follower_angle), np.exp(1j * q1)
    mass = mechanism.follower.mass + mechanism.tip_body.mass
    tool = tip_force(mechanism.tip_body, q1, motion.follower_angle)
    swing = 1j * motion.follower_acceleration - motion.follower_speed**2
    at_pivot = (follower_inertia(mechanism)[1] * swing - 1j * force) * along - mass * gravity - tool
    if (spring := mechanism.acting_spring) is not None:
        place = spring.place_on(mechanism.follower.length) * along
        at_pivot -= pull_of(spring, mechanism.pivot_distance + place, 1j * motion.follower_speed * place).force
    swing = 1j * np.asarray(crank_acceleration) - np.square(crank_speed)
    at_crank = mechanism.crank_moment * swing * arm + 1j * force * along - mechanism.crank_mass * gravity
    return np.array([at_pivot.real, at_pivot.imag]), np.array([at_crank.real, at_crank.imag])


def rigid_axial_force(
    mechanism: Mechanism, place: float | Array, crank_angle: Array, crank_speed: Array | float, crank_acceleration: Array | float = 0.0
) -> Array:
    """Normal force (N) at the arc length `place` (m) for a given motion, positive where it pulls: the loads outboard of it along the arm.

    An element of a turning arm is pulled by rho A omega^2 r dr, and by its weight; a slider without friction does not push along the arm.
    The other arguments are as of `rigid_motion`.
    """
    motion = rigid_motion(mechanism, crank_angle, crank_speed, crank_acceleration)
    beam, tip, q2 = mechanism.follower, mechanism.tip_body, motion.follower_angle
    tool = tip_force(tip, np.asarray(crank_angle, dtype=float), q2)
    weight = np.cos(q2) * mechanism.gravity[0] + np.sin(q2) * mechanism.gravity[1]
    turning = beam.mass_per_length * (beam.length**2 - place**2) / 2.0 + tip.mass * (beam.length + tip.center_of_mass)
    outboard = beam.mass_per_length * (beam.length - place) + tip.mass
    force = turning * motion.follower_speed**2 + outboard * weight + np.cos(q2) * tool.real + np.sin(q2) * tool.imag
    if (spring := mechanism.acting_spring) is not None:
        at, along = spring.place_on(beam.length), np.exp(1j * q2)
        pull = pull_of(spring, mechanism.pivot_distance + at * along, 1j * motion.follower_speed * at * along)
        force = force + np.where((place < at) | (at == beam.length), (pull.force / along).real, 0.0)
    return np.asarray(force)


def rigid_bending_moment(
    mechanism: Mechanism, place: float | Array, crank_angle: Array, crank_speed: Array | float, crank_acceleration: Array | float = 0.0
) -> Array:
    """Bending moment (N m) at the arc length `place` (m) for a given motion, from the loads outboard of it, equation 9.11.

    A column of places gives a row for each. The other arguments are as of `rigid_motion`.
    """
    motion = rigid_motion(mechanism, crank_angle, crank_speed, crank_acceleration)
    force = rigid_kinetostatics(mechanism, crank_angle, crank_speed, crank_acceleration)[0]
    beam, tip, q1 = mechanism.follower, mechanism.tip_body, np.asarray(crank_angle, dtype=float)
    q2, alpha, beyond = motion.follower_angle, motion.follower_acceleration, beam.length - place
    across = np.cos(q2) * mechanism.gravity[1] - np.sin(q2) * mechanism.gravity[0]
    moment = 0.5 * beam.mass_per_length * beyond**2 * (across - (2.0 * beam.length + place) / 3.0 * alpha)
    moment += tip.mass * (across - (beam.length + tip.center_of_mass) * alpha) * (beyond + tip.center_of_mass) - tip.inertia * alpha
    moment += tool_across(mechanism, q1, motion) * beyond
    if (spring := mechanism.acting_spring) is not None:
        moment += spring_across(mechanism, motion) * np.maximum(spring.place_on(beam.length) - place, 0.0)
    inboard = force * (motion.slider_position - place) - mechanism.slider.inertia * alpha
    return np.asarray(moment + np.where(place < motion.slider_position, inboard, 0.0))
