"""The recorded states of a run, and the columns that the models with a rigid and a flexible follower share."""

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from quickreturn.engines.exudyn.assembly import Assembly
from quickreturn.engines.exudyn.cable import Cable, dot, turned
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import PLACES, SHAPE
from quickreturn.reference_model.mechanism import MotorCurve, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.spring import Pull, Spring, pull_of, spring_energy
from quickreturn.reference_model.tip import Tip, slide_friction, tip_force

#: Values with their first and second derivatives in time.
Kinematics = tuple[Array, Array, Array]


@dataclass(frozen=True)
class Record:
    """The system's state on the output grid, one row per instant."""

    time: Array  # s since the start, shape (rows,)
    coordinates: Array  # all second-order coordinates, shape (rows, coordinates), as `rates` and `accelerations`
    rates: Array
    accelerations: Array
    multipliers: Array  # Lagrange multipliers, shape (rows, equations)
    # integral over time of the multiplier that prescribes the crank's speed, N m s, summed over the steps, shape (rows,); of its product
    # with a speed that varies, J
    impulse: Array
    lost: Array  # energy dissipated as `Model.joint_loss` says, J, summed over the steps: a blow may be shorter than a row; shape (rows,)


class Model(Protocol):
    """An assembled system that computes the observables from its coordinates."""

    assembly: Assembly
    # index of the multiplier that prescribes the crank's speed; None for a free crank or a follower alone
    drive_equation: int | None = None

    def prepare_stretch(self, coordinates: Array, rates: Array, duration: float) -> None:
        """Set what stays constant over the next stretch of the simulation, `duration` (s) long, at most `construction.longest_stretch`."""
        return

    def slider_position(self, coordinates: Array) -> float | None:
        """Arc length of the slider for one row of coordinates, m; None where there is no slider."""
        return None

    def joint_loss(self) -> float:
        """Power that the slider's joint and the friction of the tool's slide dissipate at present, W."""
        return 0.0

    def columns(self, record: Record) -> dict[str, Array]:
        """All columns of a trajectory; `dissipated_energy` and `drive_work` count from the record's first row."""


def index(assembly: Assembly, node: Any) -> int:
    """Index of a node's first coordinate among the system's second-order coordinates."""
    return int(assembly.mbs.GetNodeODE2Index(node))


def equation_of(assembly: Assembly, constraint: Any | None) -> int | None:
    """Index of a constraint's only multiplier among all multipliers; None for None."""
    return None if constraint is None else int(assembly.mbs.systemData.GetObjectLTGAE(constraint)[0])


def accumulated(time: Array, power: Array, power_rate: Array) -> Array:
    """Energy ∫ power dt (J) since the first row, by the trapezoidal rule with end correction (fourth order, additive over pieces)."""
    h = np.diff(time)
    parts = h / 2.0 * (power[1:] + power[:-1]) + h**2 / 12.0 * (power_rate[:-1] - power_rate[1:])
    return np.concatenate([[0.0], np.cumsum(parts)])


class TipMotion(NamedTuple):
    """Motion of the follower's flexible end in the fixed frame."""

    velocity: Array  # m/s, shape (rows, 2)
    acceleration: Array  # m/s^2, shape (rows, 2)
    angle: Array  # of the tangent, rad, shape (rows,)
    turn: Array  # its rate, rad/s, shape (rows,)


def drive_columns(assembly: Assembly, record: Record, crank: int, equation: int | None, tip_motion: TipMotion) -> dict[str, Array]:
    """Columns of the crank's drive: its torque, and its work with that of the force on the tip.

    Args:
        assembly: the system.
        record: its states.
        crank: index of the crank's angle.
        equation: see `Model.drive_equation`.
        tip_motion: of the follower's end.
    """
    angle, drive = record.coordinates[:, crank], assembly.mechanism.crank.drive
    match drive:
        case TorqueDrive():
            torque, work = np.full_like(angle, drive.torque), drive.torque * (angle - angle[0])
        case MotorCurve():
            speed, acceleration = record.rates[:, crank], record.accelerations[:, crank]
            torque = drive.torque_table.at(speed)
            power_rate = (torque + drive.torque_table.at(speed, slope=True) * speed) * acceleration
            work = accumulated(record.time, torque * speed, power_rate)
        case _:
            factor = drive.speed if isinstance(drive, PrescribedSpeed) else 1.0
            torque, work = -record.multipliers[:, equation], -factor * (record.impulse - record.impulse[0])
    return {"crank_torque": torque, "drive_work": work + _work_on_tip(assembly, record, crank, tip_motion)}


