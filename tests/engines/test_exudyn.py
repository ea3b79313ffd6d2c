"""The Exudyn engine against the numbers known of run 24, conservation laws and closed forms."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PPoly

from quickreturn.cases.case_file import load_case
from quickreturn.engines import accurate
from quickreturn.engines.base import Comparison, EngineFailure, Refusal
from quickreturn.engines.error_parts import ESTIMATED, Compared, estimated_part
from quickreturn.engines.exudyn import settings as ladder
from quickreturn.engines.exudyn import simulation
from quickreturn.engines.exudyn.cable import Cable, Kink
from quickreturn.engines.exudyn.damping import LONGEST, LONGEST_TURN, longest_stretch
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import SMALLEST_STEP, ExudynSettings
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.relative import relative_error
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.start_state import reconstruct
from quickreturn.engines.trajectory import REQUIRED, Trajectory, join
from quickreturn.reference_model.mechanism import Base, Crank, Follower, Mechanism, PrescribedSpeed, Tip, TorqueDrive
from tests.engines.energy import imbalance
from tests.engines.scenes import INCH, run_24

ENGINE = ExudynEngine()


def simulate(mechanism: Mechanism, duration: float, start: Start | None = None, output_step: float = 1e-3, **settings) -> Trajectory:
    prepared = ENGINE.prepare(mechanism, start or standard_start(mechanism), ExudynSettings(**settings))
    return prepared.advance(duration, output_step)


@pytest.fixture(scope="module")
def default_run() -> Trajectory:
    mechanism = run_24()
    settings = ENGINE.settings_for(ENGINE.default_accuracy, mechanism)
    return ENGINE.prepare(mechanism, standard_start(mechanism), settings).advance(2.0, 1e-3)


def test_run_24_has_the_known_peaks(default_run):
    assert len(default_run) == 2001
    assert all(np.all(np.isfinite(default_run[name])) for name in REQUIRED)
    # the default aims at 0.3 % of the RMS deflection (11.2 mm); peaks of the published digits within twice that
    assert np.abs(default_run["tip_deflection"]).max() == pytest.approx(27.27e-3, rel=6e-3)
    peaks = [np.abs(default_run[f"strain_{i}"]).max() / (0.0625 * INCH) for i in (1, 2, 3)]
    assert peaks == pytest.approx([0.122, 0.251, 0.167], rel=6e-3)
    assert np.abs(default_run["tip_acceleration"]).max() == pytest.approx(88.9, rel=6e-3)
    assert default_run["crank_angle"][-1] == pytest.approx(36.38754, abs=2e-4)


def test_run_24_keeps_its_constraint_and_its_energy(default_run):
    # Newton's iteration leaves 1e-8 of the residual; the gap of the joint is a coordinate of it, in m
    assert default_run["constraint_gap"].max() < 1e-8
    # generalized-alpha at 2.5e-4 s: measured 1.2e-4
    assert imbalance(default_run) < 3e-4


def test_pieces_equal_one_run():
    mechanism = run_24()
    whole = simulate(mechanism, 0.2)
    simulation = ENGINE.prepare(mechanism, standard_start(mechanism), ExudynSettings())
    pieces = join([simulation.advance(0.05, 1e-3), simulation.advance(0.15, 1e-3)])
    assert simulation.time == pytest.approx(0.2, abs=1e-15)
    for name, values in whole.columns.items():
        # the very same steps; only sums over time are grouped differently
        assert pieces[name] == pytest.approx(values, abs=1e-12 * max(1.0, np.abs(values).max())), name


def test_output_step_may_change_between_pieces():
    mechanism = run_24()
    simulation = ENGINE.prepare(mechanism, standard_start(mechanism), ExudynSettings(step=2.5e-4))
    simulation.advance(0.05, 1e-3)
    last = simulation.advance(0.05, 5e-3)
    # the same steps in time, but the Jacobian is refreshed at other instants: Newton's tolerance
    assert last["tip_deflection"][-1] == pytest.approx(simulate(mechanism, 0.1, step=2.5e-4)["tip_deflection"][-1], rel=1e-5)


@pytest.mark.verify
def test_second_order_in_step_and_elements():
    fine = simulate(run_24(), 0.3, elements=32, step=1.25e-4)["tip_deflection"]
    errors = {
        (n, h): relative_error(simulate(run_24(), 0.3, elements=n, step=h)["tip_deflection"], fine)
        for n, h in ((32, 1e-3), (32, 5e-4), (8, 1.25e-4), (16, 1.25e-4))
    }
    # second order: 4.2 to 5 against a reference that is itself only a fourth of the step (third of the elements) finer
    assert 3.5 < errors[32, 1e-3] / errors[32, 5e-4] < 5.5
    in_time, in_space, in_stretch, in_passing = ENGINE.comparisons(ExudynSettings(elements=32, step=2.5e-4), run_24(), 1e-3)
    assert (in_time.other, in_time.factor) == (ExudynSettings(elements=32, step=5e-4), 2.0**ladder.SAFE_IN_TIME)
    assert in_time.before == Comparison(in_time.other, ExudynSettings(elements=32, step=1e-3), in_time.factor)
    assert (in_space.run, in_space.other) == (in_time.before.other, ExudynSettings(elements=16, step=1e-3))
    assert in_space.factor == 2.0**ladder.SAFE_IN_SPACE
    assert (in_stretch.run, in_stretch.factor) == (in_space.other, 4.0)
    assert in_stretch.other == ExudynSettings(elements=16, step=1e-3, axial_factor=0.25)
    assert (in_passing.run, in_passing.other) == (in_space.run, ExudynSettings(elements=24, step=1e-3))
    assert errors[8, 1.25e-4] > 2.5 * errors[16, 1.25e-4]


@pytest.mark.verify
def test_stretch_is_estimated_and_cured_by_a_stiffer_cable():
    """A section three times as thick as run 24's at a tenth of its bending stiffness stretches; the scene's follower does not."""
    soft = load_case("hard-ei-x0.1").mechanism
    soft = dataclasses.replace(soft, follower=dataclasses.replace(soft.follower, thickness=3.0 * soft.follower.thickness))
    converged = ReferenceSettings(modes=9, tolerance=1e-8)
    truth = run_once(ReferenceEngine(), soft, standard_start(soft), 0.3, 1e-3, converged).trajectory["tip_deflection"]
    found = {}
    for factor in (1, 16):
        texts = {"elements": "32", "step": "2.5e-4", "axial_factor": str(factor)}
        result = accurate.simulate(ENGINE, soft, standard_start(soft), 0.3, 1e-3, texts)
        found[factor] = relative_error(result.trajectory["tip_deflection"], truth)
        assert found[factor] < result.error_estimate
    assert found[16] < 0.3 * found[1]  # measured 1.0e-4 and 4.7e-4; steps and elements leave 7e-5


def test_few_elements_are_not_taken_for_a_cable_that_stretches():
    """Run 24's cable stretches little. A softer one shows it with half the elements; a stiffer one of few elements does not."""
    mechanism, rung = run_24(), ladder.LADDER.pick(3e-3)

    def part(pair: Comparison) -> float:
        runs = (pair.run.as_dict(), pair.other.as_dict())
        run, other = (simulate(mechanism, 0.3, **settings) for settings in runs)
        return estimated_part(run, Compared(run, other, pair.factor), mechanism.follower.length)[0]

    _, _, stretch, _ = ENGINE.comparisons(rung, mechanism, 1e-3)
    half, whole = (part(Comparison(*(own.replaced(elements=n) for own in (stretch.run, stretch.other)), stretch.factor)) for n in (12, 24))
    few = stretch.run.replaced(elements=6)
    assert stretch.run.elements == 12
    assert half < 2e-5  # measured 7.2e-6
    assert 0.5 < half / whole < 2.0
    assert part(Comparison(few, few.replaced(axial_factor=4.0), 0.25)) > 1e-3  # measured 1.4e-3


