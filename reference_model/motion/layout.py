"""Constants, tables and scratch of one beam's equations of motion (DERIVATION.md, sections 2 to 6).

Fields over the points lie in rows, complex ones as their N real parts followed by their N imaginary parts, so that loops run along memory.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np

from quickreturn.reference_model.joint import CHORDS, LEVER, MULTIPLIER
from quickreturn.reference_model.native.memory import ComplexVector, Cube, Matrix, Vector, on_lines
from quickreturn.reference_model.spring import SpringLaw

#: Entries for the bodies behind those for the points, in rows of velocities and accelerations; two more make the rows' length a multiple
#: of four.
TIP_1, TIP_2, TIP_TURN, BASE_TURN, SLIDER_TURN, CRANK_TURN = range(6)
BODIES: Final = 8


class Facts:
    """Quantities of one state. Vectors are in frame B. The bias of an acceleration is its value while all speeds are constant."""

    frame: complex  # exp(i q2), which turns from frame B to frame N
    q2_rate: float
    q2_bias: float
    s: float  # m, the slider's place along the follower
    s_rate: float
    s_bias: float
    arm: complex  # direction of the crank
    tangent: complex  # of the line that the slider rides on
    curvature: float  # 1/m, at the slider
    angle_by_s: float  # change of the tangent's angle at the slider with s, amplitudes held, 1/m
    foot: complex  # m, place of the slider on the follower
    foot_by_s: complex  # b_1 + i b_2, derivative of the foot by s, along and across the tangent
    closing_by_q2: complex  # m, right sides of the loop's rates for the speed of q2, along and across the tangent
    missed: float  # m, error of s: the place where the loop closes, less s
    gap: float  # m, from the foot to the crank tip along the normal
    gap_rate: float
    gap_bias: float
    unclosed: float  # m, distance by which the loop is open
    tip_arm: complex  # m, from x = L to the tip's centre of mass
    gravity: complex  # m/s^2
    tip_force: complex  # N, of the tool, with the friction of its slide
    slide_loss: float  # W, that this friction dissipates
    spring_place: complex  # m, where the spring holds the follower
    spring_line: complex  # direction from there to its fixed point
    spring_length: float  # m
    spring_rate: float  # m/s, of the length
    tension: float  # N, of the spring
    spring_force: complex  # N, on the follower
    slider_point: int  # index of the slider's point
    force: float  # N, of the slider along the normal where the loop is open
    friction: float  # N, opposes the slider's motion along the follower
    normal: float  # N, components of the slider's force on the follower
    tangential: float
    slider_force: complex  # N, on the follower
    slider_moment: float  # N m, on the follower
    torque: float  # N m, of the drive, or the base's where its motion is prescribed
    torque_slope: float  # N m s/rad, derivative of a motor's by the crank's speed


_KINDS: Final = {"int": np.int64, "float": np.float64, "complex": np.complex128}
FACTS: Final = np.dtype((np.record, [(name, _KINDS[kind]) for name, kind in Facts.__annotations__.items()]))


class ShapeRow(NamedTuple):
    """Parts of a table row, in this order, for N points and n shapes; or of rows of shape (...)."""

    psi_i: Matrix  # (..., n, N) psi_i at the points
    psi_i_s: Matrix  # (..., n, N) its derivative by s at fixed arc length; (..., 0, N) where the shapes stay
    psi_i_ss: Matrix  # and the second one
    squares: Vector  # (..., n) omega_i^2, 1/s^2
    squares_s: Vector  # (..., n) its derivative by s
    curvature_at_slider: Vector  # (..., n) 1/m
    angle_at_slider_s: Vector  # (..., n) derivatives of psi_i(s; s)
    angle_at_slider_ss: Vector
    length: Vector  # (..., cells) m

    @classmethod
    def of(cls, row: Vector, n: int, t: BeamTables) -> ShapeRow:
        """Views of rows (..., row length) of a table of n shapes."""
        moving = n if t.moves else 0
        sizes = [(n, t.points), (moving, t.points), (moving, t.points), *[(n,)] * 5, (t.cells,)]
        ends = np.cumsum([math.prod(size) for size in sizes])
        parts = np.split(row, ends, axis=-1)
        return cls(*(part.reshape(*row.shape[:-1], *size) for part, size in zip(parts, sizes, strict=False)))

    @property
    def joined(self) -> Vector:
        """The rows, shape (..., row length)."""
        lead = self.length.shape[:-1]
        return np.concatenate([part.reshape(*lead, -1) for part in self], axis=-1)

    def first(self, count: int) -> ShapeRow:
        """The rows of the first `count` shapes."""
        of_points = {name: getattr(self, name)[..., :count, :] for name in self._fields[:3]}
        return self._replace(**of_points, **{name: getattr(self, name)[..., :count] for name in self._fields[3:-1]})


class BeamTables(NamedTuple):
    """psi_i and its derivatives by s at points that move with the slider, piecewise cubic in s.

    Cells divide the follower from its base to the slider and from there to the end. The points of a cell are its Gauss points, its end, and
    fillers of zero weight up to `cell_size`, the next multiple of four. A row of the table holds the parts of `ShapeRow`, then zeros up to
    the next multiple of eight.
    """

    low: float  # m, smallest s
    high: float  # m, largest s
    step: float  # m, between nodes
    moves: bool  # whether the shapes depend on s
    coefficients: Cube  # (intervals, 4, row length), powers of s - node, highest first
    slider_cell: Vector  # (intervals,) number of the cell that ends at the slider
    gauss_points: int  # of a cell
    cell_size: int  # points of a cell, fillers included
    cells: int
    points: int  # N, cells times cell_size
    tip: int  # index of the point x = L
    u: Vector  # (gauss_points,) places of the Gauss points, as fractions of a cell
    lagrange: Vector  # (gauss_points,) weights of Lagrange's polynomials through them, see `gauss_points.lagrange_weights`
    weights: Vector  # (cell_size,) of the integral over a cell of unit length
    to_points: Vector  # (gauss_points cell_size,) weight of each Gauss point (row) in the integral from the cell's begin to each point


class BeamParameters(NamedTuple):
    """Constants of the equations, SI."""

    constraint: int  # see `joint.SliderConstraint`
    n: int  # shapes
    speeds: int  # m, number of speeds: the crank's, n amplitudes', and with an open loop the base angle's
    first: int  # first free speed: 1 where the crank's is prescribed
    d: float
    LA: float
    L: float
    crank_mass: float  # with the slider's
    crank_inertia: float  # about O, with the slider's mass
    crank_moment: float  # kg m, mass times distance from O, with the slider's
    torque: float
    crank_damping: float
    drive_begin: float  # this and the next three: see `constants.drive_constants`
    drive_way: float
    drive_period: float
    drive_table: Matrix
    base_inertia: float
    base_damping: float
    base_friction: float  # N m
    base_friction_rate: float  # rad/s
    rhoA: float
    EI: float
    beam_damping: float
    tip_mass: float
    tip_inertia: float
    tip_offset: float
    force_1: float  # N, on the tip, along n1 and n2
    force_2: float
    force_begin: float  # rad, of the crank
    force_span: float
    force_ramp: float
    force_table: Matrix  # see `tip.tool_constants`
    force_follows: int  # whether the force turns with the follower's end
    slide_friction: float  # N, of the tool's slide
    slide_speed: float  # m/s, over which that changes its sign
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
    stabilization: float  # 1/s, see `SliderConstraint`
    bending_damping: float  # s, damping moment over EI, per rate of curvature
    feedback: float  # 1/s, rate at which errors of the slider's arc length decay
    is_held: int  # whether a spring holds the follower
    anchor_1: float  # m, the spring's fixed point, from O along n1 and n2
    anchor_2: float
    spring_place: float  # m, arc length
    spring: SpringLaw
    base_speed: float  # rad/s, of BASE after its spin-up
    base_time: float  # s, of the spin-up
    extreme_fibre: float  # m
    places: Vector  # m, see `parameters.places`
    added_inertia: Vector  # (n,) of the amplitudes over their modal masses, see `parameters.added_inertia`
    reach: float  # m, slider position beyond which the slider counts as off the follower
    knows_frequency: int  # whether the shapes' highest frequency bounds that of the equations (5.9)
    tables: BeamTables

    @property
    def unknowns(self) -> int:
        """Number of unknowns of the linearised equations: the accelerations of the speeds, and the force of a constraint that has one."""
        return self.speeds + int(self.constraint in (MULTIPLIER, LEVER, CHORDS))


class BeamWorkspace(NamedTuple):
    """Scratch of one evaluation, for N points, n shapes and m speeds; rows of length M = 2 N + BODIES also hold the bodies' entries."""

    row: Vector  # interpolated row of the table, and what it holds, see `ShapeRow`
    psi_i: Matrix
    psi_i_s: Matrix
    psi_i_ss: Matrix
    squares: Vector
    squares_s: Vector
    curvature_at_slider: Vector
    angle_at_slider_s: Vector
    angle_at_slider_ss: Vector
    length: Vector
    psi: Vector  # (N,)
    psi_s: Vector  # (N,)
    gamma: Vector  # (N,) bias of the angular acceleration, without the terms in the second derivatives of q2 and s
    turn: Vector  # (N,) angular rate
    curvature_rate: Vector  # (N,) 1/(m s)
    bending_load: Vector  # (N,) generalised force of the material's damping for the tangent's angle at each point, sign reversed, N m
    e: Vector  # (2 N,) exp(i psi)
    z: Vector  # (2 N,) place relative to P in frame B
    Y: Vector  # (2 N,) derivative of the place by s at fixed arc length
    integrand: Vector  # (2 N,)
    relative: Vector  # (2 N,) velocity relative to frame B
    dx: Vector  # (2 N,) integration weights, m, for the real parts and again for the imaginary ones
    at_spring: Vector  # (N,) weights of the points in a field's value at the spring's place
    mass: Vector  # (M,) kg, for turning bodies kg m^2
    U: Matrix  # (n, 2 N) partial velocities relative to frame B, s held
    V: Matrix  # (m, M) partial velocities in frame B
    A: Vector  # (2 N,) bias acceleration, without the terms in the second derivatives of q2 and s
    bias: Vector  # (M,) bias acceleration less gravity in frame B
    a: Vector  # (M,) acceleration less gravity in frame B
    force: Vector  # (M,)
    weighted: Vector  # (M,) a row of V times the masses
    foot_rate: ComplexVector  # (m,) partial velocities of the foot relative to frame B, s held
    tangent_rate: Vector  # (m,) partial angular rates of the tangent there, likewise
    closing: ComplexVector  # (m,) right sides of the loop's rates per speed, along and across the tangent
    c: Vector  # (m,) partial rates of q2
    sigma: Vector  # (m,) partial rates of s
    row_of_gap: Vector  # (m,) partial rates of the gap
    spread: Vector  # (m,) generalised force per unit of slider force, sign reversed
    M: Matrix  # (m, m) mass matrix, lower triangle
    factor: Matrix  # (m, m) its factor
    Q: Vector  # (m,) generalised forces
    response: Vector  # (m,) accelerations per unit of the slider's force
    acceleration: Vector  # (m,)
    load: Vector  # (2 N,) force on the beam per length, N/m
    load_moment: Vector  # (N,) its moment about P per length, N
    inboard_force: Vector  # (2 N,) N
    inboard_moment: Vector  # (N,) N m
    moment: Vector  # (N,) bending moment, N m
    curvature: Vector  # (N,) recovered, 1/m
    recovered_angle: Vector  # (N,)
    recovered_e: Vector  # (2 N,)
    recovered_place: Vector  # (2 N,) m
    at_places: Matrix  # (2, 4) a field and the deflection at places of a row
    watched: Vector  # (2,) read by the integrator: s, m; highest angular frequency, rad/s, 0 if unknown
    facts: Facts


