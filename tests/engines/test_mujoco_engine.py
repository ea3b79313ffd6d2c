"""What the engine builds, refuses and reports, and the chain's natural frequencies."""

import dataclasses
import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.mujoco import chain
from quickreturn.engines.mujoco.engine import FEWEST_WITH_ORDER, MujocoEngine
from quickreturn.engines.mujoco.hook import damp_beam
from quickreturn.engines.mujoco.settings import ChainSettings, hinge_count
from quickreturn.engines.mujoco.simulation import _context
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.slider import Slider
from tests.engines.scenes import INCH, run_24

ENGINE = MujocoEngine()


def test_there_are_as_many_frequencies_as_links() -> None:
    assert ENGINE.natural_frequencies(run_24(), 1.0, 99, ChainSettings(links=6)).shape == (6,)


@pytest.mark.parametrize(
    ("mechanism", "bodies", "coordinates"),
    [
        (run_24(), 2 + 12 + 1, 14),
        (run_24(tip=None), 2 + 12, 14),
        (run_24(slider=Slider(mass=0.1)), 2 + 12 + 2, 14),
        (run_24(crank={"drive": PrescribedSpeed(speed=16.0)}), 1 + 12 + 1, 13),
        (run_24(crank={"drive": PrescribedSpeed(speed=16.0)}, slider=Slider(mass=0.1)), 1 + 12 + 1, 13),
        (run_24(follower={"bending_stiffness": math.inf}), 3, 2),
        (run_24(follower={"bending_stiffness": math.inf}, tip=None), 2, 2),
    ],
)
def test_description_lists_what_is_built(mechanism: Mechanism, bodies: int, coordinates: int) -> None:
    settings = ChainSettings(links=12)
    description = ENGINE.describe(mechanism, settings)
    model = chain.build(mechanism, hinge_count(mechanism, settings.links), 0.0)
    assert len(description.bodies) == bodies == model.nbody - 1  # MuJoCo counts the world
    assert len(description.joints) - 1 == coordinates == model.njnt == model.nv  # the slider's constraint is not MuJoCo's
    assert description.degrees_of_freedom == coordinates - 1


def test_model_has_the_mass_and_inertia_of_the_scene() -> None:
    mechanism = run_24(tip={"center_of_mass": 0.5 * INCH})
    mass, _ = chain.follower_matrices(chain.build(mechanism, 12, 0.0), mechanism, 12)
    beam, tip = mechanism.follower, mechanism.tip
    about_pivot = mechanism.base.inertia + beam.mass_per_length * beam.length**3 / 3.0
    about_pivot += tip.inertia + tip.mass * (beam.length + tip.center_of_mass) ** 2
    assert mass[0, 0] == pytest.approx(about_pivot, rel=1e-9)  # MuJoCo pads nothing here that matters


@pytest.mark.parametrize(
    ("mechanism", "key"),
    [
        (run_24(slider=Slider(inertia=1e-6)), "slider.inertia: 1e-06 kg*m^2"),
        (run_24(follower={"mass_per_length": 0.0}), "follower.mass_per_length: 0 kg/m"),
        (run_24(crank={"mass": 0.0, "inertia": 0.0}), "crank.inertia: 0 kg*m^2"),
    ],
)
def test_refuses_what_it_cannot_model(mechanism: Mechanism, key: str) -> None:
    with pytest.raises(Refusal, match="accepted: ") as refusal:
        ENGINE.prepare(mechanism, standard_start(mechanism), ChainSettings())
    assert str(refusal.value).startswith(key)


def test_slider_leaving_the_follower_is_a_failure_with_its_time() -> None:
    soft = run_24(follower={"bending_stiffness": run_24().follower.bending_stiffness / 100.0})
    with pytest.raises(EngineFailure, match="slider left the follower") as failure:
        ENGINE.prepare(soft, standard_start(soft), ChainSettings()).advance(2.0, 1e-3)
    partial = failure.value.partial
    assert partial["time"][-1] == failure.value.time
    assert 0.0 < failure.value.time < 1.0
    assert partial["slider_position"].max() <= soft.follower.length


@pytest.mark.verify
def test_a_damping_that_stops_one_motion_at_once_is_kept_up_with() -> None:
    """With 8 N s/m^2 the first links stop turning against the rest at 15,000 1/s; the vibrations have 3,500 rad/s at most."""
    damped = run_24(follower={"damping": 8.0})
    coarse = simulate(ENGINE, damped, standard_start(damped), 0.3, 1e-3, {"links": "8"})
    own = simulate(engine("reference"), damped, standard_start(damped), 0.3, 1e-3, {})
    ours, theirs = (run.trajectory["tip_deflection"] for run in (own, coarse))
    difference = np.sqrt(np.mean((theirs - ours) ** 2) / np.mean(ours**2))
    claims = [run.error_estimates["tip_deflection"] for run in (own, coarse)]
    assert difference < sum(claim or 0.0 for claim in claims) < 0.05


