"""The columns of a trajectory from MuJoCo's states. Vectors of the plane are complex numbers, places are relative to P."""

from dataclasses import dataclass
from typing import Any, Self

import mujoco
import numpy as np
import scipy  # whose interpolation is imported when it is used

from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, TorqueDrive


@dataclass(frozen=True)
class Row:
    """MuJoCo's state at an instant, with the accelerations and energies that it gives, and the force of the pin."""

    angles: Array  # of crank, first link, hinges
    rates: Array
    accelerations: Array
    potential_energy: float  # of gravity and hinge springs
    kinetic_energy: float
    slider_force: float  # on the follower, positive along its normal

    @classmethod
    def of(cls, model: mujoco.MjModel, data: mujoco.MjData) -> Self:
        """The present row; `mujoco.mj_forward` must have been called."""
        force, wrench = 0.0, np.zeros(6)
        for number in range(data.ncon):
            mujoco.mj_contactForce(model, data, number, wrench)
            contact = data.contact[number]
            wall = max(contact.geom, key=lambda geom: model.geom_bodyid[geom])  # bodies are numbered from the crank to the tip
            outward = contact.frame[:2] if wall == contact.geom[1] else -contact.frame[:2]
            normal = data.xmat[model.geom_bodyid[wall]].reshape(3, 3)[:2, 1]
            force += wrench[0] * float(outward @ normal)
        potential, kinetic = data.energy
        return cls(data.qpos.copy(), data.qvel.copy(), data.qacc.copy(), float(potential), float(kinetic), force)

    @property
    def is_finite(self) -> bool:
        """Whether all numbers are."""
        return bool(np.isfinite(self.angles).all() and np.isfinite(self.rates).all() and np.isfinite(self.accelerations).all())

    def slider(self, scene: Mechanism, links: int) -> tuple[float, float]:
        """Arc length of the pin along the links' middle line, and its distance from that line."""
        place, gap = _on_line(scene, self.angles[None, :], links)
        return float(place[0]), float(gap[0])


def columns(scene: Mechanism, rows: list[Row], links: int, began_at: float) -> Columns:
    """The columns but for the time, in the scene's units. `began_at`: crank angle at which the work of the drive is zero."""
    follower, drive = scene.follower, scene.crank.drive
    assert isinstance(drive, TorqueDrive)
    h, n = follower.length / links, len(rows)
    angles, rates, accelerations = (np.array([getattr(row, name) for row in rows]) for name in ("angles", "rates", "accelerations"))
    alpha, alpha_rate, alpha_acceleration = (np.cumsum(each[:, 1:], axis=1) for each in (angles, rates, accelerations))
    e = np.exp(1j * alpha)
    corners = np.concatenate([np.zeros((n, 1)), np.cumsum(h * e, axis=1)], axis=1)
    tip, base, last = corners[:, -1], e[:, 0], e[:, -1]
    tip_acceleration = h * ((1j * alpha_acceleration - alpha_rate**2) * e).sum(axis=1)
    place, gap = _on_line(scene, angles, links)
    force = np.array([row.slider_force for row in rows])
    bend = _curvature(scene, angles[:, 2:] / h, force, place, links)
    springs = 0.5 * follower.bending_stiffness / h * (angles[:, 2:] ** 2).sum(axis=1)
    return {
        "crank_angle": angles[:, 0],
        "crank_speed": rates[:, 0],
        "follower_angle": alpha[:, 0],
        "follower_rate": alpha_rate[:, 0],
        "follower_acceleration": alpha_acceleration[:, 0],
        "slider_position": place,
        "tip_x": scene.pivot_distance + tip.real,
        "tip_y": tip.imag,
        "tip_deflection": (tip / base).imag,
        "tip_acceleration": (tip_acceleration / (1j * last)).real,
        **{f"strain_{k}": follower.extreme_fibre * bend(np.full(n, gauge)) for k, gauge in enumerate(follower.strain_gauges, start=1)},
        "slider_force": force,
        "crank_torque": np.full(n, drive.torque),
        "kinetic_energy": np.array([row.kinetic_energy for row in rows]),
        "strain_energy": springs,
        "constraint_gap": np.abs(gap),
        "gravity_energy": np.array([row.potential_energy for row in rows]) - springs,
        "drive_work": drive.torque * (angles[:, 0] - began_at),
    }


def _on_line(scene: Mechanism, angles: Array, links: int) -> tuple[Array, Array]:
    """Of the states (k, links + 1): arc length of the pin on the links' middle line, its distance along the link's normal."""
    h = scene.follower.length / links
    e = np.exp(1j * np.cumsum(angles[:, 1:], axis=1))
    corners = np.concatenate([np.zeros((len(angles), 1)), np.cumsum(h * e, axis=1)], axis=1)[:, :-1]
    pin = scene.crank.length * np.exp(1j * angles[:, :1]) - scene.pivot_distance
    local = (pin - corners) / e
    link = np.argmin(np.abs(local.real - h / 2.0), axis=1)
    chosen = np.take_along_axis(local, link[:, None], axis=1)[:, 0]
    return h * link + chosen.real, chosen.imag


def _curvature(scene: Mechanism, at_hinges: Array, force: Array, place: Array, links: int) -> Any:
    """The curvature of each row at an arc length (k,): a spline through the hinges', with the kink at the slider apart.

    The slider's force bends the follower inboard of it with the moment F (s - x), in the hinges as in a beam.
    """
    hinges = scene.follower.length / links * np.arange(1, links)
    per_force = force / scene.follower.bending_stiffness

    def ramp(x: Array) -> Array:
        return per_force * np.maximum(place - x, 0.0)

    kinked = np.array([ramp(np.full(len(force), x)) for x in hinges])
    smooth = scipy.interpolate.CubicSpline(hinges, at_hinges.T - kinked)
    return lambda x: smooth(x[0]) + ramp(x)
