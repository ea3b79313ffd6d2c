"""Run 24 as users of Exudyn build it: ANCF cable elements, and Exudyn's own sliding joint.

    python exudyn_machines.py            # the names
    python exudyn_machines.py NAME FILE  # 2 s of that construction as a CSV table

A construction says by which formulation the crank's pin is held on the cable, and with which step.
All else is Exudyn's default.
"""

import math
import time
from dataclasses import dataclass, replace
from typing import Any, Final

import exudyn as exu
import exudyn.itemInterface as eii  # noqa: N813
import numpy as np

from run_24 import REACH, SCENE, TURNING, bent, ring, write_table

#: Axial stiffness of the strip, N: that of its section, and of a modulus that gives its EI.
AXIAL: Final = 12.0 * SCENE["bending_stiffness"] / SCENE["thickness"] ** 2
OUTPUT: Final = 1e-3  # s, of a table


@dataclass(frozen=True)
class Machine:
    """A construction, with the classical formulation of `ObjectJointSliding2D` or the other."""

    step: float  # s
    classical: bool = True
    elements: int = 12
    tolerance: float = 1e-8  # relative, of Newton's iteration; Exudyn's default
    adaptive: bool = True  # smaller steps where Newton's iteration fails; Exudyn's default


FINE: Final = Machine(2.5e-4, tolerance=1e-5)
MACHINES: Final = {
    "sliding joint, 1 ms": Machine(1e-3),
    "sliding joint, 0.5 ms": Machine(5e-4),
    "sliding joint, 0.25 ms": Machine(2.5e-4),
    "sliding joint, 0.25 ms, Newton 1e-5": FINE,
    "sliding joint, not classical, 1 ms": Machine(1e-3, classical=False),
    "sliding joint, not classical, 0.5 ms": Machine(5e-4, classical=False),
    "sliding joint, not classical, 0.25 ms, Newton 1e-5": replace(FINE, classical=False),
}
PROGRAM: Final = f"Exudyn {exu.__version__}"


