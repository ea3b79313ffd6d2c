"""Tables of shapes at points that move with the slider (DERIVATION.md, section 2)."""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.beam.modes import ModeFamily, mode_family
from quickreturn.reference_model.gauss_points import integrals_to_points, lagrange_weights
from quickreturn.reference_model.machine.memory import on_lines
from quickreturn.reference_model.mechanism import Crank, FollowerAlone, Mechanism, PrescribedSpeed, Slider, Tip
from quickreturn.reference_model.motion.layout import Tables
from quickreturn.reference_model.shapes import ShapeSet
from quickreturn.reference_model.splines import spline_coefficients

Array = NDArray[np.float64]


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


#: Where the rigid mechanism keeps the slider away from the end: left at 0.06 % of the length before it, which takes violent bending.
_USUAL: Final = _Reach(1e-4, 5e-4, 1, 1)
#: Where it does not; coarser tables would lose 5e-2 of the strain energy there.
_TO_THE_END: Final = _Reach(1e-6, 1e-5, 3, 8)
#: Up to so many modes come from one family: a run and the finer ones of its error estimate share it.
_SHARED: Final = 7
#: The part of the follower's length from which on the slider counts as near the end.
_NEAR: Final = 0.95
#: How far beyond the follower's end the tables of shapes that stay go, in parts of its length: a step that passes it is seen to.
_BEYOND: Final = 0.02


def _reach(mechanism: Mechanism) -> _Reach:
    farthest = mechanism.pivot_distance + mechanism.crank.length
    return _TO_THE_END if farthest > _NEAR * mechanism.follower.length else _USUAL


def slider_range(mechanism: Mechanism) -> tuple[float, float]:
    """Arc lengths that tables of shapes that follow cover, m: from a twentieth less than the rigid mechanism's to almost the end."""
    return _nearest(mechanism), (1.0 - _reach(mechanism).end) * mechanism.follower.length


def _nearest(mechanism: Mechanism) -> float:
    return max(0.95 * (mechanism.pivot_distance - mechanism.crank.length), 0.02 * mechanism.follower.length)


class Placed(NamedTuple):
    """Tables, and the slider's place (m) at which it counts as leaving the follower."""

    tables: Tables
    reach: float


class Following(NamedTuple):
    """Natural modes of the follower supported at the slider, following it.

    Attributes:
        placed: their tables.
        family: the modes as functions of the slider's place and of arc length.
        seconds: wall time that making them took earlier, where they were kept.
    """

    placed: Placed
    family: ModeFamily
    seconds: float


def following(mechanism: Mechanism, modes: int) -> Following:
    """The first `modes` modes. The last few are kept: a run, its rungs and its settled cycles ask for the same again."""
    tip, crank = mechanism.tip, mechanism.crank
    tip = None if tip is None else Tip(mass=tip.mass, inertia=tip.inertia, center_of_mass=tip.center_of_mass)
    at_rest = Crank(length=crank.length, drive=PrescribedSpeed(speed=0.0))
    began = time.perf_counter()
    found = _following(replace(mechanism, crank=at_rest, tip=tip, slider=Slider(), gravity=(0.0, 0.0)), modes)
    return found._replace(seconds=max(0.0, found.seconds - (time.perf_counter() - began)))


@lru_cache(maxsize=16)
def _following(bare: Mechanism, modes: int) -> Following:
    """Of a mechanism without what its modes do not depend on."""
    reach, high = _reach(bare), slider_range(bare)[1]
    shared, seconds = _family(bare, max(modes, _SHARED))
    began, family = time.perf_counter(), shared.first(modes)
    tables = span_tables(family, gauss_points(modes), reach.intervals * 24 * (modes + 1))
    seconds += time.perf_counter() - began
    return Following(Placed(tables, high - reach.leaving * bare.follower.length), family, seconds)


@lru_cache(maxsize=8)
def _family(bare: Mechanism, modes: int) -> tuple[ModeFamily, float]:
    """The modes as functions, and the wall time (s) that making them took."""
    began = time.perf_counter()
    family = mode_family(bare, modes, *slider_range(bare), _reach(bare).terms * (21 + 7 * modes))
    return family, time.perf_counter() - began


