"""The Exudyn engine against the numbers known of run 24, conservation laws and closed forms, and which of its modules is loaded."""

import dataclasses
import math
import os
import subprocess
import sys

import numpy as np
import pytest

from quickreturn.cases.library import load_case
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.exudyn.cable import Cable, Kink
from quickreturn.engines.exudyn.construction import LONGEST, LONGEST_TURN, longest_stretch
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.start_state import reconstruct
from quickreturn.engines.trajectory import REQUIRED, Trajectory, join, relative_error
from quickreturn.engines.units import Units
from quickreturn.reference_model.mechanism import PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.tip import Tip
from tests.engines.energy import imbalance
from tests.engines.exudyn.runs import arm, bent_start, errors_of, simulate
from tests.engines.scenes import INCH, run_24

ENGINE = ExudynEngine()
RIGID = {"bending_stiffness": math.inf}
SETTINGS = ExudynSettings(elements=24, newton_tolerance=1e-5)  # as `simulate` has them


@pytest.fixture(scope="module")
def default_run() -> Trajectory:
    mechanism = run_24()
    settings = ENGINE.settings_for(ENGINE.default_accuracy, mechanism)
    return ENGINE.prepare(mechanism, standard_start(mechanism), settings).advance(1.0, 1e-3)  # all peaks of two seconds are in it


def test_run_24_has_the_known_peaks(default_run):
    assert len(default_run) == 1001
    assert all(np.all(np.isfinite(default_run[name])) for name in REQUIRED)
    # the default aims at 0.3 % of the RMS deflection (11.2 mm); peaks of the published digits within twice that
    assert np.abs(default_run["tip_deflection"]).max() == pytest.approx(27.27e-3, rel=6e-3)
    peaks = [np.abs(default_run[f"strain_{i}"]).max() / (0.0625 * INCH) for i in (1, 2, 3)]
    assert peaks == pytest.approx([0.122, 0.251, 0.167], rel=6e-3)
    assert np.abs(default_run["tip_acceleration"]).max() == pytest.approx(88.9, rel=6e-3)
    assert default_run["crank_angle"][-1] == pytest.approx(19.75883, abs=2e-4)  # `reference` with nine modes, to 1e-9


def test_run_24_keeps_its_constraint_and_its_energy(default_run):
    # Newton's iteration leaves 1e-8 of the residual; the gap of the joint is a coordinate of it, in m
    assert default_run["constraint_gap"].max() < 1e-8
    # generalized-alpha at 2.5e-4 s: measured 1.2e-4
    assert imbalance(default_run) < 3e-4


def test_output_step_may_change_between_pieces():
    mechanism = run_24()
    simulation = ENGINE.prepare(mechanism, standard_start(mechanism), SETTINGS)
    simulation.advance(0.05, 1e-3)
    last = simulation.advance(0.05, 5e-3)
    # the same steps in time, but the Jacobian is refreshed at other instants: Newton's tolerance
    assert last["tip_deflection"][-1] == pytest.approx(simulate(mechanism, 0.1, step=2.5e-4)["tip_deflection"][-1], rel=1e-5)


def test_energy_balance_with_everything_that_can_be_switched_on():
    mechanism = run_24(gravity=(1.0, -9.81), tip={"center_of_mass": 0.5 * INCH}, slider={"mass": 0.2}, base={"damping": 1e-2})
    coarse, fine = (imbalance(simulate(mechanism, 0.3, step=h, elements=16)) for h in (2.5e-4, 1.25e-4))
    assert fine < 2e-4  # measured 5e-5
    assert 3.0 < coarse / fine < 5.0  # it vanishes with the square of the step: no term is missing


@pytest.mark.parametrize("stiffness_factor", [1.0, math.inf])
def test_prescribed_speed_is_kept_and_its_torque_balances_the_power(stiffness_factor):
    stiffness = stiffness_factor * run_24().follower.bending_stiffness
    mechanism = run_24(crank={"drive": PrescribedSpeed(speed=16.6)}, follower={"bending_stiffness": stiffness}, gravity=(0.0, -9.81))
    t = simulate(mechanism, 0.4)
    assert t["crank_angle"] == pytest.approx(math.pi + 16.6 * t["time"], abs=1e-10)  # round-off over 1600 steps
    stored = t["kinetic_energy"] + t["strain_energy"] + t["gravity_energy"] + t["dissipated_energy"]
    # the work is summed on the output grid: trapezoidal rule on a torque of 13 N m that turns with the crank, (16.6 ms)²/12 of it
    assert t["drive_work"] == pytest.approx(stored - stored[0], abs=5e-3)


