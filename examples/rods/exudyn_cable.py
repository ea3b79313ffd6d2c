"""Exudyn: N ANCF cable elements, place and slope held at the clamp. `python exudyn_cable.py N`."""

import itertools

import exudyn as exu
import exudyn.itemInterface as eii  # noqa: N813
import numpy as np

from rod import GRAVITY, LENGTH, MASS_PER_LENGTH, MODULUS, RADIUS, STEP, STIFFNESS, TIMES, printed


def let_go(pieces: int) -> np.ndarray:
    """Deflection of the end, m."""
    container = exu.SystemContainer()
    system, h = container.AddSystem(), LENGTH / pieces
    nodes = [
        system.AddNode(eii.NodePoint2DSlope1(referenceCoordinates=[k * h, 0.0, 1.0, 0.0]))
        for k in range(pieces + 1)
    ]
    axial = MODULUS * np.pi * RADIUS**2
    for pair in itertools.pairwise(nodes):
        cable = system.AddObject(
            eii.ObjectANCFCable2D(
                length=h,
                massPerLength=MASS_PER_LENGTH,
                bendingStiffness=STIFFNESS,
                axialStiffness=axial,
                nodeNumbers=list(pair),
            )
        )
        body = system.AddMarker(eii.MarkerBodyMass(bodyNumber=cable))
        system.AddLoad(eii.LoadMassProportional(markerNumber=body, loadVector=[0.0, -GRAVITY, 0.0]))
    ground = system.AddNode(eii.NodePointGround())
    fixed = system.AddMarker(eii.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for held in (0, 1, 3):
        clamp = system.AddMarker(eii.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=held))
        system.AddObject(eii.CoordinateConstraint(markerNumbers=[fixed, clamp]))
    sensor = system.AddSensor(
        eii.SensorNode(
            nodeNumber=nodes[-1],
            outputVariableType=exu.OutputVariableType.Displacement,
            storeInternal=True,
            writeToFile=False,
        )
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = float(TIMES[-1])
    settings.timeIntegration.numberOfSteps = 4 * (len(TIMES) - 1)
    settings.timeIntegration.newton.relativeTolerance = 1e-5
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = STEP
    settings.timeIntegration.verboseMode = 0
    system.SolveDynamic(settings)
    return np.asarray(system.GetSensorStoredData(sensor))[:, 2]


if __name__ == "__main__":
    printed(let_go)
