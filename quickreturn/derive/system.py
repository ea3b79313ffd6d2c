"""The description of a planar mechanism: coordinates, bodies, beams, loads, loops, outputs (thesis, section 4.4)."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import casadi as ca

from quickreturn.derive.tables import Table
from quickreturn.derive.units import DescriptionError, in_si


def vector(x: Any, y: Any) -> ca.SX:
    """A vector by its components along n1 and n2."""
    return ca.vertcat(ca.SX(x), ca.SX(y))


def turned(angle: Any, x: Any, y: Any = 0.0) -> ca.SX:
    """The vector (x, y) of a frame that stands at an angle (rad), by its components along n1 and n2."""
    c, s = ca.cos(angle), ca.sin(angle)
    return vector(c * x - s * y, s * x + c * y)


@dataclass(frozen=True)
class Coordinate:
    """A coordinate q, its speed and acceleration as symbols, and what a simulation needs to know of it."""

    name: str
    rate_name: str
    unit: str
    size: float  # what its error is relative to, in its unit
    guess: float  # where the search for the start begins
    q: ca.SX
    v: ca.SX
    a: ca.SX


@dataclass(frozen=True)
class Points:
    """Mass points at (x, y) of a frame, columns of the same height; or turning inertias, where `x` is the angle and `y` nothing."""

    name: str
    mass: ca.SX
    x: ca.SX
    y: ca.SX | None = None
    origin: ca.SX = field(default_factory=lambda: ca.SX.zeros(2))
    angle: ca.SX = field(default_factory=lambda: ca.SX(0))


@dataclass(frozen=True)
class Loop:
    """Expressions that stay zero, the coordinates that they give, and the forces that this takes."""

    name: str
    gap: ca.SX
    unit: str
    gives: list[int]
    force: ca.SX


class System:
    """A planar mechanism as its parts; `derive` makes the equations of motion.

    Places are vectors along the fixed n1 and n2 (`vector`, `turned`), angles count from n1, counter-clockwise. Values are given in any
    unit and kept in SI.
    """

    def __init__(self, name: str) -> None:
        self.name, self.time = name, ca.SX.sym("time")
        self.coordinates: list[Coordinate] = []
        self.parameters: dict[str, tuple[ca.SX, float, str]] = {}
        self.points: list[Points] = []
        self.loads: list[tuple[str, ca.SX, ca.SX]] = []
        self.dampers: list[tuple[str, ca.SX, ca.SX]] = []
        self.energies: list[tuple[str, ca.SX]] = []
        self.loops: list[Loop] = []
        self.outputs: dict[str, tuple[ca.SX, str]] = {}
        self.tables: list[Table] = []
        self.frozen: dict[int, ca.SX] = {}
        self.stated: list[tuple[str, ca.SX, str]] = []  # expressions and the units that they must have, checked in `derive`
        self.gravity = vector(0.0, 0.0)

    def constants(self, **values: tuple[float, str]) -> SimpleNamespace:
        """Parameters by name, each as (value, unit); any of them may be changed for a simulation.

        Returns:
            Their symbols, as attributes.
        """
        for name, (value, unit) in values.items():
            self._new(name)
            self.parameters[name] = (ca.SX.sym(name), value * in_si(unit)[0], unit)
        return SimpleNamespace(**{name: self.parameters[name][0] for name in values})

    def coordinate(self, name: str, unit: str, rate: str = "", size: float = 1.0, guess: float = 0.0) -> ca.SX:
        """A coordinate; its rate is called NAME_rate, or as given. `size` and `guess` are in its unit."""
        rate = rate or f"{name}_rate"
        self._new(name, rate)
        symbols = (ca.SX.sym(name), ca.SX.sym(rate), ca.SX.sym(f"{rate}_rate"))
        self.coordinates.append(Coordinate(name, rate, unit, size * in_si(unit)[0], guess * in_si(unit)[0], *symbols))
        return symbols[0]

    def amplitudes(self, name: str, count: int, unit: str, size: float = 1.0) -> ca.SX:
        """Coordinates NAME_1 to NAME_count as a column."""
        return ca.vertcat(*(self.coordinate(f"{name}_{k}", unit, size=size) for k in range(1, count + 1)))

    def rate(self, expression: ca.SX) -> ca.SX:
        """Time derivative of an expression in coordinates; of a rate, the acceleration."""
        q, v, a = (ca.vertcat(*(getattr(each, kind) for each in self.coordinates)) for kind in "qva")
        return ca.jtimes(expression, ca.vertcat(q, v, self.time), ca.vertcat(v, a, 1))

    def freeze(self, coordinate: ca.SX) -> ca.SX:
        """The present value of a coordinate, put in after differentiation: points move with a slider, the material does not."""
        k = self._index(coordinate)
        return self.frozen.setdefault(k, ca.SX.sym(f"{self.coordinates[k].name} now"))

    def table(self, coordinate: ca.SX, low: float, step: float, coefficients: Any) -> Table:
        """Functions of a coordinate that are looked up outside the equations, see `Table`."""
        k = self._index(coordinate)
        table = Table(k, self.coordinates[k].unit, coordinate - self.freeze(coordinate), low, step, coefficients)
        self.tables.append(table)
        return table

    def body(self, name: str, mass: Any = 0.0, place: Any = None, inertia: Any = 0.0, angle: Any = None) -> None:
        """A rigid body: mass (kg) at the place of its centre, inertia (kg m^2) about that centre, which turns by an angle."""
        if place is None and angle is None:
            raise DescriptionError(f"body {name!r} has neither place nor angle; give place=... with mass=..., angle=... with inertia=...")
        if place is not None:
            self.points.append(Points(name, ca.SX(mass), ca.SX(0), ca.SX(0), origin=place))
            self.states(f"mass of body {name!r}", mass, "kg")
            self.states(f"place of body {name!r}", place, "m")
        if angle is not None:
            self.points.append(Points(name, ca.SX(inertia), ca.SX(angle)))
            self.states(f"inertia of body {name!r}", inertia, "kg*m^2")
            self.states(f"angle of body {name!r}", angle, "rad")

    def load(self, name: str, on: Any, value: Any) -> None:
        """A force (N) on a place or a torque (N m) on an angle; it may depend on coordinates, rates and time."""
        self.loads.append((name, ca.SX(on), ca.SX(value)))
        self.states(f"load {name!r} times what it acts on", ca.SX(value) * on, "J")

    def damper(self, name: str, on: Any, coefficient: Any) -> None:
        """A force -coefficient times the rate of a place, a length or an angle."""
        self.dampers.append((name, ca.SX(on), ca.SX(coefficient)))
        self.states(f"coefficient of damper {name!r} times the square of what it acts on", coefficient * ca.SX(on) ** 2, "J*s")

    def spring(self, name: str, extension: Any, stiffness: Any) -> None:
        """A spring of given extension, or turn, and stiffness."""
        self.energy(name, 0.5 * ca.sum1(ca.SX(stiffness) * ca.SX(extension) ** 2))

    def energy(self, name: str, value: Any) -> None:
        """A potential energy (J) of any kind."""
        self.energies.append((name, ca.SX(value)))
        self.states(f"energy of {name!r}", value, "J")

    def loop(self, name: str, gap: Any, unit: str = "m", gives: Iterable[ca.SX] = ()) -> ca.SX:
        """A closed loop, or a prescribed motion: `gap` stays zero. It determines the coordinates `gives`, as many as it has rows.

        Returns:
            The forces that keep it closed, which act along `gap`: on its first place, and reversed on the place subtracted.
        """
        gap, given = ca.SX(gap), [self._index(each) for each in gives]
        names = [f"{name}_force"] if gap.numel() == 1 else [f"{name}_force_{k}" for k in range(1, gap.numel() + 1)]
        self._new(*names)
        loop = Loop(name, gap, unit, given, ca.vertcat(*(ca.SX.sym(each) for each in names)))
        self.loops.append(loop)
        self.states(f"gap of loop {name!r}", gap, unit)
        return loop.force

    def output(self, name: str, expression: Any, unit: str) -> None:
        """A named result: of coordinates, their rates, accelerations (`rate` of a rate), forces of loops and time."""
        self._new(name)
        in_si(unit)
        self.outputs[name] = (ca.SX(expression), unit)

    def states(self, what: str, expression: Any, unit: str) -> None:
        """Remember that an expression must have a unit."""
        in_si(unit)
        self.stated.append((what, ca.SX(expression), unit))

    def _index(self, coordinate: ca.SX) -> int:
        for k, each in enumerate(self.coordinates):
            if ca.is_equal(each.q, coordinate):
                return k
        raise DescriptionError(f"{coordinate} is no coordinate of system {self.name!r}; declare it with coordinate(...)")

    def _new(self, *names: str) -> None:
        taken = [*self.parameters, *self.outputs, *(n for each in self.coordinates for n in (each.name, each.rate_name))]
        taken += [name.name() for loop in self.loops for name in ca.vertsplit(loop.force)]
        for name in names:
            if name in taken:
                raise DescriptionError(f"the name {name!r} is used twice in system {self.name!r}")

