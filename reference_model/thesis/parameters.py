"""Constants, scratch arrays and quadrature tables of the compiled equations, built from a `Scene` and a `ShapeSet`.

Tables have the shapes at the Gauss points of every cell, and the weights of integrals that end inside a cell. Cells carry `POINTS` Gauss
points. Integrals from 0 to a Gauss point or to the slider use the polynomial through the cell's points, so that integrands up to degree
POINTS - 1 are exact from 0 to anywhere, and up to degree 2 POINTS - 1 over a whole cell. With one cubic element and second-order
foreshortening every integral of the model is thereby exact (the highest degree is 10).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import PLACES
from quickreturn.reference_model.constants import constants
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.native.compilation import inner
from quickreturn.reference_model.native.memory import Cube, Matrix, Vector
from quickreturn.reference_model.native.pointers import reader
from quickreturn.reference_model.rigid import deflection_scale
from quickreturn.reference_model.shapes import ShapeSet

POINTS = 6  # Gauss points of a cell

_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(POINTS)
#: Gauss points and weights on 0 <= u <= 1.
UNIT_POINTS = 0.5 * (_GAUSS + 1.0)
UNIT_WEIGHTS = 0.5 * _WEIGHTS
#: PARTIAL[j]: coefficients, from u^1 on, of the integral from 0 to u of the Lagrange polynomial of point j.
PARTIAL = np.linalg.inv(np.vander(UNIT_POINTS, increasing=True)).T / np.arange(1, POINTS + 1)
#: TO_POINTS[p, j]: weight of point j in the integral from the cell's left end to point p.
TO_POINTS = np.array([[sum(PARTIAL[j, k] * u ** (k + 1) for k in range(POINTS)) for j in range(POINTS)] for u in UNIT_POINTS])


class ThesisTables(NamedTuple):
    """Shapes at the points of a mesh (m = number of cells, N = m POINTS points, n shapes; equation 1.2); arrays only, for compiled code."""

    edges: Vector  # (m + 1,) m
    x: Vector  # (N,) m
    weights: Vector  # (N,) m
    phi: Matrix  # (N, n)
    dphi: Matrix  # (N, n) 1/m
    ddphi: Matrix  # (N, n) 1/m^2
    end_phi: Vector  # (n,) at x = L
    end_dphi: Vector  # (n,)


def build_tables(shapes: ShapeSet, cells: int) -> ThesisTables:
    """Tables of `shapes` on `cells` cells of equal length, or on the shapes' own cells if `cells` is 0."""
    edges = np.linspace(0.0, shapes.edges[-1], cells + 1) if cells else shapes.edges
    lengths = np.diff(edges)
    x = (edges[:-1, None] + UNIT_POINTS * lengths[:, None]).ravel()
    weights = (UNIT_WEIGHTS * lengths[:, None]).ravel()
    end = edges[-1:]
    return ThesisTables(
        edges,
        x,
        weights,
        shapes.evaluate(x),
        shapes.evaluate(x, 1),
        shapes.evaluate(x, 2),
        shapes.evaluate(end)[0],
        shapes.evaluate(end, 1)[0],
    )


@inner
def partial_weights(u: float, length: float, out: Array) -> None:
    """To `out`: weights of a cell's points for the fraction u (0 to 1) of a cell of the given length (m), shape (3, POINTS).

    The rows give the integral from the cell's left end to u, the polynomial's value there, and its derivative by arc length. Each is the
    exact derivative of the one before, so that velocities and accelerations belong to the same discrete position.
    """
    for j in range(POINTS):
        integral = value = slope = 0.0
        for k in range(POINTS - 1, -1, -1):
            integral = (integral + PARTIAL[j, k]) * u
            value = value * u + (k + 1) * PARTIAL[j, k]
        for k in range(POINTS - 1, 0, -1):
            slope = slope * u + (k + 1) * k * PARTIAL[j, k]
        out[0, j], out[1, j], out[2, j] = integral * length, value, slope / length


@inner
def find_cell(edges: Array, x: float) -> int:
    """Index of the cell that holds x; the first or last one if x lies outside."""
    cell = 0
    while cell < len(edges) - 2 and x >= edges[cell + 1]:
        cell += 1
    return cell