def pin_force(assembly: Assembly, record: Record, name: str) -> Array:
    """Force (N) of the ground on the body in a bearing: the joint's multipliers, sign reversed; shape (rows, 2)."""
    return np.asarray(-record.multipliers[:, assembly.mbs.systemData.GetObjectLTGAE(assembly.pins[name])])


def swing(moment: float, angle: Array, rate: Array, acceleration: Array) -> Array:
    """Rate of the momentum (N), shape (rows, 2), of a body with a first moment of mass (kg m) about the bearing in which it turns.

    Exudyn's body has its mass in the bearing, so that the force of the pin lacks this part.
    """
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    return moment * (acceleration[:, None] * turned(along) - (rate**2)[:, None] * along)


def bearing_columns(name: str, force: Array) -> dict[str, Array]:
    """The columns of a bearing's force (N), shape (rows, 2)."""
    return {f"{name}_force_x": force[:, 0], f"{name}_force_y": force[:, 1]}


def crank_bearing_columns(assembly: Assembly, record: Record, crank: int) -> dict[str, Array]:
    """The columns of the force in the bearing O; `crank` is the index of the crank's angle."""
    motion = (values[:, crank] for values in (record.coordinates, record.rates, record.accelerations))
    return bearing_columns("crank", pin_force(assembly, record, "crank") + swing(assembly.mechanism.crank_moment, *motion))


@dataclass(frozen=True)
class Hold:
    """The spring in the rows of a record, and what it adds to their columns; all zero without one."""

    force: Array  # on the follower, N, shape (rows, 2)
    energy: Array  # J, shape (rows,), as the next two
    power: Array  # that it dissipates, W
    power_rate: Array
    columns: dict[str, Array]  # its own

    @classmethod
    def of(cls, spring: Spring | None, motion: Kinematics) -> "Hold":
        """`motion`: place (m, from O), velocity and acceleration of its end on the follower, each of shape (rows, 2)."""
        place, velocity, acceleration = (each @ np.array([1.0, 1j]) for each in motion)
        if spring is None:
            nothing = np.zeros(len(place))
            return cls(np.zeros((len(place), 2)), nothing, nothing, nothing, {})
        pull: Pull = pull_of(spring, place, velocity)
        second = (np.abs(velocity) ** 2 - pull.rate**2) / pull.length - (pull.direction.conj() * acceleration).real
        energy = np.array([spring_energy(length, spring.law) for length in pull.length.tolist()])
        force, damping = np.column_stack([pull.force.real, pull.force.imag]), spring.damping
        return cls(force, energy, damping * pull.rate**2, 2.0 * damping * pull.rate * second, {"spring_force": pull.tension})


def shape_columns(cable: Cable, q: Array, across: Array) -> dict[str, Array]:
    """The columns `SHAPE` (m), from nodal coordinates `q`, shape (rows, nodes, 4), and b2, `across`, shape (rows, 2)."""
    places = [np.full(len(q), cable.length * k / (PLACES + 1)) for k in range(1, PLACES + 1)]
    return {name: dot(across, cable.evaluate(q, x) - q[:, 0, :2]) for name, x in zip(SHAPE, places, strict=True)}


def force_on_tip(tip: Tip, crank_angle: Array, motion: TipMotion) -> Array:
    """Force of the tool with the friction of its slide, N, shape (rows, 2)."""
    force: Any = tip_force(tip, crank_angle, motion.angle) + slide_friction(tip, motion.velocity @ np.array([1.0, 1j]))
    return np.column_stack([force.real, force.imag])


def slide_loss(tip: Tip, velocity: Array) -> float:
    """Power that the friction of the tool's slide dissipates at a velocity (m/s, shape (2,)) of the tip, W."""
    along = np.array(complex(velocity[0], velocity[1]))
    return -float((slide_friction(tip, along) * along.conjugate()).real)


def _work_on_tip(assembly: Assembly, record: Record, crank: int, motion: TipMotion) -> Array:
    """Work of the force on the tip since the first row, J; arguments as of `drive_columns`."""
    tip = assembly.mechanism.tip_body
    if not tip.is_forced:
        return np.zeros(len(motion.angle))
    angle, end, small = record.coordinates[:, crank], motion.angle, 1e-5  # rad: the force's derivative by the angle is good to ten digits
    force = tip_force(tip, angle, end)
    force_rate = (tip_force(tip, angle + small, end) - tip_force(tip, angle - small, end)) / (2.0 * small) * record.rates[:, crank]
    if tip.follows:
        force_rate += 1j * motion.turn * force
    v, a, f, f_rate = motion.velocity, motion.acceleration, *(np.column_stack([each.real, each.imag]) for each in (force, force_rate))
    return accumulated(record.time, np.sum(f * v, axis=1), np.sum(f * a + f_rate * v, axis=1))
