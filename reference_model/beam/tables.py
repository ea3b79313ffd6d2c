"""Tables of shapes at points that move with the slider (DERIVATION.md, section 2)."""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.beam.modes import ModeFamily, mode_family, needs_base_shape
from quickreturn.reference_model.interpolation import integrals_to_points, lagrange_weights, spline_coefficients
from quickreturn.reference_model.mechanism import Crank, FollowerAlone, Mechanism, PrescribedSpeed
from quickreturn.reference_model.motion.layout import BeamTables, ShapeRow
from quickreturn.reference_model.native.memory import on_lines
from quickreturn.reference_model.rigid import crank_pace, rigid_kinetostatics
from quickreturn.reference_model.shapes import ShapeSet
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.tip import Tip


class _Reach(NamedTuple):
    """How near to the follower's end the tables go, and how fine they are; lengths as fractions of the follower's.

    Attributes:
        end: shortest second span in the tables: the stiffness of its modes grows without bound as its length vanishes.
        leaving: distance before the end of the tables at which the slider counts as off the follower, so that a step can end in between.
        terms: factor on the number of terms of the modes' series in s, whose error each derivative by s divides by the span's length.
        intervals: factor on the number of pieces of the tables.
    """

    end: float
    leaving: float
    terms: float
    intervals: float


#: For a slider that stays away from the follower's end in the rigid mechanism: off the follower 0.06 % of the length before the end.
_USUAL: Final = _Reach(1e-4, 5e-4, 1, 1)
#: For a slider that comes near the end, where coarser tables would lose 5e-2 of the strain energy.
_TO_THE_END: Final = _Reach(1e-6, 1e-5, 3, 8)
#: For one place alone: a ten-thousandth to either side of it is covered by a sixteenth of the terms as well.
_AT_ONE_PLACE: Final = _Reach(1e-4, 5e-4, 1.0 / 16.0, 1.0 / 16.0)
_TO_EITHER_SIDE: Final = 1e-4
#: Models with up to this many modes share one family: a run, and the finer runs of its error estimate.
_SHARED: Final = 7
#: Smallest slider position in any tables, and the one below which they are finer, as fractions of the follower's length.
_LEAST: Final = 1e-3
_NEAR_PIVOT: Final = 0.02
#: Gap of a compliant joint over the rigid mechanism's nearest slider position, above which the follower may fall off the slider: three such
#: gaps move the foot by the 5 % of that position that tables have to spare.
_FALLS: Final = 0.1
#: Fraction of the follower's length beyond which the slider counts as near the end.
_NEAR: Final = 0.95
#: Distance beyond the follower's end to which tables of fixed shapes go, as a fraction of its length, so that a step may pass the end.
_BEYOND: Final = 0.02


class _Range(NamedTuple):
    """Slider positions that tables of following shapes cover, and how fine they are.

    Attributes:
        low, high: m.
        reach: of the tables at the end.
    """

    low: float
    high: float
    reach: _Reach


def slider_range(mechanism: Mechanism) -> _Range:
    """From 5 % below the rigid mechanism's positions, or from the pivot where a soft joint lets the follower fall, to near the end."""
    length, farthest = mechanism.follower.length, mechanism.pivot_distance + mechanism.crank.length
    low, reach = _nearest(mechanism), _TO_THE_END if farthest > _NEAR * length else _USUAL
    if low < _NEAR_PIVOT * length:
        reach = reach._replace(terms=_TO_THE_END.terms, intervals=_TO_THE_END.intervals)
    return _Range(low, (1.0 - reach.end) * length, reach)


def _nearest(mechanism: Mechanism) -> float:
    """Smallest slider position in the tables, m."""
    least, rigid = _LEAST * mechanism.follower.length, mechanism.nearest
    return least if _gap(mechanism) > _FALLS * rigid else max(0.95 * rigid, least)


def _gap(mechanism: Mechanism) -> float:
    """Largest gap (m) that the slider force of the rigid mechanism causes in a turn, over the softer roller; infinite without stiffness."""
    if mechanism.slider.is_rigid:
        return 0.0
    force = rigid_kinetostatics(mechanism, np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False), crank_pace(mechanism))[0]
    softer = min(mechanism.slider.sides)
    return float(np.max(np.abs(force))) / softer if softer > 0.0 else math.inf


class BoundedTables(NamedTuple):
    """Tables, and the slider position `reach` (m) beyond which the slider counts as off the follower."""

    tables: BeamTables
    reach: float


class Following(NamedTuple):
    """Natural modes of the follower supported at the slider, for every slider position.

    Attributes:
        tables: their tables.
        reach: slider position beyond which the slider counts as off the follower, m.
        family: the modes as functions of the slider's place and of arc length.
        seconds: wall time (s) that an earlier call spent on them; 0 where this call made them.
    """

    tables: BeamTables
    reach: float
    family: ModeFamily
    seconds: float


