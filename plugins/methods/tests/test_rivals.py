"""The engines `multiplier`, `stiff-spring` and `nodal-load`: agreement with each other, energy, drift, limits and refusals."""

import math
from functools import cache

import numpy as np
import pytest

from quickreturn.engines.base import Engine, EngineFailure, Refusal
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory, relative_error
from quickreturn.plugins.methods.rivals import fixed_shapes, multiplier, nodal_load, stiff_spring
from quickreturn.plugins.methods.rivals.fixed_shapes import FixedShapesSettings
from quickreturn.plugins.methods.rivals.multiplier import MultiplierSettings
from quickreturn.plugins.methods.rivals.nodal_load import NodalLoadSettings
from quickreturn.plugins.methods.rivals.stiff_spring import StiffSpringSettings
from quickreturn.reference_model.mechanism import Crank, Mechanism, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.slider import Slider
from tests.engines.energy import from_nowhere
from tests.engines.scenes import run_24

CHANNELS = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force", "follower_angle", "slider_position")
SHAPES = 5


def run(chosen: Engine, settings: Settings, mechanism: Mechanism | None = None, duration: float = 0.15) -> Trajectory:
    scene = mechanism or run_24()
    return chosen.prepare(scene, standard_start(scene), settings).advance(duration, 1e-3)


@cache
def with_multiplier(stabilization: float = 100.0, shapes: int = SHAPES) -> Trajectory:
    return run(multiplier.ENGINE, MultiplierSettings(shapes=shapes, tolerance=1e-9, stabilization=stabilization))


@cache
def spring(stiffness: float) -> Trajectory:
    settings = StiffSpringSettings(shapes=SHAPES, tolerance=1e-8, stiffness=stiffness, damping=3e-5 * stiffness)
    return run(stiff_spring.ENGINE, settings)


@cache
def nodal(elements: int, distribution: str) -> Trajectory:
    return run(nodal_load.ENGINE, NodalLoadSettings(elements=elements, distribution=distribution, tolerance=1e-8))


@pytest.mark.parametrize("channel", CHANNELS)
def test_multiplier_moves_as_the_eliminated_constraint(channel: str) -> None:
    """Same beam, same shapes: what differs is integration error, 1e-9 a step in 400 steps and up to 100 times that in accelerations."""
    expected = run(fixed_shapes.ENGINE, FixedShapesSettings(shapes=SHAPES, tolerance=1e-9))
    assert relative_error(with_multiplier()[channel], expected[channel]) < 1e-5


def test_consistent_loads_on_elements_are_the_multiplier_with_these_shapes() -> None:
    """Two codes for one set of equations: what remains is the integration."""
    settings = MultiplierSettings(family="hermite", shapes=12, tolerance=1e-9)
    assert relative_error(nodal(6, "consistent")["tip_deflection"], run(multiplier.ENGINE, settings)["tip_deflection"]) < 1e-5


@pytest.mark.parametrize("stabilization", [0.0, 100.0])
def test_a_gap_decays_as_stabilization_says(stabilization: float) -> None:
    """Gap'' = -2 r gap' - r^2 gap from rest: (1 + r t) exp(-r t) of the beginning, all of it without stabilization."""
    simulation = multiplier.ENGINE.prepare(
        run_24(), standard_start(run_24()), MultiplierSettings(shapes=SHAPES, tolerance=1e-9, stabilization=stabilization)
    )
    simulation.state[SHAPES + 1] += 1e-4  # rad, of the follower's angle
    first = simulation.advance(0.05, 1e-3)
    gap, decay = first["constraint_gap"], stabilization * first["time"]
    # turned by 1e-4 the rate of the gap does not quite vanish: 1.7 m/s of the crank tip across it
    assert gap[0] == pytest.approx(1e-4 * first["slider_position"][0], rel=1e-3)
    np.testing.assert_allclose(gap, gap[0] * (1.0 + decay) * np.exp(-decay), rtol=0.0, atol=2e-2 * gap[0])


