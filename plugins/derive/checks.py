"""Finds mistakes in a description, one sentence each: units that do not fit, coordinates without inertia, shapes that are alike."""

import warnings
from collections.abc import Sequence
from typing import Any, Final

import casadi as ca
import numpy as np

from quickreturn.plugins.derive.system import System, column
from quickreturn.plugins.derive.units import Array, DescriptionError, in_si

#: Other units of mass, length and time, in kg, m and s. No product of their small powers is 1, so a wrong unit always shows.
_OTHER: Final = (2.3, 1.7, 1.3)
#: Largest relative difference from rounding when an expression is measured in other units.
_ROUNDING: Final = 1e-7
#: Largest difference over the change that changed last digits make where terms cancel, as in the gap of a loop that is nearly closed.
_CANCELLED: Final = 1e3
#: Changes that are tried.
_SAMPLES: Final = 16
#: Smallest singular value of the normalised inertia and loops at which an acceleration counts as determined.
_SINGULAR: Final = 1e-12
#: Least part of a coordinate in an undetermined direction, over the largest, with which a message names it.
PART: Final = 0.1
#: Rounding of accelerations over the tolerance at which integrations still find their steps. Six to eight powers of x/L on a spinning
#: beam: at 90 and 220 they take the time of Legendre polynomials, at 400 ten times as long, at 900 they get stuck.
ROUNDED: Final = 500.0
#: Least and largest cosine of the angles between a beam's shapes and their fourth derivatives from which they are natural ones. Those of
#: natural_shapes: 0.74 to 1.0, with up to twelve; sets of polynomials contain squares or cubes, whose fourth derivative is zero.
NATURAL: Final = 0.7, 0.98
#: Error of the integrals along a beam, all shapes taking part alike, that is told. Natural shapes of a cantilever over one
#: cell of six points: 18 % with four of them, whose frequencies are right to 6e-5; 40 % with five, where the third frequency is off by
#: 0.8 %. With six the first one is off by 12 %.
COARSE: Final = 0.25


def check_units(system: System) -> None:
    """Evaluate all expressions of a description in two systems of units: each must change as its unit says.

    Raises:
        DescriptionError: an expression does not; the sentence names the first one.
    """
    symbols = _values(system)
    known = column(*(symbol for symbol, _, _ in symbols))
    for what, expression, _ in system.stated:
        if foreign := [s.name() for s in ca.symvar(expression) if not ca.depends_on(known, s)]:
            raise DescriptionError(
                f"the {what} of {system.name!r} contains {', '.join(map(repr, foreign))}, which this system did not declare; take constants"
                " and coordinates of the same System"
            )
    if ca.SX(system.gravity).numel() != 2:
        raise DescriptionError(f"the gravity of {system.name!r} is {system.gravity}; give two components, such as vector(0, -9.81)")
    evaluate = ca.Function("stated", [known], [column(*(ca.vec(e) for _, e, _ in system.stated))])
    here = np.array([value for _, value, _ in symbols])
    one, other = (np.array(evaluate(at)).ravel() for at in (here, here * [_factor(unit) for _, _, unit in symbols]))
    ends = np.cumsum([e.numel() for _, e, _ in system.stated])
    spread: Array | None = None
    for k, (what, expression, unit) in enumerate(system.stated):
        rows = slice(ends[k] - expression.numel(), ends[k])
        measured, scaled = other[rows], one[rows] * _factor(unit)
        away = np.abs(measured - scaled)
        if not np.any(away > _ROUNDING * np.max(np.abs([measured, scaled]), initial=0.0)):
            continue
        spread = _spread(evaluate, here) if spread is None else spread
        if np.any(away > _CANCELLED * spread[rows] * _factor(unit)):  # what is left is no rounding of terms that cancel
            raise DescriptionError(
                f"units do not fit: the {what} is not in {unit}; look for a sum or a function of different dimensions, or for a plain"
                " number: constants(NAME=(VALUE, UNIT)) gives it a unit"
            )


def _spread(evaluate: ca.Function, here: Array) -> Array:
    """The largest change of each output when the inputs change in their last digits."""
    changed = here[:, None] * (1.0 + np.finfo(float).eps * np.random.default_rng(0).uniform(-1.0, 1.0, (len(here), _SAMPLES)))
    return np.ptp(np.array(evaluate(changed)).reshape(-1, _SAMPLES), axis=1)


def check_points(system: System) -> None:
    """Warn of a beam with too few Gauss points for its shapes: twice as many change its integrals of squared deflection or curvature."""
    known, here, _ = zip(*_values(system), strict=True)
    for beam, few, many in system.integrals:
        one, other = (np.array(each).ravel() for each in ca.Function("integrals", [column(*known)], [few, many])(np.array(here)))
        error = float(np.max(np.abs(one - other) / np.maximum(np.abs(other), 1e-300), where=other != 0.0, initial=0.0))
        if error > COARSE:
            warnings.warn(
                f"the Gauss points of beam {beam!r} of {system.name!r} are too few for its shapes: integrals along it are off by"
                f" {100.0 * error:.2g} %; give more `points`, or more `edges`",
                stacklevel=4,
            )


