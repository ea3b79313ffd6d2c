"""The compliant slider joint in Exudyn, against the open-loop model, MuJoCo's chain, closed forms and conservation laws."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from quickreturn.engines.base import Engine
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Trajectory, relative_error
from quickreturn.plugins.methods.rivals import stiff_spring
from quickreturn.plugins.methods.rivals.stiff_spring import StiffSpringSettings
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.rigid import follower_inertia
from quickreturn.reference_model.slider import Slider
from tests.engines.energy import imbalance
from tests.engines.exudyn.runs import bent_start
from tests.engines.scenes import INCH, run_24


def with_joint(stiffness: float, damping: float = 0.0, **changes) -> Mechanism:
    slider = Slider(joint_stiffness=stiffness, joint_damping=damping, mass=changes.pop("slider_mass", 0.0))
    return run_24(slider=slider, **changes)


def run(chosen: Engine, settings: Settings, scene: Mechanism, duration: float, start: Start | None = None) -> Trajectory:
    return chosen.prepare(scene, start or standard_start(scene), settings).advance(duration, 1e-3)


def exudyn(scene: Mechanism, duration: float, start: Start | None = None, elements: int = 16, step: float = 2.5e-4) -> Trajectory:
    return run(ExudynEngine(), ExudynSettings(elements=elements, step=step), scene, duration, start)


def open_loop(scene: Mechanism, duration: float, start: Start | None = None, shapes: int = 24) -> Trajectory:
    """Other coordinates, other shapes, the gap's direction and rate in closed form, another integrator."""
    return run(stiff_spring.ENGINE, StiffSpringSettings(shapes=shapes, tolerance=1e-8), scene, duration, start)


@cache
def rigid() -> Trajectory:
    return exudyn(run_24(), 0.1)


@pytest.mark.parametrize("damping", [pytest.param(0.0, marks=pytest.mark.verify), 20.0, pytest.param(500.0, marks=pytest.mark.verify)])
def test_moves_as_the_open_loop_model(damping: float) -> None:
    """Exudyn's own error, of second order in step and elements, leaves 2e-4 in 0.3 s with these settings, in the strains 1e-2."""
    scene = with_joint(2e4, damping)
    found, expected = exudyn(scene, 0.1), open_loop(scene, 0.1)
    for channel in ("tip_deflection", "tip_acceleration", "slider_force", "strain_2"):
        assert relative_error(found[channel], expected[channel]) < 1e-3, channel
    assert relative_error(found["constraint_gap"], np.abs(expected["constraint_gap"])) < 1e-3
    # the slider stands at the crank tip's foot: measured 2e-7. A damper that also acts along the tangent drags it away by
    # (c/k) x gap x turning, 2e-6 of its place with 20 N s/m and 4e-5 with 500 N s/m
    assert relative_error(found["slider_position"], expected["slider_position"]) < 1e-6
    assert relative_error(found["dissipated_energy"], expected["dissipated_energy"]) < 1e-5


def test_the_gap_is_the_force_over_the_stiffness() -> None:
    """Force from the joint's multipliers, gap from the coordinates; Newton's iteration leaves 1e-6 of the forces."""
    found = exudyn(with_joint(2e4), 0.1)
    assert found["constraint_gap"].max() > 1e-4
    assert found["constraint_gap"] == pytest.approx(np.abs(found["slider_force"]) / 2e4, abs=1e-6 * found["constraint_gap"].max())


def test_energy_balances_with_spring_and_damper() -> None:
    scene = with_joint(2e4, 20.0, slider_mass=0.2, gravity=(1.0, -9.81), tip={"center_of_mass": 0.5 * INCH})
    coarse, fine = (imbalance(exudyn(scene, 0.2, step=step)) for step in (2.5e-4, 1.25e-4))
    assert fine < 2e-4
    assert 3.0 < coarse / fine < 5.0  # it vanishes with the square of the step: no term is missing


@pytest.mark.parametrize("stiffness", [1e3, 2e4, 1e9])
@pytest.mark.parametrize("degrees", [180, 90, 0])
def test_frozen_crank_frequencies_are_those_of_the_supported_beam(stiffness: float, degrees: int) -> None:
    """Polynomials of high degree on either side of the slider; the cubic elements err by 1.5e-4 in the third mode at 0 deg."""
    scene, angle = with_joint(stiffness), math.radians(degrees)
    found = ExudynEngine().natural_frequencies(scene, angle, 3, ExudynSettings(elements=24))
    assert found == pytest.approx(frozen_crank_modes(scene, angle, 3).frequencies, rel=3e-4)