def test_energy_balance_with_everything_that_can_be_switched_on():
    mechanism = run_24(gravity=(1.0, -9.81), tip={"center_of_mass": 0.5 * INCH}, slider={"mass": 0.2}, base={"damping": 1e-2})
    coarse, fine = (imbalance(simulate(mechanism, 0.3, step=h, elements=16)) for h in (2.5e-4, 1.25e-4))
    assert fine < 2e-4  # measured 5e-5
    assert 3.0 < coarse / fine < 5.0  # it vanishes with the square of the step: no term is missing


def test_bare_mechanism_conserves_energy():
    drive = TorqueDrive(torque=0.0, damping=0.0, initial_speed=16.6)
    mechanism = run_24(tip=None, base={"inertia": 0.0, "damping": 0.0}, follower={"damping": 0.0}, crank={"drive": drive})
    trajectory = simulate(mechanism, 0.3, step=2.5e-4)
    assert imbalance(trajectory) < 2e-3  # measured 6e-4; a light follower stores little strain energy
    assert np.all(trajectory["dissipated_energy"] == 0.0)


def rigid_mechanism(**changes) -> Mechanism:
    follower = {"bending_stiffness": math.inf, **changes.pop("follower", {})}
    return run_24(follower=follower, **changes)


def test_rigid_follower_is_the_closed_form():
    mechanism = rigid_mechanism()
    t = simulate(mechanism, 0.4, step=2.5e-4)
    LA, d, crank = mechanism.crank.length, mechanism.pivot_distance, mechanism.crank
    q1 = t["crank_angle"]
    distance = np.sqrt(LA**2 + d**2 - 2 * LA * d * np.cos(q1))
    assert t["slider_position"] == pytest.approx(distance, abs=1e-9)  # the joint's residual
    rate = LA * (LA - d * np.cos(q1)) / distance**2  # dq2/dq1
    rate_slope = LA * d * np.sin(q1) / distance**2 * (1 - 2 * LA * (LA - d * np.cos(q1)) / distance**2)  # its derivative in q1
    follower, tip = mechanism.follower, mechanism.tip
    assert tip is not None
    inertia = mechanism.base.inertia + follower.mass_per_length * follower.length**3 / 3 + tip.inertia + tip.mass * follower.length**2
    assert isinstance(crank.drive, TorqueDrive)
    speed = t["crank_speed"]
    # Lagrange's equation of the one degree of freedom
    torque = crank.drive.torque - crank.drive.damping * speed - mechanism.base.damping * rate**2 * speed
    acceleration = (torque - inertia * rate * rate_slope * speed**2) / (crank.inertia_about_pivot + inertia * rate**2)
    follower_acceleration = rate * acceleration + rate_slope * speed**2
    # generalized-alpha's accelerations err at first order in the first steps (measured 4e-3 of the peak), then at second (1e-5)
    scale = np.abs(follower_acceleration).max()
    assert t["tip_acceleration"] == pytest.approx(follower.length * follower_acceleration, abs=6e-3 * scale * follower.length)
    assert t["tip_acceleration"][40:] == pytest.approx((follower.length * follower_acceleration)[40:], abs=5e-5 * scale * follower.length)
    # moment of the slider force about P drives the follower: positive along n
    force = (inertia * follower_acceleration + mechanism.base.damping * rate * speed) / distance
    assert t["slider_force"] == pytest.approx(force, abs=6e-3 * np.abs(force).max())


