"""Positions where the loops do not determine the motion: it passes them or begins there as its rates point, or it ends with a sentence."""

import casadi
import numpy as np
import pytest

from quickreturn.derive import DescriptionError, Model, System, natural_frequencies, sensitivities, turned, vector
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
def test_the_double_four_bar_moves_as_its_equation_of_one_degree_says(form: Form) -> None:
    """Five rods of 1 m and 1 kg. The published benchmark starts with 1 m/s at the tip and ends after 10 s, ten positions in line."""
    model = Model(parallelograms([1.0, 1.0], [1.0, 1.0], 1.0, 1.0), form)
    found = model.simulate({"arm_0": np.pi / 2, "arm_0_rate": -1.0}, 10.0, 0.1)
    end = found.iloc[-1]
    place = np.cos(end["arm_0"]), np.sin(end["arm_0"])
    velocity = -end["arm_0_rate"] * place[1], end["arm_0_rate"] * place[0]
    # a tolerance of 1e-9 grows a hundredfold in each of the turns over the top
    np.testing.assert_allclose([*place, *velocity], [0.3284581, 0.9445185, 1.423051, -0.494869], atol=2e-6)
    assert len(found.attrs["singular_positions"]) == 10
    assert np.ptp(found["energy_balance"]) < 1e-5 * found["kinetic_energy"].max()


@pytest.mark.parametrize(("form", "tolerance", "feedback"), [("multipliers", 1e-13, 100.0), ("projection", 1e-13, 0.0)])
def test_a_tight_tolerance_is_no_reason_to_end(form: Form, tolerance: float, feedback: float) -> None:
    """Rounding at the nodes of a passage is above these tolerances: two of ten passages ended the motion."""
    found = Model(parallelograms([1.0, 1.0], [1.0, 1.0], 1.0, 1.0), form, feedback).simulate(
        {"arm_0": np.pi / 2, "arm_0_rate": -1.0}, 10.0, 1.0, tolerance
    )
    assert np.cos(found["arm_0"].iloc[-1]) == pytest.approx(0.3284581112, abs=1e-8)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7])
def test_loops_are_closed_in_rows_within_long_steps(tolerance: float) -> None:
    """The rods turn slowly from the top, in steps as long as the feedback of the loops allows; in longer ones rows opened by 4 mm."""
    found = Model(parallelograms([1.0, 1.0], [1.0, 1.0], 1.0, 1.0)).simulate({"arm_0": np.pi / 2, "arm_0_rate": -1.0}, 3.0, 0.02, tolerance)
    right = angle_of_parallelograms([1.0, 1.0], 1.0, 1.0, (np.pi / 2, -1.0), found["time"].to_numpy())
    for arm in ("arm_0", "arm_1", "arm_2"):
        np.testing.assert_allclose(found[arm], right, atol=10.0 * tolerance)


def test_a_start_close_beside_a_singular_position_is_told_as_that() -> None:
    """One row of the loop nearly vanishes there: its rounding is no gap."""
    model = Model(parallelograms([1.0], [1.0], 1.0, 1.0))
    with pytest.raises(DescriptionError, match="'loop 0' of 'parallelograms' cannot determine the motion at the start: the position is"):
        model.simulate({"arm_0": 1e-7, "arm_1": 1e-7, "arm_0_rate": -3.0}, 1.0, 0.1)
    start = {"arm_0": 1e-3, "arm_1": 1e-3, "arm_0_rate": -3.0}
    right = angle_of_parallelograms([1.0], 1.0, 1.0, (1e-3, -3.0), np.array([0.0, 1.0]))[-1]
    assert model.simulate(start, 1.0, 0.1)["arm_0"].iloc[-1] == pytest.approx(right, abs=1e-7)