@pytest.mark.parametrize("mechanism", [run_24(), run_24(gravity=(0.0, -9.81), tip={"center_of_mass": 0.5 * INCH})])
def test_a_bent_start_is_taken_over(mechanism):
    start = bent_start()
    t = simulate(mechanism, 0.01, start, output_step=1e-4, step=1e-4)
    state = reconstruct(mechanism, start)
    end = np.array([mechanism.follower.length])
    # places and rates are given at nodes, between them the cubic interpolates: order h⁴ of W'''' at the slider
    assert t["follower_angle"][0] == pytest.approx(state.follower_angle, abs=1e-12)
    assert t["slider_position"][0] == pytest.approx(state.slider_position, abs=1e-7)
    assert [t["tip_x"][0], t["tip_y"][0]] == pytest.approx(state.position(end)[0], abs=1e-12)
    assert t["tip_deflection"][0] == pytest.approx(float(start.deflection(end)[0]), abs=1e-12)
    assert t["constraint_gap"][0] < 1e-7
    gauges = np.array(mechanism.follower.strain_gauges)
    slope = start.deflection(gauges, 1)
    curvature = start.deflection(gauges, 2) / np.sqrt(1 - slope**2)
    strain = [t[f"strain_{i}"][0] for i in (1, 2, 3)]
    assert strain == pytest.approx(curvature * mechanism.follower.thickness / 2, rel=1e-4)
    # consistent rates: no jump of the tip's velocity, no burst of energy
    velocity = np.array([(t[name][1] - t[name][0]) / 1e-4 for name in ("tip_x", "tip_y")])
    tip_speed = np.linalg.norm(state.velocity(end)[0])
    assert velocity == pytest.approx(state.velocity(end)[0], abs=0.05 * tip_speed)
    assert imbalance(t) < 2e-3  # measured 4e-4

    # straight, it nearly reaches the end once a turn: bent, the end is nearer than that


def test_divergence_is_a_failure_with_its_time_and_silent(capfd):
    drive = dataclasses.replace(run_24().crank.drive, initial_speed=120.0)
    with pytest.raises(EngineFailure, match=r"smaller engine\.step|left the follower") as failure:
        simulate(run_24(crank={"drive": drive}), 2.0, elements=8, step=2e-3, output_step=2e-3)
    assert np.all(np.isfinite(failure.value.partial["tip_x"]))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("joint_stiffness", [math.inf, 2e4])
def test_what_the_joint_cannot_do_is_refused(joint_stiffness):
    scene = run_24(slider={"inertia": 1e-5, "joint_stiffness": joint_stiffness})
    with pytest.raises(Refusal, match=r"slider\.inertia: 1e-05 .*accepted: 0"):
        ENGINE.prepare(scene, standard_start(scene), ExudynSettings())


@pytest.mark.parametrize(
    "mechanism",
    [
        run_24(),
        run_24(tip=None),
        run_24(base={"inertia": 0.0, "damping": 0.0}, follower={"damping": 0.0}),
        run_24(crank={"drive": PrescribedSpeed(speed=16.6)}),
        run_24(follower=RIGID),
        run_24(follower=RIGID, tip=None, crank={"drive": PrescribedSpeed(speed=16.6)}),
    ],
)
def test_the_description_is_what_was_built(mechanism):
    settings = ExudynSettings(elements=8)
    description = ENGINE.describe(mechanism, settings)
    simulation = ENGINE.prepare(mechanism, standard_start(mechanism), settings)
    mbs = simulation._model.assembly.mbs  # type: ignore[attr-defined]
    kinds = [mbs.GetObject(i)["objectType"] for i in range(mbs.systemData.NumberOfObjects())]
    bodies = kinds.count("RigidBody2D") + (kinds.count("ALEANCFCable2D") > 0)
    assert len(description.bodies) == bodies
    assert kinds.count("ALEANCFCable2D") == (0 if mechanism.follower.is_rigid else 8)
    assert len(description.joints) == sum(kind.startswith("Joint") or kind == "ConnectorCoordinate" for kind in kinds)
    # stretching counts: two places and two slopes at each of 9 nodes, less the pin; base and tip are clamped to nodes
    flexible = 4 * 9 - 2
    crank = 1 if mechanism.crank_is_free else 0
    # the slider takes one: normal to the follower
    assert description.degrees_of_freedom == (flexible if not mechanism.follower.is_rigid else 1) + crank - 1