def test_stiff_follower_approaches_the_rigid_one():
    rigid = simulate(rigid_mechanism(), 0.1)
    stiff = simulate(run_24(follower={"bending_stiffness": 1e4 * run_24().follower.bending_stiffness}), 0.1, elements=8)
    # deflection scales with 1 / EI from 27 mm
    assert np.abs(stiff["tip_deflection"]).max() < 1e-5
    assert stiff["slider_position"] == pytest.approx(rigid["slider_position"], abs=1e-6)
    # vibrations of the stiff follower ride on the force, a few per cent of it at the start
    assert relative_error(stiff["slider_force"], rigid["slider_force"]) < 0.05


@pytest.mark.parametrize("stiffness_factor", [1.0, math.inf])
def test_prescribed_speed_is_kept_and_its_torque_balances_the_power(stiffness_factor):
    stiffness = stiffness_factor * run_24().follower.bending_stiffness
    mechanism = run_24(crank={"drive": PrescribedSpeed(speed=16.6)}, follower={"bending_stiffness": stiffness}, gravity=(0.0, -9.81))
    t = simulate(mechanism, 0.4)
    assert t["crank_angle"] == pytest.approx(math.pi + 16.6 * t["time"], abs=1e-10)  # round-off over 1600 steps
    stored = t["kinetic_energy"] + t["strain_energy"] + t["gravity_energy"] + t["dissipated_energy"]
    # the work is summed on the output grid: trapezoidal rule on a torque of 13 N m that turns with the crank, (16.6 ms)²/12 of it
    assert t["drive_work"] == pytest.approx(stored - stored[0], abs=5e-3)


