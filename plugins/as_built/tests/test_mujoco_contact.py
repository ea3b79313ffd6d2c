"""Engine `mujoco-contact`: its claims, its start, its matrices, what it refuses and how it fails."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.mujoco.chain import mass_matrix
from quickreturn.engines.registry import engine
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.start_state import reconstruct
from quickreturn.engines.trajectory import relative_error
from quickreturn.plugins.as_built.contact import chain
from quickreturn.plugins.as_built.contact.settings import ContactSettings
from quickreturn.plugins.as_built.contact.simulation import ContactSimulation
from quickreturn.reference_model.mechanism import Mechanism
from tests.engines.scenes import run_24

ENGINE = engine("mujoco-contact")
#: Run 24, damped by its material.
RUN_24 = run_24(follower={"damping": 0.0, "material_damping": 1e-4})


@cache
def run(name: str, scene: Mechanism = RUN_24, duration: float = 0.5) -> Result:
    return simulate(engine(name), scene, standard_start(scene), duration, 1e-3)


@pytest.mark.verify
def test_errors_are_within_the_claims() -> None:
    """Against `reference`, whose own claims add to these. Signs and units of every column are right if this holds."""
    found, true = run("mujoco-contact"), run("reference")
    columns = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")
    used = {}
    for name in columns:
        claims = [result.error_estimates[name] for result in (found, true)]
        assert None not in claims
        used[name] = relative_error(found.trajectory[name], true.trajectory[name]) / sum(filter(None, claims))
    assert max(used.values()) < 1.0, used
    for name in ("crank_angle", "crank_speed", "slider_position", "tip_x", "kinetic_energy", "drive_work"):
        assert relative_error(found.trajectory[name], true.trajectory[name]) < 1e-3, name


@pytest.mark.verify
def test_the_error_falls_with_the_square_of_the_links() -> None:
    start, true = standard_start(RUN_24), run("reference").trajectory["tip_deflection"]
    errors = [
        relative_error(ENGINE.prepare(RUN_24, start, ContactSettings(links=links)).advance(0.5, 1e-3)["tip_deflection"], true)
        for links in (10, 20, 40)
    ]
    assert errors[0] / errors[2] == pytest.approx(4.0**2, rel=0.3)  # from one to the next it depends on where the pin meets the corners
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2]


def test_a_bent_follower_starts_on_the_pin_and_moves_along_with_it() -> None:
    def bend(x: np.ndarray, nu: int = 0) -> np.ndarray:
        return np.array([0.3 * x**2, 0.6 * x, np.full_like(x, 0.6)][nu])

    start = Start(1.2, 15.0, bend, bend)
    simulation = ContactSimulation(RUN_24, start, ContactSettings(links=40))
    first = simulation.advance(1e-3, 1e-4)
    assert first["constraint_gap"][0] < 1e-15
    rate = np.gradient(first["constraint_gap"], 1e-4)
    assert np.max(np.abs(rate[:2])) < 1e-3  # m/s, beside 1.5 m/s of the pin
    true = reconstruct(RUN_24, start)
    tip = true.position(np.array([RUN_24.follower.length]))[0]
    assert np.hypot(first["tip_x"][0] - tip[0], first["tip_y"][0] - tip[1]) < 1e-3 * RUN_24.follower.length
    assert first["slider_position"][0] == pytest.approx(true.slider_position, rel=1e-3)
    half_a_link = RUN_24.follower.length / 40 / 2.0
    assert first["follower_angle"][0] == pytest.approx(true.follower_angle, abs=0.6 * half_a_link)  # the first link's own


def test_the_matrix_of_the_straight_chain_is_that_of_mujoco() -> None:
    scene = run_24(follower={"damping": 0.0}, tip={"center_of_mass": 0.02})
    links, armature = 7, 1e-5
    model = chain.build(scene, links, 1e-4, 2e-4, armature)
    mass = mass_matrix(model)
    ours, stiffness = chain.straight_chain(scene, links, armature)
    np.testing.assert_allclose(ours, mass[1:, 1:], rtol=1e-12)
    np.testing.assert_allclose(np.diag(stiffness)[1:], model.jnt_stiffness[2:].reshape(links - 1, -1)[:, 0], rtol=1e-12)


@pytest.mark.parametrize("crank_angle", [0.3, 1.0, 2.0, 3.1])
def test_natural_frequencies_converge_to_those_of_the_beam_with_the_square_of_the_links(crank_angle: float) -> None:
    """The factor is at most 3.4, and depends on where on its link the pin is."""
    true = engine("reference").natural_frequencies(RUN_24, crank_angle, 3, engine("reference").settings_for(1e-4, RUN_24))
    for links in (15, 30, 60):
        error = ENGINE.natural_frequencies(RUN_24, crank_angle, 3, ContactSettings(links=links)) / true - 1.0
        assert np.max(np.abs(error)) < 4.0 / links**2


def test_what_mujoco_has_not_by_its_own_means_is_refused() -> None:
    for change, words in (
        ({"follower": {"damping": 0.1}}, "follower.material_damping"),
        ({"slider": {"friction": 0.1}}, "slider.friction: 0.1 is not modelled"),
        ({"slider": {"joint_stiffness": 1e4}}, "slider.joint_stiffness"),
        ({"follower": {"damping": 0.0, "bending_stiffness": np.inf}}, "accepted: a finite stiffness"),
    ):
        changes = {"follower": {"damping": 0.0}} | change
        with pytest.raises(Refusal, match=words):
            ENGINE.check(run_24(**changes))


def test_a_pin_that_a_soft_contact_lets_through_a_wall_is_told() -> None:
    settings = ContactSettings(contact_time=500.0)
    with pytest.raises(EngineFailure, match="pin was pressed through a wall of the slot") as told:
        ENGINE.prepare(RUN_24, standard_start(RUN_24), settings).advance(0.5, 1e-3)
    assert told.value.partial is not None
    assert len(told.value.partial) > 1


def test_a_step_beyond_the_limit_ends_with_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chain, "longest_stable_step", lambda *_: 0.05)
    with pytest.raises(EngineFailure, match=r"grew beyond all bounds|pressed through"):
        ENGINE.prepare(RUN_24, standard_start(RUN_24), ContactSettings()).advance(0.5, 1e-2)


def test_with_clearance_the_pin_goes_from_wall_to_wall() -> None:
    """Blows do not converge, so that RMS values are compared with those of `mujoco`."""
    loose = replace(RUN_24, slider=replace(RUN_24.slider, clearance=2e-4))
    found = ENGINE.prepare(loose, standard_start(loose), ContactSettings(links=20)).advance(1.0, 1e-3)
    chosen = engine("mujoco")
    other = chosen.prepare(loose, standard_start(loose), chosen.settings_for(1e-2, loose)).advance(1.0, 1e-3)
    assert np.max(found["constraint_gap"]) == pytest.approx(1e-4, rel=0.2)
    for name, within in (("tip_deflection", 0.05), ("strain_2", 0.05)):
        rms = [np.sqrt(np.mean(table[name] ** 2)) for table in (found, other)]
        assert rms[0] == pytest.approx(rms[1], rel=within), name