def following(mechanism: Mechanism, modes: int, *, natural: bool = False, at: float | None = None) -> Following:
    """The first `modes` modes; the last of two or more is a shape for a moment at the base where that `needs_base_shape`, unless `natural`.

    Those of the last few mechanisms are kept: a run, its error estimate and its settled cycles share them. `at`: the only place of the
    slider (m) that is wanted, which takes a twentieth of the time; None: all places.
    """
    base_shape = not natural and modes > 1 and needs_base_shape(mechanism)
    tip, crank = mechanism.tip, mechanism.crank
    tip = None if tip is None else Tip(mass=tip.mass, inertia=tip.inertia, center_of_mass=tip.center_of_mass)
    at_rest = Crank(length=crank.length, drive=PrescribedSpeed(speed=0.0))
    began = time.perf_counter()
    bare = replace(mechanism, crank=at_rest, tip=tip, slider=Slider(), gravity=(0.0, 0.0))
    covered = _Range(at * (1.0 - _TO_EITHER_SIDE), at * (1.0 + _TO_EITHER_SIDE), _AT_ONE_PLACE) if at else slider_range(mechanism)
    kept = _following(bare, modes, base_shape, covered)
    return kept._replace(seconds=max(0.0, kept.seconds - (time.perf_counter() - began)))


@lru_cache(maxsize=16)
def _following(bare: Mechanism, modes: int, base_shape: bool, covered: _Range) -> Following:
    """The modes of a mechanism `bare` of everything on which they do not depend; `seconds` is the wall time of making them."""
    reach = covered.reach
    # the shape for a moment at the base differs with the number of modes
    shared, seconds = _family(bare, modes if base_shape else max(modes, _SHARED), base_shape, covered)
    began, family = time.perf_counter(), shared.first(modes)
    tables = span_tables(family, gauss_points(modes), math.ceil(reach.intervals * 24 * (modes + 1)))
    seconds += time.perf_counter() - began
    return Following(tables, covered.high - reach.leaving * bare.follower.length, family, seconds)


@lru_cache(maxsize=64)
def _family(bare: Mechanism, modes: int, base_shape: bool, covered: _Range) -> tuple[ModeFamily, float]:
    """The modes as functions, and the wall time (s) that making them took."""
    began = time.perf_counter()
    family = mode_family(bare, modes, covered.low, covered.high, math.ceil(covered.reach.terms * (21 + 7 * modes)), base_shape)
    return family, time.perf_counter() - began


def gauss_points(modes: int) -> int:
    """Gauss points on each span for shapes that follow the slider.

    One less than a multiple of four: with the span's end they fill whole registers of four numbers, and fewer cost the same. Run 24 needs
    seven for five modes. With a crank of 6 in, which brings the slider nearer to the end, the error of the tip acceleration is 2e-3 with
    seven and 2e-4 with eleven; with four modes it is 1.2e-2 and 4e-3 (`engines/LADDERS.md`, section 1).
    """
    return 7 if modes <= 3 else 11 if modes <= 9 else 15


def span_tables(family: ModeFamily, points: int, intervals: int) -> BeamTables:
    """Tables of shapes that follow the slider: one cell to either side of it, `points` Gauss points each."""
    gauss, _ = np.polynomial.legendre.leggauss(points)
    u = np.append(0.5 * (gauss + 1.0), 1.0)
    nodes = np.linspace(family.low, family.high, intervals + 1)
    inboard, outboard = (family.shapes_at(nodes, u, span) for span in range(2))
    psi, psi_s, psi_ss, curvature = (np.stack(of_spans, axis=1) for of_spans in zip(inboard, outboard, strict=True))
    row = ShapeRow(
        psi_i=_at_points(psi),
        psi_i_s=_at_points(psi_s),
        psi_i_ss=_at_points(psi_ss),
        squares=family.squares_at(nodes),
        squares_s=family.squares_at(nodes, 1),
        curvature_at_slider=curvature[:, 0, -1],
        angle_at_slider_s=family.at_slider(nodes, 1),
        angle_at_slider_ss=family.at_slider(nodes, 2),
        length=np.stack([nodes, family.length - nodes], axis=1),
    )
    coefficients = spline_coefficients(nodes, row.joined)
    return _tables(nodes[0], nodes[-1], coefficients, True, points, np.zeros(intervals), 2)


