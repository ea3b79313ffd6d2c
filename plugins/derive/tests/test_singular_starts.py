"""Starts in a singular position, or close beside it: the motion begins as its rates point, or a sentence says what is missing."""

from typing import Any

import numpy as np
import pytest

from quickreturn.derive import DescriptionError, Model, sensitivities
from quickreturn.plugins.derive.equations import Form
from quickreturn.plugins.derive.tests.linkages import (
    angle_of_parallelograms,
    four_bar,
    parallelograms,
    rods_of_four_bar,
    rods_of_slider_crank,
    slider_crank,
    time_to,
)


def double_four_bar(form: Form = "projection") -> Model:
    return Model(parallelograms([1.0, 1.0], [1.0, 1.0], 1.0, 1.0), form)


def arms(angle: float, rate: float, count: int = 3) -> dict[str, float]:
    return {f"arm_{k}": angle for k in range(count)} | {f"arm_{k}_rate": rate for k in range(count)}


@pytest.mark.parametrize("form", ["projection", "multipliers"])
@pytest.mark.parametrize("angle", [0.0, 1e-9, -1e-7, *(pytest.param(each, marks=pytest.mark.verify) for each in (1e-6, 1e-5, 1e-4, -1e-4))])
def test_the_double_four_bar_starts_in_line(form: Form, angle: float) -> None:
    found = double_four_bar(form).simulate(arms(angle, -3.0), 1.0, 0.01)
    right = angle_of_parallelograms([1.0, 1.0], 1.0, 1.0, (angle, -3.0), found["time"].to_numpy())
    for k in range(3):
        np.testing.assert_allclose(found[f"arm_{k}"], right, atol=1e-9)
    assert np.ptp(found["energy_balance"]) < 1e-6
    # kinetic energy of three arms about their ends and two couplers on circles; the second position in line follows half a swing later
    # (the row at the start is that of a polynomial of degree 8 through the nodes, over a step of 0.1 rad)
    assert found["kinetic_energy"][0] == pytest.approx(0.5 * (3.0 / 3.0 + 2.0) * 9.0, rel=1e-8)
    assert len(found.attrs["singular_positions"]) == (2 if angle > -1e-6 else 1)
    if angle >= 0.0:
        assert found.attrs["singular_positions"][0] == pytest.approx(angle / 3.0, abs=1e-7)
    forces = found[["loop 0_force_1", "loop 1_force_2"]]
    assert np.isfinite(forces[1:]).all(axis=None)


def test_forces_have_a_pole_in_a_start_in_line() -> None:
    found = double_four_bar().simulate(arms(0.0, -3.0), 0.1, 0.01)
    loops = [name for name in found if "force" in name]
    assert found[loops].iloc[0].isna().all()
    assert np.isfinite(found.drop(columns=loops)).all(axis=None)


@pytest.mark.parametrize("angle", [1e-5, -1e-5])
def test_coordinates_that_loops_give_are_found_beside_the_line(angle: float) -> None:
    """Newton's method leaves them off by rounding over the distance, 1e-11, and the kinetic energy at the start by 1e-6."""
    found = double_four_bar().simulate({"arm_0": angle, "arm_0_rate": -3.0}, 1.0, 0.5)
    right = angle_of_parallelograms([1.0, 1.0], 1.0, 1.0, (angle, -3.0), found["time"].to_numpy())
    np.testing.assert_allclose(found["arm_0"], right, atol=1e-9)


def test_rates_choose_the_branch() -> None:
    """From the line a parallelogram may fold: arm 1 then turns against arm 0, by (coupler + arm) : (coupler - arm)."""
    lengths, masses = (2.0, 1.0, 2.0, 1.0), (1.0, 2.0, 1.5)
    start = {"crank": 0.0, "coupler": 0.0, "rocker": 0.0, "crank_rate": -4.0, "coupler_rate": 8.0, "rocker_rate": 12.0}
    found = Model(four_bar(lengths, masses)).simulate(start, 0.1, 0.01, tolerance=1e-11)
    end = found.iloc[-1]
    assert end["crank"] < -0.2
    assert end["rocker"] > 0.5
    rods = rods_of_four_bar(*lengths)
    assert time_to(rods, masses, 0.0, (end["crank"], end["crank_rate"]), -1e-3) + 1e-3 / 4.0 == pytest.approx(0.1, abs=1e-6)
    assert np.ptp(found["energy_balance"]) < 1e-8 * found["kinetic_energy"].max()


def test_a_slider_crank_starts_at_its_dead_point() -> None:
    """The block stands still there, and its place is the coordinate that no loop gives."""
    rods, masses, end = rods_of_slider_crank(0.3, 0.9), (1.0, 0.5, 2.0), 1.2
    duration = time_to(rods, masses[:2], masses[2], (0.0, 18.0), end)
    start = {"crank": 0.0, "rod": 0.0, "block": 1.2, "crank_rate": 18.0, "rod_rate": -6.0, "block_rate": 0.0}
    found = Model(slider_crank(0.3, 0.9, masses, "block")).simulate(start, duration, duration / 10)
    assert found["crank"].iloc[-1] == pytest.approx(end, abs=1e-7)
    assert found.attrs["singular_positions"] == [0.0]


@pytest.mark.parametrize(
    ("start", "sentence"),
    [
        (arms(0.0, -3.0, 2) | {"arm_2": 0.0}, r"the position is singular; give arm_2_rate, coupler_0_rate, coupler_1_rate as well"),
        (
            arms(0.0, -3.0) | {"arm_2_rate": -1.0},
            "no smooth motion passes it with these rates; give those of one motion, or start beside it",
        ),
        (arms(1e-7, -3.0) | {"arm_2_rate": -2.9}, "no smooth motion passes it with these rates"),
        (arms(0.0, 0.0), "the position is singular; nothing moves there; give rates, or start beside it"),
        ({"arm_0": 0.0, "arm_0_rate": -3.0}, "cannot move as the given rates say: .* in a singular position, give all coordinates"),
    ],
)
@pytest.mark.filterwarnings("ignore:.*could also start nearer")
def test_a_start_that_says_too_little_is_refused(start: dict[str, float], sentence: str) -> None:
    with pytest.raises(DescriptionError, match=f"of 'parallelograms' (cannot determine the motion at the start: )?.*{sentence}"):
        double_four_bar().simulate(start, 1.0, 0.1)


def test_sensitivities_do_not_begin_there() -> None:
    system = parallelograms([1.0], [1.0], 0.5, 1.0)
    system.load("wind", system.coordinates[0].q, system.constants(torque=(1.0, "N*m")).torque)
    start: dict[str, Any] = arms(0.0, -3.0, 2)
    with pytest.raises(DescriptionError, match="'loop 0' of 'parallelograms' cannot determine the motion at the start"):
        sensitivities(Model(system), ["torque"], start, 0.1, 0.1)
