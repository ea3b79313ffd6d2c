"""Run 24 as users of PyElastica build it: a Cosserat rod, and a pin on a stiff spring of their own.

    python pyelastica_machines.py            # the names
    python pyelastica_machines.py NAME FILE  # 2 s of that construction as a CSV table

PyElastica has no sliding joint. The strip becomes a round rod of the same stiffness and mass.
PyElastica is no dependency of this project: `pip install pyelastica`.
"""

import math
import time
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, Final

import elastica as ea
import numpy as np

from run_24 import COLUMNS, REACH, SCENE, aside, bent_chain, chain_row, ring, write_table

#: Radius of the rod, m; its modulus and density follow from the strip's stiffness and mass.
ROD: Final = 0.01


@dataclass(frozen=True)
class Machine:
    """A construction."""

    elements: int
    step: float  # s
    contact: float = 1e6  # of the pin's spring, N/m
    damped: bool = True  # by the material; PyElastica has no such damper, the script adds one
    output: float = 1e-3  # s, of the table


#: The damper of the material, which is explicit, limits the step.
MACHINES: Final = {
    "rod, 10 elements": Machine(10, 1e-5),
    "rod, 20 elements": Machine(20, 5e-6),
    "rod, 40 elements": Machine(40, 1.5625e-6),
    "rod, 20 elements, contact 1e5 N/m": Machine(20, 5e-6, contact=1e5),
    "rod, 20 elements, undamped": Machine(20, 1e-5, damped=False),
}
PROGRAM: Final = f"PyElastica {version('pyelastica')}"


class Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Forcing):
    """What a construction needs of PyElastica."""


class Pivot(ea.ConstraintBase):
    """Holds the rod's first node in P, free to turn."""

    def __init__(self, fixed_position: np.ndarray, **_: Any) -> None:
        super().__init__(**_)
        self.place = fixed_position

    def constrain_values(self, system: Any, time: float) -> None:
        """Place."""
        system.position_collection[:, 0] = self.place

    def constrain_rates(self, system: Any, time: float) -> None:
        """Velocity."""
        system.velocity_collection[:, 0] = 0.0


@dataclass
class Crank:
    """Its motion, and the distance of its pin to the rod."""

    speed: float  # rad/s
    angle: float = math.pi  # rad
    gap: float = 0.0  # m


class Pin(ea.NoForces):
    """The crank with its pin, and the damping of the rod's material."""

    def __init__(self, machine: Machine, crank: Crank, held: bool) -> None:
        super().__init__()
        self.machine, self.crank, self.held = machine, crank, held

    def apply_forces(self, system: Any, time: float = 0.0) -> None:
        """A step of the crank, by leapfrog as PyElastica's; the pin's spring is at its middle."""
        s, crank, half = SCENE, self.crank, 0.5 * self.machine.step
        crank.angle += half * crank.speed
        arm = s["crank_length"] * np.exp(1j * crank.angle)
        nodes = system.position_collection[0] + 1j * system.position_collection[1]
        sides = np.diff(nodes)
        lengths = np.abs(sides)
        local = (arm - nodes[:-1]) * np.conj(sides) / lengths
        element = int(np.argmin(np.abs(local.real - 0.5 * lengths)))
        crank.gap = local[element].imag
        force = 1j * self.machine.contact * crank.gap * sides[element] / lengths[element]
        share = local[element].real / lengths[element]
        for node, part in ((element, 1.0 - share), (element + 1, share)):
            system.external_forces[0, node] += part * force.real
            system.external_forces[1, node] += part * force.imag
        if not self.held:
            inertia = s["crank_inertia"] + s["crank_mass"] * s["crank_center"] ** 2
            torque = s["torque"] - s["crank_damping"] * crank.speed - (np.conj(arm) * force).imag
            crank.speed += self.machine.step * torque / inertia
            crank.angle += half * crank.speed

    def apply_torques(self, system: Any, time: float = 0.0) -> None:
        """The material's damping, between neighbours; local axis 1 is the plane's normal."""
        if self.machine.damped:
            turning = np.diff(system.omega_collection[0]) / system.rest_voronoi_lengths
            moment = SCENE["material_damping"] * SCENE["bending_stiffness"] * turning
            system.external_torques[0, :-1] += moment
            system.external_torques[0, 1:] -= moment


