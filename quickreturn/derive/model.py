"""Numerical evaluation of derived equations: start, simulation, named outputs."""

from collections.abc import Iterable, Mapping
from typing import Final

import casadi as ca
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from quickreturn.derive.checks import check_inertia, check_units
from quickreturn.derive.equations import Equations, Form
from quickreturn.derive.machine_code import MachineCode, refuse_nan
from quickreturn.derive.system import System, column
from quickreturn.derive.units import DescriptionError, in_si

Array = NDArray[np.float64]
#: Names of parameters, or of coordinates and rates, to values.
Values = Mapping[str, float]

#: A loop counts as closed if its gap, relative to the size of its terms, is below this after Newton's method.
CLOSED: Final = 1e-8
#: A loop counts as staying closed if the rate of its gap, relative to the largest rate in the loops, is below this: given rates have few
#: digits.
OPENS: Final = 1e-5


class Model:
    """A system's equations, compiled.

    Args:
        system: as described.
        form: "projection" on the free speeds, or with "multipliers", see `Equations`.
        feedback: 1/s, see `Equations`.

    Raises:
        DescriptionError: a mistake in the description.
    """

    def __init__(self, system: System, form: Form = "projection", feedback: float = 100.0) -> None:
        check_units(system)
        self.system, self.equations = system, Equations(system, form, feedback)
        e, n = self.equations, len(system.coordinates)
        self.parameters = {name: value / in_si(unit)[0] for name, (_, value, unit) in system.parameters.items()}
        self.constants = column(*(symbol for symbol, _, _ in system.parameters.values()))
        self.inputs = column(system.time, e.state, self.constants, *(table.row for table in system.tables))
        speeds = [system.coordinates[k].rate_name for k in e.free]
        names = [*(c.rate_name for c in system.coordinates), *(f"rate of {name}" for name in speeds), "dissipated power", "power"]
        self._rates = MachineCode(self.inputs, e.rates, names)
        results = column(*(expression for expression, _ in e.outputs.values()))
        self._outputs = ca.Function("outputs", [self.inputs], [ca.densify(ca.cse(results))])
        self._matrices = ca.Function("matrices", [self.inputs], [e.gap, e.G, e.M[:n, :n]])
        self.units = {"time": "s"} | {name: unit for name, (_, unit) in e.outputs.items()}

    def values(self, changed: Values | None) -> Array:
        """Values of all parameters in SI; `changed`: other values, in the parameters' units."""
        self._refuse_unknown(changed or {}, "parameter", self.parameters)
        values = self.parameters | dict(changed or {})
        return np.array([values[name] * in_si(unit)[0] for name, (_, _, unit) in self.system.parameters.items()])

    def start(self, values: Values, parameters: Values | None = None) -> Array:
        """State at time 0 from given coordinates and rates, by name in their units; the others are zero, or follow from the loops.

        Newton's method finds a coordinate that a loop gives, from its guess; a given value is kept.

        Raises:
            DescriptionError: an unknown name, or a loop that does not close.
        """
        each, p = self.system.coordinates, self.values(parameters)
        self._refuse_unknown(values, "coordinate or rate", [name for c in each for name in (c.name, c.rate_name)])
        q = np.array([values[c.name] * in_si(c.unit)[0] if c.name in values else c.guess for c in each])
        v = np.array([values.get(c.rate_name, 0.0) * in_si(c.unit)[0] for c in each])
        given = [k for loop in self.system.loops for k in loop.gives]
        seek = [k for k in given if each[k].name not in values]
        for _ in range(50):
            gap, G, _ = self.loops(q, p)
            step = np.linalg.lstsq(G[:, seek], -gap, rcond=None)[0] if seek else np.zeros(0)
            q[seek] += step
            for table in self.system.tables:
                q[table.index] = np.clip(q[table.index], table.low, table.high)
            if np.max(np.abs(step), initial=0.0) < 1e-14:
                break
        sizes = np.maximum(np.abs(G[:, :-1]) @ np.abs(q), np.max(np.abs(G[:, :-1]), axis=1, initial=0.0) * 1e-3)
        of_rows = [loop for loop in self.system.loops for _ in range(loop.gap.numel())]
        for loop, left, size in zip(of_rows, gap, sizes, strict=True):
            if not abs(left) <= CLOSED * size:
                raise DescriptionError(
                    f"loop {loop.name!r} of {self.system.name!r} cannot close at the start: {abs(left):.3g} {loop.unit} remain; change the"
                    " start, the lengths, or the guess of the coordinates that the loop gives"
                )
        if turn := [k for k in given if each[k].rate_name not in values]:
            v[turn] = np.linalg.lstsq(G[:, turn], -G @ np.append(v, 1.0), rcond=None)[0]
        rates = np.append(v, 1.0)
        for loop, opening in zip(of_rows, np.abs(G @ rates), strict=True):
            if opening > OPENS * np.max(np.abs(G) @ np.abs(rates)):
                raise DescriptionError(
                    f"loop {loop.name!r} of {self.system.name!r} opens at the start by {opening:.3g} {loop.unit} a second; leave out the"
                    " rates of the coordinates that it gives"
                )
        return self.state(q, v)

    def simulate(
        self, start: Values, duration: float, step: float, tolerance: float = 1e-9, method: str = "DOP853", parameters: Values | None = None
    ) -> pd.DataFrame:
        """Named outputs on a uniform grid of time; their units are in `attrs["units"]`.

        Args:
            start: coordinates and rates at time 0 by name, see `start`.
            duration: s.
            step: s, of the output.
            tolerance: local error relative to each coordinate and rate, and to the coordinate's `size`.
            method: of scipy's `solve_ivp`: "DOP853", or "Radau" where stiff.
            parameters: changed values, in their units.

        Raises:
            DescriptionError: an impossible start, or an integration that gets stuck; the sentence says when.
        """
        y, p = self.start(start, parameters), self.values(parameters)
        self.check(y, p)
        times, limits = np.linspace(0.0, duration, round(duration / step) + 1), {"rtol": tolerance, "atol": tolerance * self.error_sizes()}
        found = solve_ivp(self.rates, (0.0, duration), y, method, times, args=(p,), **limits)
        if not found.success:
            at = found.t[-1] if len(found.t) else 0.0
            ends = [c.name for c in (self.system.coordinates[t.index] for t in self.system.tables)]
            cause = f" ({', '.join(ends)} may have left its table)" if ends else ""
            raise DescriptionError(f"the integration of {self.system.name!r} gets stuck after {at:g} s{cause}: {found.message}")
        return self.observe(found.t, found.y.T, p)

    def check(self, y: Array, p: Array) -> None:
        """Refuse a state in which an acceleration is not determined, or an output not a number; compare code and interpreter."""
        _, G, M = self.loops(y[: len(self.system.coordinates)], p)
        check_inertia(self.system, M, G[:, :-1])
        x = self.input(0.0, y, p)
        self._rates.check(x)
        refuse_nan(list(self.equations.outputs), np.array(self._outputs(x)).ravel())

    def error_sizes(self) -> Array:
        """Scales of the errors of a state where it is small; the integrals of power are not controlled."""
        size = np.array([c.size for c in self.system.coordinates])
        return np.concatenate([size, size[self.equations.free], [np.inf, np.inf]])

    def rates(self, time: float, y: Array, p: Array) -> Array:
        """dy/dt of a state."""
        return self._rates(self.input(time, y, p))

    def observe(self, times: Array, states: Array, p: Array) -> pd.DataFrame:
        """Outputs of states (k, size of the state), in their units."""
        rows = np.array(self._outputs(np.column_stack([self.input(t, y, p) for t, y in zip(times, states, strict=True)]))).T
        frame = pd.DataFrame(np.column_stack([times, rows]), columns=list(self.units)) / [in_si(unit)[0] for unit in self.units.values()]
        frame.attrs["units"] = self.units
        return frame

    def input(self, time: float, y: Array, p: Array) -> Array:
        """Values of all symbols of the equations."""
        return np.concatenate([[time], y, p, *(table.at(y[table.index]) for table in self.system.tables)])

    def state(self, q: Array, v: Array) -> Array:
        """State from all coordinates and rates, including those that the loops give."""
        return np.concatenate([q, v[self.equations.free], [0.0, 0.0]])

    def loops(self, q: Array, p: Array) -> tuple[Array, Array, Array]:
        """Gaps, their Jacobian and the mass matrix at time 0."""
        gap, G, M = (np.array(each) for each in self._matrices(self.input(0.0, self.state(q, 0.0 * q), p)))
        return gap.ravel(), G, M

    def _refuse_unknown(self, names: Values, what: str, known: Iterable[str]) -> None:
        there = list(known)
        for name in names:
            if name not in there:
                raise DescriptionError(f"{name!r} is no {what} of {self.system.name!r}; there are {', '.join(there)}")
