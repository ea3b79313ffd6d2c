"""What the parts bear, held against closed forms, natural modes on a fine grid, and gauges at many places."""

import dataclasses
import math
from functools import cache
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.motion.number import Number
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.plugins.strength.arm import axial_forces, between, interpolated, known_moments, left_out, missing
from quickreturn.plugins.strength.case_loads import share_of
from quickreturn.plugins.strength.loads import loads_of
from quickreturn.plugins.strength.stress import arm_stress, safety, section_modulus
from quickreturn.reference_model.columns import MOMENTS
from quickreturn.reference_model.mechanism import Base, Mechanism, PrescribedSpeed
from quickreturn.reference_model.rigid import rigid_kinetostatics, rigid_motion
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.spring import Spring, pull_of
from quickreturn.reference_model.tip import Tip
from tests.engines.scenes import run_24
from tests.reference_model.rigid_loads import rigid_axial_force, rigid_bearing_forces, rigid_bending_moment

Columns = dict[str, Any]
SPEED = 12.0  # rad/s
#: Everything that gives an end of the arm, or the slider, a moment of its own, and a force on the tip.
LOADED = run_24(
    crank={"drive": PrescribedSpeed(speed=SPEED)},
    base=Base(inertia=2e-3, damping=0.05, friction_torque=0.5),
    tip=Tip(mass=0.4, inertia=3e-3, center_of_mass=0.03, force=(3.0, 20.0), force_from=1.0, force_to=5.0),
    slider=Slider(mass=0.2, inertia=2e-3),
    gravity=(0.0, -9.80665),
    follower={"bending_stiffness": math.inf, "yield_strength": 200e6, "fatigue_strength": 80e6},
)


def nothing_known(column: str, angle: float) -> None:
    """An engine without estimates."""


def rigid_cycle(mechanism: Mechanism, rows: int = 721) -> Columns:
    """A turn of the rigid mechanism in closed form, equations 9.1 to 9.11, as the columns of an engine."""
    angle = np.pi + np.linspace(0.0, 2.0 * np.pi, rows)
    motion = rigid_motion(mechanism, angle, SPEED)
    pivot, crank = rigid_bearing_forces(mechanism, angle, SPEED)
    length = mechanism.follower.length
    moments = dict(zip(MOMENTS, rigid_bending_moment(mechanism, np.linspace(0.0, length, 13)[1:-1, None], angle, SPEED), strict=True))
    at_slider = rigid_bending_moment(mechanism, motion.slider_position, angle, SPEED)
    jump = mechanism.slider.inertia * motion.follower_acceleration
    of_spring = {}
    if mechanism.spring is not None:
        place = mechanism.spring.place_on(length) * np.exp(1j * motion.follower_angle)
        pull = pull_of(mechanism.spring, mechanism.pivot_distance + place, 1j * motion.follower_speed * place)
        of_spring = {"spring_force": pull.tension}
    return {
        **of_spring,
        "time": (angle - np.pi) / SPEED,
        "crank_angle": angle,
        "follower_angle": motion.follower_angle,
        "slider_position": motion.slider_position,
        "tip_acceleration": length * motion.follower_acceleration,
        "moment_slider": at_slider,
        "moment_inboard": at_slider - jump,
        "moment_base": rigid_bending_moment(mechanism, 0.0, angle, SPEED),
        "moment_tip": rigid_bending_moment(mechanism, length, angle, SPEED),
        "axial_base": rigid_axial_force(mechanism, 0.0, angle, SPEED),
        "axial_tip": rigid_axial_force(mechanism, length, angle, SPEED),
        **dict.fromkeys(("axial_slider", "axial_inboard"), rigid_axial_force(mechanism, motion.slider_position, angle, SPEED)),
        "slider_force": rigid_kinetostatics(mechanism, angle, SPEED)[0],
        **{
            f"{name}_force_{axis}": part
            for name, parts in (("pivot", pivot), ("crank", crank))
            for axis, part in zip("xy", parts, strict=True)
        },
        **moments,
    }


@pytest.fixture(scope="module")
def rigid() -> Columns:
    return rigid_cycle(LOADED)


