"""Numbers from outside: the theory that the engines are held against is itself held against print, and each row of the table is a test."""

import math

import numpy as np
import pytest

from tests.verification.literature.rotating_cantilever import cubic_frequency, frequencies, quasi_static_deflection
from tests.verification.literature.spin_up import PUBLISHED, at_rate, fitted_vibration, manoeuvre, scene, spinning_rod_stretch
from tests.verification.row import failures


@pytest.mark.parametrize(("rate", "printed"), list(zip(PUBLISHED["rates"], PUBLISHED["frequencies"], strict=True)))
def test_the_power_series_gives_the_published_frequencies(rate: float, printed: float) -> None:
    assert math.hypot(frequencies(rate, 1)[0], rate) == pytest.approx(printed, abs=2.0 * PUBLISHED["digits"])


def test_at_rest_the_series_is_the_cantilever_of_the_textbooks() -> None:
    roots = np.array([1.875104068711961, 4.694091132974175, 7.854757438237613])  # of cos b cosh b = -1
    assert frequencies(0.0, 3) == pytest.approx(roots**2, rel=1e-9)
    # under the load -x per unit length the end deflects by the integral of x^2 (3 - x)/6 times it, 11/120
    assert quasi_static_deflection(np.zeros(1), np.ones(1))[0] == pytest.approx(-11.0 / 120.0, rel=1e-12)


def test_ritz_bounds_from_above() -> None:
    for rate in (0.0, 2.0, 5.0):
        assert 1.0 < cubic_frequency(rate) / frequencies(rate, 1)[0] < 1.05


def test_the_stretch_solves_its_equation() -> None:
    """EA u'' + rho A W^2 (x + u) = 0 with u(0) = 0 and u'(L) = 0, by finite differences."""
    follower, speed = scene().follower, scene().spin_up.speed
    points = 2001
    x = np.linspace(0.0, follower.length, points)
    h, c = x[1], follower.mass_per_length * speed**2 / follower.axial_stiffness
    matrix = np.diag(np.full(points, -2.0 + c * h**2)) + np.diag(np.ones(points - 1), 1) + np.diag(np.ones(points - 1), -1)
    load = -c * h**2 * x
    matrix[0], load[0] = 0.0, 0.0
    matrix[0, 0] = 1.0
    matrix[-1, -2] = 2.0  # u' = 0: the point beyond the end mirrors the one before it
    assert np.linalg.solve(matrix, load)[-1] == pytest.approx(spinning_rod_stretch(scene()), rel=1e-5)
    # Simo and Vu-Quoc print three digits
    assert spinning_rod_stretch(scene()) == pytest.approx(5.14e-4, abs=5e-7)


def test_a_vibration_is_found_in_a_record_that_holds_it() -> None:
    time = np.linspace(0.0, 12.0, 601)
    signal = 0.3 * np.cos(2.0 * np.pi * 0.71 * time + 1.0) + 0.05
    found = fitted_vibration(time, signal, 0.75)
    assert (found.frequency, found.amplitude, found.mean) == pytest.approx((0.71, 0.3, 0.05), rel=1e-6)


def test_the_scene_has_the_published_numbers() -> None:
    """EA, EI and mass of Simo and Vu-Quoc, of which EA comes in by the section's thickness."""
    follower = scene().follower
    assert (follower.axial_stiffness, follower.bending_stiffness, follower.mass_per_length, follower.length) == pytest.approx(
        (2.8e7, 1.4e4, 1.2, 10.0), rel=1e-12
    )
    assert follower.section.area() == pytest.approx(4e-4, rel=1e-12)


def test_the_reference_meets_theory_and_print() -> None:
    rows = list(manoeuvre("reference"))
    assert [row.quantity for row in rows] == [
        "largest tip lag, linear theory",
        "largest tip lag, published",
        "frequency in steady spin",
        "mean tip deflection in steady spin",
    ]
    assert not failures(rows)


@pytest.mark.verify
@pytest.mark.parametrize("name", ["thesis", "exudyn", "mujoco", "fixed-shapes"])
def test_every_engine_meets_theory_and_print_in_the_manoeuvre(name: str) -> None:
    assert not failures(manoeuvre(name))


@pytest.mark.verify
@pytest.mark.parametrize("rate", [2.0, 4.0, 6.0])
@pytest.mark.parametrize("name", ["reference", "thesis", "exudyn", "mujoco"])
def test_every_engine_meets_the_published_frequencies(name: str, rate: float) -> None:
    assert not failures([at_rate(name, rate)])