@pytest.mark.verify
def test_damping_matrix_takes_the_power_that_the_kernel_does() -> None:
    scene, hinges = run_24(follower={"damping": 3.0}, base={"damping": 0.2}), 12
    data = mujoco.MjData(chain.build(scene, hinges, 0.0))
    ((context,), _) = _context(scene, hinges, data)
    rates = np.sin(np.arange(1.0, hinges + 2.0))  # of the base and the hinges
    straight, forces = np.ones(hinges + 1, np.complex128), np.zeros(len(data.qpos))
    power = damp_beam(context, straight, np.cumsum(rates), forces)
    damping = chain.follower_damping(scene, hinges)
    assert rates @ damping @ rates == pytest.approx(power + 0.2 * rates[0] ** 2, rel=1e-12)
    assert damping[1:] @ rates == pytest.approx(-forces[-hinges:], rel=1e-12)


def test_an_unstable_step_is_a_failure_and_nothing_is_printed_or_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    mechanism = run_24()
    with pytest.raises(EngineFailure, match=r"engine\.step") as failure:
        ENGINE.prepare(mechanism, standard_start(mechanism), ChainSettings(links=16, armature=0.0, step=2.0)).advance(1.0, 1e-3)
    assert np.all(np.isfinite(failure.value.partial["tip_deflection"]))
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


def test_no_hook_is_left_behind() -> None:
    import mujoco

    mechanism = run_24()
    ENGINE.prepare(mechanism, standard_start(mechanism), ChainSettings()).advance(0.01, 1e-3)
    assert mujoco.get_mjcb_control() is None
    assert mujoco.get_mju_user_warning() is None


def test_simulations_do_not_disturb_each_other() -> None:
    slow = run_24(crank={"drive": TorqueDrive(torque=1.0, damping=0.1, initial_speed=5.0)})
    alone = ENGINE.prepare(slow, standard_start(slow), ChainSettings(links=8)).advance(0.02, 1e-3)
    first, second = (ENGINE.prepare(m, standard_start(m), ChainSettings(links=8)) for m in (slow, run_24()))
    pieces = []
    for _ in range(2):
        pieces.append(first.advance(0.01, 1e-3))
        second.advance(0.01, 1e-3)
    assert pieces[1]["crank_angle"][-1] == pytest.approx(alone["crank_angle"][-1], rel=1e-14)


@given(st.integers(1, 256))
def test_chains_are_compared_with_finer_ones_that_the_slider_shakes_in_another_way(links: int) -> None:
    own = ChainSettings(links=links)
    (pair,) = ENGINE.comparisons(own, run_24(), 1e-3)
    finer, order = pair.other.as_dict()["links"], 1.5 if links >= FEWEST_WITH_ORDER else 2.0
    assert pair.run == own
    assert finer >= 1.4 * links or links > 180  # which finds no finer chain
    assert math.gcd(links, finer) == 1
    assert pair.factor == pytest.approx((links / finer) ** order)
    if links >= FEWEST_WITH_ORDER:
        assert pair.before is None
        return
    assert pair.before.run == pair.other
    finest = pair.before.other.as_dict()["links"]
    assert finest >= 2.0 * links
    assert math.gcd(finest, links) == math.gcd(finest, finer) == 1


def test_half_the_step_shows_the_error_with_a_rigid_follower() -> None:
    (pair,) = ENGINE.comparisons(ChainSettings(), run_24(follower={"bending_stiffness": math.inf}), 1e-3)
    assert pair.of == "time"
    assert pair.other == ChainSettings(step=0.45)


@pytest.mark.parametrize("scene", [run_24(), run_24(follower={"damping": 8.0}), run_24(follower={"material_damping": 1e-3})])
def test_the_stable_step_is_the_longest(scene: Mechanism) -> None:
    """A crank at rest in a dead centre moves nothing; a base that turns sets the straight chain ringing."""
    quiet = dataclasses.replace(scene, crank=dataclasses.replace(scene.crank, drive=PrescribedSpeed(speed=1e-3)))
    start = standard_start(quiet)
    ENGINE.prepare(quiet, start, ChainSettings(links=8, step=0.98)).advance(0.5, 0.1)
    with pytest.raises(EngineFailure, match=r"engine\.step"):
        ENGINE.prepare(quiet, start, ChainSettings(links=8, step=1.3)).advance(0.5, 0.1)


def test_small_links_have_no_more_than_their_own_inertia() -> None:
    """A light arm in 250 links: rods of 1e-13 kg m^2, as small machines have."""
    mechanism = run_24(follower={"mass_per_length": 1e-4})
    model = chain.build(mechanism, 250, 0.0)
    rod = 1e-4 * (mechanism.follower.length / 250) ** 3 / 12.0
    assert rod < 2e-13
    assert model.body("link 1").inertia[2] == pytest.approx(rod, rel=1e-9)
    assert model.body("link 249").inertia[2] == pytest.approx(rod, rel=1e-9)
