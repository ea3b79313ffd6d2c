"""Shapes that follow the slider against the eigenvalue problem solved place by place, and the tables of all shapes."""

import itertools
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.beam.modes import ModeFamily, mode_family
from quickreturn.reference_model.beam.tables import slider_range, span_tables
from quickreturn.reference_model.mechanism import FollowerAlone, Mechanism
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.motion.layout import BeamTables, ShapeRow
from quickreturn.reference_model.natural_modes import supported_modes
from quickreturn.reference_model.shapes import hermite_elements
from tests.engines.scenes import INCH, run_24
from tests.reference_model.motion.beam_runs import fine_family, places_of, run, with_fine_tables
from tests.reference_model.motion.beam_states import ALONE, elements_of, modes_of
from tests.reference_model.thesis.thesis_runs import error

LONG_CRANK = run_24(crank={"length": 5.0 * INCH}, tip={"center_of_mass": 0.0127})
FRACTIONS = np.array([0.0, 0.2, 0.55, 0.9, 1.0])

#: Central differences of order eight, for first and second derivatives.
STENCILS = (
    np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]),
    np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560]),
)


def derivative(function: Callable[[float], Array], step: float, order: int = 1) -> Array:
    """First or second derivative at 0."""
    values = np.array([function(step * k) for k in range(-4, 5)])
    return np.asarray(np.tensordot(STENCILS[order - 1], values, axes=1) / step**order)


def largest_by_mode(values: Array) -> Array:
    return np.max(np.abs(values), axis=0)


@pytest.mark.parametrize("mechanism", [run_24(), LONG_CRANK])
@pytest.mark.parametrize("span", [0, 1])
@pytest.mark.parametrize("fraction", [0.02, 0.37, 0.98])
def test_shapes_and_derivatives_are_those_of_neighbouring_beams(mechanism: Mechanism, span: int, fraction: float) -> None:
    modes, length = 4, mechanism.follower.length
    family, (nearest, farthest) = fine_family(mechanism, modes), places_of(mechanism)
    s = nearest + fraction * (farthest - nearest)
    # points that stay on their span while s is varied: the second derivative by s jumps at the slider
    x = (0.02 + 0.9 * FRACTIONS) * s if span == 0 else s + (0.08 + 0.92 * FRACTIONS) * (length - s)
    u = x / s if span == 0 else (x - s) / (length - s)
    psi, psi_s, psi_ss, psi_x = (values[0] for values in family.shapes_at(np.array([s]), u, span))

    def angles(shift: float) -> Array:
        found = supported_modes(mechanism, s + shift, modes)
        own = (found.deflection(x, 1) - found.deflection(np.zeros(1), 1)).T
        return own * np.sign(np.sum(own * psi, axis=0))

    curvature = supported_modes(mechanism, s, modes).deflection(x, 2).T
    step = 0.004 * (length - s)
    # errors of the eigenvectors, 1e-12, over the step and its square; the family's series, whose derivatives are worst near its ends
    for found, expected, relative in (
        (psi, angles(0.0), 1e-8),
        (psi_s, derivative(angles, step), 1e-4),
        (psi_ss, derivative(angles, step, 2), 5e-3),
        (np.abs(psi_x), np.abs(curvature), 1e-7),
    ):
        assert np.all(largest_by_mode(found - expected) < relative * largest_by_mode(expected))


@pytest.mark.parametrize("mechanism", [run_24(), LONG_CRANK])
def test_frequencies_and_their_derivative(mechanism: Mechanism) -> None:
    modes = 5
    family, (nearest, farthest) = fine_family(mechanism, modes), places_of(mechanism)

    def squares_of(s: float) -> Array:
        return np.asarray((2.0 * np.pi * supported_modes(mechanism, s, modes).frequencies) ** 2, dtype=np.float64)

    for s in np.linspace(nearest, farthest, 7):
        squares = squares_of(s)
        # 120 terms resolve the sharpest bend of the five curves
        np.testing.assert_allclose(family.squares_at(np.array([s]))[0], squares, rtol=1e-8)
        slope = derivative(partial(lambda at, e: squares_of(at + e), s), 5e-4)
        # the series' derivative: two digits fewer
        np.testing.assert_allclose(
            family.squares_at(np.array([s]), 1)[0], slope, rtol=1e-5, atol=1e-5 * squares.max() / mechanism.follower.length
        )


