"""Constants, tables and scratch of one beam's equations of motion (DERIVATION.md, sections 2 to 6).

Fields over the points lie in rows, complex ones as their N real parts followed by their N imaginary parts, so that loops run along memory.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from quickreturn.reference_model.motion.address import Cube, Matrix, Vector, on_lines, reader, tuple_type

#: Quantities per shape behind those per point in a row of the table: omega^2, its derivative by s, curvature at the slider, and the
#: first two derivatives of psi(s; s).
EXTRAS: Final = 5
#: Entries for the bodies behind those for the points, in rows of velocities and accelerations; two more make the rows' length a multiple
#: of four.
TIP_1, TIP_2, TIP_TURN, BASE_TURN, SLIDER_TURN, CRANK_TURN = range(6)
BODIES: Final = 8

#: Quantities of one state in `Workspace.facts`.
COS_Q2, SIN_Q2, Q2_RATE, S_RATE, Q2_REMAINDER, S_REMAINDER, CURVATURE, SLIDER_SLOPE, ALONG, ACROSS, EXCESS = range(11)
GAP, GAP_RATE, GAP_REMAINDER, TANGENT_1, TANGENT_2, FOOT_1, FOOT_2, MISSED, FORCE = range(11, 20)
FOOT_BY_S_1, FOOT_BY_S_2, ALONG_BY_Q2, ACROSS_BY_Q2, TOOL_1, TOOL_2 = range(20, 26)
#: The slider's place among the points; its force (N) and moment (N m) on the follower; the torque (N m) of the drive, or the base's where
#: its motion is prescribed.
AT, NORMAL, TANGENTIAL, SLIDER_MOMENT, TORQUE = range(26, 31)
#: Friction (N) that opposes the slider's way along the follower.
FRICTION: Final = 31
FACTS: Final = 32


class Tables(NamedTuple):
    """psi_i and its derivatives by s at points that move with the slider, piecewise cubic in s.

    Cells divide the follower from its base to the slider and from there to the end. Each has G Gauss points and its own end, and takes S
    places, the next multiple of four above G; what is left over weighs nothing. N = cells times S in all. A row of the table holds
    `kinds` blocks of (n, N), psi and for shapes that move its first two derivatives by s at fixed arc length; then EXTRAS blocks of
    (n,), then the lengths of the cells, and nothing up to the next multiple of eight.
    """

    low: float  # m, smallest s
    high: float  # m, largest s
    step: float  # m, between nodes
    kinds: int  # 3, or 1 for shapes that stay where they are
    coefficients: Cube  # (intervals, 4, row length), powers of s - node, highest first
    before: Vector  # (intervals,) number of cells between base and slider, less one
    G: int
    S: int
    cells: int
    u: Vector  # (G,) Gauss points in fractions of a cell
    lagrange: Vector  # (G,) weights of Lagrange's polynomials through the Gauss points, see `gauss_points.lagrange_weights`
    weights: Vector  # (S,) of the integral over a cell of unit length
    to_points: Vector  # (G S,) row by row, weight of each Gauss point in the integrals from the cell's beginning to each of the S places


class Parameters(NamedTuple):
    """Constants of the equations, SI. m = speeds: the crank's, n amplitudes', and where the loop is open the base angle's."""

    treatment: int
    n: int  # shapes
    speeds: int  # m
    first: int  # first free speed: 1 where the crank's is prescribed
    d: float
    LA: float
    L: float
    crank_mass: float  # with the slider's
    crank_inertia: float  # about O, with the slider's mass
    crank_moment: float  # kg m, mass times distance from O, with the slider's
    torque: float
    crank_damping: float
    base_inertia: float
    base_damping: float
    base_friction: float  # N m
    rhoA: float
    EI: float
    beam_damping: float
    damps_along: float  # 1; 0 where the beam damping acts on the velocity across the base tangent alone
    tip_mass: float
    tip_inertia: float
    tip_offset: float
    force_1: float  # N, on the tip, along n1 and n2
    force_2: float
    force_begin: float  # rad, of the crank
    force_span: float
    force_ramp: float
    slider_inertia: float
    gravity_1: float
    gravity_2: float
    plus: float  # of the joint's rollers, see `joint.Rollers`
    minus: float
    plus_from: float
    minus_from: float
    contact_loss: float
    joint_damping: float
    friction: float  # along the follower, over the normal force
    friction_force: float  # N, whatever the normal force
    friction_speed: float  # m/s
    joint_inertia: float  # kg, force over the gap's acceleration: slows the vibration of a stiff joint
    stabilization: float  # 1/s, rate at which a gap decays that a force keeps closed
    bending_damping: float  # s, damping moment over elastic moment per curvature rate
    base_speed: float  # rad/s, of BASE after its spin-up
    base_time: float  # s, of the spin-up
    thickness: float
    gauges: Vector
    reach: float  # m, s at which the slider counts as leaving the follower
    knows_frequency: int  # whether the shapes' highest frequency bounds that of the equations (5.9)
    tables: Tables


