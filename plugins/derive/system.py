"""The description of a planar mechanism: coordinates, bodies, loads, loops, outputs (thesis, section 4.4)."""

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any, Final, NamedTuple

import casadi as ca

from quickreturn.plugins.derive.tables import Table, curve_through
from quickreturn.plugins.derive.units import DescriptionError, in_si, is_number, told

#: Outputs of every model, besides coordinates, rates and forces of loops.
COMMON_COLUMNS: Final = ("time", "kinetic_energy", "potential_energy", "dissipated_energy", "work", "energy_balance")


def column(*parts: Any) -> ca.SX:
    """All parts stacked as one column; without parts a column without rows."""
    return ca.vertcat(ca.SX(0, 1), *parts)


@told("vector")
def vector(x: Any, y: Any) -> ca.SX:
    """A vector by its components along n1 and n2."""
    return ca.vertcat(ca.SX(x), ca.SX(y))


@told("turned")
def turned(angle: Any, x: Any, y: Any = 0.0) -> ca.SX:
    """The vector (x, y) of a frame that stands at an angle (rad), by its components along n1 and n2."""
    c, s = ca.cos(angle), ca.sin(angle)
    return vector(c * x - s * y, s * x + c * y)


class Coordinate(NamedTuple):
    """A coordinate q, its speed and acceleration as symbols, and its data for a simulation, in SI."""

    name: str
    rate_name: str
    unit: str
    size: float  # scale of its error
    guess: float  # where the search for the start begins
    q: ca.SX
    v: ca.SX
    a: ca.SX


class Points(NamedTuple):
    """Mass points at (x, y), columns, of a frame."""

    mass: ca.SX
    x: ca.SX
    y: ca.SX
    origin: ca.SX
    angle: ca.SX


class Loop(NamedTuple):
    """Expressions that stay zero, the indices of the coordinates that they give, and the forces that keep them zero."""

    name: str
    gap: ca.SX
    unit: str
    gives: list[int]
    force: ca.SX
    by: ca.SX  # places or angles on which the forces act: the gap, or another part's
    by_unit: str

    @property
    def elsewhere(self) -> bool:
        """Whether the forces act on something else than the gap."""
        return self.by is not self.gap