def test_nothing_drifts_but_the_quadrature() -> None:
    """Points move with the slider, so that the gap is not quite the integral of its rate: 7e-12 m with five shapes."""
    assert np.max(with_multiplier(0.0)["constraint_gap"]) < 1e-10
    assert with_multiplier().statistics["largest_gap_rate"] < 1e-6


def test_spring_approaches_the_constraint_at_first_order() -> None:
    """In run 24 the spring's own period is far below the motion's, so that the gap is F/k and the difference in proportion to it."""
    differences = [relative_error(spring(k)["tip_deflection"], with_multiplier()["tip_deflection"]) for k in (3e5, 3e6)]
    assert differences[0] / differences[1] == pytest.approx(10.0, rel=0.1)
    later = slice(20, None)  # 20 ms after the start, when the spring has come to rest (time constant c/k and damping of the shapes)
    force, gap = spring(3e6)["slider_force"][later], spring(3e6)["constraint_gap"][later]
    assert relative_error(np.abs(force) / 3e6, gap) < 0.02  # the damper's share, c/k times the force's rate


@pytest.mark.verify
def test_linear_force_on_nodes_converges_to_the_common_motion_slowly() -> None:
    """The lever rule differs from the consistent distribution by what falls with the element's size, second order at best."""
    lever = [relative_error(nodal(n, "lever")["tip_deflection"], with_multiplier(shapes=12)["tip_deflection"]) for n in (6, 12)]
    consistent = relative_error(nodal(6, "consistent")["tip_deflection"], with_multiplier(shapes=12)["tip_deflection"])
    assert lever[1] < 0.5 * lever[0]
    assert consistent < 0.2 * lever[0]


def test_both_linear_is_workless_but_for_corners() -> None:
    """Its energy balance is that of the impacts at the nodes, which the stabilization smears."""
    trajectory = nodal(6, "both linear")
    assert "spurious_energy" not in trajectory.statistics
    assert np.max(np.abs(from_nowhere(trajectory))) < 1e-2 * np.max(trajectory["strain_energy"] + trajectory["drive_work"])


@pytest.mark.parametrize("kind", ["multiplier", "stiff-spring", "consistent"])
def test_energy_balances(kind: str) -> None:
    """Kinetic, strain, spring and dissipated energy against the drive's work; 14 J move, the integration error is 1e-8 of them."""
    trajectory = with_multiplier() if kind == "multiplier" else spring(3e5) if kind == "stiff-spring" else nodal(6, "consistent")
    assert np.max(np.abs(from_nowhere(trajectory))) < 1e-6


def test_spurious_energy_is_what_the_balance_lacks() -> None:
    trajectory = nodal(6, "lever")
    assert from_nowhere(trajectory)[-1] == pytest.approx(trajectory.statistics["spurious_energy"], abs=1e-6)
    assert trajectory.statistics["spurious_energy_moved"] > 1e-4  # J; thousands of times what the others leave
    assert trajectory.statistics["largest_spurious_power"] > 1e-2  # W


def test_lever_rule_on_few_elements_loses_its_hold() -> None:
    """Two elements: at q1 = 180 deg the force on the nodes moves the slider the wrong way."""
    with pytest.raises(EngineFailure, match="lost its hold on the gap") as caught:
        nodal(2, "lever")
    assert caught.value.time == 0.0


