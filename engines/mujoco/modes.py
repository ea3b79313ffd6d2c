"""Natural frequencies of the straight follower with the crank held, and the fastest rate that an integrator must follow."""

import math

import mujoco
import numpy as np
import scipy  # whose linear algebra is imported when it is used
from numpy.typing import NDArray

from quickreturn.engines.mujoco import chain
from quickreturn.engines.mujoco.centre_line import centre_line_coefficients
from quickreturn.engines.mujoco.settings import hinge_count
from quickreturn.engines.units import Units
from quickreturn.reference_model.eigenproblem import eigh
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.rigid import stiffness_across
from quickreturn.reference_model.scene_values import changed


def natural_frequencies(mechanism: Mechanism, crank_angle: float, count: int, links: int) -> NDArray[np.float64]:
    """Lowest `count` frequencies, Hz, of the straight chain supported at the slider; none for a rigid follower on a rigid joint.

    The hinges have no armature here, which serves the time integration only.
    """
    units = Units.of(mechanism)
    mechanism, hinges = units.scene(mechanism), hinge_count(mechanism, links)
    held = changed(mechanism, {"crank.prescribed_speed": 0.0})
    mass, stiffness = chain.follower_matrices(chain.build(held, hinges, 0.0), held, hinges)
    constraint = support_row(mechanism, hinges, crank_angle)
    if (spring := mechanism.acting_spring) is not None:
        at_spring = row_at(mechanism, hinges, spring.place_on(mechanism.follower.length))
        stiffness = stiffness + stiffness_across(mechanism, crank_angle) * np.outer(at_spring, at_spring)
    if not mechanism.slider.is_rigid:
        free = np.eye(hinges + 1)
        stiffness = stiffness + mechanism.slider.closed_stiffness * np.outer(constraint, constraint)
    else:
        free = scipy.linalg.null_space(constraint[None, :])
    squares = eigh(free.T @ stiffness @ free, free.T @ mass @ free)[0] if free.size else np.empty(0)
    return np.sqrt(np.maximum(squares[:count], 0.0)) / (2.0 * math.pi * units.time)


def support_row(mechanism: Mechanism, hinges: int, crank_angle: float) -> NDArray[np.float64]:
    """Transverse displacement of the straight follower at the slider per base and hinge angle, m, shape (N + 1,)."""
    arm = mechanism.crank.length
    return row_at(mechanism, hinges, math.hypot(mechanism.pivot_distance - arm * math.cos(crank_angle), arm * math.sin(crank_angle)))


def row_at(mechanism: Mechanism, hinges: int, x: float) -> NDArray[np.float64]:
    """The same at the arc length x, m."""
    coefficients = centre_line_coefficients(x, hinges, mechanism.follower.length / max(hinges, 1), 0)
    return np.asarray(np.cumsum(coefficients[::-1])[::-1])  # a hinge turns every link beyond it


def stable_step(model: mujoco.MjModel, scene: Scene, hinges: int) -> float:
    """Longest step (s) for which `time_loop` is stable on the straight chain; infinite for a rigid follower on a rigid joint.

    A rigid joint lowers it and is left out. A compliant joint raises it, depending on the slider's place, and so does a spring, which
    counts as if its stop were touched and it stood across the follower. A base that turns as prescribed
    stays at rest. With a light base the damping, which opposes velocities relative to the base, makes one motion decay very fast, in which
    the first links turn against the others; it hardly slows the vibrations.
    """
    mass, stiffness = chain.follower_matrices(model, scene, hinges)
    damping = chain.follower_damping(scene, hinges)
    if scene.crank is None:
        return _stable_step(mass[1:, 1:], damping[1:, 1:], stiffness[1:, 1:])
    slider, spring = scene.slider, scene.acting_spring
    if spring is not None:
        row = row_at(scene, hinges, spring.place_on(scene.follower.length))
        place = np.outer(row, row)
        stiffness, damping = stiffness + (spring.stiffness + spring.stop_stiffness) * place, damping + spring.damping * place
    if slider.is_rigid:
        return _stable_step(mass, damping, stiffness)
    joint = sum(slider.sides) if slider.preload > 0.0 else max(slider.sides)
    blow_speed = scene.crank.length * abs(scene.crank.drive.initial_speed)
    limits = []
    for crank_angle in np.linspace(0.0, math.pi, 13):
        row = support_row(scene, hinges, crank_angle)
        place = np.outer(row, row)
        # a blow at the speed v has the force v sqrt(k m), with m the mass at the slider, and the damping is in proportion to the force
        blow = slider.contact_damping * blow_speed * math.sqrt(joint / float(row @ np.linalg.solve(mass, row)))
        limits.append(_stable_step(mass, damping + (slider.joint_damping + blow) * place, stiffness + joint * place))
    return min(limits)


def _stable_step(mass: NDArray[np.float64], damping: NDArray[np.float64], stiffness: NDArray[np.float64]) -> float:
    """Longest stable step h (s) of `time_loop` for M q'' + D q' + K q = 0: at it 4 M - 7 h D - h² K is singular.

    The quickest motion then changes its sign from step to step: see `time_loop._step` with a(t + h) = -a(t).
    """
    zero, inverse = np.zeros_like(mass), np.linalg.inv(mass)
    of_one_over_h = np.block([[zero, np.eye(len(mass))], [inverse @ stiffness / 4.0, inverse @ damping * 7.0 / 4.0]])
    fastest = float(np.max(np.linalg.eigvals(of_one_over_h).real))
    return 1.0 / fastest if fastest > 0.0 else math.inf