def staying(mechanism: Mechanism, shapes: ShapeSet, squares: Array) -> BoundedTables:
    """Smooth shapes that do not change with the slider's place: slopes of `shapes`, with cells that follow the slider.

    Args:
        mechanism: the scene.
        shapes: deflections, whose coordinates are those of the equations; none for a rigid follower.
        squares: modal stiffness of each shape, rad^2/s^2, shape (n,).
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
    return BoundedTables(_tables(nodes[0], nodes[-1], coefficients, False, 7, np.full(len(nodes) - 1, inboard - 1.0), cells), length)


def elements(mechanism: Mechanism, shapes: ShapeSet, squares: Array) -> BoundedTables:
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
    return BoundedTables(tables._replace(step=step), length)


def clamped(scene: FollowerAlone, angles: Callable[[Array], Array], squares: Array, nodes: Array | None) -> BeamTables:
    """Shapes of the follower alone. The tables have one interval, at an arc length that stands in for the slider's place.

    Args:
        scene: the follower alone.
        angles: tangent angles (k, n) of the shapes at arc lengths (k,).
        squares: modal stiffness of each shape, rad^2/s^2, shape (n,).
        nodes: element boundaries, m; None where the shapes are smooth.
    """
    length, points = scene.follower.length, 7
    edges = np.linspace(0.0, length, 2 * math.ceil((3 * len(squares) + 12) / 14.0) + 1) if nodes is None else nodes
    if len(edges) == 2:  # the equations expect a cell on either side of the slider's place
        edges = np.array([0.0, 0.5 * length, length])
    cells = len(edges) - 1
    gauss, _ = np.polynomial.legendre.leggauss(points)
    x = _places(edges[None], np.append(0.5 * (gauss + 1.0), 1.0))
    nothing = np.zeros((1, len(squares)))
    row = _unmoved(angles(x.ravel()).reshape(*x.shape, -1), squares, nothing, nothing, np.diff(edges)[None]).joined
    coefficients = np.zeros((1, 4, row.shape[1]))
    coefficients[0, 3] = row
    inboard = max(cells // 2, 1)
    middle = float(edges[inboard])
    return _tables(middle, middle, coefficients, False, points, np.array([inboard - 1.0]), cells)._replace(step=length)


def _fixed_rows(shapes: ShapeSet, squares: Array, s: Array, edges: Array, points: int) -> Array:
    """Table rows of fixed shapes, for slider positions s (m), shape (k,), and cell edges (m), shape (k, cells + 1)."""
    gauss, _ = np.polynomial.legendre.leggauss(points)
    x = _places(edges, np.append(0.5 * (gauss + 1.0), 1.0))
    psi = shapes.evaluate(x.ravel(), 1).reshape(*x.shape, shapes.count)
    return _unmoved(psi, squares, shapes.evaluate(s, 2), shapes.evaluate(s, 3), np.diff(edges)).joined


def _unmoved(psi: Array, squares: Array, curvature: Array, change: Array, length: Array) -> ShapeRow:
    """Rows of shapes that stay, from psi (k, cells, points, n), and its first and second derivative at the slider, (k, n)."""
    psi_i = _at_points(psi)
    return ShapeRow(
        psi_i=psi_i,
        psi_i_s=psi_i[:, :0],
        psi_i_ss=psi_i[:, :0],
        squares=np.broadcast_to(squares, curvature.shape),
        squares_s=np.zeros_like(curvature),
        curvature_at_slider=curvature,
        angle_at_slider_s=curvature,
        angle_at_slider_ss=change,
        length=length,
    )


def _places(edges: Array, u: Array) -> Array:
    """Arc lengths (m), shape (k, cells, points), at the fractions u (points,) of every cell."""
    return edges[:, :-1, None] + np.diff(edges)[:, :, None] * u


def _at_points(psi: Array) -> Array:
    """Values (k, n, N) at the points of all cells, with fillers, from those (k, cells, points, n) at the points of each."""
    k, cells, points, n = psi.shape
    places = 4 * math.ceil(points / 4)
    return np.pad(psi, ((0, 0), (0, 0), (0, places - points), (0, 0))).transpose(0, 3, 1, 2).reshape(k, n, cells * places)


def _tables(low: float, high: float, coefficients: Array, moves: bool, points: int, slider_cell: Array, cells: int) -> BeamTables:
    gauss, weights = np.polynomial.legendre.leggauss(points)
    places = 4 * (points // 4 + 1)
    to_points = on_lines((points, places))
    to_points[:, : points + 1] = 0.5 * integrals_to_points(gauss, weights)
    cell_weights = on_lines((places,))
    cell_weights[:points] = 0.5 * weights
    return BeamTables(
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
        weights=cell_weights,
        to_points=to_points.ravel(),
    )


def padded_to_lines(coefficients: Array) -> Array:
    """Coefficients (intervals, powers, row length) with every row padded to whole cache lines of eight numbers."""
    intervals, powers, used = coefficients.shape
    rows = on_lines((intervals, powers, 8 * math.ceil(used / 8)))
    rows[:, :, :used] = coefficients
    return rows