def test_moment_along_a_rigid_arm_is_that_of_the_closed_form(rigid: Columns) -> None:
    known = known_moments(LOADED, rigid)
    x = np.linspace(0.0, LOADED.follower.length, 61)
    found = interpolated(x, known)
    right = rigid_bending_moment(LOADED, x[:, None], rigid["crank_angle"], SPEED).T
    right = np.where(np.isclose(x, rigid["slider_position"][:, None], rtol=0.0, atol=1e-9), found, right)  # it jumps there
    # the moment is a cubic on either side, which polynomials of the fifth degree meet to rounding; the slopes at the ends are extrapolated
    # by `BEYOND` of a twelfth, which leaves 5e-5 of the second derivative times the square of a twelfth: 8e-6 of the largest moment
    assert np.abs(found - right).max() < 1e-5 * np.abs(right).max()


@pytest.mark.parametrize("place", [0.42, None], ids=["within a twelfth", "end"])
def test_a_spring_makes_a_kink_in_the_moment_along_the_arm(place: float | None) -> None:
    spring = Spring(stiffness=2e3, anchor=(0.1, -0.3), place=place, free_length=0.1, damping=5.0)
    scene = dataclasses.replace(LOADED, spring=spring, slider=Slider(mass=0.2))
    columns, x = rigid_cycle(scene), np.linspace(0.0, scene.follower.length, 61)
    right = rigid_bending_moment(scene, x[:, None], columns["crank_angle"], SPEED).T
    assert np.abs(interpolated(x, known_moments(scene, columns)) - right).max() < 1e-5 * np.abs(right).max()
    known = known_moments(scene, columns)
    pull = rigid_axial_force(scene, x[:, None], columns["crank_angle"], SPEED).T
    assert np.abs(axial_forces(scene, columns, known, x)[0] - pull).max() < 1e-9 * np.abs(pull).max()
    plain = rigid_cycle(dataclasses.replace(scene, spring=None))
    assert np.abs(right).max() > 3.0 * np.abs(interpolated(x, known_moments(dataclasses.replace(scene, spring=None), plain))).max()
    assert missing(scene, plain) == "column spring_force is missing"


def test_normal_force_along_a_rigid_arm_is_that_of_the_closed_form(rigid: Columns) -> None:
    known, x = known_moments(LOADED, rigid), np.linspace(0.0, LOADED.follower.length, 61)
    found, left_out = axial_forces(LOADED, rigid, known, x)
    right = rigid_axial_force(LOADED, x[:, None], rigid["crank_angle"], SPEED).T
    assert np.abs(found - right).max() < 1e-12 * np.abs(right).max()
    assert np.all(left_out == 0.0)  # nothing bends
    assert right.min() < 0.0 < right.max()  # the tool pulls and presses


#: The rigid arm with so deep a section that the normal force counts beside the moment, and without bodies and force that bend it.
PULLED = dataclasses.replace(
    LOADED,
    base=Base(),
    slider=Slider(),
    tip=Tip(mass=0.4, inertia=0.0, force=(-400.0, 20.0), force_from=1.0, force_to=5.0),
    follower=dataclasses.replace(LOADED.follower, thickness=0.1, width=1e-3),
)


@cache
def stress_of_both(mechanism: Mechanism) -> tuple[Columns, np.ndarray]:
    """Places, and stress of both surfaces there, Pa, shape (2, places, rows), of the rigid arm in closed form."""
    follower = mechanism.follower
    fine, angles = np.linspace(0.0, follower.length, 361), np.pi + np.linspace(0.0, 2.0 * np.pi, 721)
    bending = rigid_bending_moment(mechanism, fine[:, None], angles, SPEED) / section_modulus(follower)
    pull = rigid_axial_force(mechanism, fine[:, None], angles, SPEED) / follower.section.area()
    return {"places": fine, "angles": angles, "pull": pull}, np.array([bending + pull, pull - bending])


