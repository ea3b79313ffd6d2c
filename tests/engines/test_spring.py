"""A spring with preload, damper and stops from a place of the follower to a fixed point: closed forms, energy, engine against engine."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad

from quickreturn.cases.library import load_case
from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.one_run import run_once
from quickreturn.engines.registry import engine, usable_engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory, relative_error
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.natural_modes import supported_modes
from quickreturn.reference_model.spring import Spring, spring_energy, spring_stiffness, spring_tension
from tests.engines.energy import assert_agree
from tests.engines.scenes import run_24

ALL = ("reference", "exudyn", "mujoco", "derived", "fixed-shapes", "multiplier", "stiff-spring", "nodal-load")
FOUR = ALL[:4]
SLOW = ("derived", "nodal-load")  # take half a second to make
#: Spring and damper in the middle of the follower, which the slider passes; and stops at the follower's end.
MIDDLE = Spring(stiffness=60.0, anchor=(0.1, -0.3), place=0.42, free_length=0.3, damping=0.4)
STOPPED = Spring(stiffness=20.0, anchor=(-0.15, -0.5), preload=-1.0, preload_length=0.5, shortest=0.42, longest=0.62, stop_stiffness=300.0)


def prescribed(mechanism: Mechanism, speed: float = 16.0) -> Mechanism:
    return replace(mechanism, crank=replace(mechanism.crank, drive=PrescribedSpeed(speed=speed)))


@cache
def run(name: str, mechanism: Mechanism, duration: float = 0.4, accuracy: float | None = None, **settings: str) -> Result:
    return simulate(engine(name), mechanism, standard_start(mechanism), duration, 1e-3, settings, accuracy)


@pytest.mark.parametrize("spring", [MIDDLE, STOPPED], ids=["middle", "stopped"])
def test_energy_force_and_stiffness_of_the_law_belong_together_and_the_force_is_smooth(spring: Spring) -> None:
    law = spring.law
    rest, corners = law.rest, [x for x in (law.shortest, law.longest) if x < 1.0]
    for length in np.linspace(0.2, 0.9, 29):
        work = quad(lambda x: spring_tension(x, 0.0, law), rest, length, points=corners, limit=400)[0]
        assert spring_energy(length, law) == pytest.approx(work, rel=1e-6, abs=1e-9)
        slope = (spring_tension(length + 1e-7, 0.0, law) - spring_tension(length - 1e-7, 0.0, law)) / 2e-7
        assert spring_stiffness(length, law) == pytest.approx(slope, rel=1e-5)
    assert spring_tension(rest, 2.0, law) == law.preload + 2.0 * law.damping
    if law.stop:  # the stop pulls back where the spring is too long, and pushes where it is too short; its stiffness has no step
        for end, sense in ((law.longest, 1.0), (law.shortest, -1.0)):
            plain = law.preload + law.stiffness * (end + 0.01 * sense - rest)
            assert sense * (spring_tension(end + 0.01 * sense, 0.0, law) - plain) > 0.9 * 0.01 * law.stop
        for begin in (law.longest, law.longest + law.ramp, law.shortest, law.shortest - law.ramp):
            assert abs(spring_stiffness(begin + 1e-7, law) - spring_stiffness(begin - 1e-7, law)) < 1e-3 * law.stop


def once(name: str, mechanism: Mechanism, duration: float, step: float, accuracy: float) -> Trajectory:
    """A run without an estimate of its error."""
    chosen = usable_engine(name)
    return run_once(chosen, mechanism, standard_start(mechanism), duration, step, chosen.settings_for(accuracy, mechanism)).trajectory


@pytest.mark.parametrize(
    ("name", "spring"),
    [
        *((name, spring) for name in ("reference", "exudyn", "mujoco") for spring in (MIDDLE, replace(MIDDLE, place=None), STOPPED)),
        *((name, MIDDLE) for name in ALL[4:]),
    ],
)
def test_on_a_rigid_follower_slider_force_and_torque_follow_from_moments_and_virtual_work(name: str, spring: Spring) -> None:
    """The slider bears the spring's moment about P; the drive gives what the spring takes, by a virtual turn of the crank."""
    bare = prescribed(run_24(follower={"bending_stiffness": math.inf}))
    with_spring, without = (once(name, scene, 0.4, 1e-3, 1e-3) for scene in (replace(bare, spring=spring), bare))
    q1, q2, s = (with_spring[column] for column in ("crank_angle", "follower_angle", "slider_position"))
    d, LA = bare.pivot_distance, bare.crank.length
    x = spring.place or bare.follower.length
    away = complex(*spring.anchor) - d - x * np.exp(1j * q2)
    length, across = np.abs(away), (away / np.abs(away) * np.exp(-1j * q2)).imag
    rate = -across * x * LA * np.cos(q1 - q2) / s * with_spring["crank_speed"]
    tension = np.array([spring_tension(*each, spring.law) for each in zip(length, rate, strict=True)])
    known = with_spring["time"] > (0.05 if name == "stiff-spring" else -1.0)
    tolerance = 2e-3 if name == "stiff-spring" else 1e-4
    force = with_spring["slider_force"] - without["slider_force"]
    torque = with_spring["crank_torque"] - without["crank_torque"]
    expected = -tension * across * x / s
    assert np.max(np.abs(force - expected)[known]) < tolerance * np.max(np.abs(expected))
    expected = expected * LA * np.cos(q1 - q2)
    assert np.max(np.abs(torque - expected)[known]) < tolerance * np.max(np.abs(expected))
    assert np.max(np.abs(with_spring["spring_force"] - tension)[known]) < tolerance * np.max(np.abs(tension))
    stored = np.array([spring_energy(each, spring.law) for each in length])
    energy = with_spring["strain_energy"] - without["strain_energy"]
    assert np.max(np.abs(energy - stored)[known]) < tolerance * np.max(np.abs(stored))
    assert "spring_force" not in without.columns


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.verify] * (name in SLOW)) for name in (*ALL, "thesis", "moving-boundaries")]
)
def test_a_spring_without_force_changes_nothing_beyond_rounding(name: str) -> None:
    """Linear algebra may round otherwise, with more threads above all; one bit of a length grows to 1e-7 of a column's largest."""
    plain = prescribed(run_24()) if name == "moving-boundaries" else run_24()
    nothing = replace(plain, spring=Spring(stiffness=0.0, anchor=(0.1, -0.3), free_length=0.2))
    ours, theirs = (once(name, scene, 0.05, 1e-3, 0.1) for scene in (plain, nothing))
    assert ours.columns.keys() == theirs.columns.keys()
    for column in ours.columns:
        np.testing.assert_allclose(
            ours[column], theirs[column], rtol=0.0, atol=1e-6 * np.max(np.abs(theirs[column])) + 1e-12, err_msg=column
        )


