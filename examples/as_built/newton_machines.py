"""Run 24 as users of Newton build it: a chain of links with springs, and a pin in contact.

    python newton_machines.py            # the names
    python newton_machines.py NAME FILE  # 2 s of that construction as a CSV table

Newton computes in single precision, here on the processor. It is no dependency of this project:
`pip install newton`.
"""

import math
import time
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, Final

import newton
import numpy as np
import warp as wp

from run_24 import COLUMNS, RADIUS, REACH, SCENE, aside, bent_chain, chain_row, ring, write_table

wp.config.quiet = True
AXIS: Final = wp.vec3(0.0, 0.0, 1.0)
#: Inertia of a crank that stands still, kg m^2. With a pin fixed to the world the arm rings 1.9 %
#: faster, whatever links, contact and step are.
HELD: Final = 1e4


@dataclass(frozen=True)
class Machine:
    """A construction: the pin runs in a slot between two walls on each link."""

    step: float  # s
    solver: str = "Featherstone"  # or "XPBD"
    links: int = 13
    contact: float = 1e6  # N/m
    angular_damping: float = 0.0  # 1/s; Newton's default is 0.05 with Featherstone
    output: float = 1e-3  # s, of the table


MACHINES: Final = {
    "Featherstone, 0.05 ms": Machine(5e-5),
    "Featherstone, 0.05 ms, angular damping 0.05": Machine(5e-5, angular_damping=0.05),
    "XPBD, 0.1 ms": Machine(1e-4, "XPBD"),
}
PROGRAM: Final = f"Newton {version('newton')}"


class System:
    """A construction, ready to run; with the crank held at 180 deg if `held`."""

    def __init__(self, machine: Machine, angles: np.ndarray, held: bool = False) -> None:
        s, self.machine = SCENE, machine
        self.builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
        self._chain()
        inertia = HELD if held else s["crank_inertia"]
        crank = self._link(s["crank_mass"], inertia, s["crank_center"])
        self.builder.add_articulation([self._hinge(-1, 0.0, crank, s["crank_damping"])])
        pin = wp.transform(wp.vec3(s["crank_length"], 0.0, 0.0), wp.quat_identity())
        self.builder.add_shape_sphere(crank, xform=pin, radius=RADIUS, cfg=self._touching())
        self.model = self.builder.finalize(device="cpu")
        solver = getattr(newton.solvers, f"Solver{machine.solver}")
        self.solver = solver(self.model, angular_damping=machine.angular_damping)
        self.pipeline = newton.CollisionPipeline(self.model)
        self.contacts = self.pipeline.contacts()
        self.now, self.next = self.model.state(), self.model.state()
        self.control = self.model.control()
        q, rates = np.append(angles, math.pi), np.zeros(len(angles) + 1)
        if not held:
            rates[0] = s["crank_speed"] * s["crank_length"] / REACH
            rates[-1] = s["crank_speed"]
            torque = np.append(np.zeros(len(angles)), s["torque"])
            self.control.joint_f.assign(torque.astype(np.float32))
        self.now.joint_q.assign(q.astype(np.float32))
        self.now.joint_qd.assign(rates.astype(np.float32))
        newton.eval_fk(self.model, self.now.joint_q, self.now.joint_qd, self.now)

    def _touching(self) -> Any:
        shape = newton.ModelBuilder.ShapeConfig
        return shape(density=0.0, ke=self.machine.contact, kd=0.0, kf=0.0, mu=0.0)

    def _link(self, mass: float, inertia: float, center: float = 0.0) -> int:
        turning = wp.mat33(np.diag([inertia] * 3).astype(np.float32))
        com = wp.vec3(center, 0.0, 0.0)
        return self.builder.add_link(mass=mass, inertia=turning, com=com, lock_inertia=True)

    def _hinge(
        self, parent: int, place: float, child: int, damping: float, spring: float = 0.0
    ) -> int:
        at = wp.transform(wp.vec3(place, 0.0, 0.0), wp.quat_identity())
        return self.builder.add_joint_revolute(
            parent,
            child,
            axis=AXIS,
            parent_xform=at,
            damping=damping,
            stiffness=spring,
            armature=0.0,
            rest_q=0.0,
        )

    def _chain(self) -> None:
        """The follower: links with their walls, hinges with springs; base and tip body."""
        s, n = SCENE, self.machine.links
        h, hinges, parent = s["length"] / n, [], -1
        spring, mass = s["bending_stiffness"] / h, s["mass_per_length"] * h
        for k in range(n):
            last = k == n - 1
            total = mass + (s["tip_mass"] if last else 0.0)
            center = (0.5 * mass * h + (s["tip_mass"] * h if last else 0.0)) / total
            inertia = mass * h**2 / 12.0 + mass * (0.5 * h - center) ** 2
            if last:
                inertia += s["tip_inertia"] + s["tip_mass"] * (h - center) ** 2
            link = self._link(total, inertia + (0.0 if k else s["base_inertia"]), center)
            if k:
                hinge = self._hinge(parent, h, link, s["material_damping"] * spring, spring)
            else:
                hinge = self._hinge(parent, s["pivot_distance"], link, s["base_damping"])
            hinges.append(hinge)
            for side in (1.0, -1.0):
                at = wp.transform(wp.vec3(h / 2.0, side * 1.5 * RADIUS, 0.0), wp.quat_identity())
                self.builder.add_shape_box(
                    link,
                    xform=at,
                    hx=h / 2.0,
                    hy=RADIUS / 2.0,
                    hz=s["width"] / 2.0,
                    cfg=self._touching(),
                )
            parent = link
        self.builder.add_articulation(hinges)

    def advance(self, steps: int) -> None:
        """Some steps."""
        for _ in range(steps):
            self.now.clear_forces()
            self.pipeline.collide(self.now, self.contacts)
            self.solver.step(self.now, self.next, self.control, self.contacts, self.machine.step)
            self.now, self.next = self.next, self.now

    def angles(self) -> np.ndarray:
        """Of the hinges, then of the crank, rad."""
        if self.machine.solver == "XPBD":
            newton.eval_ik(self.model, self.now, self.now.joint_q, self.now.joint_qd)
        return np.array(self.now.joint_q.numpy(), dtype=float)


def simulate(machine: Machine, duration: float = 2.0) -> tuple[dict[str, np.ndarray], float]:
    """Columns of a table, and the processor time of the solve, s.

    The table is shorter if Newton lost the motion.
    """
    start = np.zeros(machine.links)
    start[0] = math.pi
    System(machine, start).advance(2)  # compiles
    system, rows, spent = System(machine, start), [], 0.0
    for k in range(round(duration / machine.output) + 1):
        if k:
            began = time.process_time()
            system.advance(round(machine.output / machine.step))
            spent += time.process_time() - began
        q = system.angles()
        if not np.isfinite(q).all() or np.abs(q[1:-1]).max() > 0.5 * math.pi:
            break
        rows.append((k * machine.output, *chain_row(q[-1], q[:-1])))
    return dict(zip(COLUMNS, np.array(rows).T, strict=True)), spent


def pluck(machine: Machine, deflection: float = 1e-3, duration: float = 1.0) -> tuple[float, float]:
    """Frequency (Hz) and damping ratio of the first mode, with the crank held at 180 deg."""
    system, signal = System(machine, bent_chain(machine.links, deflection), held=True), []
    for _ in range(round(duration / machine.output)):
        system.advance(round(machine.output / machine.step))
        signal.append(aside(system.angles()[:-1]))
    return ring(np.array(signal), machine.output)


if __name__ == "__main__":
    write_table(MACHINES, simulate)