def bent_start() -> Start:
    """A quartic deflection of 26 mm at the tip, free of moment at both ends, and a rate of the same shape."""
    length = run_24().follower.length
    quartic = np.array([[-1.0], [2.0 * length], [0.0], [0.0], [0.0]]) / length**2  # x³ (2 L - x) / L²
    ends = np.array([0.0, length])
    return Start(2.0, 16.6, PPoly(0.1 * quartic, ends), PPoly(quartic, ends))


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


def test_slider_beyond_the_follower_is_a_failure_with_its_time():
    soft = 0.1 * run_24().follower.bending_stiffness
    gauges = (5.5 * INCH, 11.0 * INCH, 16.5 * INCH)
    mechanism = run_24(follower={"length": 22.0 * INCH, "strain_gauges": gauges, "bending_stiffness": soft})
    with pytest.raises(EngineFailure, match="left the follower") as failure:
        simulate(mechanism, 2.0)
    partial = failure.value.partial
    assert partial is not None
    assert partial["time"][-1] == failure.value.time < 2.0
    assert partial["slider_position"].max() <= mechanism.follower.length
    # straight, it just reaches the end once a turn: bent, the end is nearer than that


def test_divergence_is_a_failure_with_its_time_and_silent(capfd):
    drive = dataclasses.replace(run_24().crank.drive, initial_speed=120.0)
    with pytest.raises(EngineFailure, match=r"smaller engine\.step|left the follower") as failure:
        simulate(run_24(crank={"drive": drive}), 2.0, elements=8, step=2e-3, output_step=2e-3)
    assert failure.value.partial is not None
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
        rigid_mechanism(),
        rigid_mechanism(tip=None, crank={"drive": PrescribedSpeed(speed=16.6)}),
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


def test_only_the_parts_of_the_scene_are_built():
    bodies = ENGINE.describe(run_24(), ExudynSettings()).bodies
    assert bodies == ("crank", "follower: 24 ANCF cable elements", "base", "tip")
    bare = run_24(tip=None, base={"inertia": 0.0, "damping": 0.0}, follower={"damping": 0.0})
    assert ENGINE.describe(bare, ExudynSettings()).bodies == ("crank", "follower: 24 ANCF cable elements")
    assert ENGINE.describe(rigid_mechanism(), ExudynSettings()).bodies == ("crank", "follower: rigid, with the base and the tip")


def test_ladder_ends() -> None:
    assert ENGINE.settings_for(ENGINE.default_accuracy, run_24()) == ExudynSettings()
    steps = [rung.step for rung, _ in ladder.LADDER.rungs]
    assert steps == sorted(steps, reverse=True)
    settings, count = ExudynSettings(), 0
    while (finer := ENGINE.finer(settings, (), 1e-3)) is not None:
        assert finer.step < settings.step
        settings, count = finer, count + 1
    assert count >= 1
    assert settings.step >= SMALLEST_STEP