def gauss_points(modes: int) -> int:
    """Gauss points on each span for shapes that follow the slider.

    One less than a multiple of four, which with the span's end fills the places; fewer cost the same. Run 24 needs seven for five modes;
    a crank of 6 in, which brings the slider nearer to the end, has 2e-3 of the tip acceleration left with seven and 2e-4 with eleven. With
    four modes it has 1.2e-2 with seven and 4e-3 with eleven (`engines/LADDERS.md`, section 1).
    """
    return 7 if modes <= 3 else 11 if modes <= 9 else 15


def span_tables(family: ModeFamily, points: int, intervals: int) -> Tables:
    """Tables of shapes that follow the slider: one cell to either side of it, `points` Gauss points each."""
    gauss, _ = np.polynomial.legendre.leggauss(points)
    u = np.append(0.5 * (gauss + 1.0), 1.0)
    nodes = np.linspace(family.low, family.high, intervals + 1)
    spans = [family.shapes_at(nodes, u, span) for span in range(2)]
    psi = [np.stack([span[kind] for span in spans], axis=1) for kind in range(3)]  # (k, cells, points and end, n)
    extras = [
        *(family.squares_at(nodes, order) for order in (0, 1)),
        spans[0][3][:, -1, :],
        *(family.at_slider(nodes, order) for order in (1, 2)),
    ]
    lengths = np.stack([nodes, family.length - nodes], axis=1)
    coefficients = spline_coefficients(nodes, _rows(psi, extras, lengths))
    return _tables(nodes[0], nodes[-1], coefficients, True, points, np.zeros(intervals), 2)


def staying(mechanism: Mechanism, shapes: ShapeSet, squares: Array) -> Placed:
    """Smooth shapes that stay where they are: slopes of `shapes`, with cells that follow the slider.

    Args:
        mechanism: the scene.
        shapes: deflections, whose coordinates are those of the equations; none for a rigid follower.
        squares: stiffness of each shape, shape (n,).
    """
    length, n = mechanism.follower.length, shapes.count
    cells = 2 * max(2, math.ceil(1.3 * n / 7.0)) if n else 2
    inboard = round(2.0 * cells / 3.0)
    nodes = np.linspace(_nearest(mechanism), (1.0 + _BEYOND) * length, 12 * (n + 1) + 1)

    def edges(s: Array) -> Array:
        first = s[:, None] * np.linspace(0.0, 1.0, inboard + 1)
        return np.hstack([first, s[:, None] + (length - s[:, None]) * np.linspace(0.0, 1.0, cells - inboard + 1)[1:]])

    rows = _fixed_rows(shapes, squares, nodes, edges(nodes), 7)
    coefficients = spline_coefficients(nodes, rows)
    return Placed(_tables(nodes[0], nodes[-1], coefficients, False, 7, np.full(len(nodes) - 1, inboard - 1.0), cells), length)


def elements(mechanism: Mechanism, shapes: ShapeSet, squares: Array) -> Placed:
    """Shapes on elements of equal length: the slider divides its own, so that there is one cell more than elements.

    The slope of a cubic is a quadratic, and on a cell that the slider moves a cubic in s at most: the tables are exact.
    """
    length = mechanism.follower.length
    count = len(shapes.edges) - 1
    points = 3 if count > 4 else 7
    step = length / count
    pieces = []
    for k in range(count):
        s = shapes.edges[k] + step * np.array([0.1, 0.4, 0.7, 0.9])
        fixed = [np.full(len(s), edge) for edge in shapes.edges]
        edges = np.stack([*fixed[: k + 1], s, *fixed[k + 1 :]], axis=1)
        powers = np.vander(s - shapes.edges[k], 4)
        pieces.append(np.linalg.solve(powers, _fixed_rows(shapes, squares, s, edges, points)))
    slider_cell = np.arange(count, dtype=np.float64)
    tables = _tables(0.0, (1.0 + _BEYOND) * length, np.array(pieces), False, points, slider_cell, count + 1)
    return Placed(tables._replace(step=step), length)


