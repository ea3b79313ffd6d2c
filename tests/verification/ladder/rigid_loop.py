"""The rigid mechanism in closed form, by logarithms of complex numbers; nothing here is used by an engine.

With c = LA exp(i q1) - d = s exp(i q2) the logarithm log c = log s + i q2 gives place and rates of the follower at once.
"""

from dataclasses import dataclass

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism


@dataclass(frozen=True)
class RigidLoop:
    """Motion and forces at given crank angle, speed and acceleration; arrays of the crank angle's shape."""

    slider_position: Array  # s, m
    follower_angle: Array  # q2, rad, within 90 degrees of 180 degrees
    follower_speed: Array  # rad/s
    follower_acceleration: Array  # rad/s^2
    slider_force: Array  # on the follower, along its normal, N
    torque: Array  # all that the motor must give, the crank's damping included, N m


def rigid_loop(mechanism: Mechanism, crank_angle: Array, crank_speed: Array | float, crank_acceleration: Array | float = 0.0) -> RigidLoop:
    """Kinematics and kinetostatics; the bending stiffness is not used, the slider has no inertia of rotation."""
    crank, beam, tip = mechanism.crank, mechanism.follower, mechanism.tip_body
    arm = crank.length * np.exp(1j * np.asarray(crank_angle))
    c = arm - mechanism.pivot_distance
    first = 1j * arm * crank_speed / c
    second = (1j * crank_acceleration - np.square(crank_speed)) * arm / c - first**2
    s, q2 = np.abs(c), np.pi + np.angle(-c)
    direction = c / s
    gravity = complex(*mechanism.gravity)

    reach = beam.length + tip.center_of_mass
    inertia = mechanism.base.inertia + beam.mass_per_length * beam.length**3 / 3.0 + tip.inertia + tip.mass * reach**2
    moment = beam.mass_per_length * beam.length**2 / 2.0 + tip.mass * reach
    weight = moment * np.imag(np.conj(direction) * gravity)
    force = (inertia * second.imag + mechanism.base.damping * first.imag - weight) / s
    # power of all that acts on the crank but the motor, over its speed: inertia, damping, weight, and the slider force at the crank tip
    carried = crank.inertia_about_pivot + mechanism.slider.mass * crank.length**2
    first_moment = crank.mass * crank.center_of_mass + mechanism.slider.mass * crank.length
    torque = carried * np.asarray(crank_acceleration) + getattr(crank.drive, "damping", 0.0) * np.asarray(crank_speed)
    torque = torque - first_moment * np.imag(np.conj(arm / crank.length) * gravity)
    torque = torque + force * np.imag(np.conj(arm) * 1j * direction)
    return RigidLoop(s, q2, first.imag, second.imag, force, torque)
