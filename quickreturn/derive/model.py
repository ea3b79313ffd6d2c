"""Evaluates derived equations numerically: finds a start, integrates, and computes the named outputs."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import casadi as ca
import numpy as np
import pandas as pd

from quickreturn.derive.checks import check_condition, check_inertia
from quickreturn.derive.compiled import Array, CompiledEquations, Values
from quickreturn.derive.integration import Rates, integrated
from quickreturn.derive.machine_code import refuse_nan
from quickreturn.derive.singular import Passage, Watch
from quickreturn.derive.units import DescriptionError, in_si

#: Largest gap of a closed loop after Newton's method, relative to the size of the loop's terms.
CLOSED: Final = 1e-8
#: Largest rate of the gap of a loop that stays closed, relative to the largest rate in the loops. People give rates with few digits.
OPENS: Final = 1e-5
#: Smallest part of a Newton step that is tried to close the loops: a step is halved until it leads nearer.
SMALLEST_PART: Final = 1e-6
#: Relative rounding of a potential energy whose parts cancel.
ROUNDING: Final = 1e-12
#: Longest step of DOP853 times the rate of the feedback. At 6 the method is unstable; in a single step of 26 rows between its ends opened
#: the loops by 1e-3 at a tolerance of 1e-7.
LONGEST: Final = 5.0
#: Part of a passage beside the singular position in which forces of loops are lost in rounding, whose square they are divided by.
LOST: Final = 1e-3


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
        """The named outputs on a uniform grid of times.

        `attrs["units"]` holds their units, `attrs["singular_positions"]` the times (s) of the singular positions that the motion passed.
        There forces of loops may have a pole: a row beside it, within a thousandth of the passage, has nan in their place.

        Args:
            start: name -> coordinate or rate at time 0; see `start`.
            duration: s.
            step: time between two rows, s.
            tolerance: local error, relative to each coordinate or rate and to the coordinate's `size`.
            method: "DOP853", or "Radau" for stiff equations.
            parameters: name -> changed value, in the parameter's unit.

        Raises:
            DescriptionError: the start is impossible, the integration gets stuck, the motion ends in a singular position, or the energy
                balance changes; the sentence says when.
        """
        y, p = self.start(start, parameters), self.values(parameters)
        self.check(y, p, tolerance)
        times = np.linspace(0.0, duration, round(duration / step) + 1)
        states, passages = self.integrate(lambda t, y: self.rates(t, y, p), y, times, p, tolerance, self.error_sizes(), method)
        frame = self.observe(times, states, p, passages)
        self._check_energy(frame, y, p, tolerance)
        return frame

    def integrate(
        self, rates: Rates, y: Array, times: Array, p: Array, tolerance: float, sizes: Array, method: str = "DOP853", passes: bool = True
    ) -> tuple[Array, list[Passage]]:
        """The states at given times, shape (times, len(y)), and the passages; errors are relative to the states and to `sizes`.

        The first entries of y are the state of the system. `passes`: whether to pass singular positions. See `simulate`.
        """
        watch, tables = Watch(self, p, tolerance, passes), self.system.tables
        watch.begin(y)
        ends = ", ".join(self.system.coordinates[table.index].name for table in tables)
        cause = f" ({ends} may have left its table)" if ends else ""
        feedback = self.equations.feedback if self.equations.gap.numel() and method == "DOP853" else 0.0
        longest = LONGEST / feedback if feedback else np.inf
        return integrated(rates, y, times, tolerance, sizes, method, watch, longest, self.system.name, cause)

    def _check_energy(self, frame: pd.DataFrame, y: Array, p: Array, tolerance: float) -> None:
        """Raise DescriptionError if the energy balance changes by more than errors of integration explain."""
        n, size = len(self.system.coordinates), self.error_sizes()
        potential = frame["potential_energy"]
        moved = [frame["kinetic_energy"], potential - potential[0], frame["dissipated_energy"], frame["work"]]
        of_sizes = 0.5 * size[:n] @ self.loops(y[:n], p)[2] @ size[:n]
        energy = sum(float(each.abs().max()) for each in moved)
        change = (frame["energy_balance"] - frame["energy_balance"][0]).abs()
        # local errors of the tolerance add up to its root in as many steps
        allowed = np.sqrt(tolerance) * energy + tolerance * of_sizes + ROUNDING * float(potential.abs().max())
        if not (change <= allowed).all():
            first = int(np.argmax(~(change <= allowed)))
            raise DescriptionError(
                f"the motion of {self.system.name!r} is wrong from {frame['time'][first]:g} s at the latest: its energy balance has changed"
                f" by {change[first]:.3g} J, with {energy:.3g} J in motion; take a tolerance below {tolerance:g}, or a smaller `size` of"
                " the coordinates"
            )

    def check(self, y: Array, p: Array, tolerance: float = 1e-9) -> None:
        """Check that a start determines the motion.

        Raises:
            DescriptionError: accelerations are undetermined or lost in rounding, an output is not finite, or code and interpreter differ.
        """
        _, G, M = self.loops(y[: len(self.system.coordinates)], p)
        G, free = G[:, :-1], self.equations.free
        check_inertia(self.system, M, G)
        Watch(self, p, tolerance).begin(y)
        if len(free) < len(M):  # the matrices that the two forms solve
            given = [k for k in range(len(M)) if k not in free]
            B = np.eye(len(M))[:, free]
            B[given] = -np.linalg.solve(G[:, given], G[:, free])
            solved = B.T @ M @ B
        else:
            solved = M + np.trace(M) / max(float(np.sum(G**2)), 1e-300) * G.T @ G
        check_condition(self.system, solved, free, tolerance)
        x = self.input(0.0, y, p)
        self._rates.check(x)
        refuse_nan(list(self.equations.outputs), np.array(self._outputs(x)).ravel())

    def observe(self, times: Array, states: Array, p: Array, passages: Sequence[Passage] = ()) -> pd.DataFrame:
        """The outputs of states, shape (times, size of a state), each in its unit.

        During a passage they are interpolated, except those with forces of loops, which have a pole in the singular position.
        """
        rows, e = self._shown(times, states, p), self.equations
        for passage in passages:
            inside = (times > passage.times[0]) & (times < passage.times[-1])
            if np.any(inside):
                smooth = [k for k, (value, _) in enumerate(e.stated.values()) if not ca.depends_on(value, e.forces)]
                rows[np.ix_(inside, smooth)] = passage.between(self._shown(passage.times, passage.states, p)[:, smooth], times[inside])
                lost = np.abs(times - passage.singular) < LOST * (passage.times[-1] - passage.times[0])
                rows[np.ix_(inside & lost, [k for k in range(rows.shape[1]) if k not in smooth])] = np.nan
        frame = pd.DataFrame(np.column_stack([times, rows]), columns=list(self.units)) / [in_si(unit)[0] for unit in self.units.values()]
        frame.attrs["units"] = self.units
        frame.attrs["singular_positions"] = [passage.singular for passage in passages]
        return frame

    def _shown(self, times: Array, states: Array, p: Array) -> Array:
        """The outputs of states in SI, shape (times, outputs)."""
        return np.array(self._outputs(np.column_stack([self.input(t, y, p) for t, y in zip(times, states, strict=True)]))).T