class System:
    """A planar mechanism as its parts; `Model` derives the equations of motion.

    Places are vectors along the fixed n1 and n2 (`vector`, `turned`), angles count from n1, counter-clockwise. Values may be given in any
    unit and are stored in SI. `gravity` may be set, in m/s^2.
    """

    def __init__(self, name: str) -> None:
        self.name, self.time, self.gravity = name, ca.SX.sym("time"), vector(0.0, 0.0)
        self.parameters: dict[str, tuple[ca.SX, float, str]] = {}
        self.coordinates: list[Coordinate] = []
        self.points: list[Points] = []
        self.turning: list[tuple[ca.SX, ca.SX]] = []  # inertia and angle
        self.loads: list[tuple[ca.SX, ca.SX]] = []  # the place or angle that it acts on, and its value
        self.dampers: list[tuple[ca.SX, ca.SX]] = []
        self.energies: list[ca.SX] = []
        self.loops: list[Loop] = []
        self.outputs: dict[str, tuple[ca.SX, str]] = {}
        self.tables: list[Table] = []
        self.curves: list[str] = []  # names of functions by points
        self.frozen: dict[int, ca.SX] = {}
        self.integrals: list[tuple[str, ca.SX, ca.SX]] = []  # of a beam: its name, the integrals by its points, and by twice as many
        self.slopes: list[tuple[str, ca.SX]] = []  # of a beam by its deflection: its name, the slopes at its points
        self.stated: list[tuple[str, ca.SX, str]] = []  # meaning of an expression, the expression, and its unit

    def constants(self, **values: tuple[float, str]) -> SimpleNamespace:
        """Declare parameters by name, each as (value, unit); simulations may change them. Returns their symbols as attributes."""
        for name, pair in values.items():
            if not (isinstance(pair, tuple) and len(pair) == 2 and is_number(pair[0]) and isinstance(pair[1], str)):
                raise DescriptionError(
                    f"constant {name!r} of {self.name!r} is {pair!r}; give a finite number and its unit, such as {name}=(0.5, 'm')"
                )
            value, unit = pair
            self._new(name)
            self.parameters[name] = (ca.SX.sym(name), value * in_si(unit)[0], unit)
        return SimpleNamespace(**{name: self.parameters[name][0] for name in values})

    @told("coordinate")
    def coordinate(self, name: str, unit: str, rate: str = "", size: float = 1.0, guess: float = 0.0) -> ca.SX:
        """A coordinate; the name of its rate is NAME_rate unless `rate` is given. `size` and `guess` are in its unit."""
        rate, factor = rate or f"{name}_rate", in_si(unit)[0]
        if not (is_number(size) and size > 0.0 and is_number(guess)):
            raise DescriptionError(
                f"coordinate {name!r} of {self.name!r} needs a size above zero and a finite guess, not {size} and {guess}"
            )
        self._new(name, rate)
        symbols = (ca.SX.sym(name), ca.SX.sym(rate), ca.SX.sym(f"{rate}_rate"))
        self.coordinates.append(Coordinate(name, rate, unit, size * factor, guess * factor, *symbols))
        return symbols[0]

    def amplitudes(self, name: str, count: int, unit: str, size: float = 1.0) -> ca.SX:
        """Coordinates NAME_1 to NAME_count as a column."""
        if not (isinstance(count, int) and count >= 0):
            raise DescriptionError(f"{count} amplitudes {name!r} of {self.name!r} cannot be; give a whole number, 0 for none")
        return column(*(self.coordinate(f"{name}_{k}", unit, size=size) for k in range(1, count + 1)))

    @told("the rate")
    def rate(self, expression: ca.SX) -> ca.SX:
        """Time derivative of an expression in coordinates and time; of such a rate, the acceleration."""
        q, v, a = (column(*(getattr(c, kind) for c in self.coordinates)) for kind in "qva")
        return ca.jtimes(expression, column(q, v, self.time), column(v, a, 1))

    @told("freeze")
    def freeze(self, coordinate: ca.SX) -> ca.SX:
        """The present value of a coordinate, a constant in derivatives: points can follow a slider while the material does not."""
        k = self._index(coordinate)
        return self.frozen.setdefault(k, ca.SX.sym(f"{self.coordinates[k].name} now"))

    def table(
        self, name: str, x: tuple[Sequence[float], str], y: tuple[Sequence[float], str], smooth: bool = False
    ) -> Callable[[Any], ca.SX]:
        """A function by points, of any expression: a torque over a speed, a force or a motion over time, a stiffness along a beam.

        Between two points it is a monotone cubic (scipy's PCHIP), as is the tool's force in a case file: it stays between their values, and
        its slope is continuous. Before the first point and after the last one it has the value of that point. Parameters NAME_x and NAME_y,
        which are 1 in the given units, scale it.

        Args:
            name: name of the table.
            x: ascending places of two or more points, and their unit.
            y: values there, and their unit.
            smooth: take a cubic spline, whose second derivative is continuous, too: for a prescribed motion. It may overshoot.

        Raises:
            DescriptionError: what is given makes no table.
        """
        for axis, pair in (("x", x), ("y", y)):
            if not (isinstance(pair, tuple) and len(pair) == 2 and isinstance(pair[1], str)):
                raise DescriptionError(
                    f"{axis} of table {name!r} of {self.name!r} is {pair!r}; give numbers and their unit, such as ([0, 310], 'rpm')"
                )
        curve = curve_through(f"table {name!r} of {self.name!r}", x[0], y[0], smooth)
        self.constants(**{f"{name}_x": (1.0, x[1]), f"{name}_y": (1.0, y[1])})
        self.curves.append(name)
        of_x, of_y = (self.parameters[f"{name}_{axis}"][0] for axis in "xy")

        @told(f"the argument of table {name!r}")
        def function(expression: Any) -> ca.SX:
            u, moving = ca.SX(expression), (symbol for c in self.coordinates for symbol in (c.q, c.v, c.a))
            known = column(self.time, *moving, *(symbol for symbol, _, _ in self.parameters.values()))
            if all(ca.depends_on(known, symbol) for symbol in ca.symvar(u)):  # others are places along a beam
                self.states(f"argument of table {name!r}", u, x[1])
            return of_y * curve(u / of_x)

        return function

    def tabulated(self, coordinate: ca.SX, low: float, step: float, coefficients: Any) -> Table:
        """Functions of a coordinate from a table outside the equations, see `Table`."""
        k = self._index(coordinate)
        self.tables.append(Table(k, self.coordinates[k].unit, coordinate - self.freeze(coordinate), low, step, coefficients))
        return self.tables[-1]

    @told("body")
    def body(self, name: str, mass: Any = 0.0, place: Any = None, inertia: Any = 0.0, angle: Any = None) -> None:
        """Add a rigid body: mass (kg), place of its centre, inertia (kg m^2) about that centre, and the angle by which it turns.

        Raises:
            DescriptionError: a mass without a place, or an inertia without an angle: it would not count.
        """
        for value, what, at, where in ((mass, "mass", place, "place"), (inertia, "inertia", angle, "angle")):
            if at is None and not ca.SX(value).is_zero():
                raise DescriptionError(
                    f"body {name!r} of {self.name!r} has {what} but no {where}, so that it would not count; give {where}="
                )
        if place is not None:
            self.mass_points(name, mass, ca.SX(0), ca.SX(0), place, 0.0)
        if angle is not None:
            self._has_rows(f"angle of {name!r}", angle, 1)
            self.turning.append((ca.SX(inertia), ca.SX(angle)))
            self._stays(f"inertia of {name!r}", inertia)
            self.states(f"inertia of {name!r}", inertia, "kg*m^2")
            self.states(f"angle of {name!r}", angle, "rad")

    def mass_points(self, name: str, mass: Any, x: Any, y: Any, origin: Any, angle: Any) -> None:
        """Add mass points (kg) at the places (x, y), columns, of a moving frame."""
        self._has_rows(f"place of {name!r}", origin, 2)
        self.points.append(Points(ca.SX(mass), x, y, ca.SX(origin), ca.SX(angle)))
        self._stays(f"mass of {name!r}", mass)
        self.states(f"mass of {name!r}", mass, "kg")
        self.states(f"place of {name!r}", column(x, y, origin), "m")

    @told("load")
    def load(self, name: str, on: Any, value: Any) -> None:
        """Add a force (N) on a place or a torque (N m) on an angle; it may depend on coordinates, rates and time."""
        self._has_rows(f"load {name!r}", value, ca.SX(on).numel())
        self.loads.append((ca.SX(on), ca.SX(value)))
        self.states(f"load {name!r} times what it acts on", ca.SX(value) * on, "J")

    @told("damper")
    def damper(self, name: str, on: Any, coefficient: Any) -> None:
        """Add a force of minus the coefficient times the rate of a place, a length or an angle."""
        self.dampers.append((ca.SX(on), ca.SX(coefficient)))
        self.states(f"coefficient of damper {name!r} times the square of what it acts on", coefficient * ca.SX(on) ** 2, "J*s")

    @told("spring")
    def spring(self, name: str, extension: Any, stiffness: Any) -> None:
        """Add a spring of given extension (m, or an angle in rad) and stiffness."""
        self.energy(name, 0.5 * ca.sum1(ca.SX(stiffness) * ca.SX(extension) ** 2))

    @told("energy")
    def energy(self, name: str, value: Any) -> None:
        """Add a potential energy (J) of any kind."""
        self._has_rows(f"energy of {name!r}", value, 1)
        self.energies.append(ca.SX(value))
        self.states(f"energy of {name!r}", value, "J")

    @told("loop")
    def loop(self, name: str, gap: Any, unit: str = "m", gives: Sequence[ca.SX] = (), by: tuple[Any, str] | None = None) -> ca.SX:
        """Add a closed loop, or a prescribed motion: `gap` stays zero. It determines as many coordinates (`gives`) as it has rows.

        Args:
            name: name of the loop.
            gap: expressions that stay zero.
            unit: unit of the gap.
            gives: coordinates that the loop determines.
            by: a place or an angle with as many rows, and its unit, on which the forces act in place of the gap: the torque at one link
                that makes a motion given at another.

        Returns:
            The forces that keep it closed. They act along `gap`, on its first place, and reversed on the subtracted place; or on `by`.
        """
        if not isinstance(gives, Sequence):
            raise DescriptionError(f"loop {name!r} of {self.name!r} gives {gives}; write a list of coordinates, such as gives=[{gives}]")
        gap = ca.SX(gap)
        on, on_unit = (ca.SX(by[0]), by[1]) if by else (gap, unit)
        if on.numel() != gap.numel():
            raise DescriptionError(
                f"loop {name!r} of {self.name!r} has {gap.numel()} rows and acts on {on.numel()}: it needs as many forces"
            )
        names = [f"{name}_force"] if gap.numel() == 1 else [f"{name}_force_{k}" for k in range(1, gap.numel() + 1)]
        self._new(*names)
        self.loops.append(Loop(name, gap, unit, [self._index(each) for each in gives], column(*map(ca.SX.sym, names)), on, on_unit))
        self.states(f"gap of loop {name!r}", gap, unit)
        self.states(f"place or angle on which loop {name!r} acts", on, on_unit)
        return self.loops[-1].force

    @told("output")
    def output(self, name: str, expression: Any, unit: str) -> None:
        """Add a named result: an expression in coordinates, their rates, accelerations (`rate` of a rate), forces of loops and time."""
        self._has_rows(f"output {name!r}", expression, 1)
        self._new(name)
        self.outputs[name] = (ca.SX(expression), unit)
        self.states(f"output {name!r}", expression, unit)

    def states(self, what: str, expression: Any, unit: str) -> None:
        """State that an expression has a unit; `Model` checks it. `what` names the expression in the message."""
        in_si(unit)
        self.stated.append((what, ca.SX(expression), unit))

    def _stays(self, what: str, value: Any) -> None:
        """Raise DescriptionError if a mass or an inertia depends on a coordinate: its bias acceleration would lack a part."""
        if ca.depends_on(ca.SX(value), column(*(symbol for c in self.coordinates for symbol in (c.q, c.v, c.a)))):
            raise DescriptionError(
                f"the {what} depends on a coordinate; describe a mass that moves by its place, such as turned(angle, radius)"
            )

    def _has_rows(self, what: str, value: Any, rows: int) -> None:
        """Raise DescriptionError for a scalar in place of a vector, or the reverse: CasADi would take it for both components."""
        shape = "one number" if rows == 1 else f"{rows} components, such as vector(x, y)"
        if isinstance(value, (tuple, list)):
            raise DescriptionError(f"the {what} of {self.name!r} is a {type(value).__name__}; it needs {shape}")
        given = ca.SX(value).numel()
        if given != rows:
            raise DescriptionError(f"the {what} of {self.name!r} has {given} component{'s' if given != 1 else ''}; it needs {shape}")

    def _index(self, coordinate: ca.SX) -> int:
        for k, each in enumerate(self.coordinates):
            if isinstance(coordinate, ca.SX) and ca.is_equal(each.q, coordinate):
                return k
        raise DescriptionError(f"{coordinate} is no coordinate of {self.name!r}; declare it with coordinate(...)")

    def _new(self, *names: str) -> None:
        taken = {*COMMON_COLUMNS, *self.parameters, *self.outputs, *(name for c in self.coordinates for name in (c.name, c.rate_name))}
        for name in names:
            if name in taken or name in [force.name() for loop in self.loops for force in ca.vertsplit(loop.force)]:
                raise DescriptionError(f"the name {name!r} is used twice in {self.name!r}")
