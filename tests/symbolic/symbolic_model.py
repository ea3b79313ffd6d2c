"""The single-cubic model from positions and energies alone: an oracle that shares nothing with the package under test.

Only the places of the bodies, the energies and a dissipation function are written down; Lagrange's equations of the first kind do the
rest (sympy), in the coordinates q = (q1, q2, w, psi, s):

    q1   rad  crank angle, from n1
    q2   rad  follower angle: tangent at the base, from n1
    w    m    deflection of the flexible end x = L along b2
    psi  rad  slope W' there
    s    m    arc length of the slider from the pivot P

With `mu` the force of the slider on the follower (N, along n1 and n2) and the loop closed by phi(q) = 0 they read

    M q'' = f + G^T mu,    G q'' + gamma = 0,    G = d phi/dq,    gamma = (dG/dt) q'.

s is a coordinate of its own: without slider inertia its row of M vanishes and says that `mu` has no part along the follower.
The field is W = (3 (x/L)^2 - 2 (x/L)^3) w + L ((x/L)^3 - (x/L)^2) psi, a point stands at (x - F, W) in frame B with
F = 1/2 integral of W'^2 from 0 to x, and every tangent angle relative to b1 is W' itself.

Numbers are evaluated by mpmath with `DIGITS` digits and rounded at the very end, so that cancellation does not count.
"""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, TypedDict

import mpmath  # type: ignore[import-untyped]
import numpy as np
import sympy as sp
from numpy.typing import NDArray

#: Decimal digits of every evaluation.
DIGITS = 40

#: What `parameters` must hold, with units.
PARAMETERS = {
    "pivot_distance": "m, from O to P along n1",
    "crank_length": "m, from O to the slider",
    "crank_mass": "kg",
    "crank_center_of_mass": "m, from O",
    "crank_inertia": "kg m^2, about the centre of mass",
    "crank_torque": "N m",
    "crank_damping": "N m s/rad",
    "base_inertia": "kg m^2, about P",
    "base_damping": "N m s/rad",
    "length": "m",
    "mass_per_length": "kg/m",
    "bending_stiffness": "N m^2",
    "beam_damping": "N s/m^2, per unit length",
    "tip_mass": "kg",
    "tip_inertia": "kg m^2, about the centre of mass",
    "tip_center_of_mass": "m, beyond the flexible end",
    "slider_mass": "kg",
    "slider_inertia": "kg m^2",
    "gravity_1": "m/s^2, along n1",
    "gravity_2": "m/s^2, along n2",
    "force_1": "N, constant, on x = L, along n1",
    "force_2": "N, along n2",
}
#: What `state` must hold, with units.
STATE = {
    "crank_angle": "rad",
    "tip_deflection": "m",
    "tip_slope": "1",
    "crank_speed": "rad/s",
    "tip_deflection_rate": "m/s",
    "tip_slope_rate": "1/s",
}

Array = NDArray[np.float64]
FREE, DEPENDENT = (0, 2, 3), (1, 4)  # places of (q1, w, psi) and (q2, s) in q


class Evaluation(TypedDict):
    """Everything about one state; SI, rows and columns in the order (q1, q2, w, psi, s) unless said otherwise."""

    coordinates: Array  # (5,)
    rates: Array  # (5,)
    accelerations: Array  # (5,)
    mass_matrix: Array  # (5, 5)
    force: Array  # (5,) right-hand side f: applied and elastic forces, gravity, damping, less the velocity-dependent inertia forces
    constraint_jacobian: Array  # (2, 5), rows along n1 and n2
    constraint_bias: Array  # (2,) gamma, m/s^2
    multiplier: Array  # (2,) force of the slider on the follower along n1 and n2, N
    slider_force: float  # N, its part along the follower's normal (-W', 1 - W'^2/2)
    projected_mass_matrix: Array  # (3, 3) on the free speeds (q1', w', psi')
    projected_force: Array  # (3,) so that projected_mass_matrix @ (q1'', w'', psi'') = projected_force
    kinetic_energy: float  # J
    strain_energy: float  # J
    gravity_energy: float  # J, zero at O
    dissipated_power: float  # W, all dampings
    drive_power: float  # W, of the constant torque and the force on x = L
    tip_position: Array  # (2,) x = L from O, along n1 and n2, m
    tip_acceleration: Array  # (2,) absolute acceleration of x = L along n1 and n2, m/s^2


_Q = sp.symbols("q1 q2 w psi s", real=True)
_V = sp.symbols("q1' q2' w' psi' s'", real=True)
_P = {name: sp.Symbol(name, real=True) for name in PARAMETERS}


