"""Evaluates derived equations numerically: finds a start, integrates, and computes the named outputs."""

from collections.abc import Callable, Iterable, Mapping, Sequence
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
#: Name of a parameter, a coordinate or a rate -> its value.
Values = Mapping[str, float]
#: A function that gives the rate of the state at a time and a state.
Rates = Callable[[float, Array], Array]

#: Largest gap of a closed loop after Newton's method, relative to the size of the loop's terms.
CLOSED: Final = 1e-8
#: Largest rate of the gap of a loop that stays closed, relative to the largest rate in the loops. People give rates with few digits.
OPENS: Final = 1e-5
#: Smallest part of a Newton step that is tried to close the loops: a step is halved until it leads nearer.
SMALLEST_PART: Final = 1e-6


class Model:
    """The compiled equations of a system.

    Args:
        system: the description.
        form: "projection" onto the free speeds, or "multipliers"; see `Equations`.
        feedback: 1/s; see `Equations`.

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
        """Values of all parameters in SI; `changed` gives other values, each in the parameter's unit."""
        self.refuse_unknown(changed or {}, "parameter", self.parameters)
        values = self.parameters | dict(changed or {})
        return np.array([values[name] * in_si(unit)[0] for name, (_, _, unit) in self.system.parameters.items()])

    def start(self, values: Values, parameters: Values | None = None) -> Array:
        """The state at time 0 for given coordinates and rates, by name in their units. The others are zero or follow from the loops.

        Newton's method starts from the guess of each coordinate that a loop gives, and keeps given values.

        Raises:
            DescriptionError: an unknown name, or a loop that does not close.
        """
        coordinates = self.system.coordinates
        self.refuse_unknown(values, "coordinate or rate", [name for c in coordinates for name in (c.name, c.rate_name)])
        q = np.array([values[c.name] * in_si(c.unit)[0] if c.name in values else c.guess for c in coordinates])
        v = np.array([values.get(c.rate_name, 0.0) * in_si(c.unit)[0] for c in coordinates])
        given = [k for loop in self.system.loops for k in loop.gives]
        seek, turn = ([k for k in given if coordinates[k][which] not in values] for which in (0, 1))
        return self.closed(q, v, self.values(parameters), seek, turn)

    def closed(self, q: Array, v: Array, p: Array, seek: Sequence[int], turn: Sequence[int]) -> Array:
        """State at time 0 for coordinates q and rates v, SI. Coordinates `seek` and rates `turn` (indices) change until the loops close.

        Raises:
            DescriptionError: a loop does not close.
        """
        v, part = v.copy(), 1.0
        gap, G, _ = self.loops(q, p)
        for _ in range(100):
            step = np.linalg.lstsq(G[:, seek], -gap, rcond=None)[0] if seek else np.zeros(0)
            if np.max(np.abs(step), initial=0.0) < 1e-14 or part < SMALLEST_PART:
                break
            there = q.copy()
            there[seek] += part * step
            for table in self.system.tables:
                there[table.index] = np.clip(there[table.index], table.low, table.high)
            moved = self.loops(there, p)
            if np.linalg.norm(moved[0]) < np.linalg.norm(gap):
                q, (gap, G, _), part = there, moved, min(1.0, 2.0 * part)
            else:
                part *= 0.5
        sizes = np.maximum(np.abs(G[:, :-1]) @ np.abs(q), np.max(np.abs(G[:, :-1]), axis=1, initial=0.0) * 1e-3)
        problem = "cannot close at the start: {left:.3g} {unit} remain; change the start, the lengths, or the guess of what it gives"
        self._refuse_rows(gap, CLOSED * sizes, problem)
        if turn:
            v[turn] = np.linalg.lstsq(G[:, turn], -G @ np.append(v, 1.0), rcond=None)[0]
        rates = np.append(v, 1.0)
        fastest = np.max(np.abs(G) @ np.abs(rates), initial=0.0)
        problem = "opens at the start by {left:.3g} {unit} a second; leave out the rates of the coordinates that it gives"
        self._refuse_rows(G @ rates, np.full(len(gap), OPENS * fastest), problem)
        return self.state(q, v)

    def _refuse_rows(self, rows: Array, allowed: Array, problem: str) -> None:
        """Raise DescriptionError if a row of the loops exceeds its allowed size, for the one that exceeds it most."""
        of_rows = [loop for loop in self.system.loops for _ in range(loop.gap.numel())]
        kept = np.abs(rows) <= allowed
        if np.all(kept):
            return
        with np.errstate(divide="ignore"):
            worst = int(np.argmax(np.where(kept, 0.0, np.abs(rows) / np.where(kept, 1.0, allowed))))
        loop, left = of_rows[worst], abs(rows[worst])
        raise DescriptionError(f"loop {loop.name!r} of {self.system.name!r} {problem.format(left=left, unit=loop.unit)}")

    def simulate(
        self, start: Values, duration: float, step: float, tolerance: float = 1e-9, method: str = "DOP853", parameters: Values | None = None
    ) -> pd.DataFrame:
        """The named outputs on a uniform grid of times; `attrs["units"]` holds their units.

        Args:
            start: name -> coordinate or rate at time 0; see `start`.
            duration: s.
            step: time between two rows, s.
            tolerance: local error, relative to each coordinate or rate and to the coordinate's `size`.
            method: method of scipy's `solve_ivp`: "DOP853", or "Radau" for stiff equations.
            parameters: name -> changed value, in the parameter's unit.

        Raises:
            DescriptionError: the start is impossible, or the integration gets stuck; the sentence says when.
        """
        y, p = self.start(start, parameters), self.values(parameters)
        self.check(y, p)
        times = np.linspace(0.0, duration, round(duration / step) + 1)
        states = self.integrate(lambda t, y: self.rates(t, y, p), y, times, tolerance, self.error_sizes(), method)
        return self.observe(times, states, p)

    def integrate(self, rates: Rates, y: Array, times: Array, tolerance: float, sizes: Array, method: str = "DOP853") -> Array:
        """The states at given times, shape (times, len(y)); errors are relative to the states and to `sizes`. See `simulate`."""
        with np.errstate(invalid="ignore"):  # where the motion ends, a step too far has rates that are no numbers
            solution = solve_ivp(rates, (0.0, times[-1]), y, method, times, rtol=tolerance, atol=tolerance * sizes)
        if not solution.success:
            at = solution.t[-1] if len(solution.t) else 0.0
            ends = ", ".join(self.system.coordinates[table.index].name for table in self.system.tables)
            cause = f" ({ends} may have left its table)" if ends else ""
            raise DescriptionError(f"the integration of {self.system.name!r} gets stuck after {at:g} s{cause}: {solution.message}")
        return np.asarray(solution.y.T)

    def check(self, y: Array, p: Array) -> None:
        """Raise DescriptionError if accelerations are undetermined, an output is not finite, or code and interpreter differ."""
        _, G, M = self.loops(y[: len(self.system.coordinates)], p)
        check_inertia(self.system, M, G[:, :-1])
        x = self.input(0.0, y, p)
        self._rates.check(x)
        refuse_nan(list(self.equations.outputs), np.array(self._outputs(x)).ravel())

    def error_sizes(self) -> Array:
        """The scale of each state's error for small states; it is infinite for the two integrals of power, which are not controlled."""
        size = np.array([c.size for c in self.system.coordinates])
        return np.concatenate([size, size[self.equations.free], [np.inf, np.inf]])

    def rates(self, time: float, y: Array, p: Array) -> Array:
        """The rate dy/dt of a state."""
        return self._rates(self.input(time, y, p))

    def observe(self, times: Array, states: Array, p: Array) -> pd.DataFrame:
        """The outputs of states, shape (times, size of a state), each in its unit."""
        rows = np.array(self._outputs(np.column_stack([self.input(t, y, p) for t, y in zip(times, states, strict=True)]))).T
        frame = pd.DataFrame(np.column_stack([times, rows]), columns=list(self.units)) / [in_si(unit)[0] for unit in self.units.values()]
        frame.attrs["units"] = self.units
        return frame

    def input(self, time: float, y: Array, p: Array) -> Array:
        """The values of all symbols of the equations, SI, in the order of `inputs`."""
        return np.concatenate([[time], y, p, *(table.at(y[table.index]) for table in self.system.tables)])

    def state(self, q: Array, v: Array) -> Array:
        """The state for all coordinates and rates, including those that the loops give."""
        return np.concatenate([q, v[self.equations.free], [0.0, 0.0]])

    def loops(self, q: Array, p: Array) -> tuple[Array, Array, Array]:
        """The gaps, their Jacobian and the mass matrix at time 0."""
        gap, G, M = (np.array(each) for each in self._matrices(self.input(0.0, self.state(q, 0.0 * q), p)))
        return gap.ravel(), G, M

    def refuse_unknown(self, names: Iterable[str], what: str, known: Iterable[str]) -> None:
        """Raise DescriptionError for an unknown name; the message lists the known ones."""
        accepted = list(known)
        for name in names:
            if name not in accepted:
                raise DescriptionError(f"{name!r} is no {what} of {self.system.name!r}; there are {', '.join(accepted)}")
