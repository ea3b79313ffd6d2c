"""What the equations read of the shapes, as functions of the support's place l: integrals over both domains (section 2 of DERIVATION.md).

A row holds vectors of n numbers, one behind the other, and then matrices of n times n. On each interval of l it is a polynomial. As the
equations come from the tabulated kinetic and potential energy and their derivatives, energy is kept as well as the polynomials meet.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from reference_model.beam.modes import ModeFamily
from reference_model.beam.tables import following
from reference_model.gauss_points import integrals_to_points
from reference_model.mechanism import Mechanism

Array = NDArray[np.float64]

#: Vectors in a row, in this order: omega_i^2, b, a, W(L) and W'(0) (equations 2.5 to 2.8).
SQUARES, TURNING, WEIGHT, END, BASE = range(5)
VECTORS: Final = 5
#: Matrices behind them (equations 2.5 to 2.11).
CARRIED, DRAG, DRAG_CARRIED, DRAG_CARRIED_TWICE, CARRIED_TWICE, ROTATED, HANGING, PULLED, SHORTENED = range(9)
#: The first of those whose signals are kept, which are symmetric, and the number of all.
SYMMETRIC: Final = CARRIED_TWICE
MATRICES: Final = 9

#: Gauss points on each domain beyond twice the number of shapes: products of two modes then are exact to round-off.
_SPARE_POINTS: Final = 16
#: Intervals of l over those of the tables of `reference`, and degree of the polynomials: they meet to 1e-9 of the second derivatives.
COARSER: Final = 2
_DEGREE: Final = 7


class Shapes(NamedTuple):
    """The shapes of a scene and their tables.

    Attributes:
        family: the modes as functions of the support's place and of arc length; None for a rigid follower.
        low, high: m, range of the support's place l.
        coefficients: of the rows, shape (intervals, degree + 1, length of a row), highest power of the fraction of the interval first.
        reach: m, place of the slider at which it counts as leaving the follower.
        seconds: wall time that parts took which were kept from an earlier model.
    """

    family: ModeFamily | None
    low: float
    high: float
    coefficients: Array
    reach: float
    seconds: float


def shapes_of(mechanism: Mechanism, modes: int, foreshortening: bool) -> Shapes:
    """Modes of the beam supported at l, and the integrals of section 2 over the range of l that the crank reaches."""
    if mechanism.follower.is_rigid:
        return Shapes(None, 0.0, mechanism.follower.length, np.zeros((1, 1, 0)), mechanism.follower.length, 0.0)
    (tables, reach), family, seconds = following(mechanism, modes)
    edges = np.linspace(family.low, family.high, len(tables.coefficients) // COARSER + 1)
    u = 0.5 * (1.0 + chebyshev.chebpts1(_DEGREE + 1))
    places = edges[:-1, None] + np.diff(edges)[:, None] * u
    rows = _rows(mechanism, family, places.ravel(), foreshortening).reshape(*places.shape, -1)
    coefficients = np.ascontiguousarray(np.linalg.inv(np.vander(u)) @ rows)
    return Shapes(family, family.low, family.high, coefficients, reach, seconds)


def _rows(mechanism: Mechanism, family: ModeFamily, nodes: Array, foreshortening: bool) -> Array:
    """Rows for places l (k,), shape (k, VECTORS n + MATRICES n^2)."""
    rhoA, L, tip = mechanism.follower.mass_per_length, mechanism.follower.length, mechanism.tip_body
    m, e = tip.mass, tip.center_of_mass
    n = family.squares.shape[1]
    gauss, weights = np.polynomial.legendre.leggauss(2 * n + _SPARE_POINTS)
    u = np.append(0.5 * (gauss + 1.0), 1.0)
    to_points = 0.5 * integrals_to_points(gauss, weights)

    l = nodes[:, None, None]
    lengths = (l, L - l)
    psi, psi_l, across, across_l = [], [], [0.0 * l], [0.0 * l]  # across the base tangent: integrals of psi from 0
    for span in range(2):
        angle, angle_l, _, _ = family.shapes_at(nodes, u, span)
        psi.append(angle)
        psi_l.append(angle_l)
        for parts, integrand in ((across, angle), (across_l, angle_l)):
            parts.append(parts[-1][:, -1:] + lengths[span] * np.einsum("jp,kjn->kpn", to_points, integrand[:, :-1]))
    base = -across[1][:, -1:] / l  # (2.3)
    base_l = -(across_l[1][:, -1:] + psi[0][:, -1:] + base) / l
    x = np.concatenate([l * u[:-1, None], l + (L - l) * u[:-1, None], 0.0 * l + L], axis=1)
    dx = 0.5 * np.concatenate([lengths[0][:, :, 0] * weights, lengths[1][:, :, 0] * weights], axis=1)

    def along(spans: list[Array]) -> Array:
        """At the Gauss points of both domains, and at L."""
        return np.concatenate([spans[-2][:, :-1], spans[-1]], axis=1)

    V, V_l, slope, slope_l = (along(parts) for parts in (across, across_l, psi, psi_l))
    W, W_l, slope, slope_l = V + x * base, V_l + x * base_l, slope + base, slope_l + base_l
    # displacements of the points and the tip's centre, then the turning of tip and base block
    moves, moves_l, rigid = (
        np.concatenate([w[:, :-1], w[:, -1:] + e * d[:, -1:], d[:, -1:], at_base], axis=1)
        for w, d, at_base in ((W, slope, base), (W_l, slope_l, base_l), (x, 1.0 + 0.0 * x, 1.0 + 0.0 * l))
    )
    of_points = np.pad(rhoA * dx, ((0, 0), (0, 3)))
    of_points[:, -3] = m
    masses = of_points.copy()
    masses[:, -2:] = tip.inertia, mechanism.base.inertia

    def product(weight: Array, one: Array, other: Array) -> Array:
        return np.einsum("kp,kpi,kpj->kij", weight, one, other, optimize=True)

    def pull(per_length: Array, at_end: float) -> Array:
        """Of an axial force on each point, and a moment per slope at the end."""
        ends = np.full((len(nodes), 1), at_end)
        return product(np.concatenate([per_length[:, : dx.shape[1]] * dx, ends], axis=1), slope, slope)

    x = x[:, :, 0]
    carried = product(masses, moves, moves_l)
    rotated = product(of_points, moves, moves)
    hanging = pulled = np.zeros_like(rotated)
    if foreshortening:
        rotated = rotated - pull(0.5 * rhoA * (L**2 - x**2) + m * (L + e), m * e * (L + e))
        hanging, pulled = pull(rhoA * (L - x) + m, m * e), pull(np.ones_like(x), 0.0)
    shortened = pull(1.0 * (x < nodes[:, None]), 0.0)
    dx = np.pad(dx, ((0, 0), (0, 1)))
    vectors = (
        family.squares_at(nodes),
        product(masses, rigid, moves)[:, 0],
        np.einsum("kp,kpi->ki", of_points, moves),
        W[:, -1],
        base[:, 0],
    )
    matrices = (
        0.5 * (carried - carried.transpose(0, 2, 1)),  # antisymmetric as the modes stay normalised
        *(product(dx, one, other) for one, other in ((V, V), (V, V_l), (V_l, V_l))),
        product(masses, moves_l, moves_l),
        rotated,
        hanging,
        pulled,
        shortened,
    )
    return np.concatenate([*vectors, *(each.reshape(len(nodes), -1) for each in matrices)], axis=1)
