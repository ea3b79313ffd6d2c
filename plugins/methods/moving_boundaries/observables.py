"""Observables of states, directly from the shapes (section 6 of DERIVATION.md)."""

from typing import Any, Final

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from quickreturn.plugins.methods.moving_boundaries import tables as t
from quickreturn.plugins.methods.moving_boundaries.equations import ACCELERATION, FORCE, KINETIC, RATE, STRAIN, TORQUE, VALUE
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import BENDING, PLACES, SHAPE
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import RigidMotion, follower_inertia, rigid_motion
from quickreturn.reference_model.state import BY_DRIVE, DISSIPATED, State
from quickreturn.reference_model.tip import tip_force

_RATES: Final = [VALUE, RATE, ACCELERATION]


def observables(mechanism: Mechanism, shapes: t.Shapes, states: Array, signals: Array, facts: Array) -> dict[str, Array]:
    """Columns by name, each of shape (k,).

    Args:
        mechanism: the scene.
        shapes: of its beam.
        states: shape (k, 2 n + 4).
        signals: the equations' `MovingBoundariesWorkspace.signals` of each state, shape (k, *its shape there).
        facts: their `MovingBoundariesWorkspace.facts`, shape (k, 4).
    """
    state = State.of(states, slider=False)
    q1, q1_rate = state.q[:, 0], state.u[:, 0]
    line = rigid_motion(mechanism, q1, q1_rate)
    follower, tip, moment = mechanism.follower, mechanism.tip_body, follower_inertia(mechanism)[1]
    L, distance, gravity = follower.length, line.slider_position, complex(*mechanism.gravity)
    unit, crank = np.exp(1j * line.follower_angle), np.exp(1j * q1)

    def from_pivot(straight: float, short: int, across: int) -> Array:
        """A place or a first moment relative to P, along and across the line, and its two rates; shape (k, 3)."""
        return np.array([straight, 0.0, 0.0]) - signals[:, t.VECTORS + short, _RATES] + 1j * signals[:, across, _RATES]

    # the tip's place and the follower's first moment (equation 6.1)
    end, mass = from_pivot(L, t.PULLED, t.END), from_pivot(moment, t.HANGING, t.WEIGHT)
    place, base = mechanism.pivot_distance + unit * end[:, 0], signals[:, t.BASE, VALUE]
    base_moment, tip_moment = _end_moments(mechanism, line, signals, end, gravity * np.conj(unit))
    places = L * np.arange(1, PLACES + 1) / (PLACES + 1)
    shown = np.column_stack([distance, np.tile([*follower.strain_gauges, *places, L], (len(q1), 1))])
    across_base, slope, bend = _fields(shapes, distance, L, state.eta, shown)
    across, slope = across_base + base[:, None] * shown, slope + base[:, None]

    # forces of the slider and of the bearings (equations 6.3 and 6.4)
    total, tool = follower.mass + tip.mass, tip_force(tip, q1, line.follower_angle)
    of_slider = facts[:, FORCE] * (1j - slope[:, 0]) * unit
    at_pivot = unit * _acceleration(line, mass) - of_slider - total * gravity - tool
    at_crank = of_slider - mechanism.crank_moment * q1_rate**2 * crank - mechanism.crank_mass * gravity
    height = total * mechanism.pivot_distance + unit * mass[:, 0] + mechanism.crank_moment * crank
    columns = {
        "crank_angle": q1,
        "crank_speed": q1_rate,
        "follower_angle": line.follower_angle + base,
        "follower_rate": line.follower_speed + signals[:, t.BASE, RATE],
        "follower_acceleration": line.follower_acceleration + signals[:, t.BASE, ACCELERATION],
        "slider_position": distance + signals[:, t.VECTORS + t.SHORTENED, VALUE],
        "tip_x": place.real,
        "tip_y": place.imag,
        "tip_deflection": (np.exp(-1j * base) * end[:, 0]).imag,
        "tip_acceleration": (np.exp(-1j * slope[:, -1]) * _acceleration(line, end)).imag,
        **{f"strain_{k}": follower.extreme_fibre * bend[:, k] for k in (1, 2, 3)},
        "slider_force": facts[:, FORCE],
        "crank_torque": facts[:, TORQUE],
        "kinetic_energy": facts[:, KINETIC],
        "strain_energy": facts[:, STRAIN],
        "dissipated_energy": state.work[:, DISSIPATED],
        "drive_work": state.work[:, BY_DRIVE],
        "gravity_energy": -(np.conj(gravity) * height).real,
        "constraint_gap": np.abs(across[:, 0]),
        "pivot_force_x": at_pivot.real,
        "pivot_force_y": at_pivot.imag,
        "crank_force_x": at_crank.real,
        "crank_force_y": at_crank.imag,
        **dict(zip(SHAPE, (np.cos(base)[:, None] * across[:, 4:-1] - np.sin(base)[:, None] * places).T, strict=True)),
    }
    if state.eta.size:
        inner = follower.bending_stiffness * bend[:, [*range(4, 4 + PLACES), 0, 0]].T  # no moment acts at the slider
        columns |= dict(zip(BENDING, (*inner, base_moment, tip_moment), strict=True))
    return {name: np.ascontiguousarray(values) for name, values in columns.items()}