@pytest.mark.parametrize("place", [None, 0.6], ids=["end", "overhang"])
@pytest.mark.parametrize("name", [FOUR[0], *(pytest.param(name, marks=pytest.mark.verify) for name in FOUR[1:])])
def test_at_rest_the_deflection_is_that_of_the_overhung_beam_on_an_elastic_support(name: str, place: float | None) -> None:
    """The crank is held at 180 degrees, and the follower swings until it rests. The spring is long, so that it keeps its direction."""
    machine = run_24(follower={"material_damping": 4e-3}, base={"damping": 0.0}, crank={"drive": PrescribedSpeed(speed=0.0)})
    L, EI, s = machine.follower.length, machine.follower.bending_stiffness, machine.pivot_distance + machine.crank.length
    x, far, stiffness, drawn = place or L, 50.0, 40.0, 0.02
    spring = Spring(stiffness=stiffness, anchor=(machine.pivot_distance - x, -far), place=place, free_length=far - drawn)
    scene, b = replace(machine, spring=spring), x - s
    found = once(name, scene, 2.0, 1e-2, 1e-3)
    support = 3.0 * EI / (b**2 * x)  # of the overhung beam under a force at x
    force = stiffness * support / (stiffness + support) * drawn
    at_base, beyond = -force * b * s / (6.0 * EI), L - x
    slope = force * b * (2.0 * s + 3.0 * b) / (6.0 * EI)  # at x
    tip = force / support + slope * beyond - at_base * L
    for column, expected in (
        ("tip_deflection", tip),
        ("spring_force", force),
        ("moment_slider", force * b),
        ("slider_force", -force * x / s),
    ):
        assert found[column][-1] == pytest.approx(expected, rel=3e-3), column


