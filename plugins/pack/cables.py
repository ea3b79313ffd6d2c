"""Bodies and ANCF cables in Exudyn, written for the pack: they share no file with the engines of the project.

Places and velocities are complex numbers, m and m/s.
"""

from collections.abc import Callable
from typing import Any, Final

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items  # noqa: N813
from exudyn.beams import GenerateBeamElementsAlongLine

from quickreturn.plugins.pack.values import CRANK, HUB, PENDULUM, Columns, G, times
from quickreturn.reference_model.arrays import Array

#: Axial stiffness (N) of strips that are meant to be inextensible: it lengthens them by less than 1e-5 of themselves.
STIFF: Final = 1e6


class Plane:
    """A plane system."""

    def __init__(self) -> None:
        self._container = exu.SystemContainer()
        self.mbs = self._container.AddSystem()
        self._ground = self.coordinate(self.mbs.AddNode(items.NodePointGround()), 0)

    def cable(self, strip: Any, elements: int, begin: complex, along: complex = 1.0, rate: float = 0.0, pull: complex = 0.0) -> list[int]:
        """A straight strip from `begin` in the direction `along`, its nodes; `rate` (rad/s) about `begin`, gravity `pull` (m/s^2)."""
        element = items.ObjectANCFCable2D(massPerLength=strip.mass, bendingStiffness=strip.bending, axialStiffness=STIFF)
        ends = ([*_parts(begin + along * x), 0.0] for x in (0.0, strip.length))
        made = GenerateBeamElementsAlongLine(self.mbs, *ends, elements, element, [*_parts(pull), 0.0])
        nodes: list[int] = made["nodes"]
        for k, node in enumerate(nodes):
            velocities = _parts(1j * rate * along * strip.length * k / elements, 1j * rate * along)
            self.mbs.SetNodeParameter(node, "initialVelocities", velocities)
        return nodes

    def coordinate(self, node: int, number: int) -> int:
        """A marker of a node's coordinate."""
        marker: int = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=number))
        return marker

    def hold(self, node: int, number: int, given: Callable[[float], float] | None = None) -> None:
        """Hold a node's coordinate, or move it as given: to a distance from its reference at a time (s)."""
        how = {} if given is None else {"offset": given(0.0), "offsetUserFunction": lambda mbs, t, item, offset: given(t)}
        self.mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[self._ground, self.coordinate(node, number)], **how))

    def move(self, duration: float, rows: int, steps: int, *nodes: int) -> list[Array]:
        """Integrate with `steps` steps from row to row: coordinates of each node, shape (rows + 1, coordinates)."""
        recorded = {"outputVariableType": exu.OutputVariableType.CoordinatesTotal, "storeInternal": True}
        sensors = [self.mbs.AddSensor(items.SensorNode(nodeNumber=node, **recorded)) for node in nodes]
        self.mbs.Assemble()
        settings = exu.SimulationSettings()
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = duration / rows
        settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = duration, rows * steps
        settings.timeIntegration.verboseMode = 0
        settings.timeIntegration.adaptiveStep = False  # a step that is halved would spoil the extrapolation
        # judged by the change of coordinates: rounding of the residual grows with the axial stiffness
        newton = settings.timeIntegration.newton
        newton.residualMode, newton.relativeTolerance, newton.absoluteTolerance = 1, 1e-8, 1e-14
        settings.displayComputationTime = settings.displayStatistics = False
        assert self.mbs.SolveDynamic(settings)
        return [np.array(self.mbs.GetSensorStoredData(sensor))[:, 1:] for sensor in sensors]


def _parts(*numbers: complex) -> list[float]:
    return [part for z in numbers for part in (complex(z).real, complex(z).imag)]


def _limit(run: Callable[[int, int], Array], duration: float, elements: int, steps: int, *names: str) -> Columns:
    """Columns of `run(elements, steps)` extrapolated to no step, with the second order, and to no element, with the fourth."""
    one, half = run(elements, steps), run(elements, 2 * steps)
    more = run(2 * elements, steps)
    found = half + (half - one) / 3.0 + (more - one) * 16.0 / 15.0
    return {"time": times(duration, len(found) - 1)} | dict(zip(names, found.T, strict=True))


