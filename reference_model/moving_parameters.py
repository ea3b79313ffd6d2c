"""Constants and tables of the model whose shapes follow the slider, for compiled code (DERIVATION.md, section 10)."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from reference_model.gauss_points import barycentric_weights, integrals_to_points
from reference_model.mechanism import Mechanism, PrescribedSpeed, Tip, TorqueDrive
from reference_model.moving_modes import ModeFamily, mode_family
from reference_model.rigid import deflection_scale

Array = NDArray[np.float64]

KINDS = 3  # psi, its first and its second derivative by s at fixed arc length
EXTRAS = 5  # omega^2, its derivative by s, psi' at the slider, and first two derivatives of psi(s; s)


#: Quantities of one state in `MovingWorkspace.facts`.
COS_Q2, SIN_Q2, Q2_RATE, S_RATE, Q2_REMAINDER, S_REMAINDER, CURVATURE, SLIDER_SLOPE, ALONG, ACROSS, EXCESS = range(11)
#: Entries for the bodies behind those for the points, in rows of velocities and accelerations.
TIP_1, TIP_2, TIP_TURN, BASE_TURN, SLIDER_TURN, CRANK_TURN = range(6)
BODIES = 6


class SpanTables(NamedTuple):
    """psi_i and its derivatives by s at points that move with the slider, piecewise cubic in s.

    Points: G Gauss points of the first span, the slider, G Gauss points of the second span, the end. Each span takes S places, the
    next multiple of four above G; what is left over weighs nothing. N = 2 S in all. A row of the table holds KINDS blocks of (modes,
    N), then EXTRAS blocks of (modes).
    """

    low: float  # m, smallest s
    high: float  # m, largest s
    step: float  # m, between nodes
    coefficients: Array  # (intervals, 4, row length), powers of s - node, highest first
    G: int  # Gauss points per span
    S: int  # places per span
    u: Array  # (G,) fractions of a span
    barycentric: Array  # (G,) weights of the polynomial through the Gauss points (Berrut and Trefethen, 2004)
    weights: Array  # (S,) of the integral over a span of unit length
    to_points: Array  # (G, S) weight of each Gauss point in the integrals from the span's beginning to each point


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
    reach: float  # m, s at which the slider counts as leaving the follower
    deflection_scale: float  # m, size that errors of the deflection are measured against
    tables: SpanTables


class MovingWorkspace(NamedTuple):
    """Scratch of one evaluation, for N places, n modes and n + 1 speeds.

    Complex quantities are rows of N real and N imaginary parts; rows of length M = 2 N + BODIES also hold the bodies' entries.
    """

    row: Array  # interpolated row of the table
    psi: Array  # (N,)
    psi_s: Array  # (N,)
    gamma: Array  # (N,) remainder of the angular acceleration before q2 and s are known
    turn: Array  # (N,) angular rate alpha'
    e: Array  # (2 N,) exp(i psi)
    z: Array  # (2 N,) place relative to P in frame B
    Y: Array  # (2 N,) change of the place with s
    integrand: Array  # (2 N,)
    relative: Array  # (2 N,) velocity relative to frame B
    dx: Array  # (2 N,) share of the length, m, for real and imaginary parts alike
    mass: Array  # (M,) kg, for turning bodies kg m^2
    V: Array  # (n + 1, M) partial velocities in frame B
    A: Array  # (M,) remaining acceleration less gravity in frame B
    force: Array  # (M,)
    weighted: Array  # (M,) a row of V times the masses
    c: Array  # (n + 1,) partial rates of q2
    sigma: Array  # (n + 1,) partial rates of s
    reduced: Array  # (n + 1, n + 1) mass matrix
    acceleration: Array  # (n + 1,)
    slider: Array  # (2,) s, m; highest angular frequency with the crank free or held, rad/s
    facts: Array  # (11,)


def moving_workspace(tables: SpanTables, n: int) -> MovingWorkspace:
    """Scratch arrays for a table."""
    N = 2 * tables.S
    M = 2 * N + BODIES
    shapes = dict.fromkeys(("mass", "A", "force", "weighted"), M)
    shapes |= dict.fromkeys(("psi", "psi_s", "gamma", "turn"), N)
    shapes |= dict.fromkeys(("e", "z", "Y", "integrand", "relative", "dx"), 2 * N)
    shapes |= dict.fromkeys(("c", "sigma", "acceleration"), n + 1)
    return MovingWorkspace(
        row=np.zeros(tables.coefficients.shape[2]),
        V=np.zeros((n + 1, M)),
        reduced=np.zeros((n + 1, n + 1)),
        slider=np.zeros(2),
        facts=np.zeros(11),
        **{name: np.zeros(shape) for name, shape in shapes.items()},
    )


class _Reach(NamedTuple):
    """How near to the follower's end the tables go, and how fine they are; lengths in parts of the follower's.

    Attributes:
        end: what the second span keeps: its stiffness grows without bound as it vanishes.
        leaving: the follower counts as left so much before the tables end, so that a step can end between and be seen to.
        terms: factor on the terms of the modes' series in s, whose errors the derivatives by s divide by the span's length, twice.
        intervals: factor on the pieces of the tables.
    """

    end: float
    leaving: float
    terms: int
    intervals: int


#: Where the rigid mechanism keeps the slider away from the end: left at 0.06 % of the length before it, which takes violent bending. Run
#: 24 at three times the speed passes there at 9 m/s, and the rest in 0.04 ms; a slider that would turn back on the rest counts as gone.
_USUAL: Final = _Reach(1e-4, 5e-4, 1, 1)
#: Where it does not: with a crank of 6.95 in the slider of run 24 turns back 6e-5 before the end, and leaves one cycle later. With a crank
#: of 6.9 in tables as coarse as usual would lose 5e-2 of the strain energy with two modes and 2e-3 with five; these lose 9e-6 and 1e-6.
_TO_THE_END: Final = _Reach(1e-6, 1e-5, 3, 8)
#: The part of the follower's length from which on the slider counts as near the end.
_NEAR: Final = 0.95


def _reach(mechanism: Mechanism) -> _Reach:
    farthest = mechanism.pivot_distance + mechanism.crank.length
    return _TO_THE_END if farthest > _NEAR * mechanism.follower.length else _USUAL


def slider_range(mechanism: Mechanism) -> tuple[float, float]:
    """Arc lengths that the tables cover, m: from a twentieth less than the rigid mechanism's to (almost) the follower's end."""
    d, LA, L = mechanism.pivot_distance, mechanism.crank.length, mechanism.follower.length
    return max(0.95 * (d - LA), 0.02 * L), (1.0 - _reach(mechanism).end) * L


def gauss_points(modes: int) -> int:
    """Gauss points on each span in the equations of motion.

    One less than a multiple of four, which with the span's end fills the places; fewer cost the same. In run 24 seven are enough
    for five modes, but a crank of 6 in, which brings the slider nearer to the end, leaves 2e-3 of the tip acceleration with seven
    and 2e-4 with eleven.
    """
    return 7 if modes <= 3 else 11 if modes <= 9 else 15


def moving_parameters(mechanism: Mechanism, modes: int) -> MovingParameters:
    """Parameters for a flexible follower with a rigid slider joint, `modes` >= 1."""
    drive, follower, slider = mechanism.crank.drive, mechanism.follower, mechanism.slider
    tip = mechanism.tip or Tip(mass=0.0, inertia=0.0)
    reach, (low, high) = _reach(mechanism), slider_range(mechanism)
    family = mode_family(mechanism, modes, low, high, reach.terms * (21 + 7 * modes))
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
        reach=high - reach.leaving * follower.length,
        deflection_scale=deflection_scale(mechanism),
        tables=span_tables(family, gauss_points(modes), reach.intervals * 24 * (modes + 1)),
    )


def span_tables(family: ModeFamily, points: int, intervals: int) -> SpanTables:
    """Tables with `points` Gauss points a span and `intervals` cubic pieces in s."""
    gauss, weights = np.polynomial.legendre.leggauss(points)
    u = 0.5 * (gauss + 1.0)
    nodes = np.linspace(family.low, family.high, intervals + 1)
    places = 4 * (points // 4 + 1)
    spans = [family.shapes_at(nodes, np.append(u, 1.0), span) for span in range(2)]
    squares = [family.squares_at(nodes, order) for order in (0, 1)]
    curvature = spans[0][3][:, -1, :]
    angle = [_slider_angle(family, nodes, order) for order in (1, 2)]
    rest = ((0, 0), (0, places - points - 1), (0, 0))
    blocks = [np.concatenate([np.pad(span[kind], rest) for span in spans], axis=1).transpose(0, 2, 1) for kind in range(KINDS)]
    rows = np.concatenate([*(block.reshape(len(nodes), -1) for block in blocks), *squares, curvature, *angle], axis=1)
    coefficients = np.ascontiguousarray(CubicSpline(nodes, rows, axis=0).c.transpose(1, 0, 2))
    weights_to = np.zeros((points, places))
    weights_to[:, : points + 1] = 0.5 * integrals_to_points(gauss, weights)
    to_end = np.pad(0.5 * weights, (0, places - points))
    between = barycentric_weights(gauss, weights)
    return SpanTables(family.low, family.high, nodes[1] - nodes[0], coefficients, points, places, u, between, to_end, weights_to)


def _slider_angle(family: ModeFamily, nodes: Array, order: int) -> Array:
    """Derivative of psi_i(s; s) along the moving slider: the Legendre series of the first span at its end, by s."""
    # every Legendre polynomial is 1 at the end
    return family._series(family.coefficients[:, 0].sum(axis=1), nodes, order)
