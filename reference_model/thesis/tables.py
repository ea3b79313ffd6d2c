"""Quadrature tables: shapes at the Gauss points of every cell, and the weights of integrals that end inside a cell.

Cells carry `POINTS` Gauss points. Integrals from 0 to a Gauss point or to the slider use the polynomial through the cell's points,
so that integrands up to degree POINTS - 1 are exact from 0 to anywhere, and up to degree 2 POINTS - 1 over a whole cell. With one
cubic element and second-order foreshortening every integral of the model is thereby exact (the highest degree is 10).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.native.compilation import inner
from quickreturn.reference_model.native.memory import Matrix, Vector
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
def partial_weights(u: float, length: float, out: NDArray[np.float64]) -> None:
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
def find_cell(edges: NDArray[np.float64], x: float) -> int:
    """Index of the cell that holds x; the first or last one if x lies outside."""
    cell = 0
    while cell < len(edges) - 2 and x >= edges[cell + 1]:
        cell += 1
    return cell


@inner
def cumulate(
    edges: NDArray[np.float64], integrand: NDArray[np.float64], at_points: NDArray[np.float64], at_edges: NDArray[np.float64]
) -> None:
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