def _fields(shapes: t.Shapes, distance: Array, L: float, eta: Array, x: Array) -> tuple[Array, Array, Array]:
    """Deflection across the tangent at P, slope relative to it and curvature at arc lengths x (k, m), each (k, m)."""
    if shapes.family is None:
        return (np.zeros_like(x),) * 3
    lengths = np.stack([distance, L - distance], axis=1)[:, :, None]
    angle = np.einsum("ksdn,kn->ksd", shapes.family.series_at(distance), eta)  # Legendre coefficients on both domains
    deflection = legendre.legint(angle, lbnd=-1, axis=2) * (0.5 * lengths)
    deflection[:, 1, 0] += deflection[:, 0].sum(axis=1)
    inboard, start = x <= distance[:, None], distance[:, None]
    place = np.where(inboard, 2.0 * x / start - 1.0, 2.0 * (x - start) / (L - start) - 1.0)
    polynomials = legendre.legvander(place, angle.shape[2])

    def at(series: Array) -> Array:
        chosen = np.where(inboard[:, :, None], series[:, :1], series[:, 1:])
        return np.asarray(np.einsum("kmd,kmd->km", polynomials[:, :, : series.shape[2]], chosen))

    return at(deflection), at(angle), at(legendre.legder(angle, axis=2) * (2.0 / lengths))


def _end_moments(mechanism: Mechanism, line: RigidMotion, signals: Array, end: Array, gravity: Array) -> tuple[Array, Array]:
    """Bending moments that base block and tip body require (equations 6.5 and 6.6): the series of curvatures has them last of all.

    Args:
        mechanism: the scene.
        line: the line's motion.
        signals: as in `observables`.
        end: the tip's place from P and its two rates, in the line's frame, (k, 3).
        gravity: in the line's frame, (k,).
    """
    base, tip, turn = mechanism.base, mechanism.tip_body, line.follower_acceleration
    pivot = base.damping * (line.follower_speed + signals[:, t.BASE, RATE])
    at_base = base.inertia * (turn + signals[:, t.BASE, ACCELERATION]) + pivot - mechanism.follower.damping * signals[:, t.DRAG_LEVER, RATE]
    slope = signals[:, t.END_SLOPE][:, _RATES]
    arm = tip.center_of_mass * (np.array([1.0, 0.0, 0.0]) + 1j * slope)
    lever = (np.conj(arm[:, 0]) * (_acceleration(line, end + arm) - gravity)).imag
    return at_base, -tip.inertia * (turn + slope[:, 2]) - tip.mass * lever


def _acceleration(line: RigidMotion, z: Array) -> NDArray[Any]:
    """Second rate, in the line's frame, of a vector z with its two rates along and across the line, shape (k, 3) (equation 6.2)."""
    turn = line.follower_speed
    return np.asarray(z[:, 2] + 2j * turn * z[:, 1] + (1j * line.follower_acceleration - turn**2) * z[:, 0])
