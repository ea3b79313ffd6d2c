"""Positions where the loops do not determine the motion: it ends there, or is refused at the start, with a sentence."""

import numpy as np
import pytest

from quickreturn.derive import DescriptionError, Model, System, natural_frequencies, turned, vector
from quickreturn.plugins.derive.equations import Form
from quickreturn.plugins.derive.tests.linkages import (
    G,
    angle_of_parallelograms,
    four_bar,
    parallelograms,
    rods_of_four_bar,
    rods_of_slider_crank,
    slider_crank,
    time_to,
    units,
)


@pytest.mark.parametrize("form", ["projection", "multipliers"])
@pytest.mark.parametrize("seed", range(4))
def test_a_row_of_parallelograms_moves_as_its_equation_of_one_degree_says_until_all_rods_are_in_line(seed: int, form: Form) -> None:
    """In line it may go on as such, or with arms against each other; it comes there fast, and in steps as long as a loose tolerance has."""
    random = np.random.default_rng(seed)
    count = 1 + seed % 3
    lengths, masses = random.uniform(0.3, 3.0, count).tolist(), random.uniform(0.1, 5.0, count).tolist()
    arm, arm_mass = random.uniform(0.2, 2.0, 2)
    start = float(random.uniform(0.2, 1.2)), -float(random.uniform(2.0, 30.0) / np.sqrt(arm))
    times = np.linspace(0.0, 1.0, 20_001)
    right = angle_of_parallelograms(masses, arm, arm_mass, start, times)
    end, tolerance = float(np.interp(0.0, -right, times)), 10.0 ** -random.uniform(4, 10)
    model = Model(parallelograms(lengths, masses, arm, arm_mass), form)
    arms = {f"arm_{k}": start[0] for k in range(count + 1)} | {f"arm_{k}_rate": start[1] for k in range(count + 1)}
    found = model.simulate(arms, 0.95 * end, 0.05 * end, tolerance)
    for k in range(count + 1):
        np.testing.assert_allclose(found[f"arm_{k}"], np.interp(found["time"], times, right), atol=1e3 * tolerance + 1e-8)
    with pytest.raises(
        DescriptionError, match=r"of 'parallelograms' comes to a singular position at .* s, with arm_0 = .*: there loop"
    ) as told:
        model.simulate(arms, 1.0, 0.01, tolerance)
    assert float(str(told.value).split(" at ")[1].split(" s,")[0]) == pytest.approx(end, rel=2e-2)


@pytest.mark.parametrize("free", ["rod", "block"])
def test_at_a_dead_point_of_the_chosen_coordinates_a_motion_ends_that_multipliers_continue(free: str) -> None:
    """The block stands still where crank and rod are in line, the rod's angle has its extremes; the crank's is the truth's coordinate."""
    masses, begin, end = (1.0, 0.5, 2.0), 0.8, 0.8 + 2.5 * np.pi
    rods, ratio = rods_of_slider_crank(0.3, 0.9), 3.0
    duration = time_to(rods, masses[:2], masses[2], (begin, 18.0), end)
    rod = float(np.arcsin(-np.sin(begin) / ratio))
    rate = {"rod": -18.0 * np.cos(begin) / (ratio * np.cos(rod)), "block": 18.0 * rods(begin)[1][3].real}[free]
    start = {"crank": begin, "rod": rod, "block": rods(begin)[1][1].real, f"{free}_rate": rate}
    system = slider_crank(0.3, 0.9, masses, free)
    with pytest.raises(DescriptionError, match=r"comes to a singular position at .* do not determine how it goes on"):
        Model(system).simulate(start, duration, duration / 20, tolerance=1e-10)
    found = Model(system, "multipliers").simulate(start, duration, duration / 20, tolerance=1e-10)
    assert found["crank"].iloc[-1] == pytest.approx(end, abs=1e-7)


@pytest.mark.parametrize("off", [1e-1, *(pytest.param(each, marks=pytest.mark.verify) for each in (1e-2, 1e-3, 1e-4))])
def test_a_linkage_that_nearly_folds_turns_off_as_its_lengths_say(off: float) -> None:
    """A longer rocker: at the line it misses the other branch by the root of `off`, and no step may lead there."""
    lengths, masses, speed = (1.0, 0.5, 1.0 - off / 4, 0.5 + off), (1.0, 2.0, 1.0), 9.0
    rods, end = rods_of_four_bar(*lengths), 1.0 + 2.0 * np.pi
    duration = time_to(rods, masses, 0.0, (1.0, speed), end)
    found = Model(four_bar(lengths, masses)).simulate({"crank": 1.0, "crank_rate": speed}, duration, duration / 10, tolerance=1e-10)
    assert found["crank"].iloc[-1] == pytest.approx(end, abs=1e-6)


@pytest.mark.parametrize("form", ["projection", "multipliers"])
@pytest.mark.parametrize("system", [slider_crank(0.2, 0.5, (1.0, 1.0, 1.0), "crank"), four_bar((1.0, 0.4, 0.9, 0.8), (1.0, 2.0, 1.5))])
def test_a_crank_that_turns_starts_at_any_angle(system: System, form: Form) -> None:
    model = Model(system, form)
    for angle in np.linspace(0.0, 2.0 * np.pi, 17):
        found = model.simulate({"crank": angle, "crank_rate": 20.0}, 0.05, 0.05)
        assert found["crank"].iloc[-1] > angle + 0.5


