"""MuJoCo's model of a scene by MuJoCo's own means, and the matrices of its straight chain.

The follower is N links of the length h = L/N: one hinge at P, N - 1 hinges of stiffness EI/h between the links. Each link has two boxes,
the walls of a slot along its middle line. The slider is a sphere on the crank's end, the pin. MuJoCo's contact keeps it in the slot.

The contact has no friction: a pin that rubs rattles from wall to wall at the chain's corners. With a friction coefficient of 0.1 run 24 was
off by 58 %, by 3 % with a contact four times as soft, and by 70 % with that contact and a seventh of the step. No estimate could bound
such an error.
"""

import math
from typing import Any, Final

import mujoco
import numpy as np
import scipy  # whose linear algebra is imported when it is used

from quickreturn.engines.mujoco.chain import add_body, add_hinge
from quickreturn.engines.units import Units
from quickreturn.reference_model.arrays import Array, eigh
from quickreturn.reference_model.mechanism import Mechanism, TorqueDrive

#: Radius of the pin over the follower's length, and half the thickness of the slot's walls over that.
PIN: Final = 0.008
#: Bits of the geometries that touch: the pin touches the walls, walls do not touch each other.
_WALL, _PIN = 1, 2


def build(scene: Mechanism, links: int, step: float, contact_time: float, armature: float) -> mujoco.MjModel:
    """MuJoCo's model. Coordinates: the angle of the crank, that of the first link, the hinges' angles.

    Args:
        scene: the mechanism, in units of its own.
        links: number of boxes.
        step: time step.
        contact_time: time constant of the contact.
        armature: inertia added to every hinge's own motion.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = (*scene.gravity, 0.0)
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # the sparse Newton solver of MuJoCo 4.0.0 is wrong
    # After a bad acceleration MuJoCo would reset the state and silently continue from the start.
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_AUTORESET
    spec.option.enableflags = mujoco.mjtEnableBit.mjENBL_ENERGY
    contact: dict[str, Any] = {"condim": 1, "solref": (contact_time, 1.0), "mass": 0.0}
    _add_crank(spec, scene, contact)
    _add_follower(spec, scene, links, armature, contact)
    return spec.compile()


def reach_of_pin(scene: Mechanism) -> float:
    """Distance of the slot's walls from the follower's centre line: the pin's radius and half the clearance."""
    return PIN * scene.follower.length + scene.slider.clearance / 2.0


def _add_crank(spec: mujoco.MjSpec, scene: Mechanism, contact: dict[str, Any]) -> None:
    part, drive = scene.crank, scene.crank.drive
    assert isinstance(drive, TorqueDrive)
    crank = add_body(spec.worldbody, "crank", 0.0, part.mass, part.center_of_mass, part.inertia)
    add_hinge(crank, damping=drive.damping)
    slider = crank if scene.slider.mass == 0.0 else add_body(crank, "slider", part.length, scene.slider.mass, 0.0, 0.0)
    place = (part.length if slider is crank else 0.0, 0.0, 0.0)
    sphere, size = mujoco.mjtGeom.mjGEOM_SPHERE, (PIN * scene.follower.length, 0.0, 0.0)
    slider.add_geom(name="pin", type=sphere, size=size, pos=place, contype=_PIN, conaffinity=_WALL, **contact)


def _add_follower(spec: mujoco.MjSpec, scene: Mechanism, links: int, armature: float, contact: dict[str, Any]) -> None:
    follower, tip = scene.follower, scene.tip
    h = follower.length / links
    mass, stiffness = follower.mass_per_length * h, follower.bending_stiffness / h
    half = (h / 2.0, PIN * follower.length / 2.0, follower.section.breadth / 2.0)
    body, place = spec.worldbody, scene.pivot_distance
    for number in range(links):
        body = add_body(body, f"link {number}", place, mass, h / 2.0, mass * h**2 / 12.0)
        if number == 0:
            add_hinge(body, damping=scene.base.damping, armature=scene.base.inertia)
        else:
            add_hinge(body, stiffness, follower.material_damping * stiffness, armature)
        for side in (1.0, -1.0):
            wall = (h / 2.0, side * (reach_of_pin(scene) + half[1]), 0.0)
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=wall, contype=_WALL, conaffinity=_PIN, **contact)
        place = h
    if tip is not None:
        add_body(body, "tip", h, tip.mass, tip.center_of_mass, tip.inertia)


def straight_chain(scene: Mechanism, links: int, armature: float) -> tuple[Array, Array]:
    """Mass and stiffness matrices of the straight chain alone in the angles of `build`, that of the first link and the hinges'; (N, N)."""
    follower, tip = scene.follower, scene.tip_body
    h = follower.length / links
    hinge, inboard = h * np.arange(links), np.tri(links)  # a hinge turns its own link and every one outboard of it
    arms = inboard * (hinge[:, None] + h / 2.0 - hinge)  # from hinge j to the centre of link i
    mass = follower.mass_per_length * h * (arms.T @ arms + h**2 / 12.0 * inboard.T @ inboard)
    to_tip = follower.length + tip.center_of_mass - hinge
    mass += tip.mass * np.outer(to_tip, to_tip) + tip.inertia
    mass += np.diag([scene.base.inertia, *[armature] * (links - 1)])
    stiffness = np.diag([0.0, *[follower.bending_stiffness / h] * (links - 1)])
    return mass, stiffness


def longest_stable_step(scene: Mechanism, links: int, armature: float) -> float:
    """2 over the largest natural angular frequency of the straight chain: the limit of the semi-implicit Euler method."""
    mass, stiffness = straight_chain(scene, links, armature)
    return float(2.0 / np.sqrt(eigh(stiffness, mass)[0][-1]))


def natural_frequencies(mechanism: Mechanism, crank_angle: float, count: int, links: int) -> Array:
    """Lowest `count` frequencies, Hz; without armature, which serves the time integration only."""
    units = Units.of(mechanism)
    scene = units.scene(mechanism)
    mass, stiffness = straight_chain(scene, links, 0.0)
    arm, h = scene.crank.length, scene.follower.length / links
    slider = math.hypot(scene.pivot_distance - arm * math.cos(crank_angle), arm * math.sin(crank_angle))
    row = np.maximum(slider - h * np.arange(links), 0.0)  # a hinge moves the point at the slider by its distance
    free = scipy.linalg.null_space(row[None, :])
    squares = eigh(free.T @ stiffness @ free, free.T @ mass @ free)[0]
    return np.sqrt(np.maximum(squares[:count], 0.0)) / (2.0 * math.pi * units.time)