def test_shapes_of_one_place_store_energy_separately() -> None:
    """The curvatures are orthogonal with the frequencies' squares, so that strain energy needs no integral."""
    mechanism, modes = LONG_CRANK, 5
    family = fine_family(mechanism, modes)
    points, weights = np.polynomial.legendre.leggauss(30)
    s, length = 0.47, mechanism.follower.length
    gram = np.zeros((modes, modes))
    for span, h in ((0, s), (1, length - s)):
        curvature = family.shapes_at(np.array([s]), 0.5 * (points + 1.0), span)[3][0]
        gram += mechanism.follower.bending_stiffness * curvature.T @ (0.5 * h * weights[:, None] * curvature)
    squares = family.squares_at(np.array([s]))[0]
    np.testing.assert_allclose(gram / np.sqrt(np.outer(squares, squares)), np.eye(modes), atol=1e-7)  # interpolation in s


def test_angle_curvature_and_rate_are_continuous_at_the_slider() -> None:
    family = fine_family(LONG_CRANK, 4)
    s = np.linspace(*places_of(LONG_CRANK), 9)
    first, second = family.shapes_at(s, np.ones(1), 0), family.shapes_at(s, np.zeros(1), 1)
    # psi, its derivative by s: interpolation; curvature: a natural condition of the eigenvalue problem, met as its shapes converge
    for kind, relative in ((0, 1e-7), (1, 1e-4), (3, 5e-5)):
        np.testing.assert_allclose(first[kind], second[kind], atol=relative * np.max(np.abs(first[kind])))
    assert np.max(np.abs(family.shapes_at(s, np.zeros(1), 0)[0])) < 1e-12 * np.max(np.abs(first[0]))  # rounding: psi(0) = 0


@pytest.mark.parametrize("mechanism", [run_24(), run_24(tip=None), LONG_CRANK])
def test_signs_do_not_jump(mechanism: Mechanism) -> None:
    """Between neighbouring places a mode changes by far less than itself; with a flipped sign it would change by twice itself."""
    family = mode_family(mechanism, 7, *slider_range(mechanism)[:2], 60)
    s = np.linspace(*places_of(mechanism), 400)
    shapes = np.concatenate([family.shapes_at(s, np.linspace(0, 1, 30), span)[0] for span in (0, 1)], axis=1)
    for before, after in itertools.pairwise(shapes):
        assert np.all(np.sum(before * after, axis=0) > 0.9 * np.sum(before**2, axis=0))


def rows_at(t: BeamTables, s: Array) -> Array:
    interval = np.clip(((s - t.low) / t.step).astype(int), 0, len(t.coefficients) - 1)
    ds = (s - t.low - interval * t.step)[:, None]
    c = t.coefficients[interval]
    return ((c[:, 0] * ds + c[:, 1]) * ds + c[:, 2]) * ds + c[:, 3]


def table_error(t: BeamTables, family: ModeFamily, s: Array, modes: int) -> list[float]:
    """Largest error of psi and its two derivatives on both spans, relative to the largest value."""
    rows, places, worst = rows_at(t, s), 2 * t.cell_size, []
    kept = np.concatenate([np.arange(t.gauss_points + 1), t.cell_size + np.arange(t.gauss_points + 1)])
    exact = [np.concatenate(pair, axis=1) for pair in zip(*(family.shapes_at(s, np.append(t.u, 1.0), k)[:3] for k in (0, 1)), strict=True)]
    for kind in range(3 if t.moves else 1):
        found = rows[:, kind * places * modes : (kind + 1) * places * modes].reshape(len(s), modes, places)[:, :, kept].transpose(0, 2, 1)
        worst.append(float(np.max(np.abs(found - exact[kind])) / np.max(np.abs(exact[kind]))))
    return worst


def test_cubic_tables_converge_to_the_family() -> None:
    modes = 3
    family, s = fine_family(run_24(), modes), np.linspace(*places_of(run_24()), 301)
    errors = np.array([table_error(span_tables(family, 6, intervals), family, s, modes) for intervals in (24, 48, 96)])
    # a cubic spline of a smooth function: halving the spacing gains 2^4, asymptotically
    assert np.all(errors[:-1] > 7.0 * errors[1:])
    assert np.all(errors[-1] < [1e-6, 1e-5, 1e-4])


#: Models with tables of every family, and what a cubic spline in s leaves of a row's parts, relative to the largest value. Found: 2e-7 with
#: fine tables of shapes that follow and those in use of clamped-free modes; rounding where shapes are cubic or the slider is not there.
FAMILIES: dict[str, tuple[Callable[[], BeamModel], float]] = {
    "following": (lambda: with_fine_tables(LONG_CRANK, 3), 1e-6),
    "modes": (lambda: BeamModel.staying(LONG_CRANK, modes_of(LONG_CRANK, 3)), 1e-6),
    "elements": (lambda: BeamModel.staying(LONG_CRANK, elements_of(LONG_CRANK, 3)), 1e-11),
    "alone": (lambda: BeamModel.alone(ALONE, 3), 1e-11),
    "alone, elements": (lambda: BeamModel.alone(ALONE, hermite_elements(ALONE.follower.length, 2)), 1e-11),
}


