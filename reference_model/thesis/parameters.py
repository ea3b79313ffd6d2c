"""Constants and scratch arrays of the compiled equations, built from a `Scene` and a `ShapeSet`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from quickreturn.reference_model.columns import PLACES
from quickreturn.reference_model.constants import constants
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.native.memory import Cube, Matrix, Vector
from quickreturn.reference_model.native.pointers import reader
from quickreturn.reference_model.rigid import deflection_scale
from quickreturn.reference_model.shapes import ShapeSet
from quickreturn.reference_model.thesis.tables import POINTS, ThesisTables, build_tables


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