def check_shear(system: System, beam: str, fields: Sequence[ca.SX], varies: bool) -> None:
    """Warn of a beam whose stiffness varies, or all of whose shapes are natural ones: their fourth derivatives are like the shapes.

    Args:
        system: the system that contains the beam.
        beam: name of the beam.
        fields: its field, and the second and the fourth derivative, at places along it.
        varies: whether its stiffness does, along it.
    """
    if varies:
        warnings.warn(
            f"the stiffness of beam {beam!r} of {system.name!r} varies along it: few shapes have the moment and the shear of a force only"
            " roughly, while deflections are right already; compare with more shapes",
            stacklevel=4,
        )
    known, here, _ = zip(*_values(system), strict=True)
    jacobians = [ca.densify(ca.jacobian(each, column(*(c.q for c in system.coordinates)))) for each in fields]
    shapes, bent, fourth = (np.array(each).T for each in ca.Function("shapes", [column(*known)], jacobians)(np.array(here)))
    pairs = [(one, other) for one, curved, other in zip(shapes, bent, fourth, strict=True) if np.any(curved)]
    alike = [abs(one @ other) / max(float(np.linalg.norm(one) * np.linalg.norm(other)), 1e-300) for one, other in pairs]
    if alike and min(alike) > NATURAL[0] and max(alike) > NATURAL[1]:
        warnings.warn(
            f"the shapes of beam {beam!r} of {system.name!r} are natural ones: they do not have the shear of a force on the beam; add its"
            " shape, such as (x / L)**2 * (3 - x / L) for one at a free end, or take Legendre polynomials",
            stacklevel=4,
        )


def check_inertia(system: System, M: Array, G: Array) -> None:
    """Check that the mass matrix (n, n) or the Jacobian of the loops (rows, n) determines every acceleration.

    Raises:
        DescriptionError: an acceleration is not determined; the sentence names its coordinate.
    """
    columns = np.vstack([M, G])
    sizes = np.linalg.norm(columns, axis=0)
    worst = int(np.argmin(sizes))
    if sizes[worst] > 0.0:
        _, singular, directions = np.linalg.svd(columns / sizes)
        shares = np.abs(directions[-1])
        # where more than two have a part in it, they are shapes that are nearly alike: see check_condition
        alike = np.sum(shares > PART * np.max(shares)) > 2
        worst = int(np.argmax(shares)) if singular[-1] < _SINGULAR and not alike else -1
    if worst >= 0:
        name = system.coordinates[worst].name
        raise DescriptionError(
            f"coordinate {name!r} of {system.name!r} has no inertia, and no loop holds it; give a body whose place or angle follows it, or"
            " a loop that determines it"
        )


def check_condition(system: System, solved: Array, indices: Sequence[int], tolerance: float) -> None:
    """Check that the matrix from which the accelerations follow leaves them more digits than the integration asks for.

    Args:
        system: the description.
        solved: the matrix, of the coordinates `indices`.
        indices: of coordinates.
        tolerance: of the integration.

    Raises:
        DescriptionError: rounding is too large; the sentence names the coordinates whose inertias are nearly alike.
    """
    if not len(indices):
        return
    size = np.sqrt(np.abs(np.diag(solved)))
    values, vectors = np.linalg.eigh(solved / np.outer(size, size))
    if values[0] < -_ROUNDING:
        worst = system.coordinates[indices[int(np.argmax(np.abs(vectors[:, 0])))]].name
        raise DescriptionError(f"the inertia of {worst!r} of {system.name!r} is negative; a mass or an inertia has the wrong sign")
    condition = values[-1] / max(values[0], np.finfo(float).eps)
    least = np.finfo(float).eps * condition / ROUNDED
    if least > tolerance > 0.0:
        shares = np.abs(vectors[:, 0])
        names = [repr(system.coordinates[k].name) for k, share in zip(indices, shares, strict=True) if share > PART * np.max(shares)]
        raise DescriptionError(
            f"the inertias of {', '.join(names)} of {system.name!r} are nearly alike (condition of the mass matrix {condition:.0e}):"
            f" rounding is in the way of a tolerance below {least:.0e}; take shapes that differ more, such as Legendre polynomials or"
            " natural_shapes"
        )


def _values(system: System) -> list[tuple[ca.SX, Any, str]]:
    """A value in SI for each symbol of a description, and its unit."""
    symbols = [(system.time, 0.113, "s"), *system.parameters.values()]
    for k, c in enumerate(system.coordinates):
        now = c.guess + 0.127 * c.size * (1.0 + 0.1 * k)
        symbols += [(c.q, now, c.unit), (c.v, 0.2 * c.size, f"({c.unit})/s"), (c.a, 0.3 * c.size, f"({c.unit})/s^2")]
        symbols += [(system.frozen[k], now, c.unit)] if k in system.frozen else []
    symbols += [(force, 1.0, f"J/({loop.by_unit})") for loop in system.loops for force in ca.vertsplit(loop.force)]
    for table in system.tables:
        middle = table.at(0.5 * (table.low + table.high))
        symbols += [(table.row[k], middle[k], unit) for k, unit in table.units.items()]
    return symbols


def _factor(unit: str) -> float:
    return float(np.prod(np.array(_OTHER) ** np.array(in_si(unit)[1])))
