"""Evaluates derived equations numerically: finds a start, integrates, and computes the named outputs."""

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from numbers import Real
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy import integrate

from quickreturn.plugins.derive.checks import check_condition, check_inertia
from quickreturn.plugins.derive.compiled import CompiledEquations, Values
from quickreturn.plugins.derive.singular import Watch
from quickreturn.plugins.derive.units import Array, DescriptionError, in_si

#: A function that gives the rate of the state at a time, for a state and values of the parameters.
Rates = Callable[[float, Array, Array], Array]

METHODS: Final[dict[str, Any]] = {"DOP853": integrate.DOP853, "Radau": integrate.Radau}
#: Longest step of DOP853 times the rate of the feedback. At 6 the method is unstable; at 5 rates in rows between the ends of a step are off
#: by 2e-6 at a tolerance of 1e-9, at 3 by 3e-8.
LONGEST: Final = 3.0
#: Largest gap of a closed loop after Newton's method, relative to the size of the loop's terms.
CLOSED: Final = 1e-8
#: Largest rate of the gap of a loop that stays closed, relative to the largest rate in the loops. People give rates with few digits.
OPENS: Final = 1e-5
#: Smallest part of a Newton step that is tried to close the loops: a step is halved until it leads nearer.
SMALLEST_PART: Final = 1e-6
#: Largest change of an angle in a step of that search, rad: longer ones lead to other ways to close the loops.
TURN: Final = 0.5
#: Change of the energy in each step, over the tolerance and the energy in motion, that errors of integration explain.
DRIFT: Final = 10.0
#: Scale of the error of dissipated energy and work, over the kinetic energy with each speed a coordinate's size in a second. With 1 a
#: recorded motion changes the energy balance by more than is allowed.
WORK: Final = 0.01
#: Relative rounding of a potential energy whose parts cancel.
ROUNDING: Final = 1e-12
#: Smallest part of a motion, over its size, in which a force that acts elsewhere must move what it acts on.
HELPLESS: Final = 1e-9


def grid(duration: float, step: float) -> Array:
    """Times from 0 to a duration (s) by the step nearest to the given one that divides it.

    Raises:
        DescriptionError: no numbers, a step that is not positive or longer than the duration, or a negative duration.
    """
    if not (isinstance(duration, Real) and isinstance(step, Real)):
        raise DescriptionError(f"the duration {duration!r} and the step {step!r} must be numbers, in s")
    if not (step > 0.0 and 0.0 <= duration < np.inf and (step <= duration or duration == 0.0)):
        raise DescriptionError(f"a duration of {duration:g} s cannot have rows {step:g} s apart")
    return np.linspace(0.0, duration, round(duration / step) + 1)


