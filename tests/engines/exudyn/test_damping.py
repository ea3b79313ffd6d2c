"""Dampers act relative to the turning base and move with it."""

import numpy as np
import pytest

from quickreturn.engines.exudyn.construction import LONGEST, LONGEST_TURN, longest_stretch
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import relative_error
from quickreturn.engines.units import Units
from quickreturn.reference_model.mechanism import PrescribedSpeed, TorqueDrive
from tests.engines.exudyn.runs import arm, errors_of, simulate
from tests.engines.scenes import run_24


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