@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(k, marks=pytest.mark.verify) for k in range(2, 8))])
def test_generated_rows_of_parallelograms_pass_the_line(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = 1 + seed % 3
    form: Form = "multipliers" if seed % 2 else "projection"
    lengths, masses = random.uniform(0.3, 3.0, count).tolist(), random.uniform(0.1, 5.0, count).tolist()
    arm, arm_mass = random.uniform(0.2, 2.0, 2)
    start = float(random.uniform(-1.2, 1.2)), float(random.choice([-1, 1]) * random.uniform(2.0, 9.0) / np.sqrt(arm))
    model = Model(parallelograms(lengths, masses, arm, arm_mass), form)
    arms = {f"arm_{k}": start[0] for k in range(count + 1)} | {f"arm_{k}_rate": start[1] for k in range(count + 1)}
    found = model.simulate(arms, 1.5, 0.01, tolerance=1e-10)
    np.testing.assert_allclose(found["arm_0"], angle_of_parallelograms(masses, arm, arm_mass, start, found["time"].to_numpy()), atol=1e-6)
    assert len(found.attrs["singular_positions"]) >= 1
    # the last coupler does not turn: half of its weight and inertia hangs on the last arm, whose torque is that along the coupler
    turn, rate = found["arm_0"].to_numpy(), found["arm_0_rate"].to_numpy()
    inertia = (count + 1) * arm_mass * arm**2 / 3 + sum(masses) * arm**2
    acceleration = -9.81 * ((count + 1) * arm_mass * arm / 2 + sum(masses) * arm) / inertia * np.cos(turn)
    across = masses[-1] / 2 * (arm * (acceleration * np.cos(turn) - rate**2 * np.sin(turn)) + 9.81)
    torque = arm_mass * arm**2 / 3 * acceleration + arm_mass * 9.81 * arm / 2 * np.cos(turn) + arm * np.cos(turn) * across
    forces = found[f"loop {count - 1}_force_1"].to_numpy(), found[f"loop {count - 1}_force_2"].to_numpy()
    near = np.abs(np.sin(turn)) < 2e-4  # the pole: forces divided by the sine
    np.testing.assert_allclose(forces[1][~near], across[~near], atol=1e-5 * np.max(np.abs(across)))
    np.testing.assert_allclose(forces[0][~near], (torque / (arm * np.sin(turn)))[~near], rtol=1e-4, atol=1e-4 * np.max(np.abs(across)))
    times = np.array(found.attrs["singular_positions"])
    at = np.interp(times, found["time"], found["arm_0"])
    np.testing.assert_allclose(np.sin(at), 0.0, atol=5e-3)  # rows are 10 ms apart


@pytest.mark.parametrize("free", ["rod", "block"])
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.verify) for k in range(1, 6))])
def test_dead_points_of_the_chosen_coordinates_are_no_end(free: str, seed: int) -> None:
    """The block stands still where crank and rod are in line, the rod's angle has its extremes; the crank's is the truth's coordinate."""
    random = np.random.default_rng(seed)
    crank, ratio = random.uniform(0.1, 1.0), random.uniform(1.3, 4.0)
    masses = (float(random.uniform(0.2, 3.0)), float(random.uniform(0.2, 3.0)), float(random.uniform(0.2, 3.0)))
    begin, speed, end = 0.8, float(random.uniform(8.0, 20.0) / np.sqrt(crank)), 0.8 + 2.5 * np.pi
    rods = rods_of_slider_crank(crank, ratio * crank)
    duration = time_to(rods, masses[:2], masses[2], (begin, speed), end)
    b = float(np.arcsin(-np.sin(begin) / ratio))
    start = {"crank": begin, "rod": b, "block": rods(begin)[1][1].real}
    rate = {"rod": -speed * np.cos(begin) / (ratio * np.cos(b)), "block": speed * rods(begin)[1][3].real}[free]
    model = Model(slider_crank(crank, ratio * crank, masses, free))
    found = model.simulate({**start, f"{free}_rate": rate}, duration, duration / 20, tolerance=1e-10)
    assert found["crank"].iloc[-1] == pytest.approx(end, abs=1e-7)
    assert len(found.attrs["singular_positions"]) >= 2


@pytest.mark.parametrize("off", [1e-1, *(pytest.param(each, marks=pytest.mark.verify) for each in (1e-2, 1e-3, 1e-4))])
def test_a_linkage_that_nearly_folds_turns_off_as_its_lengths_say(off: float) -> None:
    """A longer rocker: at the line it misses the other branch by the root of `off`, and no step may lead there."""
    lengths, masses, speed = (1.0, 0.5, 1.0 - off / 4, 0.5 + off), (1.0, 2.0, 1.0), 9.0
    rods, end = rods_of_four_bar(*lengths), 1.0 + 2.0 * np.pi
    duration = time_to(rods, masses, 0.0, (1.0, speed), end)
    found = Model(four_bar(lengths, masses)).simulate({"crank": 1.0, "crank_rate": speed}, duration, duration / 10, tolerance=1e-10)
    assert found["crank"].iloc[-1] == pytest.approx(end, abs=1e-6)
    assert not found.attrs["singular_positions"]


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


def test_a_singular_start_and_a_loop_that_repeats_another_are_named() -> None:
    model = Model(parallelograms([1.0], [1.0], 0.5, 1.0))
    with pytest.raises(DescriptionError, match="loop 'loop 0' of 'parallelograms' cannot determine the motion at the start"):
        model.simulate({"arm_0": 0.0, "arm_0_rate": 1.0, "arm_1": 0.0, "coupler_0": 0.0}, 1.0, 0.1)
    system = slider_crank(0.2, 0.5, (1.0, 1.0, 1.0), "crank")
    (crank, rod, _), m = (c.q for c in system.coordinates), system.parameters["m"][0]
    system.loop("level", turned(crank, 0.2 * m)[1] + turned(rod, 0.5 * m)[1])
    with pytest.raises(DescriptionError, match="loops 'pin' and 'level' of 'slider-crank' cannot determine the motion at the start"):
        Model(system, "multipliers").simulate({"crank": 1.0}, 1.0, 0.1)