@inner
def cumulate(edges: Array, integrand: Array, at_points: Array, at_edges: Array) -> None:
    """To `at_points` and `at_edges`: integrals from 0 to every point and every edge of a function given at the points (N,)."""
    at_edges[0] = 0.0
    for c in range(len(edges) - 1):
        length = edges[c + 1] - edges[c]
        first = c * POINTS
        total = 0.0
        for p in range(POINTS):
            part = 0.0
            for j in range(POINTS):
                part += TO_POINTS[p, j] * integrand[first + j]
            at_points[first + p] = at_edges[c] + part * length
            total += UNIT_WEIGHTS[p] * integrand[first + p]
        at_edges[c + 1] = at_edges[c] + total * length


class UnsuitableShapes(ValueError):
    """The shapes cannot describe a part of the scene; the text is a clause that says why."""


class ThesisParameters(NamedTuple):
    """Constants of the equations (thesis/DERIVATION.md, section 1), SI; read-only in compiled code."""

    d: float  # m, pivot distance
    LA: float  # m, crank length
    L: float  # m, follower length
    crank_mass: float  # kg, slider included
    crank_inertia: float  # kg m^2 about O, slider mass included
    crank_moment: float  # kg m, first moment of crank and slider about O
    torque: float  # N m
    crank_damping: float  # N m s
    drive_begin: float  # this and the next three: see `constants.drive_constants`
    drive_way: float
    drive_period: float
    drive_table: Matrix
    crank_is_free: bool
    base_inertia: float  # kg m^2
    base_damping: float  # N m s
    rhoA: float  # kg/m
    EI: float  # N m^2 (0 for the rigid follower: no shape refers to it)
    beam_damping: float  # N s/m^2
    tip_mass: float  # kg
    tip_inertia: float  # kg m^2
    tip_offset: float  # m
    force_1: float  # N, on the tip, along n1 and n2
    force_2: float  # N
    force_begin: float  # rad, of the crank
    force_span: float  # rad
    force_ramp: float  # rad
    force_table: Matrix  # without rows: a table is not modelled
    slider_inertia: float  # kg m^2
    gravity_1: float  # m/s^2
    gravity_2: float  # m/s^2
    has_gravity: bool
    exact_geometry: bool
    n: int  # number of shapes
    extreme_fibre: float  # m
    gauges: Vector  # (3,) m
    tables: ThesisTables
    shape_edges: Vector
    shape_coefficients: Cube  # (cells, degree + 1, n)
    shape_places: Matrix  # (PLACES, n) phi at the interior places whose deflection is shown
    moment_places: Matrix  # (PLACES, n) N, EI phi'' there
    stiffness: Matrix  # (n, n) N/m: EI int phi'' phi''
    mass_transverse: Matrix  # (n, n) kg: rhoA int phi phi
    base_speed: float  # rad/s, of a base that turns as prescribed, after its spin-up
    base_time: float  # s, of the spin-up
    deflection_scale: float  # m, see `rigid.deflection_scale`


def build_parameters(scene: Scene, shapes: ShapeSet, *, exact_geometry: bool, cells: int) -> ThesisParameters:
    """Parameters of the equations for a scene.

    Args:
        scene: the mechanism, with a rigid slider joint, or the follower alone, for which the constants of crank and slider are zero.
        shapes: the follower's shapes (`no_shapes` for a rigid follower).
        exact_geometry: exact planar geometry, or the thesis' second-order foreshortening with linear curvature.
        cells: cells of the quadrature mesh; 0 takes the shapes' own cells.

    Raises:
        UnsuitableShapes: a slider with rotary inertia on shapes whose curvature jumps.
    """
    of_scene, follower = constants(scene), scene.follower
    if of_scene["slider_inertia"] > 0.0 and not shapes.has_continuous_curvature:
        raise UnsuitableShapes(
            "a slider with rotary inertia needs shapes with continuous curvature: clamped-free modes or one Hermite element"
        )
    tables = build_tables(shapes, cells)
    EI = 0.0 if follower.is_rigid else follower.bending_stiffness
    places = follower.length * np.arange(1, PLACES + 1) / (PLACES + 1)
    return ThesisParameters(
        **{name: value for name, value in of_scene.items() if name in ThesisParameters._fields},
        crank_is_free=scene.crank_is_free,
        EI=EI,
        has_gravity=scene.has_gravity,
        exact_geometry=exact_geometry,
        n=shapes.count,
        tables=tables,
        shape_edges=np.ascontiguousarray(shapes.edges),
        shape_coefficients=np.ascontiguousarray(shapes.coefficients),
        shape_places=shapes.evaluate(places),
        moment_places=EI * shapes.evaluate(places, 2),
        stiffness=EI * (tables.ddphi.T @ (tables.weights[:, None] * tables.ddphi)),
        mass_transverse=follower.mass_per_length * (tables.phi.T @ (tables.weights[:, None] * tables.phi)),
        deflection_scale=deflection_scale(scene),
    )