class Model(CompiledEquations):
    """A system that can be simulated: the compiled equations, a start, integration and outputs.

    Args:
        system: the description.
        form: "projection" onto the free speeds, or "multipliers"; see `Equations`.
        feedback: 1/s; see `Equations`.

    Raises:
        DescriptionError: a mistake in the description.
    """

    def start(self, values: Values, parameters: Values | None = None) -> Array:
        """The state at time 0 for coordinates and rates given by name in their units; others are zero, or follow from the loops.

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
        v = v.copy()
        q, gap, G = self._nearest(q, p, seek)
        of_rows = np.maximum(np.abs(G[:, :-1]) @ np.abs(q), np.max(np.abs(G[:, :-1]), axis=1, initial=0.0) * 1e-3)
        ends = np.cumsum([0, *(loop.gap.numel() for loop in self.system.loops)])
        # one row of a loop may vanish in a singular position, and no other unit is in it
        sizes = np.concatenate([np.zeros(0), *(np.full(b - a, np.max(of_rows[a:b])) for a, b in pairwise(ends))])
        problem = "cannot close at the start: {left:.3g} {unit} remain; change the start, the lengths, or the guess of what it gives"
        self._refuse_rows(gap, CLOSED * sizes, problem)
        if turn:
            v[turn] = np.linalg.lstsq(G[:, turn], -G @ np.append(v, 1.0), rcond=None)[0]
        rates = np.append(v, 1.0)
        fastest = np.max(np.abs(G) @ np.abs(rates), initial=0.0)
        problem = (
            "opens at the start by {left:.3g} {unit} a second; leave out the rates of the coordinates that it gives, or start"
            " beside a singular position"
        )
        self._refuse_rows(G @ rates, np.full(len(gap), OPENS * fastest), problem)
        return self.state(q, v)

    def _nearest(self, q: Array, p: Array, seek: Sequence[int]) -> tuple[Array, Array, Array]:
        """Coordinates that close the loops, by Newton's method from q, and the gap and its Jacobian there."""
        part, coordinates = 1.0, [self.system.coordinates[k] for k in seek]
        angle, sizes = np.array([not any(in_si(c.unit)[1]) for c in coordinates], dtype=bool), np.array([c.size for c in coordinates])
        gap, G, _ = self.loops(q, p)
        for _ in range(100):
            step = np.linalg.lstsq(G[:, seek], -gap, rcond=None)[0] if seek else np.zeros(0)
            if np.max(np.abs(step) / sizes, initial=0.0) < 1e-14 or part < SMALLEST_PART:
                break
            step /= max(1.0, np.max(np.abs(step[angle]), initial=0.0) / TURN)
            there = q.copy()
            there[seek] += part * step
            for table in self.system.tables:
                there[table.index] = np.clip(there[table.index], table.low, table.high)
            moved = self.loops(there, p)
            if np.linalg.norm(moved[0]) < np.linalg.norm(gap):
                q, (gap, G, _), part = there, moved, min(1.0, 2.0 * part)
            else:
                part *= 0.5
        return q, gap, G

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
        """The named outputs on a uniform grid of times.

        `attrs["units"]` holds their units.

        Args:
            start: name -> coordinate or rate at time 0; see `start`.
            duration: s.
            step: time between two rows, s; the nearest that divides the duration is taken.
            tolerance: local error, relative to each coordinate or rate and to the coordinate's `size`.
            method: "DOP853", or "Radau" for stiff equations.
            parameters: name -> changed value, in the parameter's unit.

        Raises:
            DescriptionError: the start is impossible, the integration gets stuck, the motion comes to a singular position, or the
                energy balance changes; the sentence says when.
        """
        times, p, y = grid(duration, step), self.values(parameters), self.start(start, parameters)
        self.check_drives([0.0], y[None], p)
        _, G, M = self.loops(y[: len(self.system.coordinates)], p)
        check_inertia(self.system, M, G[:, :-1])
        self.check(y, p, tolerance)
        sizes, n = self.error_sizes(), len(M)
        if self.system.curves:  # forces may jump at the points of a table: there steps must be short enough for the work
            sizes[-2:] = WORK * 0.5 * sizes[:n] @ M @ sizes[:n] or np.inf
        states, steps = self.integrate(self.rates, y, times, p, tolerance, sizes, method)
        self.check_drives(times, states, p)
        frame = self.observe(times, states, p)
        self.check_motion(frame, y, p, tolerance, steps)
        return frame

    def integrate(
        self, rates: Rates, y: Array, times: Array, p: Array, tolerance: float, sizes: Array, method: str = "DOP853"
    ) -> tuple[Array, int]:
        """The states at given times, shape (times, len(y)), and the number of steps. Without feedback the loops are left as they are.

        Args:
            rates: of the integrated state, of which that of the model is the first part.
            y: state at time 0.
            times: s, ascending from 0.
            p: values of the parameters, SI.
            tolerance: local error, relative to each state and to `sizes`.
            sizes: scale of each state's error.
            method: a name in METHODS.

        Raises:
            DescriptionError: an unknown method or tolerance, a singular position, or no step is found; the sentence says when.
        """
        if method not in METHODS:
            raise DescriptionError(f"method {method!r} is not known; take one of {', '.join(METHODS)}")
        if not 0.0 < tolerance < 1.0:
            raise DescriptionError(f"a tolerance of {tolerance:g} is not between 0 and 1")
        watch, feedback = Watch(self, p, y), self.equations.feedback if self.equations.gap.numel() else 0.0
        longest = LONGEST / feedback if feedback and method == "DOP853" else np.inf

        def begun(time: float, state: Array, first_step: float | None = None) -> Any:
            accuracy: Any = {"rtol": tolerance, "atol": tolerance * sizes, "max_step": longest}
            return METHODS[method](lambda t, y: rates(t, y, p), time, state, times[-1], first_step=first_step, **accuracy)

        states, row, steps, solver = np.tile(y, (len(times), 1)), 1, 0, begun(0.0, y)
        while row < len(times):
            before = solver.y
            # where a motion ends, a step too far has rates that are no numbers
            with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
                message = solver.step()
            if solver.status == "failed":
                watch.stuck(solver.t, solver.y)
                ends = ", ".join(self.system.coordinates[table.index].name for table in self.system.tables)
                cause = f" ({ends} may have left its table)" if ends else ""
                raise DescriptionError(f"the integration of {self.system.name!r} gets stuck after {solver.t:g} s{cause}: {message}")
            if not watch.follows(solver.t, solver.y):
                solver = begun(solver.t_old, before, 0.5 * (solver.t - solver.t_old))
                continue
            steps, end = steps + 1, int(np.searchsorted(times, solver.t, side="right"))
            if end > row:  # evaluating between steps costs rates
                there = solver.dense_output()
                states[row:end] = [there(time) for time in times[row:end]]
                row = end
        if feedback:
            states = self._rows_on_loops(times, states, p)
        self.check_slopes(times, states, p)
        return states, steps

    def _rows_on_loops(self, times: Array, states: Array, p: Array) -> Array:
        """States, shape (times, size of a state), put on the loops: between steps they stand off by more than the tolerance."""
        states, n, free = states.copy(), len(self.system.coordinates), self.equations.free
        moves = [k for k in range(n) if k not in free] or list(range(n))
        sizes = np.array([self.system.coordinates[k].size for k in moves])
        for _ in range(2):  # each leaves the square of the gap
            at = np.column_stack([self._place(t, y[:n], p) for t, y in zip(times, states, strict=True)])
            gap, G, _ = (np.array(each) for each in self._matrices(at))
            G = G.reshape(len(gap), len(times), n + 1).swapaxes(0, 1)
            inverse = sizes[:, None] * np.linalg.pinv(G[:, :, moves] * sizes)
            states[:, moves] -= np.einsum("tkl,lt->tk", inverse, gap)
        if len(free) == n:
            opening = np.einsum("tlk,tk->tl", G[:, :, :n], states[:, n : 2 * n]) + G[:, :, n]
            states[:, n : 2 * n] -= np.einsum("tkl,tl->tk", inverse, opening)
        return states

    def check_motion(self, frame: pd.DataFrame, y: Array, p: Array, tolerance: float, steps: int) -> None:
        """Raise DescriptionError if the energy balance changes by more than errors of integration explain."""
        n, size = len(self.system.coordinates), self.error_sizes()
        potential = frame["potential_energy"]
        moved = [frame["kinetic_energy"], potential - potential[0], frame["dissipated_energy"], frame["work"]]
        of_sizes = 0.5 * size[:n] @ self.loops(y[:n], p)[2] @ size[:n]
        energy = sum(float(each.abs().max()) for each in moved)
        change = (frame["energy_balance"] - frame["energy_balance"][0]).abs()
        # local errors add up: some tolerances of each step
        allowed = (
            min(DRIFT * tolerance * steps, np.sqrt(tolerance)) * energy + tolerance * of_sizes + ROUNDING * float(potential.abs().max())
        )
        if not (change <= allowed).all():
            first = int(np.argmax(~(change <= allowed)))
            raise DescriptionError(
                f"the motion of {self.system.name!r} is wrong from {frame['time'][first]:g} s at the latest: its energy balance has changed"
                f" by {change[first]:.3g} J, with {energy:.3g} J in motion; take a tolerance below {tolerance:g}, or a smaller `size` of"
                " the coordinates"
            )

    def check_drives(self, times: Iterable[float], states: Array, p: Array) -> None:
        """Raise DescriptionError if forces that act elsewhere than they hold have a pole in a state, or between two."""
        if not self.equations.elsewhere:
            return
        last = 0.0, np.inf
        for time, y in zip(times, states, strict=True):
            value, distance = self.levers(time, y[: len(self.system.coordinates)], p)
            if distance < HELPLESS or (value * last[0] < 0.0 and min(distance, last[1]) < np.inf):
                names = " and ".join(repr(loop.name) for loop in self.system.loops if loop.elsewhere)
                raise DescriptionError(
                    f"the force of loop {names} of {self.system.name!r} cannot make its motion at {time:g} s: what it acts on stands still"
                    " in the motion there, or does not reach it without delay; end the motion before, or let the force act on another part"
                )
            last = value, distance

    def check(self, y: Array, p: Array, tolerance: float = 1e-9) -> None:
        """Check that the state at time 0 determines the motion.

        Raises:
            DescriptionError: accelerations are undetermined or lost in rounding, or a rate or an output is not finite.
        """
        q = y[: len(self.system.coordinates)]
        (_, G, M), free = self.loops(q, p), self.equations.free
        Watch(self, p, y)
        if len(free) < len(M):  # the matrices that the two forms solve
            given = [k for k in range(len(M)) if k not in free]
            B = np.eye(len(M))[:, free]
            B[given] = -np.linalg.solve(G[:, given], G[:, free])
            solved = B.T @ M @ B
        else:
            solved = M + np.trace(M) / max(float(np.sum(G[:, :-1] ** 2)), 1e-300) * G[:, :-1].T @ G[:, :-1]
        check_condition(self.system, solved, free, tolerance)
        x = self.input(0.0, y, p)
        names, values = [*self._rates.names, *self.equations.outputs], [*self._rates(x), *np.array(self._outputs(x)).flat]
        for name, value in zip(names, values, strict=True):
            if not np.isfinite(value):
                raise DescriptionError(f"{name} is {value} at the start; look for a root of a negative number or a division by zero there")

    def observe(self, times: Array, states: Array, p: Array) -> pd.DataFrame:
        """The outputs of states, shape (times, size of a state), each in its unit."""
        rows = np.array(self._outputs(np.column_stack([self.input(t, y, p) for t, y in zip(times, states, strict=True)]))).T
        frame = pd.DataFrame(np.column_stack([times, rows]), columns=list(self.units)) / [in_si(unit)[0] for unit in self.units.values()]
        frame.attrs["units"] = self.units
        return frame
