"""MuJoCo's model of a scene, with the follower as a chain of rigid links; its natural frequencies and fastest rate.

N hinges are at (j - 1/2) h, h = L/N. Between them are N - 1 links of length h, half a link is on the base, and half a link with the tip
body at the end. Links are uniform rods and hinges have the stiffness EI/h, so that the errors of order h² of inertia and stiffness cancel
in the interior. The rest is of order h⁴ (see centre_line.py for the last term of order h²).
"""

import math

import mujoco
import numpy as np
import scipy  # whose linear algebra is imported when it is used

from quickreturn.engines.mujoco.centre_line import centre_line_coefficients
from quickreturn.engines.mujoco.settings import hinge_count
from quickreturn.engines.units import Units
from quickreturn.reference_model.arrays import Array, eigh
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.rigid import stiffness_across
from quickreturn.reference_model.scene_values import changed

#: Smallest mass and inertia of a body in units of the scene (`engines.units`): MuJoCo refuses 1e-15 and less. The inertia of a link of
#: a chain of 256 is some 5e-9.
_LEAST = 2e-15
_AXIS = (0.0, 0.0, 1.0)


def build(scene: Scene, hinges: int, armature: float) -> mujoco.MjModel:
    """MuJoCo's model. Coordinates: the crank's angle if it is free, the angle of the follower's first piece, the hinges' angles.

    Args:
        scene: with or without crank.
        hinges: N, 0 for a rigid follower.
        armature: inertia added to every hinge's own motion, kg m^2.
    """
    spec = mujoco.MjSpec()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.gravity = (*scene.gravity, 0.0)
    # After a bad acceleration MuJoCo would reset the state and silently continue from the start.
    spec.option.disableflags = (
        mujoco.mjtDisableBit.mjDSBL_AUTORESET | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    )
    spec.nuserdata = 1  # holds the address of the control hook's context
    if scene.crank is not None and scene.crank_is_free:
        _add_crank(spec, scene)
    _add_follower(spec, scene, hinges, armature)
    return spec.compile()


def _add_crank(spec: mujoco.MjSpec, mechanism: Mechanism) -> None:
    part = mechanism.crank
    crank = add_body(spec.worldbody, "crank", 0.0, part.mass, part.center_of_mass, part.inertia)
    add_hinge(crank, damping=part.drive.damping)
    if mechanism.slider.mass > 0.0:
        add_body(crank, "slider", part.length, mechanism.slider.mass, 0.0, 0.0)


def _add_follower(spec: mujoco.MjSpec, scene: Scene, hinges: int, armature: float) -> None:
    follower, base, tip = scene.follower, scene.base, scene.tip
    body, place = spec.worldbody, scene.pivot_distance
    for number, piece in enumerate(pieces(follower.length, hinges)):
        mass = follower.mass_per_length * piece
        rod = mass * piece**2 / 12.0
        body = add_body(
            body, "base" if number == 0 else f"link {number}", place, mass, piece / 2.0, rod + (base.inertia if number == 0 else 0.0)
        )
        if number == 0:
            add_hinge(body, damping=base.damping)
        else:
            stiffness = follower.bending_stiffness * hinges / follower.length
            add_hinge(body, stiffness, follower.material_damping * stiffness, armature)
        place = piece
    if tip is not None:
        add_body(body, "tip", place, tip.mass, tip.center_of_mass, tip.inertia)


def pieces(length: float, hinges: int) -> list[float]:
    """Lengths of the rigid pieces from the base to the end, m: half a link, N - 1 links, half a link."""
    link = length / max(hinges, 1)
    return [link / 2.0, *[link] * (hinges - 1), link / 2.0] if hinges else [length]


def add_body(parent: mujoco.MjsBody, name: str, place: float, mass: float, center: float, inertia: float) -> mujoco.MjsBody:
    """A body with these properties, `place` along the parent's axis, its centre at `center` along its own; MuJoCo needs some mass."""
    turning = max(inertia, _LEAST)
    return parent.add_body(
        name=name,
        pos=(place, 0.0, 0.0),
        explicitinertial=True,
        mass=max(mass, _LEAST),
        ipos=(center, 0.0, 0.0),
        inertia=(turning, turning, turning),
    )