@pytest.mark.parametrize(
    ("chosen", "settings"),
    [
        (multiplier.ENGINE, MultiplierSettings()),
        (stiff_spring.ENGINE, StiffSpringSettings()),
        (nodal_load.ENGINE, NodalLoadSettings()),
    ],
    ids=["multiplier", "stiff-spring", "nodal-load"],
)
class TestFeatures:
    def test_rigid_follower_is_the_rigid_mechanism(self, chosen: Engine, settings: Settings) -> None:
        scene = run_24(follower={"bending_stiffness": math.inf})
        expected = run(fixed_shapes.ENGINE, FixedShapesSettings(), scene, 0.05)
        found = run(chosen, settings, scene, 0.05)
        # the spring gives way by F/k = 2e-5 m at a lever of 0.4 m
        np.testing.assert_allclose(found["follower_angle"], expected["follower_angle"], rtol=0.0, atol=1e-4)

    def test_prescribed_speed_takes_the_torque_that_balances(self, chosen: Engine, settings: Settings) -> None:
        crank = run_24().crank
        steady = Crank(length=crank.length, drive=PrescribedSpeed(speed=16.6), mass=crank.mass, center_of_mass=crank.center_of_mass)
        found = run(chosen, settings, run_24(crank=steady), 0.05)
        np.testing.assert_allclose(found["crank_speed"], 16.6, rtol=1e-12)
        lacking = from_nowhere(found) - np.array([0.0, *[found.statistics.get("spurious_energy", 0.0)] * 50])
        assert abs(lacking[-1]) < 1e-5  # J; the default tolerance of 1e-9

    def test_refusals_name_the_key(self, chosen: Engine, settings: Settings) -> None:
        idle = Crank(length=0.1, drive=TorqueDrive(torque=0.0, damping=0.0, initial_speed=1.0))
        for scene, key in ((run_24(slider=Slider(inertia=1e-5)), "slider.inertia"), (run_24(crank=idle), "crank.inertia")):
            with pytest.raises(Refusal, match=key):
                chosen.check(scene)

    def test_ladder_climbs_to_its_end(self, chosen: Engine, settings: Settings) -> None:
        rung: Settings | None = chosen.settings_for(0.3, run_24())
        finest, unknowns = rung, []
        while rung is not None:
            finest, rung = rung, chosen.finer(rung, {}, 1e-3)
            unknowns.append(chosen.describe(run_24(), finest).degrees_of_freedom)
            assert all(pair.run == finest != pair.other for pair in chosen.comparisons(finest, run_24(), 1e-3))
        assert unknowns == sorted(unknowns)
        assert len(unknowns) > 2
        assert unknowns[-1] >= chosen.describe(run_24(), chosen.settings_for(1e-9, run_24())).degrees_of_freedom


@pytest.mark.parametrize("chosen", [multiplier.ENGINE, nodal_load.ENGINE], ids=["multiplier", "nodal-load"])
def test_methods_that_close_the_gap_refuse_a_compliant_joint(chosen: Engine) -> None:
    with pytest.raises(Refusal, match=r"slider\.joint_stiffness: 20000\.0 N/m"):
        chosen.check(run_24(slider=Slider(joint_stiffness=2e4)))


def test_frequencies_rise_with_the_stiffness_to_the_rigid_ones() -> None:
    found = [stiff_spring.ENGINE.natural_frequencies(run_24(), math.pi, 3, StiffSpringSettings(stiffness=k)) for k in (1e4, 1e6, 1e9)]
    rigid = multiplier.ENGINE.natural_frequencies(run_24(), math.pi, 3, MultiplierSettings())
    assert np.all(np.diff(np.array(found), axis=0) > 0.0)
    np.testing.assert_allclose(found[-1], rigid, rtol=1e-4)
    np.testing.assert_allclose(rigid, [20.354, 62.287, 112.95], rtol=0.02)  # converged, from the supported beam; 12 shapes lie above


@pytest.mark.verify
def test_shapes_that_stay_confirm_the_compliant_joint_of_those_that_follow() -> None:
    """Other shapes, same joint: 24 clamped-free modes leave 2.5e-4 of the deflection in run 24, seven that follow 8e-5."""
    scene = run_24(slider=Slider(joint_stiffness=2e4, joint_damping=5.0))
    reference = run(ReferenceEngine(), ReferenceSettings(modes=7, tolerance=1e-8), scene)
    own = run(stiff_spring.ENGINE, StiffSpringSettings(shapes=24, tolerance=1e-8), scene)
    for channel in ("tip_deflection", "tip_acceleration", "slider_force", "strain_1", "strain_2"):
        assert relative_error(reference[channel], own[channel]) < 5e-4, channel
    assert np.max(reference["constraint_gap"]) > 1e-4  # m: F/k of some 20 N
    assert ReferenceEngine().natural_frequencies(scene, math.pi, 1, ReferenceSettings())[0] < 20.354  # Hz, the rigid joint's
