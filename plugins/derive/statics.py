"""Equilibrium, and small vibrations about a configuration at rest."""

import warnings
from collections.abc import Sequence
from typing import Any, Final, NamedTuple
from weakref import WeakKeyDictionary

import casadi as ca
import numpy as np
from scipy.linalg import eigh

from quickreturn.plugins.derive.checks import check_inertia
from quickreturn.plugins.derive.compiled import Values
from quickreturn.plugins.derive.model import Model
from quickreturn.plugins.derive.system import column
from quickreturn.plugins.derive.units import Array, DescriptionError, in_si

#: Distance from rest, over the size of a coordinate, from which frequencies are told to be those of no rest.
AWAY: Final = 0.1
#: Rounding of forces that cancel, over their sizes.
ROUNDING: Final = 1e-9
#: Smallest singular value of the loops and held coordinates, each of size 1, that counts as singular.
SINGULAR: Final = 1e-6
#: Largest number of Newton's steps, and so the farthest rest from a start, in sizes of a coordinate.
STEPS: Final = 1000


class Linear(NamedTuple):
    """M x'' + D x' + K x = 0 for small motions q = q0 + Z x that keep the loops closed, SI; x has m entries, q has n."""

    M: Array  # mass, shape (m, m)
    D: Array  # damping, shape (m, m)
    K: Array  # stiffness, shape (m, m)
    Z: Array  # shape (n, m)


class Rest(dict[str, float]):
    """Coordinates at rest, by name in their units: a start for a simulation.

    Attributes:
        outputs: all outputs at rest, by name in their units, forces of loops and energies among them; without forces that hold coordinates.
    """

    outputs: dict[str, float]


class Statics:
    """Forces of a system at rest, and how they change with its coordinates.

    Args:
        model: the compiled equations of the system.
        hold: names of coordinates that do not move.
        parameters: name -> changed value, in the parameter's unit.
    """

    def __init__(self, model: Model, hold: Sequence[str] = (), parameters: Values | None = None) -> None:
        names = [c.name for c in model.system.coordinates]
        model.refuse_unknown(hold, "coordinate", names)
        self._model, self._parameters, self._names = model, parameters, names
        self._held = [names.index(name) for name in hold]
        self._moving = [k for k in range(len(names)) if k not in self._held]
        if model not in _FUNCTIONS:
            _FUNCTIONS[model] = _functions(model)
        self._evaluate, self._outputs = _FUNCTIONS[model]

    def equilibrium(self, start: Values) -> Rest:
        """Coordinates and outputs at rest under the forces, found from a start by Newton's method.

        No step moves a coordinate by more than its declared size. A warning says when the rest
        bends a beam too far. It may be unstable: see `natural_frequencies`.

        Raises:
            DescriptionError: no equilibrium is found.
        """
        system, moving = self._model.system, self._moving
        q = self._model.start(start, self._parameters)[: len(self._names)]
        force = np.zeros(self._model.equations.gap.numel())
        sizes = np.array([system.coordinates[k].size for k in moving])
        for _ in range(STEPS):
            balance, gap, G, C, _, _, K = self._at(q, force)
            J = np.block([[-K[np.ix_(moving, moving)], C[:, moving].T], [G[:, moving], np.zeros((len(gap), len(gap)))]])
            lacking = np.concatenate([balance[moving], gap])
            step = np.linalg.lstsq(J, -lacking, rcond=None)[0]
            terms = np.abs(J) @ np.concatenate([sizes, np.abs(force)])
            if np.linalg.norm(J @ step + lacking) > 1e-6 * np.linalg.norm(lacking) + 1e-12 * np.linalg.norm(terms):
                break  # no displacement balances the forces
            longest = np.max(np.abs(step[: len(moving)]) / sizes, initial=0.0)
            step /= max(1.0, longest)  # full steps wander, and rounding decides where they end
            q[moving] += step[: len(moving)]
            force += step[len(moving) :]
            rounding = 1e-14 * np.abs(J) @ np.abs(np.concatenate([q[moving], force]))
            if longest < 1e-12 or np.all(np.abs(lacking) <= rounding):
                self._model.check_slopes([0.0], q[None], self._model.values(self._parameters))
                rest = Rest({c.name: float(q[k] / in_si(c.unit)[0]) for k, c in enumerate(system.coordinates)})
                values, stated = np.array(self._outputs(self._inputs(q, force))).ravel(), self._model.equations.stated
                rest.outputs = {name: float(x / in_si(unit)[0]) for x, (name, (_, unit)) in zip(values, stated.items(), strict=True)}
                return rest
        raise DescriptionError(f"no equilibrium of {system.name!r} is found from this start; give one that is nearer, or a spring")

    def linearised(self, at: Values) -> Linear:
        """Linear equations for small motions about a configuration at rest; the loops give its other coordinates.

        A warning says when forces would move it from there.

        Raises:
            DescriptionError: the position is singular, a loop repeats another, or a loop's force acts elsewhere.
        """
        small, moved = self.small(at)
        if moved:
            warnings.warn(moved, stacklevel=3)
        return small

    def small(self, at: Values) -> tuple[Linear, str]:
        """The same, and a sentence in place of the warning, empty if it is at rest there."""
        if names := [loop.name for loop in self._model.system.loops if loop.elsewhere]:
            raise DescriptionError(
                f"small motions of {self._model.system.name!r}: loops {names} act elsewhere than they hold; leave them out, and hold the"
                " coordinates instead"
            )
        q = self._model.start(at, self._parameters)[: len(self._names)]
        nothing = np.zeros(self._model.equations.gap.numel())
        balance, _, G, _, M, *_ = self._at(q, nothing)
        check_inertia(self._model.system, M, np.vstack([G, np.eye(len(q))[self._held]]))
        force = np.asarray(np.linalg.lstsq(G[:, self._moving].T, -balance[self._moving], rcond=None)[0], dtype=np.float64)
        pushed = balance
        balance, _, G, _, M, D, K = self._at(q, force)
        Z = self._possible(G)
        moved = self._moved(Z, Z.T @ K @ Z, Z.T @ balance, float(np.linalg.norm(Z.T @ np.abs(pushed))))
        return Linear(Z.T @ M @ Z, Z.T @ D @ Z, 0.5 * Z.T @ (K + K.T) @ Z, Z), moved

    def _moved(self, Z: Array, K: Array, balance: Array, pushed: float) -> str:
        """Tell of forces that are out of balance: they move a coordinate without end, or by more than AWAY of its size."""
        coordinates, shift = self._model.system.coordinates, np.linalg.lstsq(K, balance, rcond=1e-12)[0]
        endless = float(np.linalg.norm(balance - K @ shift)) > ROUNDING * pushed
        far = np.abs(Z @ (balance if endless else shift)) / np.array([c.size for c in coordinates])
        if not endless and np.max(far, initial=0.0) <= AWAY:
            return ""
        return (
            f"{self._model.system.name!r} is not at rest there: forces move {coordinates[int(np.argmax(far))].name!r}; vibrations are small"
            " about an equilibrium (Statics(model).equilibrium)"
        )

    def _possible(self, G: Array) -> Array:
        """The small motions that loops and held coordinates allow, as columns."""
        n, sizes = len(self._names), np.array([c.size for c in self._model.system.coordinates])
        A = np.vstack([G, np.eye(n)[self._held]]) * sizes
        norms = np.linalg.norm(A, axis=1, keepdims=True)
        _, singular, right = np.linalg.svd(A / np.where(norms > 0.0, norms, 1.0))
        if len(A) > n or np.min(singular, initial=1.0) < SINGULAR:
            raise DescriptionError(
                f"small motions of {self._model.system.name!r} are not determined: the position is singular, or a loop or a held coordinate"
                " repeats another; give a position beside it, or leave out what repeats"
            )
        return np.asarray(sizes[:, None] * right[len(A) :].T)

    def _at(self, q: Array, force: Array) -> list[Array]:
        """Balance, gaps, G, C, M, D and K."""
        values = self._evaluate(self._inputs(q, force))
        return [np.array(each).ravel() if k < 2 else np.array(each) for k, each in enumerate(values)]

    def _inputs(self, q: Array, force: Array) -> Array:
        rows = [t.at(q[t.index], slope) for t in self._model.system.tables for slope in (False, True)]
        constants = self._model.values(self._parameters)
        return np.concatenate([[0.0], q, q, np.zeros(len(q)), force, constants, *rows])