class Workspace(NamedTuple):
    """Scratch of one evaluation, for N points, n shapes and m speeds; rows of length M = 2 N + BODIES also hold the bodies' entries."""

    row: Vector  # interpolated row of the table
    psi: Vector  # (N,)
    psi_s: Vector  # (N,)
    gamma: Vector  # (N,) remainder of the angular acceleration before q2 and s are known
    turn: Vector  # (N,) angular rate
    curvature: Vector  # (N,) recovered, 1/m
    curvature_rate: Vector  # (N,) 1/(m s)
    bending_load: Vector  # (N,) what the material's damping does to an angle at the points, N m
    length: Vector  # (cells,) m
    e: Vector  # (2 N,) exp(i psi)
    z: Vector  # (2 N,) place relative to P in frame B
    Y: Vector  # (2 N,) change of the place with s
    integrand: Vector  # (2 N,)
    relative: Vector  # (2 N,) velocity relative to frame B
    dx: Vector  # (2 N,) share of the length, m, for real and imaginary parts alike
    mass: Vector  # (M,) kg, for turning bodies kg m^2
    V: Matrix  # (m, M) partial velocities in frame B
    A: Vector  # (M,) remaining acceleration less gravity in frame B
    force: Vector  # (M,)
    weighted: Vector  # (M,) a row of V times the masses
    foot: Matrix  # (3, m) right sides of the loop's rates along and across the tangent, and the tangent's turning, per speed, s held
    c: Vector  # (m,) partial rates of q2
    sigma: Vector  # (m,) partial rates of s
    row_of_gap: Vector  # (m,) partial rates of the gap
    spread: Vector  # (m,) generalised force per unit of slider force, sign reversed
    reduced: Matrix  # (m, m) mass matrix, factored in place
    response: Vector  # (m,) accelerations per unit of the slider's force
    acceleration: Vector  # (m,)
    slider: Vector  # (2,) s, m; highest angular frequency, rad/s, 0 where nobody knows it
    facts: Vector  # (FACTS,)


TABLES_TYPE: Final = tuple_type(Tables)
PARAMETERS_TYPE: Final = tuple_type(Parameters, tables=TABLES_TYPE)
WORKSPACE_TYPE: Final = tuple_type(Workspace)
parameters_at = reader(PARAMETERS_TYPE)
workspace_at = reader(WORKSPACE_TYPE)


def workspace(p: Parameters) -> Workspace:
    """Scratch arrays for these parameters."""
    n, m, N = p.n, p.speeds, p.tables.cells * p.tables.S
    M = 2 * N + BODIES
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(
        ("psi", "psi_s", "gamma", "turn", "curvature", "curvature_rate", "bending_load"), (N,)
    )
    shapes |= dict.fromkeys(("e", "z", "Y", "integrand", "relative", "dx"), (2 * N,))
    shapes |= dict.fromkeys(("mass", "A", "force", "weighted"), (M,))
    shapes |= dict.fromkeys(("c", "sigma", "row_of_gap", "spread", "response", "acceleration"), (m,))
    shapes |= {"row": p.tables.coefficients.shape[2:], "length": (p.tables.cells,), "foot": (3, m), "V": (m, M), "reduced": (m, m)}
    shapes |= {"slider": (2,), "facts": (FACTS,)}
    assert p.tables.kinds * n * N + EXTRAS * n + p.tables.cells <= shapes["row"][0]
    return Workspace(**{name: on_lines(shapes[name]) for name in Workspace._fields})


def state_size(p: Parameters) -> int:
    """Numbers of a state: coordinates, s, speeds, dissipated energy, work of the drive, and with an open loop that of the joint."""
    return 2 * p.speeds + 3 + (1 if p.speeds > p.n + 1 else 0)