class System:
    """A construction, ready to run; with the crank held at 180 deg and the tip aside if `held`."""

    def __init__(self, machine: Machine, held: bool = False, deflection: float = 0.0) -> None:
        s, self.machine = SCENE, machine
        n, area = machine.elements, math.pi * ROD**2
        modulus = s["bending_stiffness"] / (0.25 * math.pi * ROD**4)
        pivot = np.array([s["pivot_distance"], 0.0, 0.0])
        along, normal = np.array([-1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
        self.rod = ea.CosseratRod.straight_rod(
            n,
            pivot,
            along,
            normal,
            s["length"],
            ROD,
            s["mass_per_length"] / area,
            youngs_modulus=modulus,
            shear_modulus=modulus / 2.6,
        )
        self._with_bodies()
        if held:
            self._bend(bent_chain(n, deflection))
        else:
            turning = s["crank_speed"] * s["crank_length"] / REACH
            self.rod.omega_collection[0] = turning
            self.rod.velocity_collection[1] = turning * (self.rod.position_collection[0] - pivot[0])
        self.simulator = Simulator()
        self.simulator.append(self.rod)
        self.simulator.constrain(self.rod).using(Pivot, constrained_position_idx=(0,))
        self.crank = Crank(0.0 if held else s["crank_speed"])
        self.simulator.add_forcing_to(self.rod).using(Pin, machine, self.crank, held)
        self.simulator.finalize()
        self.stepper, self.time = ea.PositionVerlet(), 0.0

    def _with_bodies(self) -> None:
        """Add the base's inertia to the first element, the tip body to the last and its node."""
        s, rod = SCENE, self.rod
        rod.mass[-1] += s["tip_mass"]
        for element, inertia in ((0, s["base_inertia"]), (-1, s["tip_inertia"])):
            for axis in range(3):
                rod.mass_second_moment_of_inertia[axis, axis, element] += inertia
                rod.inv_mass_second_moment_of_inertia[axis, axis, element] = (
                    1.0 / rod.mass_second_moment_of_inertia[axis, axis, element]
                )

    def _bend(self, angles: np.ndarray) -> None:
        """Put the rod at rest along a chain."""
        directions = np.exp(1j * np.cumsum(angles))
        places = SCENE["length"] / len(angles) * np.cumsum(directions)
        self.rod.position_collection[0, 1:] = SCENE["pivot_distance"] + places.real
        self.rod.position_collection[1, 1:] = places.imag
        tangents = np.array([directions.real, directions.imag, 0.0 * directions.real])
        normal = np.array([0.0, 0.0, 1.0])
        self.rod.director_collection[2] = tangents
        self.rod.director_collection[1] = np.cross(tangents.T, normal).T

    def advance(self, end: float) -> None:
        """Step until a time."""
        for _ in range(round((end - self.time) / self.machine.step)):
            self.time = self.stepper.step(self.simulator, self.time, self.machine.step)

    def angles(self) -> np.ndarray:
        """Between the elements, rad; the first one is that of the first element."""
        places = self.rod.position_collection
        along = np.unwrap(np.angle(np.diff(places[0] + 1j * places[1])))
        return np.diff(along, prepend=0.0)


def simulate(machine: Machine, duration: float = 2.0) -> tuple[dict[str, np.ndarray], float]:
    """Columns of a table, and the processor time of the solve, s."""
    System(machine).advance(machine.step)  # compiles
    system, rows, spent = System(machine), [], 0.0
    for k in range(round(duration / machine.output) + 1):
        began = time.process_time()
        system.advance(k * machine.output)
        spent += time.process_time() - began
        q1, deflection, _ = chain_row(system.crank.angle, system.angles())
        rows.append((k * machine.output, q1, deflection, abs(system.crank.gap)))
    return dict(zip(COLUMNS, np.array(rows).T, strict=True)), spent


def pluck(machine: Machine, deflection: float = 1e-3, duration: float = 1.0) -> tuple[float, float]:
    """Frequency (Hz) and damping ratio of the first mode, with the crank held at 180 deg."""
    system, signal = System(machine, held=True, deflection=deflection), []
    for k in range(round(duration / machine.output)):
        system.advance((k + 1) * machine.output)
        signal.append(aside(system.angles()))
    return ring(np.array(signal), machine.output)


if __name__ == "__main__":
    write_table(MACHINES, simulate)