@pytest.mark.parametrize("name", FAMILIES)
def test_rows_of_tables_hold_what_they_name(name: str) -> None:
    """`ShapeRow`, by the shapes themselves: angles at the points, stiffness by integrals of the curvature, derivatives by differences."""
    make, within = FAMILIES[name]
    model = make()
    t, n, follower = model.parameters.tables, model.shapes, model.scene.follower
    gauss, weights = np.polynomial.legendre.leggauss(24)
    for s in [t.low] if isinstance(model.scene, FollowerAlone) else [0.38, 0.47, 0.55]:
        row = ShapeRow.of(rows_at(t, np.array([s]))[0], n, t)
        cell = int(t.slider_cell[min(int((s - t.low) / t.step), len(t.slider_cell) - 1)])
        begin = np.cumsum(row.length) - row.length
        assert np.sum(row.length) == pytest.approx(follower.length)
        assert begin[cell] + row.length[cell] == pytest.approx(s)
        x = begin[:, None] + row.length[:, None] * np.append(t.u, 1.0)
        places = (np.arange(t.cells)[:, None] * t.cell_size + np.arange(t.gauss_points + 1)).ravel()
        psi, psi_s = model._shapes(s, x.ravel())
        close(row.psi_i[:, places].T, psi, within)
        if t.moves:
            close(row.psi_i_s[:, places].T, psi_s, within)
        inner = begin[:, None] + row.length[:, None] * 0.5 * (gauss + 1.0)
        angles = model._shapes(s, inner.ravel())[0].reshape(t.cells, 24, n).transpose(1, 0, 2).reshape(24, -1)
        series = np.polynomial.legendre.legder(np.polynomial.legendre.legfit(gauss, angles, 23))
        curvature = np.polynomial.legendre.legval(np.append(gauss, 1.0), series).reshape(t.cells, n, -1) * 2.0 / row.length[:, None, None]
        stiffness = np.einsum("cip,cp->i", curvature[:, :, :-1] ** 2, 0.5 * row.length[:, None] * weights)
        close(row.squares, follower.bending_stiffness * stiffness, within)
        if isinstance(model.scene, FollowerAlone):
            continue
        close(row.curvature_at_slider, curvature[cell, :, -1], within)

        def there(e: float) -> Array:
            return np.asarray(model._shapes(s + e, np.array([s + e]))[0][0])  # noqa: B023

        def squares(e: float) -> Array:
            return ShapeRow.of(rows_at(t, np.array([s + e]))[0], n, t).squares  # noqa: B023

        close(row.angle_at_slider_s, derivative(there, 2e-3), within)
        close(row.angle_at_slider_ss, derivative(there, 2e-3, 2), within)
        close(row.squares_s, derivative(squares, 2e-3), within, float(np.max(row.squares)) / follower.length)


def close(found: Array, expected: Array, within: float, size: float = 0.0) -> None:
    """Equal to a part of the largest value."""
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=within * max(float(np.max(np.abs(expected))), size))


@pytest.mark.parametrize("modes", [2, 3, 5])
@pytest.mark.parametrize(
    ("mechanism", "factor"), [(run_24(), 1.0), (run_24(crank={"length": 6.0 * INCH}), 10.0)], ids=["run 24", "crank 6 in"]
)
def test_tables_in_use_do_not_show_in_the_motion(mechanism: Mechanism, modes: int, factor: float) -> None:
    """An error of the shapes alone makes other, equally good shapes; replacing the tables by far finer ones must change little.

    Found in run 24: 1.5e-5, 5e-5, 4e-5, 6e-5; with the longest crank, whose slider comes close to the end, where shapes change fast:
    1.5e-4, 8e-4, 1.2e-3, 2.2e-3, of the size of what three to five modes leave.
    """
    own, fine = (run(model, 0.5, 500, 1e-9)[1] for model in (BeamModel.following(mechanism, modes), with_fine_tables(mechanism, modes)))
    for name, effect in (("tip_deflection", 3e-5), ("strain_1", 1e-4), ("slider_force", 2e-4), ("tip_acceleration", 3e-4)):
        assert error(own[name], fine[name]) < factor * effect, name