@pytest.mark.parametrize("mechanism", [LOADED, PULLED], ids=["bent", "pulled"])
def test_largest_stress_and_amplitude_of_a_rigid_arm(mechanism: Mechanism) -> None:
    found = arm_stress(mechanism, rigid_cycle(mechanism), nothing_known)
    assert found is not None
    grid, right = stress_of_both(mechanism)
    fine, angles = grid["places"], grid["angles"]
    side, place, row = np.unravel_index(int(np.abs(right).argmax()), right.shape)
    share = grid["pull"][place, row]
    assert abs(share) > (0.1 if mechanism is PULLED else 1e-5) * np.abs(right).max()
    assert found.axial is not None
    assert found.axial.value == pytest.approx(share, rel=0.02)
    assert found.lowest.min() == pytest.approx(right[0].min(), rel=0.02)
    assert found.highest.max() == pytest.approx(right[0].max(), rel=0.02)
    right = right[side]
    # half a step of the grid on either side of a corner leaves 3e-3
    assert abs(found.largest.value - abs(right[place, row])) <= found.largest.uncertainty + 3e-3 * found.largest.value
    assert found.largest.uncertainty < 0.01 * found.largest.value
    assert found.largest.place == pytest.approx(fine[place], abs=3e-3)
    assert found.largest.crank_angle == pytest.approx(angles[row] % (2.0 * np.pi), abs=0.02)
    right = max(stress_of_both(mechanism)[1], key=lambda each: np.ptp(each, axis=1).max())
    half = np.ptp(right, axis=1) / 2.0
    assert abs(found.amplitude.value - half.max()) <= found.amplitude.uncertainty + 3e-3 * half.max()
    assert found.amplitude.place == pytest.approx(fine[half.argmax()], abs=6e-3)  # places are 5.3 mm apart
    assert found.mean == pytest.approx((right[half.argmax()].max() + right[half.argmax()].min()) / 2.0, abs=0.02 * half.max())


def test_forces_and_safety(rigid: Columns) -> None:
    loads = loads_of(LOADED, rigid, lambda column, angle: 0.01 if "force" in column else 1e-3)
    assert loads.stress is not None
    angles = np.pi + np.linspace(0.0, 2.0 * np.pi, 14401)
    for name, force in zip(("pivot_force", "crank_force"), rigid_bearing_forces(LOADED, angles, SPEED), strict=True):
        peak, size = loads.peaks[name], np.hypot(*force)
        assert peak is not None
        assert abs(peak.value - size.max()) <= peak.uncertainty + 1e-5 * peak.value  # the tip's force comes and goes with corners
        assert peak.uncertainty < 1e-3 * peak.value
        assert peak.estimate == pytest.approx(0.01 * math.sqrt(2.0))
        assert peak.crank_angle == pytest.approx(angles[size.argmax()] % (2.0 * np.pi), abs=0.01)
    assert loads.peaks["crank_torque"] is None  # the engine does not give it
    assert loads.strain is not None
    assert loads.strain.value == 0.0  # a rigid arm is stressed and not strained
    assert loads.yield_factor is not None
    assert loads.yield_factor.value == pytest.approx(200e6 / loads.stress.largest.value)
    error = loads.stress.largest.error
    assert loads.yield_factor.error == pytest.approx(error / loads.stress.largest.value)
    assert loads.fatigue_factor is not None
    assert loads.fatigue_factor.value == pytest.approx(80e6 / loads.stress.amplitude.value)
    assert safety(None, loads.stress.largest) is None
    assert loads_of(LOADED, {"time": rigid["time"]}, nothing_known).stress is None


