"""Bodies and ANCF cables in Exudyn, written for the pack: they share no file with the engines of the project.

Places and velocities are complex numbers, m and m/s.
"""

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from operator import mul
from typing import Any, Final, NamedTuple

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items  # noqa: N813

from quickreturn.pack.make.values import CRANK, HUB, PENDULUM, SAG, Array, Columns, G, times

#: The value of a coordinate at a time (s), counted from its reference.
Given = Callable[[float], float]


class Strip(NamedTuple):
    """A uniform beam."""

    length: float  # m
    mass: float  # kg/m
    bending: float  # N m^2
    axial: float  # N; large: the strip is meant to be inextensible


class Plane:
    """A plane system, and what is recorded of it."""

    def __init__(self, gravity: complex = 0.0) -> None:
        self._container = exu.SystemContainer()
        self.mbs = self._container.AddSystem()
        self._gravity, self._sensors = gravity, dict[str, int]()
        self._ground = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=self.mbs.AddNode(items.NodePointGround()), coordinate=0))

    def body(self, mass: float, inertia: float) -> tuple[int, int]:
        """A rigid body at the origin: its node and object."""
        node = self.mbs.AddNode(items.NodeRigidBody2D())
        return node, self.mbs.AddObject(items.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    def cable(self, strip: Strip, elements: int, begin: complex, along: complex, rate: float = 0.0) -> list[int]:
        """A straight cable that leaves `begin` in the direction `along` and turns about `begin` at a rate (rad/s): its nodes."""
        h, mbs = strip.length / elements, self.mbs
        nodes = [
            mbs.AddNode(
                items.NodePoint2DSlope1(
                    referenceCoordinates=_parts(begin + along * h * k, along),
                    initialVelocities=_parts(1j * rate * along * h * k, 1j * rate * along),
                )
            )
            for k in range(elements + 1)
        ]
        for pair in pairwise(nodes):
            element = items.ObjectANCFCable2D(
                length=h, massPerLength=strip.mass, bendingStiffness=strip.bending, axialStiffness=strip.axial, nodeNumbers=list(pair)
            )
            weight = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=mbs.AddObject(element)))
            if self._gravity:
                load = [*_parts(self._gravity), 0.0]
                mbs.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=load))
        return nodes

    def coordinate(self, node: int, number: int) -> int:
        """A marker of a node's coordinate."""
        return self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=number))

    def hold(self, node: int, number: int, given: Given | None = None) -> None:
        """Hold a node's coordinate, or move it as given."""
        how = {} if given is None else {"offset": given(0.0), "offsetUserFunction": lambda mbs, t, item, offset: given(t)}
        self.mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[self._ground, self.coordinate(node, number)], **how))

    def clamp(self, node: int, body: int, x: float) -> None:
        """Clamp a cable's node to a body's place (x, 0)."""
        markers = [
            self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=[x, 0.0, 0.0])),
            self.mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node)),
        ]
        self.mbs.AddObject(items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=[1, 1, 0, 0, 0, 1]))

    def point_mass(self, mass: float, node: int, place: complex) -> None:
        """A point mass pinned to a node."""
        point = self.mbs.AddNode(items.NodePoint2D(referenceCoordinates=_parts(place)))
        self.mbs.AddObject(items.ObjectMassPoint2D(physicsMass=mass, nodeNumber=point))
        markers = [self.mbs.AddMarker(items.MarkerNodePosition(nodeNumber=each)) for each in (point, node)]
        self.mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))

    def load(self, node: int, number: int, size: Given) -> None:
        """A force or moment (N, N m) on a node's coordinate, as a function of time (s)."""
        marker = self.coordinate(node, number)
        self.mbs.AddLoad(items.LoadCoordinate(markerNumber=marker, load=1.0, loadUserFunction=lambda mbs, t, load: size(t)))

    def watch(self, name: str, node: int) -> None:
        """Record all coordinates of a node."""
        kind = exu.OutputVariableType.CoordinatesTotal
        self._sensors[name] = self.mbs.AddSensor(items.SensorNode(nodeNumber=node, outputVariableType=kind, storeInternal=True))

    def move(self, duration: float, rows: int, steps: int) -> dict[str, Array]:
        """Integrate with `steps` steps from row to row: coordinates of the watched nodes, shape (rows + 1, coordinates)."""
        settings = self._assembled()
        settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = duration, rows * steps
        settings.solutionSettings.sensorsWritePeriod = duration / rows
        assert self.mbs.SolveDynamic(settings)
        return self._recorded()

    def load_up(self, rows: int) -> dict[str, Array]:
        """Equilibria while time, on which loads depend, goes from 0 to 1 in steps of 1/rows."""
        settings = self._assembled()
        settings.staticSolver.numberOfLoadSteps = rows
        assert self.mbs.SolveStatic(settings)
        return self._recorded()

    def _assembled(self) -> Any:
        self.mbs.Assemble()
        settings = exu.SimulationSettings()
        settings.solutionSettings.writeSolutionToFile = False
        settings.timeIntegration.verboseMode = settings.staticSolver.verboseMode = 0
        settings.timeIntegration.adaptiveStep = False  # a step that is halved would spoil the extrapolation
        # judged by the change of coordinates: rounding of the residual grows with the axial stiffness
        newton = settings.timeIntegration.newton
        newton.residualMode, newton.relativeTolerance, newton.absoluteTolerance = 1, 1e-8, 1e-14
        settings.displayComputationTime = settings.displayStatistics = False
        return settings

    def _recorded(self) -> dict[str, Array]:
        return {name: np.array(self.mbs.GetSensorStoredData(sensor))[:, 1:] for name, sensor in self._sensors.items()}