def bending_pendulum(rows: int, elements: int = 12, steps: int = 5) -> Columns:
    """A cable pinned at its beginning."""

    def run(elements: int, steps: int) -> Array:
        plane = Plane()
        nodes = plane.cable(PENDULUM, elements, 0.0, -1j, PENDULUM.rate, -1j * G)
        plane.hold(nodes[0], 0)
        plane.hold(nodes[0], 1)
        tip, middle = plane.move(PENDULUM.duration, rows, steps, nodes[-1], nodes[elements // 2])
        return np.column_stack([tip[:, :2], middle[:, :2]])

    return _limit(run, PENDULUM.duration, elements, steps, "tip_x", "tip_y", "middle_x", "middle_y")


def hub(rows: int, elements: int = 16, steps: int = 10) -> Columns:
    """A cable clamped to a hub."""

    def torque(mbs: Any, t: float, load: float) -> float:
        return float(HUB.torque * np.sin(2 * np.pi * t / HUB.period)) if t < HUB.period else 0.0

    def run(elements: int, steps: int) -> Array:
        plane = Plane()
        mbs, node = plane.mbs, plane.mbs.AddNode(items.NodeRigidBody2D())
        body = mbs.AddObject(items.ObjectRigidBody2D(mass=1.0, inertia=HUB.inertia, nodeNumber=node))
        plane.hold(node, 0)
        plane.hold(node, 1)
        nodes = plane.cable(HUB, elements, HUB.radius)
        clamped = [
            mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=[HUB.radius, 0.0, 0.0])),
            mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0])),
        ]
        mbs.AddObject(items.ObjectJointGeneric(markerNumbers=clamped, constrainedAxes=[1, 1, 0, 0, 0, 1]))
        mbs.AddLoad(items.LoadCoordinate(markerNumber=plane.coordinate(node, 2), load=1.0, loadUserFunction=torque))
        turned, tip = plane.move(HUB.duration, rows, steps, node, nodes[-1])
        x, y, angle = *tip[:, :2].T, turned[:, 2]
        return np.column_stack([x, y, np.cos(angle) * y - np.sin(angle) * x, angle])

    return _limit(run, HUB.duration, elements, steps, "tip_x", "tip_y", "tip_deflection", "hub_angle")


def slider_crank(rows: int, elements: int = 12, steps: int = 5) -> Columns:
    """A cable whose beginning moves as the crank's end, and whose end a point mass holds on a line."""
    period = CRANK.ramp / (2 * np.pi)

    def turn(t: float) -> float:
        begun = CRANK.speed / CRANK.ramp * (t**2 / 2 + period**2 * (np.cos(t / period) - 1))
        return float(begun if t < CRANK.ramp else CRANK.speed * (t - CRANK.ramp / 2))

    def run(elements: int, steps: int) -> Array:
        plane = Plane()
        nodes = plane.cable(CRANK, elements, CRANK.crank)
        plane.hold(nodes[0], 0, lambda t: CRANK.crank * (np.cos(turn(t)) - 1))
        plane.hold(nodes[0], 1, lambda t: CRANK.crank * np.sin(turn(t)))
        plane.hold(nodes[-1], 1)
        point = plane.mbs.AddNode(items.NodePoint2D(referenceCoordinates=[CRANK.crank + CRANK.length, 0.0]))
        plane.mbs.AddObject(items.ObjectMassPoint2D(physicsMass=CRANK.block, nodeNumber=point))
        markers = [plane.mbs.AddMarker(items.MarkerNodePosition(nodeNumber=each)) for each in (point, nodes[-1])]
        plane.mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))
        found = plane.move(CRANK.duration, rows, steps, nodes[0], nodes[elements // 2], nodes[-1])
        begin, middle, block = (each[:, 0] + 1j * each[:, 1] for each in found)
        bow = ((middle - (begin + block) / 2) * np.conj(1j * (block - begin))).real / np.abs(block - begin)
        return np.column_stack([block.real, middle.real, middle.imag, bow])

    return _limit(run, CRANK.duration, elements, steps, "block_x", "middle_x", "middle_y", "bow")