@pytest.mark.verify
def test_work_of_the_drive_is_known_though_the_arm_rings_faster_than_the_rows() -> None:
    """Of 10 J of kinetic energy 3.5e-3 J are strain: rows of 1 ms would lose 0.1 of these, steps what falls with their square."""
    mechanism = load_case("hard-shaper-steel").mechanism
    found = []
    for step in (2.5e-4, 1.25e-4):
        settings = ExudynSettings(elements=12, step=step, newton_tolerance=1e-5)
        simulation = ExudynEngine().prepare(mechanism, standard_start(mechanism), settings)
        found.append(imbalance(join([simulation.advance(0.1, 1e-3), simulation.advance(0.1, 1e-3)])))
    assert found[1] < 5e-3  # measured 2.5e-3
    assert 3.0 < found[0] / found[1] < 5.0


@pytest.mark.verify
def test_force_of_the_joint_is_there_beside_a_large_axial_stiffness():
    """The arm's axial stiffness is 3e8 times the force; where Newton's residual is at its round-off, that is not yet known."""
    mechanism = arm(0.65, 25.0, 0.087, 1.06, 16.0, Tip(mass=0.45, inertia=1.1e-3))
    errors = errors_of(mechanism, 2.0, 5, elements=12, step=2.5e-4, newton_tolerance=1e-6)
    assert errors["slider_force"] < 1e-5  # measured 2.6e-6, and 6.4e-5 by the residual


@pytest.mark.verify
def test_damping_acts_relative_to_the_turning_base_however_far_the_beam_bends():
    """Against the reference, whose damping is relative to the base frame by its equations; the beam bends by a third of its length."""
    soft = run_24(follower={"bending_stiffness": 0.1 * run_24().follower.bending_stiffness})
    converged = engine("reference")
    settings = converged.settings_for(1e-4, soft).with_texts({"modes": "11", "tolerance": "1e-9"})  # 3e-5 from 13 modes
    truth = converged.prepare(soft, standard_start(soft), settings).advance(0.3, 1e-3)
    assert np.abs(truth["tip_deflection"]).max() > 0.2  # m
    found = simulate(soft, 0.3, elements=24, step=2.5e-4)
    # 1.0e-4, as without any damping: elements and step; 7.9e-4 with dampers that are tied to points fixed in the base body
    assert relative_error(found["tip_deflection"], truth["tip_deflection"]) < 2e-4
    coarse = simulate(soft, 0.3, output_step=1e-2, elements=24, step=2.5e-4)
    # the dampers' points follow every millisecond here, too; Newton's iteration leaves 1e-6
    assert relative_error(coarse["tip_deflection"], found["tip_deflection"][::10]) < 1e-5


@pytest.mark.verify
def test_damping_leaves_the_turning_of_a_fast_arm_alone():
    """An arm of 9 cm at 380 rpm, its bending damped as by 77 /s: an arm whose whole velocity is braked is bent by that."""
    errors = errors_of(arm(0.09, 27.0, 6e-3, 40.0, 77.0), 0.16, 7, elements=12, step=1.25e-4)
    assert errors["tip_deflection"] < 1e-4  # measured 3.0e-5, and 2.0e-4 with points carried on along their tangents
    assert errors["strain_1"] < 1e-4


def test_dampers_are_moved_before_they_turn_far():
    """In units of the scene's own, in which a crank that keeps its speed turns by about a radian in a unit of time."""
    assert longest_stretch(Units.of(run_24()).scene(run_24())) == LONGEST
    hurried = run_24(crank={"drive": TorqueDrive(torque=20.0, damping=0.1, initial_speed=10.0)})
    units = Units.of(hurried)
    assert longest_stretch(units.scene(hurried)) == pytest.approx(LONGEST_TURN / 200.0 / units.time)
    assert longest_stretch(run_24(crank={"drive": PrescribedSpeed(speed=0.0)})) == LONGEST