def add_hinge(body: mujoco.MjsBody, stiffness: float = 0.0, damping: float = 0.0, armature: float = 0.0) -> None:
    """A hinge at the body's origin, by the body's name, in the plane of the mechanism, with a linear spring and damper."""
    joint = body.add_joint(name=body.name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=_AXIS, armature=armature)
    cubic = np.ndim(joint.damping) == 1  # newer versions of MuJoCo take the coefficients of a cubic law, older ones one number
    joint.stiffness, joint.damping = ((linear, 0.0, 0.0) if cubic else linear for linear in (stiffness, damping))


def follower_matrices(model: mujoco.MjModel, mechanism: Scene, hinges: int) -> tuple[Array, Array]:
    """Mass (kg m^2) and stiffness (N m) matrices of the straight follower in base and hinge angles, crank held; (N + 1, N + 1)."""
    mass = mass_matrix(model)
    first = model.nv - hinges - 1
    stiffness = np.zeros(hinges + 1)
    if hinges:
        stiffness[1:] = mechanism.follower.bending_stiffness * hinges / mechanism.follower.length
    return mass[first:, first:], np.diag(stiffness)


def mass_matrix(model: mujoco.MjModel) -> Array:
    """MuJoCo's mass matrix at zero coordinates; `mj_fullM` has other arguments in older versions."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    for column, unit in zip(mass, np.eye(model.nv), strict=True):  # symmetric
        mujoco.mj_mulM(model, data, column, unit)
    return mass


def follower_damping(scene: Scene, hinges: int) -> Array:
    """Damping matrix (N m s) that goes with `follower_matrices`: of the base and the tip at rest, of the link centres and in the hinges."""
    lengths = np.full(hinges, scene.follower.length / max(hinges, 1))
    lengths[-1:] *= 0.5
    every_hinge = np.tril(np.ones((hinges, hinges)))  # turns its own link and every one beyond
    centres = (np.tril(every_hinge * lengths, -1) + np.diag(0.5 * lengths)) @ every_hinge
    damping = np.zeros((hinges + 1, hinges + 1))
    damping[0, 0] = scene.base.damping
    if scene.base.friction_torque > 0.0:
        damping[0, 0] += scene.base.friction_torque / scene.base.friction_rate
    damping[1:, 1:] = scene.follower.damping * (centres.T * lengths) @ centres
    if scene.follower.material_damping > 0.0:
        in_hinge = scene.follower.material_damping * scene.follower.bending_stiffness * hinges / scene.follower.length
        damping[1:, 1:] += in_hinge * np.eye(hinges)
    if (tip := scene.tip_body).friction_force > 0.0:
        levers = np.append(scene.follower.length, np.cumsum(lengths[::-1])[::-1])
        damping += tip.friction_force / tip.friction_speed * np.outer(levers, levers)
    return damping


def natural_frequencies(mechanism: Mechanism, crank_angle: float, count: int, links: int) -> Array:
    """Lowest `count` frequencies, Hz, of the straight chain supported at the slider; none for a rigid follower on a rigid joint.

    The hinges have no armature here, which serves the time integration only.
    """
    units = Units.of(mechanism)
    mechanism, hinges = units.scene(mechanism), hinge_count(mechanism, links)
    held = changed(mechanism, {"crank.prescribed_speed": 0.0})
    mass, stiffness = follower_matrices(build(held, hinges, 0.0), held, hinges)
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


def support_row(mechanism: Mechanism, hinges: int, crank_angle: float) -> Array:
    """Transverse displacement of the straight follower at the slider per base and hinge angle, m, shape (N + 1,)."""
    arm = mechanism.crank.length
    return row_at(mechanism, hinges, math.hypot(mechanism.pivot_distance - arm * math.cos(crank_angle), arm * math.sin(crank_angle)))


def row_at(mechanism: Mechanism, hinges: int, x: float) -> Array:
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
    mass, stiffness = follower_matrices(model, scene, hinges)
    damping = follower_damping(scene, hinges)
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


def _stable_step(mass: Array, damping: Array, stiffness: Array) -> float:
    """Longest stable step h (s) of `time_loop` for M q'' + D q' + K q = 0: at it 4 M - 7 h D - h² K is singular.

    The quickest motion then changes its sign from step to step: see `time_loop._step` with a(t + h) = -a(t).
    """
    zero, inverse = np.zeros_like(mass), np.linalg.inv(mass)
    of_one_over_h = np.block([[zero, np.eye(len(mass))], [inverse @ stiffness / 4.0, inverse @ damping * 7.0 / 4.0]])
    fastest = float(np.max(np.linalg.eigvals(of_one_over_h).real))
    return 1.0 / fastest if fastest > 0.0 else math.inf