#: Each model's functions.
_FUNCTIONS: Final[WeakKeyDictionary[Model, tuple[Any, Any]]] = WeakKeyDictionary()


def _functions(model: Model) -> tuple[Any, Any]:
    """CasADi functions of a system at rest: balance of forces, gaps, G, C, M, D and K; and its outputs."""
    e, system, n = model.equations, model.system, len(model.system.coordinates)
    force, now = ca.SX.sym("force", e.gap.numel()), ca.SX.sym("now", n)
    M, Q, G, C, gap = e.M[:n, :n], e.Q[:n], e.G[:, :n], e.C[:, :n], e.gap
    # values of a table change with its coordinate
    moved = column(*(t.row + t.row_slope * (e.q[t.index] - now[t.index]) for t in system.tables))
    M, Q, G, C, gap = ca.substitute([M, Q, G, C, gap], [column(*(t.row for t in system.tables))], [moved])
    balance = Q + C.T @ force
    expressions = [balance, gap, G, C, M, -ca.jacobian(Q, e.v), -ca.jacobian(balance, e.q)]
    tables = [each for t in system.tables for each in (t.row, t.row_slope)]
    inputs = column(system.time, e.q, now, e.v, force, model.constants, *tables)
    still = [column(e.a, e.lost, e.done, e.forces)], [column(ca.SX.zeros(n + 2), force)]
    shown = ca.substitute([column(*(value for value, _ in e.stated.values()))], *still)
    return (
        ca.Function("statics", [inputs], [ca.densify(each) for each in expressions]),
        ca.Function("outputs", [inputs], [ca.densify(each) for each in shown]),
    )


def natural_frequencies(model: Model, at: Values, hold: Sequence[str] = (), parameters: Values | None = None) -> Array:
    """Undamped natural frequencies (Hz, ascending) of small vibrations about a configuration at rest; below zero: unstable.

    Args:
        model: the compiled equations of the system.
        at: coordinates by name; the others are zero, or follow from the loops.
        hold: names of coordinates that do not move.
        parameters: name -> changed value, in the parameter's unit.
    """
    small = Statics(model, hold, parameters).linearised(at)
    squares = eigh(small.K, small.M, eigvals_only=True)
    return np.sign(squares) * np.sqrt(np.abs(squares)) / (2.0 * np.pi)