def test_finer_settings_cure_what_is_too_large():
    settings = ExudynSettings(elements=24, step=2.5e-4)
    # of second order in time: 7 steps leave 2.0 (4/7)^2 = 0.65; 6 would leave 0.89, and with 0.1 in space too much
    assert ENGINE.finer(settings, (2.0, 0.1), 1e-3) == settings.replaced(step=1e-3 / 7)
    # of third order in space: 32 elements leave 0.42
    assert ENGINE.finer(settings, (0.5, 1.0), 1e-3) == settings.replaced(elements=32)
    assert ENGINE.finer(settings, (0.5, 0.4, 0.0, 0.6), 1e-3) == settings.replaced(elements=32)  # what passing shows is in space as well
    # smaller steps are cheaper than another cable, whose comparisons are all to be made again
    assert ENGINE.finer(settings, (0.7, 0.3, 0.1), 1e-3) == settings.replaced(step=2e-4)
    assert ENGINE.finer(settings, (0.5, 0.1, 0.8), 1e-3) == settings.replaced(axial_factor=4.0)


@given(
    st.tuples(*[st.floats(0.0, 20.0)] * 4).filter(lambda excess: sum(excess) > 1.0),
    st.integers(6, 48).map(lambda half: 2 * half),
    st.sampled_from((1.0, 4.0, 16.0)),
    st.integers(1, 12),
)
def test_climbing_takes_what_the_orders_leave_to_within_reach(excess, elements, axial_factor, steps):
    own = ExudynSettings(elements=elements, axial_factor=axial_factor, step=1e-3 / steps)
    finer = ENGINE.finer(own, excess, 1e-3)
    if finer is None:
        return
    in_time, in_space, in_stretch, passing = excess

    def left(settings: ExudynSettings) -> float:
        in_elements = (in_space + passing) * (elements / settings.elements) ** 3
        return in_time * (settings.step / own.step) ** 2 + in_elements + in_stretch * axial_factor / settings.axial_factor

    most = own.replaced(
        elements=max(elements, min(2 * elements, ladder.MOST_ELEMENTS)), step=1e-3 / min(4 * steps, 50), axial_factor=max(ladder.STIFFER)
    )
    assert left(finer) <= max(1.0, 1.2 * left(most))
    assert left(finer) < sum(excess)
    assert (finer.step, finer.elements, finer.axial_factor) != (own.step, own.elements, own.axial_factor)


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


def test_work_of_the_drive_is_known_though_the_arm_rings_faster_than_the_rows() -> None:
    """Of 10 J of kinetic energy 3.5e-3 J are strain: rows of 1 ms would lose 0.1 of these, steps what falls with their square."""
    mechanism = load_case("hard-shaper-steel").mechanism
    found = []
    for step in (2.5e-4, 1.25e-4):
        simulation = ExudynEngine().prepare(mechanism, standard_start(mechanism), ExudynSettings(elements=12, step=step))
        found.append(imbalance(join([simulation.advance(0.1, 1e-3), simulation.advance(0.1, 1e-3)])))
    assert found[1] < 5e-3  # measured 2.5e-3
    assert 3.0 < found[0] / found[1] < 5.0


def arm(length: float, slenderness: float, width: float, speed: float, damping: float, tip: Tip | None = None) -> Mechanism:
    """A steel arm `slenderness` times as long as thick, its crank a fifth of it and turned at `speed` (rad/s)."""
    thickness = length / slenderness
    follower = Follower(
        length=length,
        mass_per_length=7850.0 * width * thickness,
        bending_stiffness=210e9 * width * thickness**3 / 12.0,
        thickness=thickness,
        width=width,
        damping=damping * 7850.0 * width * thickness,
        strain_gauges=(0.25 * length, 0.5 * length, 0.75 * length),
    )
    crank = Crank(length=0.2 * length, drive=PrescribedSpeed(speed=speed))
    return Mechanism(pivot_distance=0.54 * length, crank=crank, base=Base(), follower=follower, tip=tip)