def _parts(*numbers: complex) -> list[float]:
    return [part for z in numbers for part in (complex(z).real, complex(z).imag)]


def in_the_limit(run: Callable[[int, int], Array], elements: int, steps: int) -> Array:
    """`run(elements, steps)` extrapolated to no step, with the second order, and to no element, with the fourth."""
    one, half = run(elements, steps), run(elements, 2 * steps)
    more = run(2 * elements, steps)
    return half + (half - one) / 3.0 + (more - one) * 16.0 / 15.0


#: Axial stiffness (N) of strips that are meant to be inextensible: it lengthens them by less than 1e-5 of themselves.
STIFF: Final = 1e6


def _strip_of(values: Any) -> Strip:
    return Strip(values.length, values.mass, values.bending, STIFF)


def sag(rows: int, elements: int = 32) -> Columns:
    """A clamped cable under growing parts of weight and tip force."""

    def run(elements: int) -> Array:
        plane = Plane()
        nodes = plane.cable(_strip_of(SAG)._replace(axial=100 * STIFF), elements, 0.0, 1.0)
        for number in (0, 1, 3):
            plane.hold(nodes[0], number)
        share = SAG.mass * G * SAG.length / elements  # of the weight on each element, with consistent nodal forces
        for k, node in enumerate(nodes):
            inner = 0 < k < elements
            weight, moment = share * (1.0 if inner else 0.5), 0.0 if inner else share * SAG.length / elements / (12.0 if k == 0 else -12.0)
            tip = SAG.force if k == elements else 0.0
            plane.load(node, 1, partial(mul, -weight - tip))
            plane.load(node, 3, partial(mul, -moment))
        plane.watch("tip", nodes[-1])
        plane.watch("middle", nodes[elements // 2])
        found = plane.load_up(rows)
        tip, middle = found["tip"], found["middle"]
        return np.column_stack([tip[:, :2], np.arctan2(tip[:, 3], tip[:, 2]), middle[:, 1]])

    one, more = run(elements), run(2 * elements)
    return _named(1.0, rows, more + (more - one) / 15.0, "tip_x", "tip_y", "tip_angle", "middle_y")


def bending_pendulum(rows: int, elements: int = 12, steps: int = 5) -> Columns:
    """A cable pinned at its beginning."""

    def run(elements: int, steps: int) -> Array:
        plane = Plane(-1j * G)
        nodes = plane.cable(_strip_of(PENDULUM), elements, 0.0, -1j, PENDULUM.rate)
        plane.hold(nodes[0], 0)
        plane.hold(nodes[0], 1)
        plane.watch("tip", nodes[-1])
        plane.watch("middle", nodes[elements // 2])
        found = plane.move(PENDULUM.duration, rows, steps)
        return np.column_stack([found["tip"][:, :2], found["middle"][:, :2]])

    return _named(PENDULUM.duration, rows, in_the_limit(run, elements, steps), "tip_x", "tip_y", "middle_x", "middle_y")


def hub(rows: int, elements: int = 16, steps: int = 10) -> Columns:
    """A cable clamped to a hub."""

    def run(elements: int, steps: int) -> Array:
        plane = Plane()
        node, body = plane.body(1.0, HUB.inertia)
        plane.hold(node, 0)
        plane.hold(node, 1)
        nodes = plane.cable(_strip_of(HUB), elements, HUB.radius, 1.0)
        plane.clamp(nodes[0], body, HUB.radius)
        plane.load(node, 2, lambda t: HUB.torque * np.sin(2 * np.pi * t / HUB.period) if t < HUB.period else 0.0)
        plane.watch("hub", node)
        plane.watch("tip", nodes[-1])
        found = plane.move(HUB.duration, rows, steps)
        x, y, angle = *found["tip"][:, :2].T, found["hub"][:, 2]
        return np.column_stack([x, y, np.cos(angle) * y - np.sin(angle) * x, angle])

    return _named(HUB.duration, rows, in_the_limit(run, elements, steps), "tip_x", "tip_y", "tip_deflection", "hub_angle")


def slider_crank(rows: int, elements: int = 12, steps: int = 5) -> Columns:
    """A cable whose beginning moves as the crank's end."""
    period = CRANK.ramp / (2 * np.pi)

    def turn(t: float) -> float:
        begun = CRANK.speed / CRANK.ramp * (t**2 / 2 + period**2 * (np.cos(t / period) - 1))
        return float(begun if t < CRANK.ramp else CRANK.speed * (t - CRANK.ramp / 2))

    def run(elements: int, steps: int) -> Array:
        plane = Plane()
        nodes = plane.cable(_strip_of(CRANK), elements, CRANK.crank, 1.0)
        plane.hold(nodes[0], 0, lambda t: CRANK.crank * (np.cos(turn(t)) - 1))
        plane.hold(nodes[0], 1, lambda t: CRANK.crank * np.sin(turn(t)))
        plane.hold(nodes[-1], 1)
        plane.point_mass(CRANK.block, nodes[-1], CRANK.crank + CRANK.length)
        for name, node in (("begin", nodes[0]), ("middle", nodes[elements // 2]), ("block", nodes[-1])):
            plane.watch(name, node)
        begin, middle, block = (each[:, 0] + 1j * each[:, 1] for each in plane.move(CRANK.duration, rows, steps).values())
        bow = ((middle - (begin + block) / 2) * np.conj(1j * (block - begin))).real / np.abs(block - begin)
        return np.column_stack([block.real, middle.real, middle.imag, bow])

    return _named(CRANK.duration, rows, in_the_limit(run, elements, steps), "block_x", "middle_x", "middle_y", "bow")


def _named(duration: float, rows: int, values: Array, *names: str) -> Columns:
    return {"time": times(duration, rows)} | dict(zip(names, values.T, strict=True))