def rigid_mechanism(**changes) -> Mechanism:
    return with_joint(2e4, 20.0, slider_mass=0.2, follower={"bending_stiffness": math.inf}, gravity=(1.0, -9.81), **changes)


def test_rigid_follower_on_a_spring_is_two_bodies_in_closed_form() -> None:
    """Two angles and the force k gap + c gap rate between them, integrated by scipy; second order: 2.4e-5 with this step."""
    scene = rigid_mechanism()
    crank, follower, tip, slider = scene.crank, scene.follower, scene.tip, scene.slider
    torque, damping = crank.drive.torque, crank.drive.damping
    LA, d, (gx, gy) = crank.length, scene.pivot_distance, scene.gravity
    crank_inertia = crank.inertia_about_pivot + slider.mass * LA**2
    crank_moment = crank.mass * crank.center_of_mass + slider.mass * LA
    moment = follower.mass_per_length * follower.length**2 / 2.0 + tip.mass * follower.length

    def joint(q1, q2, q1_rate, q2_rate):
        gap = LA * np.sin(q1 - q2) + d * np.sin(q2)
        arm = LA * np.cos(q1 - q2)  # of the force about O
        place = arm - d * np.cos(q2)  # of the slider on the follower, and the arm about P
        force = slider.joint_stiffness * gap + slider.joint_damping * (arm * q1_rate - place * q2_rate)
        return gap, arm, place, force

    def rates(_, y):
        q1, q2, q1_rate, q2_rate = y
        _, arm, place, force = joint(*y)
        crank_weight = crank_moment * (gy * np.cos(q1) - gx * np.sin(q1))
        weight = moment * (gy * np.cos(q2) - gx * np.sin(q2))
        q1_acceleration = (torque - damping * q1_rate + crank_weight - force * arm) / crank_inertia
        q2_acceleration = (weight - scene.base.damping * q2_rate + force * place) / follower_inertia(scene)[0]
        return [q1_rate, q2_rate, q1_acceleration, q2_acceleration]

    speed = crank.drive.initial_speed
    begin = [math.pi, math.pi, speed, LA * speed / (d + LA)]
    found = exudyn(scene, 0.2)
    y = solve_ivp(rates, (0.0, 0.2), begin, method="DOP853", t_eval=found["time"], rtol=1e-10, atol=1e-12).y
    gap, _, place, force = joint(*y)
    assert relative_error(found["slider_force"], force) < 1e-4
    assert relative_error(found["constraint_gap"], np.abs(gap)) < 1e-4
    assert found["slider_position"] == pytest.approx(place, abs=1e-6)
    assert relative_error(found["follower_angle"], y[1]) < 1e-6
    assert relative_error(found["crank_speed"], y[2]) < 1e-5
    assert imbalance(found) < 1e-2  # of the spring's 7 mJ, 5e-5 of what the gravity moves


@pytest.mark.verify
def test_a_bent_start_begins_without_force() -> None:
    """Gap and gap rate are zero, so the follower begins as if it were free; a carriage without mass would begin with no acceleration."""
    scene = with_joint(2e4, 20.0)
    found, expected = exudyn(scene, 0.03, bent_start(), elements=24, step=1.25e-4), open_loop(scene, 0.03, bent_start())
    assert abs(found["slider_force"][0]) < 1e-4  # N: the carriage's own inertia
    assert found["tip_acceleration"][0] < -100.0  # m/s^2
    # second order in the step: 1.4e-3 and 4.6e-4 with 2.5e-4 and 1.25e-4 s; without the start's accelerations 1.5e-2
    assert relative_error(found["tip_deflection"], expected["tip_deflection"]) < 1e-3
    # The bend does not fit the tip body, which sets off all modes: measured 7e-3, between 24 and 48 shapes 2e-3
    assert relative_error(found["slider_force"], expected["slider_force"]) < 2e-2


def test_what_is_built_is_listed() -> None:
    settings = ExudynSettings(elements=8)
    stiff, soft, damped = (ExudynEngine().describe(scene, settings) for scene in (run_24(), with_joint(2e4), with_joint(2e4, 5.0)))
    assert soft.degrees_of_freedom == stiff.degrees_of_freedom + 1  # the gap
    assert "compliant joint, 20000 N/m, 0 N*s/m" in soft.joints[-1]
    assert "5 N*s/m" in damped.joints[-1]
    assert ExudynEngine().describe(rigid_mechanism(), settings).degrees_of_freedom == 2
