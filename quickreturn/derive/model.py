"""Numbers from derived equations: start, simulation, named outputs."""

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from quickreturn.derive.checks import check_inertia, check_units
from quickreturn.derive.equations import Equations, Form
from quickreturn.derive.machine_code import MachineCode
from quickreturn.derive.system import System
from quickreturn.derive.units import DescriptionError, in_si

Array = NDArray[np.float64]
Values = Mapping[str, float]

#: A loop counts as closed when its gap, over the size of the numbers in it, is below this after Newton's method.
CLOSED = 1e-9


class Model:
    """A system's equations, compiled.

    Args:
        system: as described.
        form: "projection" on the free speeds or with "multipliers", see `Equations`.
        feedback: 1/s, see `Equations`.

    Raises:
        DescriptionError: a mistake in the description.
    """

    def __init__(self, system: System, form: Form = "projection", feedback: float = 100.0) -> None:
        check_units(system)
        self.system, self.equations = system, Equations(system, form, feedback)
        e = self.equations
        self.parameters = {name: value for name, (_, value, _) in system.parameters.items()}
        self._constants = ca.vertcat(*(symbol for symbol, _, _ in system.parameters.values()))
        rows = ca.vertcat(*(table.row for table in system.tables))
        self.inputs = ca.vertcat(system.time, e.state, self._constants, rows)
        names = [*(c.rate_name for c in system.coordinates), *(f"rate of {system.coordinates[k].rate_name}" for k in e.free)]
        self._rates = MachineCode(self.inputs, e.state_rates, [*names, "dissipated power", "power"])
        self._outputs = MachineCode(self.inputs, ca.vertcat(*(each for each, _ in e.outputs.values())), list(e.outputs))
        self.units = {"time": "s"} | {name: unit for name, (_, unit) in e.outputs.items()}

    def with_parameters(self, values: Values | None) -> Array:
        """Values of all parameters, SI, some of them changed."""
        if unknown := set(values or {}) - set(self.parameters):
            raise DescriptionError(f"{sorted(unknown)[0]!r} is no parameter of {self.system.name!r}; there are {', '.join(self.parameters)}")
        return np.array(list((self.parameters | dict(values or {})).values()), dtype=np.float64)

    def start(self, values: Values, parameters: Values | None = None, time: float = 0.0) -> Array:
        """State with given coordinates and rates, by name in their units; the others are zero, or as the loops give them.

        A coordinate that a loop gives is found by Newton's method from its guess, unless a value is given: then it is kept.

        Raises:
            DescriptionError: an unknown name, or a loop that does not close.
        """
        e, each = self.equations, self.system.coordinates
        names = {name for c in each for name in (c.name, c.rate_name)}
        if unknown := set(values) - names:
            raise DescriptionError(f"{sorted(unknown)[0]!r} is no coordinate or rate of {self.system.name!r}; there are {', '.join(sorted(names))}")
        q = np.array([values[c.name] * in_si(c.unit)[0] if c.name in values else c.guess for c in each])
        v = np.array([values.get(c.rate_name, 0.0) * in_si(c.unit)[0] for c in each])
        given = [k for loop in self.system.loops for k in loop.gives]
        seek, turn = ([k for k in given if name(each[k]) not in values] for name in (lambda c: c.name, lambda c: c.rate_name))
        p = self.with_parameters(parameters)
        loops = ca.Function("loops", [self.inputs], [e.gap, e.G])
        for _ in range(50):
            gap, G = (np.array(found) for found in loops(self._input(time, self._state(q, v), p)))
            gap = gap.ravel()
            step = np.linalg.lstsq(G[:, seek], -gap, rcond=None)[0] if seek else np.zeros(0)
            q[seek] += step
            if np.max(np.abs(step), initial=0.0) < 1e-14:
                break
        self._refuse_open(gap, np.abs(G[:, :-1]) @ np.maximum(np.abs(q), 1e-3))
        if turn:
            v[turn] = 0.0
            v[turn] = np.linalg.lstsq(G[:, turn], -G[:, :-1] @ v - G[:, -1], rcond=None)[0]
        return self._state(q, v)

    def simulate(
        self,
        start: Values | Array,
        duration: float,
        step: float,
        *,
        tolerance: float = 1e-9,
        method: str = "DOP853",
        parameters: Values | None = None,
    ) -> pd.DataFrame:
        """Named outputs on a uniform grid of time; their units are in `attrs["units"]`.

        Args:
            start: coordinates and rates at time 0 by name, or a state.
            duration: s.
            step: s, of the output.
            tolerance: local error relative to each coordinate and rate, and to the coordinate's `size`.
            method: of scipy's `solve_ivp`: "DOP853", or "Radau" where stiff.
            parameters: changed values, SI.

        Raises:
            DescriptionError: a start that cannot be, or an integration that gets stuck; it says when.
        """
        y = self.start(start, parameters) if isinstance(start, Mapping) else start
        p = self.with_parameters(parameters)
        self.check(y, p)
        times = np.linspace(0.0, duration, round(duration / step) + 1)
        size = np.array([c.size for c in self.system.coordinates])
        absolute = np.concatenate([size, size[self.equations.free], [np.inf, np.inf]]) * tolerance
        try:
            found = solve_ivp(self.rate_at, (0.0, duration), y, method, times, args=(p,), rtol=max(tolerance, 3e-14), atol=absolute)
        except DescriptionError as error:
            raise DescriptionError(f"{self.system.name!r} cannot go on: {error}") from error
        if not found.success:
            reached = found.t[-1] if len(found.t) else 0.0
            raise DescriptionError(f"the integration of {self.system.name!r} gets stuck after {reached:g} s: {found.message}")
        return self.observe(found.t, found.y.T, p)

    def check(self, y: Array, p: Array) -> None:
        """Refuse a state in which an acceleration is not determined, or an output not a number."""
        x = self._input(0.0, y, p)
        check_inertia(self.system, self.equations, ca.Function("inertia", [self.inputs], [self.equations.M, self.equations.G]), x)
        self._rates.check(x)
        self._outputs.check(x)

    def rate_at(self, time: float, y: Array, p: Array) -> Array:
        """dy/dt of a state."""
        return self._rates(self._input(time, y, p))

    def observe(self, times: Array, states: Array, p: Array) -> pd.DataFrame:
        """Outputs of states (k, size of the state), in their units."""
        rows = np.array([self._outputs(self._input(t, y, p)) for t, y in zip(times, states, strict=True)])
        factors = np.array([in_si(unit)[0] for _, unit in self.equations.outputs.values()])
        frame = pd.DataFrame(np.column_stack([times, rows / factors]), columns=list(self.units))
        frame.attrs["units"] = self.units
        return frame

    def _state(self, q: Array, v: Array) -> Array:
        return np.concatenate([q, v[self.equations.free], [0.0, 0.0]])

    def _input(self, time: float, y: Array, p: Array) -> Array:
        rows = [table.at(y[table.index]) for table in self.system.tables]
        return np.concatenate([[time], y, p, *rows])

    def _refuse_open(self, gap: Array, size: Array) -> None:
        row = 0
        for loop in self.system.loops:
            rows = slice(row, row + loop.gap.numel())
            row = rows.stop
            left = np.abs(gap[rows])
            if not np.all(left <= CLOSED * np.maximum(size[rows], 1e-12)):
                raise DescriptionError(
                    f"loop {loop.name!r} of {self.system.name!r} cannot close at the start: {np.max(left):.3g} {loop.unit} remain; change the"
                    " start, the lengths, or the guess of the coordinates that the loop gives"
                )
