"""MuJoCo's model of a scene, with the follower as a chain of rigid links.

N hinges are at (j - 1/2) h, h = L/N. Between them are N - 1 links of length h, half a link is on the base, and half a link with the tip
body at the end. Links are uniform rods and hinges have the stiffness EI/h, so that the errors of order h² of inertia and stiffness cancel
in the interior. The rest is of order h⁴ (see centre_line.py for the last term of order h²).
"""

import mujoco
import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.mechanism import Mechanism, Scene, TorqueDrive

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
    if scene.crank is not None and isinstance(scene.crank.drive, TorqueDrive):
        _add_crank(spec, scene, scene.crank.drive)
    _add_follower(spec, scene, hinges, armature)
    return spec.compile()


def _add_crank(spec: mujoco.MjSpec, mechanism: Mechanism, drive: TorqueDrive) -> None:
    part = mechanism.crank
    crank = add_body(spec.worldbody, "crank", 0.0, part.mass, part.center_of_mass, part.inertia)
    add_hinge(crank, damping=drive.damping)
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


def follower_matrices(model: mujoco.MjModel, mechanism: Scene, hinges: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mass (kg m^2) and stiffness (N m) matrices of the straight follower in base and hinge angles, crank held; (N + 1, N + 1)."""
    mass = mass_matrix(model)
    first = model.nv - hinges - 1
    stiffness = np.zeros(hinges + 1)
    if hinges:
        stiffness[1:] = mechanism.follower.bending_stiffness * hinges / mechanism.follower.length
    return mass[first:, first:], np.diag(stiffness)


def mass_matrix(model: mujoco.MjModel) -> NDArray[np.float64]:
    """MuJoCo's mass matrix at zero coordinates; `mj_fullM` has other arguments in older versions."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    for column, unit in zip(mass, np.eye(model.nv), strict=True):  # symmetric
        mujoco.mj_mulM(model, data, column, unit)
    return mass


def follower_damping(scene: Scene, hinges: int) -> NDArray[np.float64]:
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