def clamped(scene: FollowerAlone, angles: Callable[[Array], Array], squares: Array, nodes: Array | None) -> Tables:
    """Shapes of the follower alone, for one place of a slider that is not there.

    Args:
        scene: the follower alone.
        angles: tangent angles (k, n) of the shapes at arc lengths (k,).
        squares: stiffness of each shape, shape (n,).
        nodes: of elements, m; None where the shapes are smooth.
    """
    n, length, points = len(squares), scene.follower.length, 7
    edges = np.linspace(0.0, length, 2 * math.ceil((3 * n + 12) / 14.0) + 1) if nodes is None else nodes
    if len(edges) == 2:  # there is a cell to either side of where the slider would be
        edges = np.array([0.0, 0.5 * length, length])
    cells = len(edges) - 1
    gauss, _ = np.polynomial.legendre.leggauss(points)
    x = _places(edges[None], np.append(0.5 * (gauss + 1.0), 1.0))
    nothing = np.zeros((1, n))
    row = _rows([angles(x.ravel()).reshape(*x.shape, n)], [squares[None], nothing, nothing, nothing, nothing], np.diff(edges)[None])
    coefficients = np.zeros((1, 4, row.shape[1]))
    coefficients[0, 3] = row
    inboard = max(cells // 2, 1)
    middle = float(edges[inboard])
    return _tables(middle, middle, coefficients, False, points, np.array([inboard - 1.0]), cells)._replace(step=length)


def _fixed_rows(shapes: ShapeSet, squares: Array, s: Array, edges: Array, points: int) -> Array:
    """Rows of tables whose shapes stay, for places s (k,) and edges of the cells (k, cells + 1)."""
    gauss, _ = np.polynomial.legendre.leggauss(points)
    x = _places(edges, np.append(0.5 * (gauss + 1.0), 1.0))
    psi = shapes.evaluate(x.ravel(), 1).reshape(*x.shape, shapes.count)
    curvature, change = (shapes.evaluate(s, order) for order in (2, 3))
    rest = np.zeros_like(curvature)
    return _rows([psi], [np.broadcast_to(squares, curvature.shape), rest, curvature, curvature, change], np.diff(edges))


def _places(edges: Array, u: Array) -> Array:
    """Arc lengths (k, cells, points) of the fractions u of every cell."""
    return edges[:, :-1, None] + np.diff(edges)[:, :, None] * u


def _rows(psi: list[Array], extras: list[Array], lengths: Array) -> Array:
    """Rows (k, row length) of blocks (k, cells, Gauss points and end, n), extras (k, n) and lengths of cells (k, cells)."""
    places, taken = len(psi[0]), psi[0].shape[2]
    rest = 4 * ((taken - 1) // 4 + 1) - taken
    blocks = [np.pad(block, ((0, 0), (0, 0), (0, rest), (0, 0))).transpose(0, 3, 1, 2).reshape(places, -1) for block in psi]
    return np.concatenate([*blocks, *extras, lengths], axis=1)


def _tables(low: float, high: float, coefficients: Array, moves: bool, points: int, slider_cell: Array, cells: int) -> Tables:
    gauss, weights = np.polynomial.legendre.leggauss(points)
    places = 4 * (points // 4 + 1)
    to_points = on_lines((points, places))
    to_points[:, : points + 1] = 0.5 * integrals_to_points(gauss, weights)
    of_cell = on_lines((places,))
    of_cell[:points] = 0.5 * weights
    return Tables(
        low=float(low),
        high=float(high),
        step=float(high - low) / len(coefficients),
        moves=moves,
        coefficients=padded_to_lines(coefficients),
        slider_cell=np.ascontiguousarray(slider_cell),
        gauss_points=points,
        cell_size=places,
        cells=cells,
        points=cells * places,
        tip=(cells - 1) * places + points,
        u=0.5 * (gauss + 1.0),
        lagrange=lagrange_weights(0.5 * (gauss + 1.0)),
        weights=of_cell,
        to_points=to_points.ravel(),
    )


def padded_to_lines(coefficients: Array) -> Array:
    """The same (intervals, powers, row length), every row a whole number of the memory's lines."""
    intervals, powers, taken = coefficients.shape
    rows = on_lines((intervals, powers, 8 * math.ceil(taken / 8)))
    rows[:, :, :taken] = coefficients
    return rows