LOADED = """
import sys
import quickreturn.engines.exudyn.simulation
print(*(name for name in sys.modules if name.startswith("exudyn.exudynCPP") and name.count(".") == 1))
"""


def loaded(before: str = "", **environment: str) -> str:
    """What a process prints that loads the engine after the statement `before`: the compiled modules, if nothing else prints."""
    inherited = {name: value for name, value in os.environ.items() if name != "EXUDYN_MODULE"}
    command = [sys.executable, "-c", f"{before}\n{LOADED}"]
    return subprocess.run(command, env=inherited | environment, capture_output=True, text=True, check=True).stdout.strip()


def test_the_module_without_range_checks_is_loaded_where_the_processor_can() -> None:
    with open("/proc/cpuinfo") as processors:
        name = "exudynCPPfast" if "avx2" in processors.read() else "exudynCPP"
    assert loaded() == f"exudyn.{name}"


@pytest.mark.verify
def test_who_chooses_a_module_keeps_it() -> None:
    assert loaded("import sys; sys.exudynFast = False") == "exudyn.exudynCPP"
    assert loaded("import exudyn") == "exudyn.exudynCPP"
    assert loaded(EXUDYN_MODULE="checked") == "exudyn.exudynCPP"


@pytest.mark.parametrize("x", [0.0, 0.02, 0.1, 0.33, 0.5, 0.999, 1.0])
def test_curvature_is_of_third_order_anywhere_and_better_inside(x):
    """The plane curve r = (x, x³/3 - x⁵/20), given exactly at the nodes."""
    slope = x**2 - x**4 / 4
    exact = (2 * x - x**3) / (1 + slope**2)
    errors = []
    for elements in (16, 32):
        cable = Cable(1.0, elements, 1.0, 1.0, 1.0)
        nodes = cable.nodes
        q = np.column_stack([nodes, nodes**3 / 3 - nodes**5 / 20, np.ones_like(nodes), nodes**2 - nodes**4 / 4])[None]
        errors.append(abs(cable.curvatures(q, np.array([[x]]))[0, 0] - exact))
    h = 1 / 16
    # inside, r'' is exact to the fifth degree and between nodes the slope is the cubic's, third order with a small factor;
    # in the first and last element r'' at the very end errs by a twelfth of h³ times the fifth derivative
    assert errors[0] < (h**3 / 100 if h < x < 1 - h else h**3)
    assert errors[1] < max(1e-9, errors[0] / 5)


@pytest.mark.parametrize("x", [0.05, 0.33, 0.5, 0.512])
@pytest.mark.parametrize("place", [0.5, 0.515, 0.53, 0.9])
def test_curvature_has_the_kink_of_a_point_force(x, place):
    """The line of the test above with a jump in its third derivative, given exactly at the nodes, and kinks in rows of their own."""
    jump, beyond = 3.0, max(0.0, x - place)
    bent, slope = 2 * x - x**3 + jump * beyond, x**2 - x**4 / 4 + jump * beyond**2 / 2
    exact = bent / (1 + slope**2)
    cable = Cable(1.0, 32, 1.0, 1.0, 1.0)
    nodes, kinks = cable.nodes, np.array([place, 0.8])
    levers = np.maximum(0.0, nodes - kinks[:, None])
    lines = nodes**3 / 3 - nodes**5 / 20 + jump * levers**3 / 6, nodes**2 - nodes**4 / 4 + jump * levers**2 / 2
    q = np.stack([np.broadcast_to(nodes, levers.shape), lines[0], np.ones_like(levers), lines[1]], axis=2)
    kink = Kink(kinks, np.array([[0.0, jump], [0.0, jump]]))
    places = np.full((1, 2), x)
    found, rounded_off = (cable.curvatures(q, places, *known)[0, 0] - exact for known in ((kink,), ()))
    assert abs(found) < 1e-4 * abs(exact)  # the slope, a cubic's, misses 2e-5 of it at most
    assert abs(rounded_off) > 10 * abs(found) or abs(x - place) > 2 / 32