def _rate(expression: Any) -> Any:
    """Time derivative of an expression in coordinates (and rates, held constant)."""
    return sum((expression.diff(q) * v for q, v in zip(_Q, _V, strict=True)), start=0 * expression)


def _integral(integrand: Any, x: sp.Symbol, upper: Any) -> Any:
    """Exact integral from 0 to `upper` of a polynomial in x."""
    powers = sp.Poly(sp.expand(integrand), x).all_coeffs()[::-1]
    return sp.expand(sum(c * upper ** (k + 1) / (k + 1) for k, c in enumerate(powers)))


def _square(vector: sp.Matrix) -> Any:
    """Squared length, with the sines of q2 eliminated (only to keep the expression short)."""
    return sp.expand(sp.expand(vector.dot(vector)).subs(sp.sin(_Q[1]) ** 2, 1 - sp.cos(_Q[1]) ** 2))


def _direction(angle: Any) -> sp.Matrix:
    return sp.Matrix([sp.cos(angle), sp.sin(angle)])


@cache
def _compiled() -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Functions of (coordinates, rates, parameters): the loop alone, and everything else."""
    q1, q2, w, psi, s = _Q
    x = sp.Symbol("x", real=True)
    p, L = _P, _P["length"]
    rotation = sp.Matrix([[sp.cos(q2), -sp.sin(q2)], [sp.sin(q2), sp.cos(q2)]])
    pivot = sp.Matrix([p["pivot_distance"], 0])
    gravity = sp.Matrix([p["gravity_1"], p["gravity_2"]])

    deflection = sp.expand((3 * (x / L) ** 2 - 2 * (x / L) ** 3) * w + L * ((x / L) ** 3 - (x / L) ** 2) * psi)
    slope = sp.expand(deflection.diff(x))
    in_base = sp.Matrix([x - _integral(slope**2 / 2, x, x), deflection])
    at_tip, at_slider = in_base.subs(x, L).applyfunc(sp.expand), in_base.subs(x, s)
    slope_at_tip, slope_at_slider = sp.expand(slope.subs(x, L)), slope.subs(x, s)

    beam = pivot + rotation * in_base
    tip_end = pivot + rotation * at_tip
    tip = tip_end + rotation * p["tip_center_of_mass"] * _direction(slope_at_tip)
    crank = p["crank_center_of_mass"] * _direction(q1)
    coupler = p["crank_length"] * _direction(q1)
    loop = pivot + rotation * at_slider - coupler

    translating = [(p["tip_mass"], tip), (p["crank_mass"], crank), (p["slider_mass"], coupler)]
    rotating = [
        (p["crank_inertia"], q1),
        (p["base_inertia"], q2),
        (p["tip_inertia"], q2 + slope_at_tip),
        (p["slider_inertia"], q2 + slope_at_slider),
    ]
    kinetic = _integral(p["mass_per_length"] * _square(_rate(beam)) / 2, x, L)
    kinetic += sum(m * _square(_rate(r)) / 2 for m, r in translating) + sum(j * _rate(a) ** 2 / 2 for j, a in rotating)
    strain = _integral(p["bending_stiffness"] * slope.diff(x) ** 2 / 2, x, L)
    weight = -_integral(p["mass_per_length"] * beam.dot(gravity), x, L) - sum(m * r.dot(gravity) for m, r in translating)
    # Beam damping sees velocities relative to the base frame, so the dissipation function holds no rate of q2 for it.
    dissipation = _integral(p["beam_damping"] * _square(_rate(in_base)) / 2, x, L)
    dissipation += (p["crank_damping"] * _V[0] ** 2 + p["base_damping"] * _V[1] ** 2) / 2
    drive = p["crank_torque"] * _V[0] + _rate(tip_end).dot(sp.Matrix([p["force_1"], p["force_2"]]))

    momenta = [kinetic.diff(v) for v in _V]
    mass = sp.Matrix(5, 5, lambda i, j: momenta[i].diff(_V[j]))
    force = [
        drive.diff(v) - dissipation.diff(v) - (strain + weight).diff(q) + kinetic.diff(q) - _rate(momentum)
        for q, v, momentum in zip(_Q, _V, momenta, strict=True)
    ]
    jacobian = loop.jacobian(_Q)
    normal = rotation * sp.Matrix([-slope_at_slider, 1 - slope_at_slider**2 / 2])
    tip_jacobian = tip_end.jacobian(_Q)
    values = [
        mass,
        sp.Matrix(force),
        jacobian,
        _rate(_rate(loop)),
        normal,
        sp.Matrix([kinetic, strain, weight, 2 * dissipation, drive]),
        tip_end,
        tip_jacobian,
        _rate(_rate(tip_end)),
    ]
    arguments = (_Q, _V, tuple(p.values()))
    closing = sp.lambdify(arguments, [loop, jacobian[:, list(DEPENDENT)]], "mpmath", cse=True)
    return closing, sp.lambdify(arguments, values, "mpmath", cse=True)


def _close_loop(free: list[Any], parameters: list[Any], values: Mapping[str, float]) -> list[Any]:
    """Coordinates (5,) of the closed loop, q2 within 90 deg of 180 deg: Newton from the straight follower."""
    closing, _ = _compiled()
    towards = values["crank_length"] * mpmath.expj(free[0]) - values["pivot_distance"]
    q2, s = mpmath.arg(towards) % (2 * mpmath.pi), abs(towards)
    for _ in range(50):
        coordinates = [free[0], q2, free[1], free[2], s]
        gap, jacobian = closing(coordinates, [0] * 5, parameters)
        if mpmath.norm(gap) < mpmath.mpf(10) ** (5 - DIGITS) * values["length"]:
            return coordinates
        step = mpmath.lu_solve(jacobian, gap)
        q2, s = q2 - step[0], s - step[1]
    raise ValueError("the loop does not close")


def _array(values: Any) -> Array:
    return np.array(values.tolist(), dtype=float)


def evaluate(parameters: Mapping[str, float], state: Mapping[str, float]) -> Evaluation:
    """Everything that the model says about one state.

    Args:
        parameters: value in SI of every name in `PARAMETERS`; zero where a part is absent.
        state: value in SI of every name in `STATE`: the free coordinates and speeds. q2, s and their rates follow from the loop.

    Returns:
        See `Evaluation`; every number is correctly rounded to double precision or nearly so.

    Raises:
        KeyError: a name is missing.
        ValueError: the loop does not close.
    """
    with mpmath.workdps(DIGITS):
        constants = [mpmath.mpf(float(parameters[name])) for name in PARAMETERS]
        given = [mpmath.mpf(float(state[name])) for name in STATE]
        free_speeds = mpmath.matrix(given[3:])
        coordinates = _close_loop(given[:3], constants, parameters)
        jacobian = _compiled()[1](coordinates, [0] * 5, constants)[2]
        # q' = B u with the free speeds u, and G B = 0.
        dependent, independent = mpmath.matrix(2, 2), mpmath.matrix(2, 3)
        for row in range(2):
            for j, column in enumerate(DEPENDENT):
                dependent[row, j] = jacobian[row, column]
            for j, column in enumerate(FREE):
                independent[row, j] = jacobian[row, column]
        basis = _assemble(mpmath.eye(3), -(mpmath.inverse(dependent) * independent))
        rates = list(basis * free_speeds)
        mass, force, jacobian, bias, normal, scalars, tip, tip_jacobian, tip_bias = _compiled()[1](coordinates, rates, constants)

        system = mpmath.zeros(7)
        for i in range(5):
            for j in range(5):
                system[i, j] = mass[i, j]
            for k in range(2):
                system[i, 5 + k] = -jacobian[k, i]
                system[5 + k, i] = jacobian[k, i]
        solution = mpmath.lu_solve(system, mpmath.matrix([*force, *(-bias)]))
        accelerations, multiplier = solution[:5], solution[5:]

        offset = _assemble(mpmath.zeros(3, 1), -mpmath.lu_solve(dependent, bias))
        return Evaluation(
            coordinates=np.array(coordinates, dtype=float),
            rates=np.array(rates, dtype=float),
            accelerations=np.array(list(accelerations), dtype=float),
            mass_matrix=_array(mass),
            force=_array(force)[:, 0],
            constraint_jacobian=_array(jacobian),
            constraint_bias=_array(bias)[:, 0],
            multiplier=np.array(list(multiplier), dtype=float),
            slider_force=float(mpmath.fdot(multiplier, normal) / mpmath.norm(normal)),
            projected_mass_matrix=_array(basis.T * mass * basis),
            projected_force=_array(basis.T * (force - mass * offset))[:, 0],
            kinetic_energy=float(scalars[0]),
            strain_energy=float(scalars[1]),
            gravity_energy=float(scalars[2]),
            dissipated_power=float(scalars[3]),
            drive_power=float(scalars[4]),
            tip_position=_array(tip)[:, 0],
            tip_acceleration=_array(tip_jacobian * mpmath.matrix(accelerations) + tip_bias)[:, 0],
        )


def _assemble(free: Any, dependent: Any) -> Any:
    """Rows in the order of q from the rows of (q1, w, psi) and those of (q2, s)."""
    result = mpmath.matrix(5, free.cols)
    for rows, part in ((FREE, free), (DEPENDENT, dependent)):
        for i, row in enumerate(rows):
            for column in range(free.cols):
                result[row, column] = part[i, column]
    return result