def test_gauges_anywhere_read_what_is_recovered_there() -> None:
    """The model's own strain at twelve places other than the twelfths, in run 24 with a heavy tip beyond the end."""
    mechanism = run_24(tip={"center_of_mass": 0.0127})
    length, settings = mechanism.follower.length, ReferenceSettings(modes=5, tolerance=1e-7)
    gauges = np.array([0.02, 0.13, 0.21, 0.31, 0.44, 0.55, 0.63, 0.71, 0.8, 0.87, 0.94, 0.98]) * length
    size = mechanism.follower.thickness / (2.0 * mechanism.follower.bending_stiffness)

    def with_gauges(three: np.ndarray) -> tuple[Columns, np.ndarray]:
        scene = dataclasses.replace(mechanism, follower=dataclasses.replace(mechanism.follower, strain_gauges=tuple(three.tolist())))
        columns = ReferenceEngine().prepare(scene, standard_start(scene), settings).advance(0.4, 1e-3).columns
        return columns, np.column_stack([columns[f"strain_{number}"] for number in (1, 2, 3)])

    for three in gauges.reshape(4, 3):
        columns, strains = with_gauges(three)
        known = known_moments(mechanism, columns)
        found, left_open = (size * each for each in (interpolated(three, known), between(three, left_out(known), known)))
        # 1e-4 of the peak: the estimate of an interpolation error is half of the largest that leaving out shows nearby
        assert np.all(np.abs(found - strains) <= left_open + 1e-4 * size * np.abs(known.twelfths).max())
    strain = loads_of(mechanism, columns, nothing_known).strain
    assert strain is not None
    assert strain.place is not None
    # the strain falls from the corner at the slider by 1 / (s (1 - s / L)) of itself for each metre: 5e-4 for 0.1 mm
    _, strains = with_gauges(strain.place + 1e-4 * np.array([-1.0, 0.0, 1.0]))
    assert np.abs(strains).max() == pytest.approx(strain.value, rel=1e-3)
    assert np.abs(strains[:, 1]).argmax() == pytest.approx(strain.time / 1e-3, abs=1.0)


def test_the_interval_of_a_factor_is_that_of_the_stress_inverted() -> None:
    """A stress of 100 ± 50 MPa gives 240 MPa a factor from 1.6 to 4.8; one of 508,164 MPa ± 369 % gives no bound above."""
    for value, error in ((100e6, 50e6), (508164e6, 3.69 * 508164e6), (100e6, 1e6), (100e6, 100e6)):
        factor = safety(240e6, Number(value, error))
        assert factor is not None
        assert factor.lowest == pytest.approx(240e6 / (value + error))
        assert factor.highest == (pytest.approx(240e6 / (value - error)) if error < value else math.inf)
        assert factor.judged == (error < 0.1 * value)
    unknown = safety(240e6, Number(100e6))
    assert unknown is not None
    assert (unknown.lowest, unknown.highest, unknown.judged) == (None, None, False)


def test_without_the_moment_of_a_body_at_the_end_there_is_no_stress(rigid: Columns) -> None:
    """Differentiating the end's angle twice amplifies: a third party's table without the column gets no number."""
    for name, scene in (("moment_tip", LOADED), ("moment_base", LOADED), ("moment_inboard", LOADED), ("moment_03", LOADED)):
        lacking = {column: values for column, values in rigid.items() if column != name}
        assert name in missing(scene, lacking)
        assert arm_stress(scene, lacking, nothing_known) is None
    bare = dataclasses.replace(
        LOADED, base=Base(), tip=None, slider=Slider(), follower=dataclasses.replace(LOADED.follower, bending_stiffness=1e3, damping=0.0)
    )
    found = rigid_cycle(dataclasses.replace(bare, follower=LOADED.follower))
    ends = {"moment_tip", "moment_base", "moment_inboard"}
    without = arm_stress(bare, {name: values for name, values in found.items() if name not in ends}, lambda column, angle: 0.0)
    with_ends = arm_stress(bare, found, lambda column, angle: 0.0)
    assert without is not None
    assert with_ends is not None
    assert without.largest.value == pytest.approx(with_ends.largest.value, rel=1e-9)
    assert without.largest.estimate == 0.0


def test_the_share_of_a_harmonic_is_that_of_its_neighbourhood() -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, 721)
    orders = {0: 5.0, 1: 3.0, 30: 1.0, 31: 0.3, 33: 0.4, 36: 2.0}
    cycle = {"time": 0.1 * angle, "tip_acceleration": sum(size * np.cos(order * angle) for order, size in orders.items())}
    assert share_of(33, cycle) == pytest.approx(math.hypot(0.3, 0.4) / math.hypot(3.0, 1.0, 0.3, 0.4, 2.0), rel=1e-9)  # without the mean
    assert share_of(1, cycle) == pytest.approx(3.0 / math.hypot(3.0, 1.0, 0.3, 0.4, 2.0), rel=1e-9)
    assert share_of(180, cycle) is None, "too few rows"
    assert share_of(33, {"time": angle}) is None
