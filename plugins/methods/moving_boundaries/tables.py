"""Integrals of the shapes over both domains, tabulated over the support's place l for the equations (section 2 of DERIVATION.md).

A row holds vectors of n numbers, then matrices of n times n. On each interval of l it is a polynomial. The equations derive from the
tabulated kinetic and potential energy, so that energy is conserved up to the jumps of the polynomials between intervals.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.beam.modes import ModeFamily
from quickreturn.reference_model.beam.tables import following
from quickreturn.reference_model.interpolation import integrals_to_points
from quickreturn.reference_model.mechanism import Mechanism

#: Vectors in a row, in this order: omega_i^2, b, a, W(L), W'(0), W'(L) and d (equations 2.3, 2.5 and 2.6).
SQUARES, TURNING, WEIGHT, END, BASE, END_SLOPE, DRAG_LEVER = range(7)
VECTORS: Final = 7
#: Matrices behind them: B, D, D^l, D^ll, C, R, H, P and S (equations 2.5 to 2.9).
CARRIED, DRAG, DRAG_CARRIED, DRAG_CARRIED_TWICE, CARRIED_TWICE, ROTATED, HANGING, PULLED, SHORTENED = range(9)
#: The first of the matrices whose signals are kept, from which on all are symmetric; and the number of all matrices.
SYMMETRIC: Final = CARRIED_TWICE
MATRICES: Final = 9

#: Number of Gauss points on each domain, less twice the number of shapes: products of two modes are then exact to round-off.
SPARE_POINTS: Final = 16
#: Length of an interval of l over that in the tables of `reference`, and degree of the polynomials: the second derivatives jump by 1e-9.
COARSER: Final = 2
DEGREE: Final = 7


class Shapes(NamedTuple):
    """The shapes of a scene and their tables."""

    family: ModeFamily | None  # the modes as functions of the support's place and of arc length; None for a rigid follower
    low: float  # m, range of the support's place l
    high: float  # m, range of the support's place l
    coefficients: Array  # of the rows, shape (intervals, degree + 1, length of a row), highest power of the fraction of the interval first
    reach: float  # slider position beyond which the slider counts as off the follower, m
    seconds: float  # wall time (s) that an earlier model spent on parts that this one reuses


def shapes_of(mechanism: Mechanism, modes: int, foreshortening: bool) -> Shapes:
    """Modes of the beam supported at l (equation 2.2) and their integrals, for every l that the crank reaches."""
    if mechanism.follower.is_rigid:
        return Shapes(None, 0.0, mechanism.follower.length, np.zeros((1, 1, 0)), mechanism.follower.length, 0.0)
    tables, reach, family, seconds = following(mechanism, modes, natural=True)
    edges = np.linspace(family.low, family.high, len(tables.coefficients) // COARSER + 1)
    u = 0.5 * (1.0 + chebyshev.chebpts1(DEGREE + 1))
    places = edges[:-1, None] + np.diff(edges)[:, None] * u
    rows = _rows(mechanism, family, places.ravel(), foreshortening).reshape(*places.shape, -1)
    coefficients = np.ascontiguousarray(np.linalg.inv(np.vander(u)) @ rows)
    return Shapes(family, family.low, family.high, coefficients, reach, seconds)


class _Fields(NamedTuple):
    """Fields for places l (k,) at p points of both domains, the last of which is x = L; those of n shapes have the shape (k, p, n)."""

    x: Array  # arc lengths and integration weights, m, (k, p); the domains' ends have zero weight
    dx: Array  # arc lengths and integration weights, m, (k, p); the domains' ends have zero weight
    V: Array  # deflection across the tangent at P, slope across the line, and their derivatives by l
    V_l: Array  # deflection across the tangent at P, slope across the line, and their derivatives by l
    slope: Array  # deflection across the tangent at P, slope across the line, and their derivatives by l
    slope_l: Array  # deflection across the tangent at P, slope across the line, and their derivatives by l
    base: Array  # slope at P across the line, (k, 1, n)
    base_l: Array  # slope at P across the line, (k, 1, n)


def _fields(family: ModeFamily, places: Array) -> _Fields:
    """The fields of equation 2.3 for places l (m), shape (k,)."""
    gauss, weights = np.polynomial.legendre.leggauss(2 * family.squares.shape[1] + SPARE_POINTS)
    u, to_points = np.append(0.5 * (gauss + 1.0), 1.0), 0.5 * integrals_to_points(gauss, weights)
    distance, parts = places[:, None], list[tuple[Array, ...]]()
    V = V_l = np.zeros((len(places), 1, family.squares.shape[1]))
    for span, (start, length) in enumerate(((0.0 * distance, distance), (distance, family.length - distance))):
        psi, psi_l, _, _ = family.shapes_at(places, u, span)
        V, V_l = (
            before[:, -1:] + length[:, :, None] * np.einsum("jp,kjn->kpn", to_points, angle[:, :-1])
            for before, angle in ((V, psi), (V_l, psi_l))
        )
        parts.append((start + length * u, 0.5 * length * np.append(weights, 0.0), V, V_l, psi, psi_l))
    _, _, at_l, at_l_l, angle, _ = (part[:, -1:] for part in parts[0])
    base = -at_l / distance[:, :, None]
    base_l = -(at_l_l + angle + base) / distance[:, :, None]
    x, dx, V, V_l, psi, psi_l = (np.concatenate(pair, axis=1) for pair in zip(*parts, strict=True))
    return _Fields(x, dx, V, V_l, psi + base, psi_l + base_l, base, base_l)


def _rows(mechanism: Mechanism, family: ModeFamily, places: Array, foreshortening: bool) -> Array:
    """Table rows for places l (m), shape (k,); returns shape (k, VECTORS n + MATRICES n^2)."""
    rhoA, L, tip = mechanism.follower.mass_per_length, mechanism.follower.length, mechanism.tip_body
    m, e = tip.mass, tip.center_of_mass
    x, dx, V, V_l, slope, slope_l, base, base_l = _fields(family, places)

    def motion(w: Array, turn: Array, of_base: Array) -> Array:
        """Displacements of the points and of the tip's centre, then rotations of tip and base block; shape (k, p + 3, n)."""
        return np.concatenate([w, w[:, -1:] + e * turn[:, -1:], turn[:, -1:], of_base], axis=1)

    one = np.ones_like(x)[:, :, None]
    moves, moves_l = motion(V + x[:, :, None] * base, slope, base), motion(V_l + x[:, :, None] * base_l, slope_l, base_l)
    rigid = motion(x[:, :, None], one, one[:, :1])
    masses = np.concatenate([rhoA * dx, np.tile([m, tip.inertia, mechanism.base.inertia], (len(places), 1))], axis=1)
    moved = masses.copy()
    moved[:, -2:] = 0.0  # without the rotations

    def product(weights: Array, first: Array, second: Array) -> Array:
        """The scalar products of equation 2.1, with these weights, of two sets of fields; shape (k, n, n)."""
        return np.einsum("kp,kpi,kpj->kij", weights, first, second, optimize=True)

    def tightened(tension: Array, at_end: float = 0.0) -> Array:
        """Geometric stiffness of a tension at the points (k, p), and of a moment per slope at the end; shape (k, n, n)."""
        weights = tension * dx
        weights[:, -1] = at_end
        return product(weights, slope, slope)

    carried, rotated = product(masses, moves, moves_l), product(moved, moves, moves)
    hanging = pulled = np.zeros_like(rotated)
    if foreshortening:
        rotated -= tightened(0.5 * rhoA * (L**2 - x**2) + m * (L + e), m * e * (L + e))
        hanging, pulled = tightened(rhoA * (L - x) + m, m * e), tightened(0.0 * x + 1.0)
    end = V[:, -1] + L * base[:, 0]
    vectors = (
        *(family.squares_at(places), product(masses, rigid, moves)[:, 0], np.einsum("kp,kpi->ki", moved, moves)),
        *(end, base[:, 0], slope[:, -1], np.einsum("kp,kpi->ki", x * dx, V)),
    )
    matrices = (
        0.5 * (carried - carried.transpose(0, 2, 1)),  # (2.5) makes it antisymmetric, the tabulated modes do so only nearly
        *(product(dx, V, V), product(dx, V, V_l), product(dx, V_l, V_l)),
        *(product(masses, moves_l, moves_l), rotated, hanging, pulled),
        tightened((x < places[:, None]).astype(np.float64)),
    )
    return np.concatenate([*vectors, *(matrix.reshape(len(places), -1) for matrix in matrices)], axis=1)