@pytest.mark.parametrize(
    ("start", "words"),
    [
        ({"arm_0": 0.5, "arm_0_rate": -5.0}, r"comes to a singular position at 0\.\d+ s, with arm_0 = .*: there loop 'loop 0' loses rank"),
        ({"arm_0": 0.0, "arm_1": 0.0, "arm_0_rate": -3.0, "arm_1_rate": -3.0}, "'loop 0' of 'parallelograms' cannot determine the motion"),
    ],
)
def test_sensitivities_neither_begin_nor_end_in_a_singular_position(start: dict[str, float], words: str) -> None:
    system = parallelograms([1.0], [1.0], 0.5, 1.0)
    system.load("wind", system.coordinates[0].q, system.constants(torque=(1.0, "N*m")).torque)
    with pytest.raises(DescriptionError, match=words):
        sensitivities(Model(system), ["torque"], start, 1.0, 0.1)


def test_a_motion_whose_energy_does_not_balance_is_no_result(monkeypatch: pytest.MonkeyPatch) -> None:
    """An acceleration that is wrong by a thousandth, as a wrong branch or too loose a tolerance would make it."""
    system = System("pendulum")
    system.gravity = vector(0, -9.81)
    angle, u = system.coordinate("angle", "rad"), units(system)
    system.body("bob", u.kg, turned(angle, u.m))
    model = Model(system)
    right = model.rates
    assert np.ptp(model.simulate({"angle_rate": 3.0}, 10.0, 0.1)["energy_balance"]) < 1e-5
    monkeypatch.setattr(model, "rates", lambda time, y, p: right(time, y, p) * [1.0, 1.001, 1.0, 1.0])
    with pytest.raises(DescriptionError, match=r"'pendulum' is wrong from 0\.\d s at the latest: its energy balance has changed by"):
        model.simulate({"angle_rate": 3.0}, 10.0, 0.1)


def test_an_unknown_method_is_named() -> None:
    with pytest.raises(DescriptionError, match="method 'RK45' is not known; take one of DOP853, Radau"):
        Model(stretched()).simulate({}, 0.1, 0.1, method="RK45")


def with_pendulum(system: System, length: float) -> System:
    """The same system with a bead of 1 kg that swings on a thread beside it."""
    p, swing = system.constants(bead=(1.0, "kg"), thread=(length, "m")), system.coordinate("swing", "rad")
    system.body("bead", p.bead, p.thread * vector(casadi.sin(swing), -casadi.cos(swing)))
    return system


def test_at_a_dead_point_a_held_block_holds_the_crank() -> None:
    """Crank and rod in line: the block's place is of second order in the crank's angle, so that no small motion is left to them."""
    model = Model(with_pendulum(slider_crank(1.0, 2.0, (1.0, 1.0, 1.0), "crank"), 0.5))
    pendulum = np.sqrt(G / 0.5) / (2.0 * np.pi)
    np.testing.assert_allclose(natural_frequencies(model, {}, hold=["block"]), [pendulum], rtol=1e-9)
    with pytest.warns(UserWarning, match="'slider-crank' is not at rest there: forces move 'crank'"):
        assert len(natural_frequencies(model, {})) == 2
    alone = Model(slider_crank(1.0, 2.0, (1.0, 1.0, 1.0), "crank"))
    assert len(natural_frequencies(alone, {}, hold=["block"])) == 0


def test_where_motions_cross_there_are_no_frequencies() -> None:
    """A parallelogram in line may go on as such, or with its arms against each other."""
    system = parallelograms([1.0], [1.0], 2.0, 1.0)
    system.gravity = vector(G, 0)
    model = Model(system)
    with pytest.raises(DescriptionError, match="motions cross there; give a position beside it"):
        natural_frequencies(model, {"arm_0": 0.0, "arm_1": 0.0})
    # beside it the arms swing as one with the coupler at their ends: g (2 m L/2 + m L) / (2 m L^2/3 + m L^2)
    swinging = np.sqrt(G * 4.0 / (4.0 * 2.0 / 3.0 + 4.0)) / (2.0 * np.pi)
    np.testing.assert_allclose(natural_frequencies(model, {f"arm_{k}": 1e-3 for k in range(2)}), [swinging], rtol=1e-5)


def test_a_loop_that_repeats_another_takes_no_motion_away() -> None:
    once, twice = (slider_crank(1.0, 2.0, (1.0, 1.0, 1.0), "crank") for _ in range(2))
    loop = twice.loops[0]
    twice.loop("again", loop.gap, gives=[])
    for each in (once, twice):
        each.gravity = vector(0, 0)
        each.spring("spring", each.coordinates[0].q - 0.3, each.constants(stiffness=(2.0, "N*m/rad")).stiffness)
    at = {"crank": 0.3}
    np.testing.assert_allclose(natural_frequencies(Model(twice, "multipliers"), at), natural_frequencies(Model(once), at), rtol=1e-9)


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
