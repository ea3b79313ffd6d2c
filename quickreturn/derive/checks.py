"""Finds mistakes in a description, each named in one sentence: units that do not fit, coordinates without inertia."""

from typing import Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from quickreturn.derive.system import System, column
from quickreturn.derive.units import DescriptionError, in_si

#: Other units of mass, length and time, in kg, m and s. No product of their small powers is 1, so a wrong unit always shows.
_OTHER: Final = (2.3, 1.7, 1.3)
#: Largest relative difference from rounding when an expression is measured in other units.
_ROUNDING: Final = 1e-7
#: Smallest singular value of the normalised inertia and loops at which an acceleration counts as determined.
_SINGULAR: Final = 1e-12


def check_units(system: System) -> None:
    """Evaluate all expressions of a description in two systems of units: each must change as its unit says.

    Raises:
        DescriptionError: an expression does not; the sentence names the first one.
    """
    symbols = [(system.time, 0.1, "s"), *system.parameters.values()]
    for k, c in enumerate(system.coordinates):
        now = c.guess + 0.1 * c.size * (1.0 + 0.1 * k)
        symbols += [(c.q, now, c.unit), (c.v, 0.2 * c.size, f"({c.unit})/s"), (c.a, 0.3 * c.size, f"({c.unit})/s^2")]
        symbols += [(system.frozen[k], now, c.unit)] if k in system.frozen else []
    symbols += [(force, 1.0, f"J/({loop.unit})") for loop in system.loops for force in ca.vertsplit(loop.force)]
    for table in system.tables:
        middle = table.at(0.5 * (table.low + table.high))
        symbols += [(table.row[k], middle[k], unit) for k, unit in table.units.items()]
    evaluate = ca.Function("stated", [column(*(symbol for symbol, _, _ in symbols))], [column(*(ca.vec(e) for _, e, _ in system.stated))])
    here = np.array([value for _, value, _ in symbols])
    one, other = (np.array(evaluate(at)).ravel() for at in (here, here * [_factor(unit) for _, _, unit in symbols]))
    ends = np.cumsum([e.numel() for _, e, _ in system.stated])
    for (what, _, unit), measured, expected in zip(system.stated, np.split(other, ends), np.split(one, ends), strict=False):
        scaled = expected * _factor(unit)
        if np.any(np.abs(measured - scaled) > _ROUNDING * np.max(np.abs([measured, scaled]), initial=0.0)):
            raise DescriptionError(f"units do not fit: the {what} is not in {unit}; look for a sum or a function of different dimensions")


def check_inertia(system: System, M: NDArray[np.float64], G: NDArray[np.float64]) -> None:
    """Check that the mass matrix (n, n) or the Jacobian of the loops (rows, n) determines every acceleration.

    Raises:
        DescriptionError: an acceleration is not determined; the sentence names its coordinate.
    """
    columns = np.vstack([M, G])
    sizes = np.linalg.norm(columns, axis=0)
    worst = int(np.argmin(sizes))
    if sizes[worst] > 0.0:
        _, singular, directions = np.linalg.svd(columns / sizes)
        worst = int(np.argmax(np.abs(directions[-1]))) if singular[-1] < _SINGULAR else -1
    if worst >= 0:
        name = system.coordinates[worst].name
        raise DescriptionError(
            f"coordinate {name!r} of {system.name!r} has no inertia, and no loop holds it; give a body whose place or angle follows it, or"
            " a loop that determines it"
        )


def _factor(unit: str) -> float:
    return float(np.prod(np.array(_OTHER) ** np.array(in_si(unit)[1])))
