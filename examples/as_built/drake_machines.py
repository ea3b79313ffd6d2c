"""Run 24 as users of Drake build it: a chain of links with springs, and point contact.

    python drake_machines.py            # the names
    python drake_machines.py NAME FILE  # 2 s of that construction as a CSV table

Drake is no dependency of this project: `pip install drake` (220 MB).
"""

import math
import time
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, Final

import numpy as np
from pydrake.geometry import AddContactMaterial, Box, ProximityProperties, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    RevoluteJoint,
    RevoluteSpring,
    RotationalInertia,
    SpatialInertia,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from run_24 import (
    COLUMNS,
    RADIUS,
    REACH,
    SCENE,
    aside,
    bent_chain,
    chain_row,
    ring,
    write_table,
)


@dataclass(frozen=True)
class Machine:
    """A construction: the pin runs in a slot between two walls on each link."""

    step: float  # s
    links: int = 13
    stiffness: float | None = None  # of the contact, N/m; None: as Drake estimates it
    friction: float = 0.0
    output: float = 1e-3  # s, of the table


MACHINES: Final = {
    "slot, 1 ms": Machine(1e-3),
    "slot, 0.5 ms": Machine(5e-4),
    "slot, 0.2 ms": Machine(2e-4),
    "slot, 0.1 ms": Machine(1e-4),
    "slot, contact 1e5 N/m, 0.1 ms": Machine(1e-4, stiffness=1e5),
    "slot, friction 0.5, 0.1 ms": Machine(1e-4, friction=0.5),
}
PROGRAM: Final = f"Drake {version('drake')}"


class System:
    """A construction, ready to run; with the crank held at 180 deg if `held`."""

    def __init__(self, machine: Machine, held: bool = False) -> None:
        self.machine = machine
        builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlantSceneGraph(builder, machine.step)
        self.plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
        self.hinges = self._chain()
        self.crank = self._crank(held)
        self.plant.Finalize()
        if self.crank is not None:
            torque = np.zeros(self.plant.num_velocities())
            torque[self.crank.velocity_start()] = SCENE["torque"]
            port = self.plant.get_applied_generalized_force_input_port()
            builder.Connect(builder.AddSystem(ConstantVectorSource(torque)).get_output_port(), port)
        diagram = builder.Build()
        self.simulator = Simulator(diagram)
        self.context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())

    def _touching(self, body: Any, name: str, shape: Any, place: list[float]) -> None:
        friction = CoulombFriction(self.machine.friction, self.machine.friction)
        properties = ProximityProperties()
        AddContactMaterial(
            point_stiffness=self.machine.stiffness, friction=friction, properties=properties
        )
        self.plant.RegisterCollisionGeometry(body, RigidTransform(place), shape, name, properties)

    def _body(self, name: str, mass: float, inertia: float, center: float = 0.0) -> Any:
        turning = RotationalInertia(inertia, inertia, inertia)
        return self.plant.AddRigidBody(
            name, SpatialInertia.MakeFromCentralInertia(mass, [center, 0.0, 0.0], turning)
        )

    def _hinge(self, name: str, parent: Any, place: float, child: Any, damping: float) -> Any:
        at = FixedOffsetFrame(f"{name} at", parent.body_frame(), RigidTransform([place, 0.0, 0.0]))
        axis, frame = [0.0, 0.0, 1.0], self.plant.AddFrame(at)
        joint = RevoluteJoint(name, frame, child.body_frame(), axis, damping)
        return self.plant.AddJoint(joint)

    def _chain(self) -> list[Any]:
        """The follower: links with their walls, hinges with springs, base and tip body."""
        s, n, plant = SCENE, self.machine.links, self.plant
        h, hinges = s["length"] / n, []
        spring, mass = s["bending_stiffness"] / h, s["mass_per_length"] * h
        for k in range(n):
            inertia = mass * h**2 / 12.0 + (0.0 if k else s["base_inertia"])
            link = self._body(f"link{k}", mass, inertia, h / 2.0)
            place, damping = h, s["material_damping"] * spring
            if k == 0:
                parent, place, damping = plant.world_body(), s["pivot_distance"], s["base_damping"]
            hinges.append(self._hinge(f"hinge{k}", parent, place, link, damping))
            if k:
                plant.AddForceElement(RevoluteSpring(hinges[-1], 0.0, spring))
            for side in (1.0, -1.0):
                wall = Box(h, RADIUS, s["width"])
                self._touching(link, f"wall{side}", wall, [h / 2.0, side * 1.5 * RADIUS, 0.0])
            parent = link
        tip, end = self._body("tip", s["tip_mass"], s["tip_inertia"]), RigidTransform([h, 0.0, 0.0])
        plant.WeldFrames(parent.body_frame(), tip.body_frame(), end)
        return hinges

    def _crank(self, held: bool) -> Any:
        """The crank's hinge; None if it is held."""
        s, plant = SCENE, self.plant
        crank = self._body("crank", s["crank_mass"], s["crank_inertia"], s["crank_center"])
        self._touching(crank, "pin", Sphere(RADIUS), [s["crank_length"], 0.0, 0.0])
        if held:
            half_turn = RigidTransform(RotationMatrix.MakeZRotation(math.pi), [0.0, 0.0, 0.0])
            plant.WeldFrames(plant.world_frame(), crank.body_frame(), half_turn)
            return None
        return self._hinge("crank", plant.world_body(), 0.0, crank, s["crank_damping"])

    def angles(self) -> np.ndarray:
        """Of the hinges, rad."""
        return np.array([hinge.get_angle(self.context) for hinge in self.hinges])


def simulate(machine: Machine, duration: float = 2.0) -> tuple[dict[str, np.ndarray], float]:
    """Columns of a table, and the processor time of the solve, s.

    The table is shorter if Drake gave up.
    """
    system, s = System(machine), SCENE
    turning = s["crank_speed"] * s["crank_length"] / REACH
    for hinge, speed in ((system.crank, s["crank_speed"]), (system.hinges[0], turning)):
        hinge.set_angle(system.context, math.pi)
        hinge.set_angular_rate(system.context, speed)
    rows, spent = [], 0.0
    for k in range(round(duration / machine.output) + 1):
        began = time.process_time()
        try:
            system.simulator.AdvanceTo(k * machine.output)
        except RuntimeError:
            break
        spent += time.process_time() - began
        q1 = system.crank.get_angle(system.context)
        rows.append((k * machine.output, *chain_row(q1, system.angles())))
    return dict(zip(COLUMNS, np.array(rows).T, strict=True)), spent


def pluck(machine: Machine, deflection: float = 1e-3, duration: float = 1.0) -> tuple[float, float]:
    """Frequency (Hz) and damping ratio of the first mode, with the crank held at 180 deg."""
    system, signal = System(machine, held=True), []
    for hinge, angle in zip(system.hinges, bent_chain(machine.links, deflection), strict=True):
        hinge.set_angle(system.context, angle)
    for k in range(round(duration / machine.output)):
        system.simulator.AdvanceTo((k + 1) * machine.output)
        signal.append(aside(system.angles()))
    return ring(np.array(signal), machine.output)


if __name__ == "__main__":
    write_table(MACHINES, simulate)
