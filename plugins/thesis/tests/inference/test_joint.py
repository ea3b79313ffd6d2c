"""A mass beyond the compliance, and the strip's twist, by second formulations."""

import math
from itertools import pairwise

import exudyn as exu
import numpy as np
import pytest
from exudyn.itemInterface import MarkerBodyRigid, MarkerNodeRigid, ObjectBeamGeometricallyExact, ObjectGround
from exudyn.utilities import Force, GenericJoint, NodeRigidBodyEP, Torque

from quickreturn.cases.library.thesis import run_case
from quickreturn.plugins.thesis.inference.unknowns import NAMES, PRINTED
from quickreturn.plugins.thesis.inference.weights import RETURN, at_return, greatest_first_frequency, moved_by_mass, with_mass
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.scene_values import changed

SCENE = run_case(24).mechanism
#: Poisson's ratio of aluminium.
POISSON = 0.33
#: Stiffness, N/m, of a roller that lowers the frequency of its half by 2 %, the least that the words mean.
ONE_SIDED = 18.5e3


def test_a_mass_beyond_the_compliance_is_a_spring_that_its_own_frequency_softens() -> None:
    """The follower meets k - m omega^2: with that spring and no mass it has the same frequency."""
    stiffness, mass, angle = 2e4, 0.05, math.pi
    first = with_mass(changed(SCENE, {"slider.joint_stiffness": stiffness}), angle, mass)[0]
    softer = stiffness - mass * (2.0 * math.pi * first) ** 2
    assert softer < 0.98 * stiffness
    modes = frozen_crank_modes(changed(SCENE, {"slider.joint_stiffness": softer}), angle, 1)
    assert first == pytest.approx(modes.frequencies[0], rel=1e-5)


def test_without_a_mass_the_frequencies_are_those_of_the_crank_held() -> None:
    of_spring = changed(SCENE, {"slider.joint_stiffness": 2e4, "follower.bending_stiffness": 1.2 * SCENE.follower.bending_stiffness})
    found = at_return(np.array([1.2]), np.array([20.0]), np.zeros(1))[0]
    # the table is interpolated in the stiffness
    assert found == pytest.approx(frozen_crank_modes(of_spring, RETURN, len(found)).frequencies, rel=5e-3)


def test_a_mass_lowers_the_mode_that_rings_or_leaves_the_next_one() -> None:
    stiffness, plus = np.ones(2), np.full(2, 10.0)
    without, having = (at_return(stiffness, plus, mass) for mass in (np.zeros(2), np.array([0.0, 0.05])))
    own, following = moved_by_mass(without[:, 2], without, having)
    assert own[0] == following[0] == pytest.approx(without[0, 2])
    assert own[1] < without[1, 2] < following[1]


def test_the_greatest_first_frequency_grows_with_the_root_of_the_bending_stiffness() -> None:
    printed, stiffer = (np.array([{**PRINTED, "stiffness": ratio}[name] for name in NAMES]) for ratio in (1.0, 1.21))
    assert greatest_first_frequency(stiffer) == pytest.approx(1.1 * greatest_first_frequency(printed), rel=2e-3)  # the base turns, too
    assert greatest_first_frequency(printed) == pytest.approx(20.7, abs=0.1)  # Hz


def torsional_stiffness() -> float:
    """G J of the follower's rectangular section, N m^2, with J = b t^3 / 3 (1 - 0.63 t / b).

    A roller that pushes at the distance e from the middle of the strip's width twists it by F e s / (G J) where the slider holds it: the
    base holds the twist at P alone. The point of contact moves by e times this twist, so it has the compliance c = e^2 s / (G J)
    (Timoshenko and Goodier, "Theory of Elasticity", 1970, sections 108 and 109), the same for both directions of the force.
    """
    width, thickness = SCENE.follower.width or math.nan, SCENE.follower.thickness or math.nan
    torsion = width * thickness**3 / 3.0 * (1.0 - 0.63 * thickness / width)
    return SCENE.follower.elastic_modulus / (2.0 * (1.0 + POISSON)) * torsion


def twisted(eccentricity: float, elements: int = 16) -> float:
    """Twist (rad) at the slider under 1 N that acts beside the middle, by three-dimensional beams of Exudyn."""
    follower, length, force = SCENE.follower, SCENE.pivot_distance, 1.0
    width, thickness, modulus = follower.width, follower.thickness, follower.elastic_modulus
    assert width is not None
    assert thickness is not None
    area, shear = width * thickness, modulus / (2.0 * (1.0 + POISSON))
    section = exu.BeamSection()
    bending = (modulus * thickness * width**3 / 12.0, modulus * width * thickness**3 / 12.0)
    stiffness = (modulus * area, 5 / 6 * shear * area, 5 / 6 * shear * area, torsional_stiffness(), *bending)
    section.stiffnessMatrix, section.inertia, section.massPerLength = np.diag(stiffness), 1e-3 * np.eye(3), 1.0
    system = exu.SystemContainer().AddSystem()
    places = np.linspace(0.0, length, elements + 1)
    nodes = [system.AddNode(NodeRigidBodyEP(referenceCoordinates=[place, 0, 0, 1, 0, 0, 0])) for place in places]
    for pair in pairwise(nodes):
        system.AddObject(ObjectBeamGeometricallyExact(nodeNumbers=[*pair], length=length / elements, sectionData=section))
    ground = system.AddMarker(MarkerBodyRigid(bodyNumber=system.AddObject(ObjectGround())))
    first, last = (system.AddMarker(MarkerNodeRigid(nodeNumber=node)) for node in (nodes[0], nodes[-1]))
    system.AddObject(GenericJoint(markerNumbers=[ground, first], constrainedAxes=[1] * 6))
    system.AddLoad(Force(markerNumber=last, loadVector=[0, force, 0]))
    system.AddLoad(Torque(markerNumber=last, loadVector=[-force * eccentricity, 0, 0]))
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.staticSolver.verboseMode = 0
    settings.staticSolver.newton.relativeTolerance = 1e-10
    system.SolveStatic(settings)
    return abs(float(system.GetNodeOutput(nodes[-1], exu.OutputVariableType.Rotation)[0]))


def test_a_three_dimensional_model_twists_as_the_formula_says() -> None:
    eccentricity = 0.5 * (SCENE.follower.width or 0.0)
    torsional = torsional_stiffness() / SCENE.pivot_distance
    # the bent strip's end turns by 17 mrad, which the formula leaves out
    assert eccentricity * twisted(eccentricity) == pytest.approx(eccentricity**2 / torsional, rel=1e-3)
    assert torsional / eccentricity**2 == pytest.approx(52.4e3, rel=1e-2)  # docs/thesis.md
    assert math.sqrt(torsional / ONE_SIDED) > eccentricity  # the contact would have to lie outside the strip


def test_the_third_mode_of_the_crank_held_lies_at_132_hz_and_bends_gauges_1_and_3_against_gauge_2() -> None:
    modes = [frozen_crank_modes(SCENE, float(angle), 3) for angle in np.linspace(0.0, math.pi, 61)]
    second, third = np.array([each.frequencies[1:] for each in modes]).T
    assert third.min() < 132.0 < third.max()
    assert second.max() < 70.0
    signs = np.sign([each.curvature(np.array(SCENE.follower.strain_gauges))[2] for each in modes])
    assert np.all(signs[:, 0] == signs[:, 2])
    assert np.all(signs[:, 0] == -signs[:, 1])
