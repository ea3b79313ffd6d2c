"""The compiled equations of a system, as functions of numbers in SI units."""

import warnings
from collections.abc import Iterable, Mapping
from functools import cached_property
from numbers import Real
from typing import Any, Final

import casadi as ca
import numpy as np

from quickreturn.plugins.derive.checks import check_points, check_units
from quickreturn.plugins.derive.equations import Equations, Form
from quickreturn.plugins.derive.machine_code import MachineCode
from quickreturn.plugins.derive.system import System, column
from quickreturn.plugins.derive.units import Array, DescriptionError, in_si, told

#: Name of a parameter, a coordinate or a rate -> its value.
Values = Mapping[str, float]
#: Half the squared slope of a beam given by its deflection that is told. The end of a cantilever is off by that part: 10.5 % at 10.6 %.
STEEP: Final = 0.1


class CompiledEquations:
    """The rates of a system's state, and the terms of its equations.

    Args:
        system: the description.
        form: "projection" onto the free speeds, or "multipliers"; see `Equations`.
        feedback: 1/s; see `Equations`.

    Raises:
        DescriptionError: a mistake in the description.
    """

    @told("the equations")
    def __init__(self, system: System, form: Form = "projection", feedback: float = 100.0) -> None:
        check_units(system)
        check_points(system)
        self.system, self.equations = system, Equations(system, form, feedback)
        e, n = self.equations, len(system.coordinates)
        self.parameters = {name: value / in_si(unit)[0] for name, (_, value, unit) in system.parameters.items()}
        self.constants = column(*(symbol for symbol, _, _ in system.parameters.values()))
        self.inputs = column(system.time, e.state, self.constants, *(table.row for table in system.tables))
        rows = [table.row for table in system.tables]
        at = [column(system.time, e.q, self.constants, *rows)]
        self._jacobian = ca.Function("jacobian", at, [ca.densify(e.G)])
        self._matrices = ca.Function("matrices", at, [e.gap, e.G, e.M[:n, :n]])
        now = [column(*system.frozen.values())], [column(*(e.q[k] for k in system.frozen))]
        self._slopes = ca.Function("slopes", at, ca.substitute([column(*(ca.norm_inf(psi) for _, psi in system.slopes))], *now))
        self._levers = ca.Function("levers", at, [e.M[:n, :n], e.G[:, :n], e.C[:, :n]])
        self.units = {"time": "s"} | {name: unit for name, (_, unit) in e.outputs.items()}

    @cached_property
    def _rates(self) -> MachineCode:
        """The rates of a state. They are compiled for the first motion; a rest and small vibrations need none."""
        speeds = [self.system.coordinates[k].rate_name for k in self.equations.free]
        names = [*(c.rate_name for c in self.system.coordinates), *(f"rate of {name}" for name in speeds), "dissipated power", "power"]
        return MachineCode(self.inputs, self.equations.rates, names)

    @cached_property
    def _outputs(self) -> Any:
        """The outputs of a state as a CasADi function."""
        results = column(*(expression for expression, _ in self.equations.outputs.values()))
        return ca.Function("outputs", [self.inputs], [ca.densify(ca.cse(results))])

    def values(self, changed: Values | None) -> Array:
        """Values of all parameters in SI; `changed` gives other values, each in the parameter's unit."""
        self.refuse_unknown(changed or {}, "parameter", self.parameters)
        values = self.parameters | dict(changed or {})
        return np.array([values[name] * in_si(unit)[0] for name, (_, _, unit) in self.system.parameters.items()])

    def error_sizes(self) -> Array:
        """The scale of each state's error for small states; it is infinite for the two integrals of power, which are not controlled."""
        size = np.array([c.size for c in self.system.coordinates])
        return np.concatenate([size, size[self.equations.free], [np.inf, np.inf]])

    def rates(self, time: float, y: Array, p: Array) -> Array:
        """The rate dy/dt of a state."""
        return self._rates(self.input(time, y, p))

    def input(self, time: float, y: Array, p: Array) -> Array:
        """The values of all symbols of the equations, SI, in the order of `inputs`."""
        return np.concatenate([[time], y, p, *(table.at(y[table.index]) for table in self.system.tables)])

    def state(self, q: Array, v: Array) -> Array:
        """The state for all coordinates and rates, including those that the loops give."""
        return np.concatenate([q, v[self.equations.free], [0.0, 0.0]])

    def loops(self, q: Array, p: Array) -> tuple[Array, Array, Array]:
        """The gaps, their Jacobian and the mass matrix at time 0."""
        gap, G, M = (np.array(each) for each in self._matrices(self._place(0.0, q, p)))
        return gap.ravel(), G, M

    def check_slopes(self, times: Iterable[float], states: Array, p: Array) -> None:
        """Warn of beams that bend too far for their description, in states of which the first entries are the coordinates."""
        n = len(self.system.coordinates)
        at = np.column_stack([self._place(t, y[:n], p) for t, y in zip(times, states, strict=True)])
        for (beam, _), slope in zip(self.system.slopes, np.nan_to_num(np.array(self._slopes(at))).max(axis=1, initial=0.0), strict=True):
            if (error := 0.5 * slope**2) > STEEP:
                bent = f"beam {beam!r} of {self.system.name!r} has a slope of {slope:.2g}"
                told = f"{bent}: by its deflection alone its places are off by about {100.0 * error:.2g} %; give tangent="
                warnings.warn(told, stacklevel=4)

    def jacobian(self, time: float, q: Array, p: Array) -> Array:
        """The Jacobian of the loops by coordinates and time, shape (rows, n + 1)."""
        return np.array(self._jacobian(self._place(time, q, p)))

    def levers(self, time: float, q: Array, p: Array) -> tuple[float, float]:
        """How forces that act elsewhere move what they hold: a number that changes sign in a pole of the forces, and the distance to one.

        The number is the determinant of S = [A^T M A, -(C A)^T; G A, 0] in the motions A that the other loops allow. The distance is
        the smallest singular value of S. If nothing else moves, it is that of C A, or infinite where G A is nearer to losing rank.
        """
        M, G, C = (np.array(each) for each in self._levers(self._place(time, q, p)))
        sizes, rows = np.array([c.size for c in self.system.coordinates]), self.equations.elsewhere
        others = np.delete(G, rows, axis=0) * sizes
        A = sizes[:, None] * np.linalg.svd(others)[2][len(others) :].T
        held, moved = ((J @ A / np.maximum(np.linalg.norm(J * sizes, axis=1), 1e-300)[:, None]) for J in (G[rows], C[rows]))
        free, empty = A.T @ M @ A, np.zeros((len(rows), len(rows)))
        S = np.block([[free / max(np.trace(free), 1e-300), -moved.T], [held, empty]])
        distance, least, other = (float(np.linalg.svd(J)[1][-1]) for J in (S, moved, held))
        if A.shape[1] == len(rows):
            distance = least if least < other else np.inf
        return float(np.linalg.det(S)), distance

    def _place(self, time: float, q: Array, p: Array) -> Array:
        return np.concatenate([[time], q, p, *(table.at(q[table.index]) for table in self.system.tables)])

    def refuse_unknown(self, names: Iterable[str], what: str, known: Iterable[str]) -> None:
        """Raise DescriptionError for an unknown name, listing the known ones, or for a value that is no finite number."""
        accepted = list(known)
        for name in names:
            if name not in accepted:
                raise DescriptionError(f"{name!r} is no {what} of {self.system.name!r}; there are {', '.join(accepted)}")
            if isinstance(names, Mapping) and not (isinstance(names[name], Real) and np.isfinite(float(names[name]))):
                raise DescriptionError(f"{what} {name!r} of {self.system.name!r} is {names[name]!r}, which is no finite number")
