"""A four-bar linkage with a flexible coupler: energy, both forms, the rigid limit, and Exudyn's ANCF cable."""

from itertools import pairwise

import exudyn as exu
import numpy as np
import pandas as pd
import pytest
from exudyn import itemInterface as items  # noqa: N813

from quickreturn.derive import Model
from quickreturn.plugins.derive.tests.descriptions import described

GROUND, CRANK, COUPLER, ROCKER = 0.4, 0.1, 0.4, 0.3
START = {"crank_angle": 0.3, "crank_angle_rate": 20.0}


@pytest.fixture(scope="module")
def models() -> dict[str, Model]:
    system = described("four_bar").four_bar()
    return {form: Model(system, form) for form in ("projection", "multipliers")}


def test_energy_stays_and_both_forms_agree(models: dict[str, Model]) -> None:
    found = [model.simulate(START, 0.2, 0.01, tolerance=1e-11) for model in models.values()]
    for each in found:
        assert each["bow"].abs().max() > 2.0  # mm: it bends
        assert np.ptp(each["energy_balance"]) < 1e-9 * each["kinetic_energy"].max()
    for name in ("crank_angle", "bow", "coupler_angle", "eta_3"):
        assert np.max(np.abs(found[0][name] - found[1][name])) < 1e-7 * np.max(np.abs(found[0][name])), name


@pytest.mark.verify
def test_a_flexible_coupler_of_a_parallelogram_passes_the_line() -> None:
    """A bent coupler is shorter, so that the rods are in line twice within 0.2 ms, while it vibrates; one passage may cross both."""
    start = {"crank_angle": 0.5, "crank_angle_rate": 20.0, "rocker_angle": 0.5, "coupler_angle": 0.0}
    system = described("four_bar").four_bar(2)
    found = [Model(system, form).simulate(start, 0.6, 0.002, parameters={"rocker": 100.0}) for form in ("projection", "multipliers")]
    for each in found:
        np.testing.assert_allclose(each.attrs["singular_positions"], 0.13214, atol=1e-4)
        assert np.ptp(each["energy_balance"]) < 1e-7 * each["kinetic_energy"].max()
    one, other = (each[["crank_angle", "rocker_angle"]] for each in found)
    np.testing.assert_allclose(one, other, atol=1e-5)


@pytest.mark.verify
def test_a_stiff_coupler_moves_as_a_rigid_one() -> None:
    """The difference falls with 1/EI."""
    four_bar = described("four_bar").four_bar
    rigid = Model(four_bar(0)).simulate(START, 0.2, 0.02, tolerance=1e-10)
    model, errors = Model(four_bar(1)), []
    for factor in (100.0, 1000.0):
        found = model.simulate(START, 0.2, 0.02, tolerance=1e-10, parameters={"bending_stiffness": 1.2 * factor})
        errors.append(np.max(np.abs(found["crank_angle"] - rigid["crank_angle"])))
    assert 1e-7 < errors[1] < errors[0] / 5 < 1e-3


def by_exudyn(start: pd.Series, duration: float, elements: int, steps: int, axial_stiffness: float = 1e6) -> tuple[float, float]:
    """Crank angle (rad) and distance of the coupler's middle from its chord (mm) at the end."""
    mbs = exu.SystemContainer().AddSystem()
    ground = mbs.AddObject(items.ObjectGround())
    bars = []
    for pivot, angle, rate, inertia in (
        (0.0, "crank_angle", "crank_angle_rate", 5e-3),
        (GROUND, "rocker_angle", "rocker_angle_rate", 4e-3),
    ):
        # turned about its pivot, where a mass does nothing
        node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[pivot, 0, start[angle]], initialVelocities=[0, 0, start[rate]]))
        body = mbs.AddObject(items.ObjectRigidBody2D(mass=1.0, inertia=inertia, nodeNumber=node))
        at = [
            mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=number, localPosition=[x, 0, 0]))
            for number, x in ((ground, pivot), (body, 0.0))
        ]
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=at))
        bars.append((node, body))
    arm, hinge = (length * np.exp(1j * start[f"{name}_angle"]) for name, length in (("crank", CRANK), ("rocker", ROCKER)))
    speeds = [1j * start[f"{name}_angle_rate"] * arm_ for name, arm_ in (("crank", arm), ("rocker", hinge))]
    chord, chord_rate = (GROUND + hinge - arm) / COUPLER, (speeds[1] - speeds[0]) / COUPLER
    nodes = []
    for x in np.linspace(0.0, COUPLER, elements + 1):
        place, velocity = arm + chord * x, speeds[0] + chord_rate * x
        at_node = [each for z in (place, chord) for each in (z.real, z.imag)]
        moving = [each for z in (velocity, chord_rate) for each in (z.real, z.imag)]
        nodes.append(mbs.AddNode(items.NodePoint2DSlope1(referenceCoordinates=at_node, initialVelocities=moving)))
    for left, right in pairwise(nodes):
        mbs.AddObject(
            items.ObjectANCFCable2D(
                length=COUPLER / elements,
                massPerLength=0.16,
                bendingStiffness=1.2,
                axialStiffness=axial_stiffness,
                nodeNumbers=[left, right],
            )
        )
    for (_, body), length, node in ((bars[0], CRANK, nodes[0]), (bars[1], ROCKER, nodes[-1])):
        end = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[length, 0, 0]))
        mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[end, mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node))]))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = duration, steps
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.95
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    assert mbs.SolveDynamic(settings)
    turned = float(mbs.GetNodeOutput(bars[0][0], exu.OutputVariableType.Coordinates)[2]) + start["crank_angle"]
    first, middle, last = (
        complex(*mbs.GetNodeOutput(node, exu.OutputVariableType.Position)[:2]) for node in (nodes[0], nodes[elements // 2], nodes[-1])
    )
    across = 1j * (last - first) / abs(last - first)
    return turned, 1e3 * ((middle - (first + last) / 2) * across.conjugate()).real


@pytest.mark.verify
def test_exudyns_ancf_cable_moves_alike() -> None:
    duration = 0.1
    model = Model(described("four_bar").four_bar(3))
    found = model.simulate(START, duration, duration / 2, tolerance=1e-9)
    coarse, fine, soft = (by_exudyn(found.iloc[0], duration, *run) for run in ((6, 750), (12, 1500), (12, 1500, 1e5)))
    ours = found.iloc[-1][["crank_angle", "bow"]].to_numpy()
    assert abs(ours[1]) > 1.0
    for k in range(2):
        # of second order in step and element; the cable stretches, and what that does goes with 1/EA, of which the soft one has ten times
        bound = abs(coarse[k] - fine[k]) + abs(fine[k] - soft[k]) / 9
        assert abs(ours[k] - fine[k]) < bound < 5e-3 * abs(fine[k])
