"""Mistakes in a description, each told in one sentence: units that do not fit, coordinates without inertia."""

from typing import Any, Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from quickreturn.derive.equations import Equations
from quickreturn.derive.system import System
from quickreturn.derive.units import DescriptionError, in_si

#: Other units of mass, length and time, in kg, m and s: no product of powers of these is 1.
_OTHER: Final = (2.3, 1.7, 1.3)
#: Largest relative difference that rounding leaves in an expression measured in other units.
_ROUNDING: Final = 1e-7
#: Smallest singular value of the normalised inertia and loops below which an acceleration is not determined.
_SINGULAR: Final = 1e-12


def check_units(system: System) -> None:
    """Measure the whole description in other units: an expression must change as its unit says.

    Raises:
        DescriptionError: names the first that does not.
    """
    rng = np.random.default_rng(0)
    known = [(system.time, 0.1, "s"), *system.parameters.values()]
    for c in system.coordinates:
        known += [(c.q, c.guess + 0.1 * c.size * rng.random(), c.unit)]
        known += [(symbol, 0.1 * c.size, f"({c.unit})/s**{power}") for power, symbol in enumerate((c.v, c.a), start=1)]
    known += [(force, 1.0, f"J/({loop.unit})") for loop in system.loops for force in ca.vertsplit(loop.force)]
    for table in system.tables:
        middle = table.at(0.5 * (table.low + table.high))
        known += [(table.row[k], middle[k], unit) for k, unit in table.units.items()]
    stated = [*system.stated, *((f"output {name!r}", e, unit) for name, (e, unit) in system.outputs.items())]
    known += [(symbol, *next((value, unit) for q, value, unit in known if q is system.coordinates[k].q)) for k, symbol in system.frozen.items()]
    symbols, values, units = zip(*known, strict=True)
    evaluate = ca.Function("stated", [ca.vertcat(*symbols)], [ca.vertcat(*(ca.vec(e) for _, e, _ in stated))])
    here = np.array(values)
    one, other = (np.array(evaluate(at)).ravel() for at in (here, here * [_factor(unit) for unit in units]))
    row = 0
    for what, expression, unit in stated:
        rows = slice(row, row + expression.numel())
        row = rows.stop
        expected, found = one[rows] * _factor(unit), other[rows]
        if np.any(np.abs(found - expected) > _ROUNDING * np.max(np.abs([one[rows], found, expected]), initial=0.0)):
            raise DescriptionError(f"units do not fit: the {what} is not in {unit}; look for a sum or a function of different dimensions")


def check_inertia(system: System, equations: Equations, matrices: Any, x: NDArray[np.float64]) -> None:
    """Every acceleration must be determined, by inertia or by loops.

    Raises:
        DescriptionError: names the coordinate that is not.
    """
    M, G = (np.array(each) for each in matrices(x))
    n = len(system.coordinates)
    columns = np.vstack([M[:n, :n], G[:, :n]])
    sizes = np.linalg.norm(columns, axis=0)
    worst = int(np.argmin(sizes))
    if sizes[worst] > 0.0 and np.all(np.isfinite(columns)):
        _, singular, directions = np.linalg.svd(columns / sizes)
        if singular[-1] > _SINGULAR:
            return
        worst = int(np.argmax(np.abs(directions[-1])))
    raise DescriptionError(
        f"coordinate {system.coordinates[worst].name!r} of {system.name!r} has no inertia and no loop that holds it: no body's place or angle"
        " follows it alone; give such a body, or a loop that determines it"
    )


def _factor(unit: str) -> float:
    return float(np.prod(np.array(_OTHER) ** np.array(in_si(unit)[1])))

