"""The linear model of a system from inputs to outputs about a rest: A, B, C and D with names and units."""

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca
import numpy as np
from scipy.linalg import block_diag, qr

from quickreturn.plugins.derive.compiled import Values
from quickreturn.plugins.derive.model import Model
from quickreturn.plugins.derive.singular import Watch
from quickreturn.plugins.derive.statics import Statics
from quickreturn.plugins.derive.system import column
from quickreturn.plugins.derive.units import Array, DescriptionError, in_si


class _Matrices(NamedTuple):
    A: Array
    B: Array
    C: Array
    D: Array


class StateSpace(_Matrices):
    """x' = A x + B u, y = C x + D u for small deviations from a rest: the tuple of A, B, C and D.

    Attributes:
        states: names of x, independent coordinates and then their rates.
        inputs: names of u.
        outputs: names of y.
        units: unit of each by name, as in the description; A, B, C and D are in these units and seconds.
    """

    states: list[str]
    inputs: list[str]
    outputs: list[str]
    units: dict[str, str]


def state_space(model: Model, at: Values, inputs: Sequence[str], outputs: Sequence[str], parameters: Values | None = None) -> StateSpace:
    """The linear model about a rest, from exact derivatives of the derived equations.

    Args:
        model: the compiled equations of the system.
        at: coordinates at rest by name; the others are zero, or follow from the loops.
        inputs: names of parameters that vary about their values: forces, torques, places that hold a spring.
        outputs: names of coordinates, rates, forces of loops and declared outputs.
        parameters: name -> changed value, in the parameter's unit.

    Raises:
        DescriptionError: an unknown name, no rest, a singular position, or a motion that is prescribed in time or by an input.
    """
    e, system = model.equations, model.system
    inputs, outputs = ([names] if isinstance(names, str) else list(names) for names in (inputs, outputs))
    _refuse(model, inputs, outputs)
    small, moved = Statics(model, (), parameters).small(at)
    if moved:
        raise DescriptionError(moved)
    p, q = model.values(parameters), model.start(at, parameters)[: len(small.Z)]
    rest = model.state(q, np.zeros(len(q)))
    Watch(model, p, rest)
    states, Z = _independent(model, small.Z)
    m = len(states)
    # what changes along each state and each input: time, coordinates, speeds, two integrals, parameters and rows of tables
    of_inputs = np.eye(len(p))[:, [list(system.parameters).index(name) for name in inputs]]
    rows = [np.outer(table.at(q[table.index], True), Z[table.index]) for table in system.tables]
    change = block_diag(np.zeros((1, 0)), Z, Z[e.free], np.zeros((2, 0)), of_inputs)
    change = np.vstack([change, *(np.pad(row, ((0, 0), (0, m + len(inputs)))) for row in rows)])
    along = ca.SX.sym("along", len(change))
    wanted = ca.jtimes(column(e.acceleration[states], *(e.outputs[name][0] for name in outputs)), model.inputs, along)
    slopes = np.array(ca.Function("slopes", [model.inputs, along], [ca.densify(wanted)])(model.input(0.0, rest, p), change))

    names = [system.coordinates[k].name for k in states] + [system.coordinates[k].rate_name for k in states]
    units = model.units | {name: unit for name, (_, _, unit) in system.parameters.items()}
    by, of = (np.array([in_si(units[name])[0] for name in (*names, *others)]) for others in (inputs, outputs))
    whole, k = np.vstack([np.eye(m, 2 * m + len(inputs), m), slopes]) * by / of[:, None], 2 * m
    found = StateSpace(whole[:k, :k], whole[:k, k:], whole[k:, :k], whole[k:, k:])
    found.states, found.inputs, found.outputs = names, inputs, outputs
    found.units = {name: units[name] for name in (*names, *inputs, *outputs)}
    return found


def _refuse(model: Model, inputs: Sequence[str], outputs: Sequence[str]) -> None:
    """Raise DescriptionError for unknown names, and for what moves something by itself: its own rate would be missing."""
    e, system = model.equations, model.system
    model.refuse_unknown(inputs, "parameter", model.parameters)
    first = [name for name, (value, _) in e.outputs.items() if not ca.depends_on(value, column(e.lost, e.done))]
    model.refuse_unknown(outputs, "output of small motions", first)
    parts = [*(part for points in system.points for part in points[1:]), *(angle for _, angle in system.turning)]
    moving = column(e.gap, *map(ca.vec, parts), *(ca.vec(on) for on, _ in system.dampers))
    for name, symbol in (("time", system.time), *((name, system.parameters[name][0]) for name in inputs)):
        if ca.depends_on(moving, symbol):
            raise DescriptionError(
                f"small motions of {system.name!r}: {name!r} moves a mass, a damper or a loop; an input may be a force, or move the end of"
                " a spring, and a motion prescribed in time has no rest"
            )


def _independent(model: Model, Z: Array) -> tuple[list[int], Array]:
    """Indices of independent coordinates, and the motions of all coordinates, shape (n, m), in which one of them moves by 1."""
    free, sizes = model.equations.free, np.array([c.size for c in model.system.coordinates])
    if len(free) > Z.shape[1]:
        free = sorted(qr((Z / sizes[:, None]).T, mode="r", pivoting=True)[1][: Z.shape[1]].tolist())
    return free, Z @ np.linalg.inv(Z[free])
