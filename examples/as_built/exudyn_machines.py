"""Run 24 as users of Exudyn build it: ANCF cable elements, and Exudyn's own sliding joint.

    python exudyn_machines.py            # the names
    python exudyn_machines.py NAME FILE  # 2 s of that construction as a CSV table

A construction says by which formulation the crank's pin is held on the cable, and with which step.
All else is Exudyn's default.
"""

import math
import time
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Final

import exudyn as exu
import exudyn.itemInterface as eii  # noqa: N813
import numpy as np

from run_24 import REACH, SCENE, TURNING, write_table

#: Axial stiffness of the strip, N: that of its section, and of a modulus that gives its EI.
AXIAL: Final = 12.0 * SCENE["bending_stiffness"] / SCENE["thickness"] ** 2


@dataclass(frozen=True)
class Machine:
    """A construction, with the classical formulation of `ObjectJointSliding2D` or the other."""

    step: float  # s
    classical: bool = True
    elements: int = 12
    tolerance: float = 1e-8  # relative, of Newton's iteration; Exudyn's default


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
    """A construction, assembled in the standard start: crank at 180 deg, follower straight.

    Attributes:
        mbs: Exudyn's system.
        nodes: of the cable's beginning, of its end, of the crank.
    """

    def __init__(self, machine: Machine) -> None:
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.ground = self.mbs.AddObject(eii.ObjectGround())
        cables, ends = self._cable(machine.elements)
        pin, crank = self._crank()
        self.nodes = [*ends, crank]
        self._guide(pin, cables, machine.classical)
        self.mbs.Assemble()

    def _point(self, body: Any, x: float) -> Any:
        return self.mbs.AddMarker(eii.MarkerBodyRigid(bodyNumber=body, localPosition=[x, 0.0, 0.0]))

    def _hinge(self, place: float, body: Any, x: float) -> None:
        markers = [self._point(self.ground, place), self._point(body, x)]
        self.mbs.AddObject(eii.ObjectJointRevolute2D(markerNumbers=markers))

    def _body(
        self, place: float, mass: float, inertia: float, turning: float, pivot: float
    ) -> tuple[Any, Any, Any]:
        """Body on the line OP that turns about `pivot`; marker of its rotation; its node."""
        node = self.mbs.AddNode(
            eii.NodeRigidBody2D(
                referenceCoordinates=[place, 0.0, math.pi],
                initialVelocities=[0.0, turning * (place - pivot), turning],
            )
        )
        body = self.mbs.AddObject(
            eii.ObjectRigidBody2D(nodeNumber=node, mass=mass, inertia=inertia)
        )
        turned = self.mbs.AddMarker(eii.MarkerNodeCoordinate(nodeNumber=node, coordinate=2))
        return body, turned, node

    def _damper(self, turned: Any, damping: float) -> None:
        fixed = self.mbs.AddNode(eii.NodePointGround())
        still = self.mbs.AddMarker(eii.MarkerNodeCoordinate(nodeNumber=fixed, coordinate=0))
        self.mbs.AddObject(
            eii.ObjectConnectorCoordinateSpringDamper(
                markerNumbers=[still, turned], damping=damping
            )
        )

    def _cable(self, n: int) -> tuple[list[Any], tuple[Any, Any]]:
        """The follower with base and tip body; its elements, and the nodes of its ends."""
        s, mbs = SCENE, self.mbs
        h, pivot = s["length"] / n, s["pivot_distance"]
        nodes = [
            mbs.AddNode(
                eii.NodePoint2DSlope1(
                    referenceCoordinates=[pivot - x, 0.0, -1.0, 0.0],
                    initialVelocities=[0.0, -TURNING * x, 0.0, -TURNING],
                )
            )
            for x in h * np.arange(n + 1)
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
            for left, right in pairwise(nodes)
        ]
        base, turned, _ = self._body(pivot, 1.0, s["base_inertia"], TURNING, pivot)
        self._damper(turned, s["base_damping"])
        self._hinge(pivot, base, 0.0)
        end = pivot - s["length"]
        tip, *_ = self._body(end, s["tip_mass"], s["tip_inertia"], TURNING, pivot)
        for body, node in ((base, nodes[0]), (tip, nodes[-1])):
            markers = [self._point(body, 0.0), mbs.AddMarker(eii.MarkerNodeRigid(nodeNumber=node))]
            clamp = [1, 1, 0, 0, 0, 1]
            mbs.AddObject(eii.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=clamp))
        return cables, (nodes[0], nodes[-1])

    def _crank(self) -> tuple[Any, Any]:
        """The crank with its drive; marker of its pin, and its node."""
        s, center = SCENE, SCENE["crank_center"]
        body, turned, node = self._body(
            -center, s["crank_mass"], s["crank_inertia"], s["crank_speed"], 0.0
        )
        self._hinge(0.0, body, -center)
        self._damper(turned, s["crank_damping"])
        self.mbs.AddLoad(eii.LoadCoordinate(markerNumber=turned, load=s["torque"]))
        return self._point(body, s["crank_length"] - center), node

    def _guide(self, pin: Any, cables: list[Any], classical: bool) -> None:
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
                useClassicalFormulation=classical,
            )
        )


def simulate(machine: Machine, duration: float = 2.0) -> tuple[dict[str, np.ndarray], float]:
    """Columns of a table, and the processor time of the solve, s."""
    system = System(machine)
    mbs, kind = system.mbs, exu.OutputVariableType.CoordinatesTotal
    sensors = [
        mbs.AddSensor(eii.SensorNode(nodeNumber=node, outputVariableType=kind, storeInternal=True))
        for node in system.nodes
    ]
    mbs.Assemble()
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps = round(duration / machine.step)
    integration.endTime = duration
    integration.verboseMode = 0
    integration.newton.relativeTolerance = machine.tolerance
    integration.newton.useModifiedNewton = True
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 1e-3
    began = time.process_time()
    mbs.SolveDynamic(settings)
    spent = time.process_time() - began
    base, tip, crank = (np.asarray(mbs.GetSensorStoredData(sensor)) for sensor in sensors)
    tangent = base[:, 3] + 1j * base[:, 4]
    chord = tip[:, 1] - base[:, 1] + 1j * (tip[:, 2] - base[:, 2])
    return {
        "time": np.round(base[:, 0], 9),
        "crank_angle": crank[:, 3],
        "tip_deflection": (chord * np.abs(tangent) / tangent).imag,
    }, spent


if __name__ == "__main__":
    write_table(MACHINES, simulate)