class System:
    """A construction, assembled.

    Attributes:
        mbs: Exudyn's system.
        nodes: of the cable, from the base to the tip.
        crank: its node; None if the crank is held at 180 deg.
    """

    def __init__(self, machine: Machine, held: bool = False, deflection: float = 0.0) -> None:
        self.machine = machine
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.ground = self.mbs.AddObject(eii.ObjectGround())
        cables = self._cable(0.0 if held else TURNING, deflection)
        self.crank: Any = None
        pin = self._point(self.ground, -SCENE["crank_length"]) if held else self._crank()
        self._guide(pin, cables)
        self.mbs.Assemble()

    def _point(self, body: Any, x: float) -> Any:
        return self.mbs.AddMarker(eii.MarkerBodyRigid(bodyNumber=body, localPosition=[x, 0.0, 0.0]))

    def _hinge(self, *markers: Any) -> None:
        self.mbs.AddObject(eii.ObjectJointRevolute2D(markerNumbers=[*markers]))

    def _turned(self, node: Any) -> Any:
        """Marker of a body's rotation."""
        return self.mbs.AddMarker(eii.MarkerNodeCoordinate(nodeNumber=node, coordinate=2))

    def _damper(self, node: Any, damping: float) -> None:
        fixed = self.mbs.AddNode(eii.NodePointGround())
        still = self.mbs.AddMarker(eii.MarkerNodeCoordinate(nodeNumber=fixed, coordinate=0))
        self.mbs.AddObject(
            eii.ObjectConnectorCoordinateSpringDamper(
                markerNumbers=[still, self._turned(node)], damping=damping
            )
        )

    def _body(
        self,
        place: float,
        mass: float,
        inertia: float,
        turning: float,
        pivot: float,
        bend: Any = (0.0, 0.0, 0.0),
    ) -> tuple[Any, Any]:
        """Node and number of a rigid body on the line from O to P, that turns about `pivot`.

        `bend`: its displacement and turn.
        """
        node = self.mbs.AddNode(
            eii.NodeRigidBody2D(
                referenceCoordinates=[place, 0.0, math.pi],
                initialCoordinates=[*bend],
                initialVelocities=[0.0, turning * (place - pivot), turning],
            )
        )
        body = eii.ObjectRigidBody2D(nodeNumber=node, mass=mass, inertia=inertia)
        return node, self.mbs.AddObject(body)

    def _cable(self, turning: float, deflection: float) -> list[Any]:
        """The follower with base and tip body; numbers of its elements."""
        s, n, mbs = SCENE, self.machine.elements, self.mbs
        h, pivot = s["length"] / n, s["pivot_distance"]
        places = h * np.arange(n + 1)
        bend, slope = (deflection * values for values in bent(places))
        moved = h * np.concatenate([[0.0], np.cumsum(slope[1:] ** 2 + slope[:-1] ** 2) / 4.0])
        self.nodes = [
            mbs.AddNode(
                eii.NodePoint2DSlope1(
                    referenceCoordinates=[pivot - x, 0.0, -1.0, 0.0],
                    initialCoordinates=[dx, -w, 0.5 * dw**2, -dw],
                    initialVelocities=[0.0, -turning * x, 0.0, -turning],
                )
            )
            for x, w, dw, dx in zip(places, bend, slope, moved, strict=True)
        ]
        cables = [
            mbs.AddObject(
                eii.ObjectANCFCable2D(
                    nodeNumbers=[left, right],
                    length=h,
                    massPerLength=s["mass_per_length"],
                    bendingStiffness=s["bending_stiffness"],
                    axialStiffness=AXIAL,
                    bendingDamping=s["material_damping"] * s["bending_stiffness"],
                )
            )
            for left, right in zip(self.nodes[:-1], self.nodes[1:], strict=True)
        ]
        at_base, at_tip = (0.0, 0.0, slope[0]), (moved[-1], -bend[-1], slope[-1])
        base, body = self._body(pivot, 1.0, s["base_inertia"], turning, pivot, at_base)
        self._damper(base, s["base_damping"])
        self._hinge(self._point(self.ground, pivot), self._point(body, 0.0))
        self._clamp(body, self.nodes[0])
        end = pivot - s["length"]
        _, body = self._body(end, s["tip_mass"], s["tip_inertia"], turning, pivot, at_tip)
        self._clamp(body, self.nodes[-1])
        return cables

    def _clamp(self, body: Any, node: Any) -> None:
        end = self.mbs.AddMarker(eii.MarkerNodeRigid(nodeNumber=node))
        self.mbs.AddObject(
            eii.ObjectJointGeneric(
                markerNumbers=[self._point(body, 0.0), end], constrainedAxes=[1, 1, 0, 0, 0, 1]
            )
        )

    def _crank(self) -> Any:
        """The crank with its drive; marker of its pin."""
        s, speed = SCENE, SCENE["crank_speed"]
        center = s["crank_center"]
        node, body = self._body(-center, s["crank_mass"], s["crank_inertia"], speed, 0.0)
        self._hinge(self._point(self.ground, 0.0), self._point(body, -center))
        self._damper(node, s["crank_damping"])
        self.mbs.AddLoad(eii.LoadCoordinate(markerNumber=self._turned(node), load=s["torque"]))
        self.crank = node
        return self._point(body, s["crank_length"] - center)

    def _guide(self, pin: Any, cables: list[Any]) -> None:
        """The sliding joint, which keeps the crank's pin on the cable."""
        n, mbs = len(cables), self.mbs
        h = SCENE["length"] / n
        markers = [mbs.AddMarker(eii.MarkerBodyCable2DCoordinates(bodyNumber=k)) for k in cables]
        first = min(int(REACH / h), n - 1)
        history = eii.NodeGenericData(initialCoordinates=[first, REACH], numberOfDataCoordinates=2)
        mbs.AddObject(
            eii.ObjectJointSliding2D(
                markerNumbers=[pin, markers[first]],
                slidingMarkerNumbers=markers,
                slidingMarkerOffsets=[k * h for k in range(n)],
                nodeNumber=mbs.AddNode(history),
                useClassicalFormulation=self.machine.classical,
            )
        )

    def solve(self, duration: float) -> tuple[dict[str, np.ndarray], float]:
        """Columns of a table, and the processor time of the solve, s."""
        of, mbs = exu.OutputVariableType, self.mbs
        nodes = self.nodes if self.crank is None else [*self.nodes, self.crank]
        sensors = [
            mbs.AddSensor(
                eii.SensorNode(
                    nodeNumber=node, outputVariableType=of.CoordinatesTotal, storeInternal=True
                )
            )
            for node in nodes
        ]
        mbs.Assemble()
        settings = exu.SimulationSettings()
        integration = settings.timeIntegration
        integration.numberOfSteps = round(duration / self.machine.step)
        integration.endTime = duration
        integration.verboseMode = 0
        integration.adaptiveStep = self.machine.adaptive
        integration.newton.relativeTolerance = self.machine.tolerance
        integration.newton.useModifiedNewton = True
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = OUTPUT
        began = time.process_time()
        mbs.SolveDynamic(settings)
        spent = time.process_time() - began
        stored = [np.asarray(mbs.GetSensorStoredData(sensor)) for sensor in sensors]
        line = np.stack(stored[: len(self.nodes)], axis=1)
        place, slope = line[..., 1] + 1j * line[..., 2], line[..., 3] + 1j * line[..., 4]
        deflection = ((place[:, -1] - place[:, 0]) * np.abs(slope[:, 0]) / slope[:, 0]).imag
        columns = {"time": np.round(stored[0][:, 0], 9), "tip_deflection": deflection}
        if self.crank is not None:
            columns["crank_angle"] = stored[-1][:, 3]
        return columns, spent


def simulate(machine: Machine, duration: float = 2.0) -> tuple[dict[str, np.ndarray], float]:
    """Columns of a table, and the processor time of the solve, s."""
    return System(machine).solve(duration)


def pluck(machine: Machine, deflection: float = 1e-3, duration: float = 1.0) -> tuple[float, float]:
    """Frequency (Hz) and damping ratio of the first mode, with the crank held at 180 deg.

    The residuals of so small a motion are round-off below 1e-6 of the first, or a little above.
    """
    machine = replace(machine, tolerance=1e-6, adaptive=False)
    columns, _ = System(machine, held=True, deflection=deflection).solve(duration)
    return ring(columns["tip_deflection"], OUTPUT)


if __name__ == "__main__":
    write_table(MACHINES, simulate)