@pytest.mark.parametrize(
    "mechanism",
    [run_24(spring=MIDDLE), run_24(spring=STOPPED), pytest.param(load_case("return-spring").mechanism, marks=pytest.mark.verify)],
    ids=["middle", "stops", "library"],
)
@pytest.mark.parametrize("name", ["mujoco", *(pytest.param(name, marks=pytest.mark.verify) for name in ("exudyn", "derived"))])
def test_engines_agree_about_a_spring_within_what_they_claim(name: str, mechanism: Mechanism) -> None:
    ours, theirs = run("reference", mechanism), run(name, mechanism, accuracy={"exudyn": 1e-2}.get(name))
    assert_agree(ours, theirs)
    assert relative_error(theirs.trajectory["spring_force"], ours.trajectory["spring_force"]) < 1e-3


@pytest.mark.parametrize(
    "spring", [replace(MIDDLE, stiffness=600.0, place=0.6), replace(STOPPED, longest=0.5)], ids=["overhang", "at a stop"]
)
@pytest.mark.parametrize("name", ["exudyn", "mujoco", pytest.param("derived", marks=pytest.mark.verify)])
def test_engines_have_the_same_frequencies_with_a_spring(name: str, spring: Spring) -> None:
    def frequencies(engine: str, scene: Mechanism) -> Array:
        return usable_engine(engine).natural_frequencies(scene, 2.0, 2, usable_engine(engine).settings_for(1e-3, scene))

    expected = frequencies("reference", run_24(spring=spring))
    assert expected[0] > 1.02 * frequencies("reference", run_24())[0]
    np.testing.assert_allclose(frequencies(name, run_24(spring=spring)), expected, rtol=2e-3)


def test_a_stiff_spring_is_a_support() -> None:
    """With the slider at the middle of the follower a very stiff spring at the end makes a beam of two spans: the textbook's pi^2."""
    bare = replace(run_24(tip=None, base={"inertia": 0.0}), spring=Spring(stiffness=1e9, anchor=(0.0, -1.0), free_length=1.0))
    L, EI, rhoA = bare.follower.length, bare.follower.bending_stiffness, bare.follower.mass_per_length
    (found,) = supported_modes(bare, L / 2.0, 1, 1e9).frequencies
    assert found == pytest.approx(math.pi**2 * math.sqrt(EI / rhoA) / (L / 2.0) ** 2 / (2.0 * math.pi), rel=1e-6)


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"preload": 3.0}, "spring.preload", "is the length without force"),
        ({"free_length": None}, "spring.free_length", "is missing"),
        ({"shortest": 0.2}, "spring.shortest", "without spring.stop_stiffness"),
        ({"stop_stiffness": 5.0}, "spring.stop_stiffness", "no stop"),
        ({"stop_stiffness": 5.0, "shortest": 0.2, "longest": 0.2}, "spring.shortest", "not below spring.longest"),
        ({"place": 0.7}, "spring.place", "not on the follower"),
        ({"anchor": (0.0373, 0.0)}, "spring.anchor", "no direction"),
    ],
)
def test_what_cannot_be_is_refused_by_key(changes: dict[str, object], key: str, words: str) -> None:
    with pytest.raises(ImpossibleMechanism, match=words) as refused:
        run_24(spring=replace(MIDDLE, **changes))  # type: ignore[arg-type]
    assert refused.value.key == key