def workspace(p: BeamParameters) -> BeamWorkspace:
    """Scratch arrays for these parameters."""
    n, m, N = p.n, p.speeds, p.tables.points
    M = 2 * N + BODIES
    row = on_lines(p.tables.coefficients.shape[2:])
    sizes = (
        ("psi psi_s gamma turn curvature_rate bending_load at_spring load_moment inboard_moment moment curvature recovered_angle", (N,)),
        ("e z Y integrand relative dx A load inboard_force recovered_e recovered_place", (2 * N,)),
        ("mass bias a force weighted", (M,)),
        ("tangent_rate c sigma row_of_gap spread Q response acceleration", (m,)),
        ("U", (n, 2 * N)),
        ("V", (m, M)),
        ("M factor", (m, m)),
        ("watched", (2,)),
        ("at_places", (2, 4)),
    )
    fields: dict[str, Any] = {name: on_lines(size) for names, size in sizes for name in names.split()}
    fields |= {name: np.zeros(m, dtype=complex) for name in ("foot_rate", "closing")}
    return BeamWorkspace(row=row, **ShapeRow.of(row, n, p.tables)._asdict(), **fields, facts=np.zeros(1, FACTS)[0])


def state_size(p: BeamParameters) -> int:
    """Size of the state vector: coordinates, s, speeds, dissipated energy, work of the drive, and with an open loop that of the joint."""
    return 2 * p.speeds + 3 + (1 if p.speeds > p.n + 1 else 0)