def errors_of(mechanism: Mechanism, duration: float, modes: int, **settings) -> dict[str, float]:
    converged = ReferenceSettings(modes=modes, tolerance=1e-9)
    truth = run_once(ReferenceEngine(), mechanism, standard_start(mechanism), duration, 1e-3, converged).trajectory
    found = simulate(mechanism, duration, **settings)
    return {name: relative_error(found[name], truth[name]) for name in ESTIMATED}


def test_damping_leaves_the_turning_of_a_fast_arm_alone():
    """An arm of 9 cm at 380 rpm, its bending damped as by 77 /s: an arm whose whole velocity is braked is bent by that."""
    errors = errors_of(arm(0.09, 27.0, 6e-3, 40.0, 77.0), 0.16, 7, elements=12, step=1.25e-4)
    assert errors["tip_deflection"] < 1e-4  # measured 3.0e-5, and 2.0e-4 with points carried on along their tangents
    assert errors["strain_1"] < 1e-4


def test_force_of_the_joint_is_there_beside_a_large_axial_stiffness():
    """The arm's axial stiffness is 3e8 times the force; where Newton's residual is at its round-off, that is not yet known."""
    mechanism = arm(0.65, 25.0, 0.087, 1.06, 16.0, Tip(mass=0.45, inertia=1.1e-3))
    errors = errors_of(mechanism, 2.0, 5, elements=12, step=2.5e-4, newton_tolerance=1e-6)
    assert errors["slider_force"] < 1e-5  # measured 2.6e-6, and 6.4e-5 by the residual


@pytest.mark.parametrize(
    ("output_step", "steps", "stretches"), [(1e-3, 4, 1), (1e-2, 40, 10), (1e-2, 7, 7), (5e-3, 6, 6), (5e-3, 5, 5), (1e-2, 21, 21)]
)
def test_dampers_are_moved_as_often_as_asked_or_every_step(output_step, steps, stretches):
    assert simulation._stretches(output_step, steps, 1e-3) == stretches


def test_dampers_are_moved_before_they_turn_far():
    assert longest_stretch(run_24()) == LONGEST
    assert longest_stretch(run_24(crank={"drive": PrescribedSpeed(speed=-200.0)})) == pytest.approx(LONGEST_TURN / 200.0)
    assert longest_stretch(run_24(crank={"drive": PrescribedSpeed(speed=0.0)})) == LONGEST


@pytest.mark.parametrize("output_step", [1e-2, 1e-3, 5e-4, 2.5e-4, 1e-5])
def test_runs_compared_differ_on_any_output_grid(output_step):
    """A step cannot pass an output: settings that differ may be the same run."""
    for step in (5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4):
        own = ExudynSettings(elements=8, step=step)
        for pair in ENGINE.comparisons(own, run_24(), output_step):
            fine, coarse = (math.ceil(output_step / settings.step - 1e-9) for settings in (pair.run, pair.other))
            stiffer = pair.other.axial_factor / pair.run.axial_factor
            assert fine != coarse or pair.run.elements != pair.other.elements or stiffer != 1.0
            in_time, in_space = (fine / coarse) ** ladder.SAFE_IN_TIME, (pair.run.elements / pair.other.elements) ** ladder.SAFE_IN_SPACE
            assert pair.factor == pytest.approx(in_time * in_space / stiffer)


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
    found, rounded_off = (cable.curvatures(q, places, known)[0, 0] - exact for known in (kink, None))
    assert abs(found) < 1e-4 * abs(exact)  # the slope, a cubic's, misses 2e-5 of it at most
    assert abs(rounded_off) > 10 * abs(found) or abs(x - place) > 2 / 32