def stretched() -> System:
    """A driven crank of 0.2 m pulls a rod of 0.1 m along n1 until the rod stands upright: at 30 deg."""
    system = System("press")
    u, speed = units(system), system.constants(speed=(2.0, "rad/s")).speed
    angle, rod, x = system.coordinate("angle", "rad"), system.coordinate("rod", "rad"), system.coordinate("x", "m", guess=0.3)
    system.body("crank", inertia=0.1 * u.kg * u.m**2, angle=angle)
    system.body("rod", inertia=0.01 * u.kg * u.m**2, angle=rod)
    system.body("block", u.kg, vector(x, 0))
    system.loop("drive", angle - speed * system.time, "rad", gives=[angle])
    system.loop("pin", turned(angle, 0.2 * u.m) + turned(rod, 0.1 * u.m) - vector(x, 0), gives=[rod, x])
    return system


@pytest.mark.parametrize("form", ["projection", "multipliers"])
def test_a_drive_that_pulls_beyond_the_reach_ends_with_time_and_loops(form: Form) -> None:
    model = Model(stretched(), form)
    motion = {"rod_rate": -4.0, "x_rate": 0.0, "angle_rate": 2.0} if form == "multipliers" else {}
    with pytest.raises(
        DescriptionError, match=r"at 0\.261[78]\d* s, with angle = 0\.523\d rad, rod = -1\.5\d* rad, x = 0\.17\d+ m: there loop.*'pin'"
    ):
        model.simulate(motion, 1.0, 0.01)
    assert model.simulate(motion, 0.25, 0.05)["rod"].iloc[-1] == pytest.approx(-np.arcsin(2 * np.sin(0.5)), abs=1e-6)


@pytest.mark.parametrize("angle", [0.0, 1e-7, -5e-4])
def test_a_start_in_line_or_a_hair_beside_it_is_refused(angle: float) -> None:
    model, start = Model(parallelograms([1.0], [1.0], 1.0, 1.0)), {"arm_0": angle, "arm_1": angle, "arm_0_rate": -3.0, "arm_1_rate": -3.0}
    with pytest.raises(
        DescriptionError, match="loop 'loop 0' of 'parallelograms' cannot determine the motion at the start: the position is"
    ):
        model.simulate(start, 1.0, 0.1)


def test_a_loop_that_repeats_another_is_named() -> None:
    system = slider_crank(0.2, 0.5, (1.0, 1.0, 1.0), "crank")
    (crank, rod, _), m = (c.q for c in system.coordinates), system.parameters["m"][0]
    system.loop("level", turned(crank, 0.2 * m)[1] + turned(rod, 0.5 * m)[1])
    model = Model(system, "multipliers")
    with pytest.raises(DescriptionError, match="loops 'pin' and 'level' of 'slider-crank' cannot determine the motion at the start"):
        model.simulate({"crank": 1.0}, 1.0, 0.1)
    with pytest.raises(DescriptionError, match="small motions of 'slider-crank' are not determined: the position is singular, or a loop"):
        natural_frequencies(model, {"crank": 1.0})


def test_in_line_there_are_no_frequencies() -> None:
    """Beside the line the arms swing as one with the coupler at their ends: g (2 m L/2 + m L) / (2 m L^2/3 + m L^2)."""
    system = parallelograms([1.0], [1.0], 2.0, 1.0)
    system.gravity = vector(G, 0)
    model = Model(system)
    with pytest.raises(DescriptionError, match="small motions of 'parallelograms' are not determined: the position is singular"):
        natural_frequencies(model, {"arm_0": 0.0, "arm_1": 0.0})
    swinging = np.sqrt(G * 4.0 / (4.0 * 2.0 / 3.0 + 4.0)) / (2.0 * np.pi)
    np.testing.assert_allclose(natural_frequencies(model, {f"arm_{k}": 1e-3 for k in range(2)}), [swinging], rtol=1e-5)


def test_a_motion_whose_energy_does_not_balance_is_no_result(monkeypatch: pytest.MonkeyPatch) -> None:
    """An acceleration that is wrong by a ten-thousandth, as a wrong branch or too loose a tolerance would make it."""
    system = System("pendulum")
    system.gravity = vector(0, -9.81)
    angle, u = system.coordinate("angle", "rad"), units(system)
    system.body("bob", u.kg, turned(angle, u.m))
    model = Model(system)
    right = model.rates
    assert np.ptp(model.simulate({"angle_rate": 3.0}, 10.0, 0.1)["energy_balance"]) < 1e-5
    monkeypatch.setattr(model, "rates", lambda time, y, p: right(time, y, p) * [1.0, 1.0001, 1.0, 1.0])
    with pytest.raises(DescriptionError, match=r"'pendulum' is wrong from 0\.\d s at the latest: its energy balance has changed by"):
        model.simulate({"angle_rate": 3.0}, 10.0, 0.1)


def test_an_unknown_method_is_named() -> None:
    with pytest.raises(DescriptionError, match="method 'RK45' is not known; take one of DOP853, Radau"):
        Model(stretched()).simulate({}, 0.1, 0.1, method="RK45")