class ThesisWorkspace(NamedTuple):
    """Scratch arrays of one evaluation of the equations (N points, m cells, n shapes); an evaluation reads nothing of the previous one."""

    slope: Vector  # (N,) W'
    slope_rate: Vector  # (N,) time derivative of W'
    W: Vector  # (N,)
    W_rate: Vector  # (N,)
    g: Vector  # (N,) 1 - dx/ds of the centre line
    g1: Vector  # (N,) dg/dW'
    F: Vector  # (N,)
    F_edges: Vector  # (m + 1,)
    f: Matrix  # (N, n) dF/deta_i
    f_edges: Matrix  # (m + 1, n)
    F_rate: Vector  # (N,)
    end: Vector  # (2,) W' and W at x = L
    watched: Vector  # (2,) read by the integrator: s, m; and 0 for the highest angular frequency, unknown here
    H: Vector  # (N,) int g'' (dW'/dt)^2
    H_edges: Vector  # (m + 1,)
    integrand: Vector  # (N,) scratch
    at_s: Matrix  # (4, n) phi, phi', phi'', phi''' at the slider
    f_s: Vector  # (n,) f at the slider
    f_s_slope: Vector  # (n,) df/dx at the slider
    weights: Matrix  # (3, POINTS)
    M: Matrix  # (n + 2, n + 2) mass matrix for (q1, q2, eta)
    Q: Vector  # (n + 2,) applied minus inertia forces
    tool: Vector  # (n + 2,) part of Q from the force on the tip
    C: Vector  # (n + 2,) q2dot = C . (q1dot, -, etadot)
    D: Vector  # (n + 2,) slider rotation rate = D . (q1dot, q2dot, etadot)
    reduced: Matrix  # (n + 1, n + 1)
    rhs: Vector  # (n + 1,)
    acceleration: Vector  # (n + 2,) q1, q2, eta


parameters_at, workspace_at = reader(ThesisParameters), reader(ThesisWorkspace)


def build_workspace(tables: ThesisTables) -> ThesisWorkspace:
    """Scratch arrays for a mesh of points and its shapes."""
    N, n, m = len(tables.x), tables.phi.shape[1], len(tables.edges) - 1
    sizes: tuple[tuple[str, tuple[int, ...]], ...] = (
        ("slope slope_rate W W_rate g g1 F F_rate H integrand", (N,)),
        ("F_edges H_edges", (m + 1,)),
        ("f", (N, n)),
        ("f_edges", (m + 1, n)),
        ("end watched", (2,)),
        ("at_s", (4, n)),
        ("f_s f_s_slope", (n,)),
        ("weights", (3, POINTS)),
        ("M", (n + 2, n + 2)),
        ("Q tool C D acceleration", (n + 2,)),
        ("reduced", (n + 1, n + 1)),
        ("rhs", (n + 1,)),
    )
    return ThesisWorkspace(**{name: np.zeros(size) for names, size in sizes for name in names.split()})


def state_size(parameters: ThesisParameters) -> int:
    """Length of the state vector (q1, eta, q1dot, etadot, dissipated energy, drive work)."""
    return 2 * parameters.n + 4
