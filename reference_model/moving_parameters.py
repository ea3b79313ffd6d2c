"""Constants and tables of the model whose shapes follow the slider, for compiled code (DERIVATION.md, section 10)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from reference_model.mechanism import Mechanism, PrescribedSpeed, Tip, TorqueDrive
from reference_model.moving_modes import ModeFamily, mode_family

Array = NDArray[np.float64]

#: Gauss points on each span when observables are evaluated, where curvature is interpolated to the gauges.
OUTPUT_POINTS = 9
KINDS = 3  # psi, its first and its second derivative by s at fixed arc length
EXTRAS = 5  # omega^2, its derivative by s, psi' at the slider, and first two derivatives of psi(s; s)


class SpanTables(NamedTuple):
    """psi_i and its derivatives by s at points that move with the slider, piecewise cubic in s.

    Points: G Gauss points of the first span, the slider, G Gauss points of the second span, the end; 2 G + 2 in all. A row of the
    table holds KINDS blocks of (points, modes), then EXTRAS blocks of (modes).
    """

    low: float  # m, range of s
    step: float  # m, between nodes
    coefficients: Array  # (intervals, 4, row length), powers of s - node, highest first
    G: int  # Gauss points per span
    u: Array  # (G,) fractions of a span
    weights: Array  # (G,) of the integral over a span of unit length
    to_points: Array  # (G, G) weights of the integrals from the span's beginning to each point


class MovingParameters(NamedTuple):
    """Constants of the equations, SI; the names are those of `reference_model.parameters.Parameters` where they mean the same."""

    d: float
    LA: float
    L: float
    crank_inertia: float
    crank_moment: float
    torque: float
    crank_damping: float
    crank_is_free: bool
    base_inertia: float
    base_damping: float
    rhoA: float
    EI: float
    beam_damping: float
    tip_mass: float
    tip_inertia: float
    tip_offset: float
    slider_inertia: float
    gravity_1: float
    gravity_2: float
    has_gravity: bool
    n: int
    thickness: float
    gauges: Array
    reach: float  # m, largest s of the tables
    tables: SpanTables
    output: SpanTables


class MovingWorkspace(NamedTuple):
    """Scratch of one evaluation, for N = 2 G + 2 points, n modes and n + 1 speeds; complex quantities as pairs in the last index."""

    row: Array  # interpolated row of the table
    psi: Array  # (N,)
    psi_s: Array  # (N,)
    gamma: Array  # (N,) remainder of the angular acceleration before q2 and s are known
    turn: Array  # (N,) angular rate alpha'
    turn_0: Array  # (N,) remainder of the angular acceleration
    e: Array  # (N, 2) exp(i psi)
    z: Array  # (N, 2) place relative to P in frame B
    beta: Array  # (n + 1, N)
    V: Array  # (n + 1, N, 2) partial velocities in frame B
    A0: Array  # (N, 2) remaining acceleration in frame B
    relative: Array  # (N, 2) velocity relative to frame B
    integrand: Array  # (N, 2)
    c: Array  # (n + 1,) partial rates of q2
    sigma: Array  # (n + 1,) partial rates of s
    reduced: Array  # (n + 1, n + 1)
    rhs: Array  # (n + 1,)
    acceleration: Array  # (n + 1,)
    slider: Array  # (1,) s
    facts: Array  # (8,) q2, q2 rate, s rate, q2 remainder, s remainder, curvature at s, direction a1 in frame B


def moving_workspace(tables: SpanTables, n: int) -> MovingWorkspace:
    """Scratch arrays for a table."""
    N = 2 * tables.G + 2

    def zeros(*shape: int) -> Array:
        return np.zeros(shape)

    return MovingWorkspace(
        row=zeros(tables.coefficients.shape[2]),
        psi=zeros(N),
        psi_s=zeros(N),
        gamma=zeros(N),
        turn=zeros(N),
        turn_0=zeros(N),
        e=zeros(N, 2),
        z=zeros(N, 2),
        beta=zeros(n + 1, N),
        V=zeros(n + 1, N, 2),
        A0=zeros(N, 2),
        relative=zeros(N, 2),
        integrand=zeros(N, 2),
        c=zeros(n + 1),
        sigma=zeros(n + 1),
        reduced=zeros(n + 1, n + 1),
        rhs=zeros(n + 1),
        acceleration=zeros(n + 1),
        slider=zeros(1),
        facts=zeros(8),
    )


def slider_range(mechanism: Mechanism) -> tuple[float, float]:
    """Arc lengths that the tables cover, m: the rigid mechanism's, a twentieth less, and up to (almost) the follower's end."""
    d, LA, L = mechanism.pivot_distance, mechanism.crank.length, mechanism.follower.length
    # the second span must keep some length: its stiffness grows without bound as it vanishes
    return max(0.95 * (d - LA), 0.02 * L), min(1.1 * (d + LA), (1.0 - 2e-4) * L)


def gauss_points(modes: int) -> int:
    """Gauss points on each span in the equations of motion.

    Measured on run 24: with fewer the tip acceleration loses digits (5 modes with 6 points: 1.5e-3 in place of 5e-4, with 8 points
    nothing more is gained), while one or two modes need no more than 5.
    """
    return max(5, modes + 3)


def moving_parameters(mechanism: Mechanism, modes: int) -> MovingParameters:
    """Parameters for a flexible follower with a rigid slider joint, `modes` >= 1."""
    drive, follower, slider = mechanism.crank.drive, mechanism.follower, mechanism.slider
    tip = mechanism.tip or Tip(mass=0.0, inertia=0.0)
    low, high = slider_range(mechanism)
    family = mode_family(mechanism, modes, low, high, 17 + 8 * modes)
    points = gauss_points(modes)
    intervals = 8 * (modes + 1)
    return MovingParameters(
        d=mechanism.pivot_distance,
        LA=mechanism.crank.length,
        L=follower.length,
        crank_inertia=mechanism.crank.inertia_about_pivot + slider.mass * mechanism.crank.length**2,
        crank_moment=mechanism.crank.mass * mechanism.crank.center_of_mass + slider.mass * mechanism.crank.length,
        torque=0.0 if isinstance(drive, PrescribedSpeed) else drive.torque,
        crank_damping=0.0 if isinstance(drive, PrescribedSpeed) else drive.damping,
        crank_is_free=isinstance(drive, TorqueDrive),
        base_inertia=mechanism.base.inertia,
        base_damping=mechanism.base.damping,
        rhoA=follower.mass_per_length,
        EI=follower.bending_stiffness,
        beam_damping=follower.damping,
        tip_mass=tip.mass,
        tip_inertia=tip.inertia,
        tip_offset=tip.center_of_mass,
        slider_inertia=slider.inertia,
        gravity_1=mechanism.gravity[0],
        gravity_2=mechanism.gravity[1],
        has_gravity=mechanism.has_gravity,
        n=modes,
        thickness=follower.thickness,
        gauges=np.array(follower.strain_gauges, dtype=float),
        reach=high,
        tables=span_tables(family, points, intervals),
        output=span_tables(family, max(OUTPUT_POINTS, points + 2), intervals),
    )


def span_tables(family: ModeFamily, points: int, intervals: int) -> SpanTables:
    """Tables with `points` Gauss points a span and `intervals` cubic pieces in s."""
    gauss, weights = np.polynomial.legendre.leggauss(points)
    u = 0.5 * (gauss + 1.0)
    nodes = np.linspace(family.low, family.high, intervals + 1)
    blocks = []
    first = family.shapes_at(nodes, np.append(u, 1.0), 0)
    second = family.shapes_at(nodes, np.append(u, 1.0), 1)
    blocks += [np.concatenate([a, b], axis=1).reshape(len(nodes), -1) for a, b in zip(first[:3], second[:3], strict=True)]
    squares = [family.squares_at(nodes, order) for order in (0, 1)]
    curvature = first[3][:, -1, :]
    angle = [_slider_angle(family, nodes, order) for order in (1, 2)]
    rows = np.concatenate([*blocks, *squares, curvature, *angle], axis=1)
    coefficients = np.ascontiguousarray(CubicSpline(nodes, rows, axis=0).c.transpose(1, 0, 2))
    inverse = np.linalg.inv(np.vander(u, increasing=True))
    powers = np.arange(1, points + 1)
    to_points = (u[:, None] ** powers / powers) @ inverse
    return SpanTables(family.low, nodes[1] - nodes[0], coefficients, points, u, 0.5 * weights, to_points)


def _slider_angle(family: ModeFamily, nodes: Array, order: int) -> Array:
    """Derivative of psi_i(s; s) along the moving slider: the Legendre series of the first span at its end, by s."""
    # every Legendre polynomial is 1 at the end
    return family._series(family.coefficients[:, 0].sum(axis=1), nodes, order)
