"""Observables of the follower alone in its clamped modes, compiled (DERIVATION.md, section 14).

Curvature, and with it deflection and tip place, are recovered from equilibrium as in the models of the mechanism.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from reference_model.clamped_dynamics import ANGLE, END_TURN, RATE, base_torque, clamped_motion, cross, cumulate, dot
from reference_model.clamped_parameters import ClampedParameters, ClampedWorkspace
from reference_model.compilation import compiled, inlined

Array = NDArray[np.float64]

#: Columns of the output, in this order; `time` is added by the caller.
FOLLOWER_COLUMNS: Final = (
    "follower_angle",
    "tip_x",
    "tip_y",
    "tip_deflection",
    "tip_acceleration",
    "strain_1",
    "strain_2",
    "strain_3",
    "base_torque",
    "kinetic_energy",
    "strain_energy",
    "dissipated_energy",
    "gravity_energy",
    "drive_work",
)


@compiled
def observe_clamped(p: ClampedParameters, w: ClampedWorkspace, states: Array, out: Array) -> int:
    """Fill `out` (k, 14), columns as in `FOLLOWER_COLUMNS`, from `states` (k, 2 n + 4).

    Returns:
        Number of rows filled; less than k where a state cannot be evaluated.
    """
    n, end = p.n, len(p.x)
    for row in range(len(states)):
        y, o = states[row], out[row]
        if not clamped_motion(p, w, y):
            return row
        theta = w.facts[ANGLE]
        weight = complex(math.cos(theta), -math.sin(theta)) * complex(p.gravity_1, p.gravity_2)
        o[0] = theta
        o[4] = dot(1.0j * w.e[end], w.A[end] + weight)
        o[8] = base_torque(p, w)
        _energies(p, w, y, weight, o)
        o[11], o[13] = y[2 * n + 2], y[2 * n + 3]
        _recover(p, w, theta, o)
    return len(states)


@inlined
def _energies(p: ClampedParameters, w: ClampedWorkspace, y: Array, weight: complex, o: Array) -> None:
    """Kinetic, strain and gravity energy, as in equations 12.2 to 12.4."""
    n, end, rate = p.n, len(p.x), w.facts[RATE]
    center = w.z[end] + p.tip_offset * w.e[end]
    velocity = w.relative[end] + 1.0j * rate * w.z[end] + 1.0j * w.turn[end] * p.tip_offset * w.e[end]
    kinetic = 0.5 * (p.base_inertia * rate**2 + p.tip_mass * dot(velocity, velocity) + p.tip_inertia * w.turn[end] ** 2)
    gravity, strain = -p.tip_mass * dot(weight, center), 0.0
    for j in range(end):
        velocity = w.relative[j] + 1.0j * rate * w.z[j]
        kinetic += 0.5 * p.rhoA * p.weights[j] * dot(velocity, velocity)
        gravity -= p.rhoA * p.weights[j] * dot(weight, w.z[j])
    for i in range(n):
        strain += 0.5 * p.squares[i] * y[1 + i] ** 2
    o[9], o[10], o[12] = kinetic, strain, gravity


@inlined
def _recover(p: ClampedParameters, w: ClampedWorkspace, theta: float, o: Array) -> None:
    """Curvature from the loads outboard, then shape and tip place (equation 14.8)."""
    end = len(p.x)
    force, inboard, moments = w.integrand, w.V[0], w.relative  # what these held is spent
    center, tip_force = w.z[end] + p.tip_offset * w.e[end], -p.tip_mass * w.tip[0]
    for j in range(end):
        force[j] = -p.rhoA * w.A[j] - p.beam_damping * w.relative[j]
    cumulate(p, force, inboard)
    for j in range(end):
        force[j] = cross(w.z[j], force[j])
    cumulate(p, force, moments)
    total_force = inboard[end] + tip_force
    total_moment = moments[end].real + cross(center, tip_force) - p.tip_inertia * w.facts[END_TURN]
    for j in range(end):
        w.integrand[j] = (total_moment - moments[j].real - cross(w.z[j], total_force - inboard[j])) / p.EI
    for gauge in range(3):
        o[5 + gauge] = 0.5 * p.thickness * _curvature_at(p, w, p.gauges[gauge])
    cumulate(p, w.integrand, w.A)
    for j in range(end):
        w.integrand[j] = complex(math.cos(w.A[j].real), math.sin(w.A[j].real))
    cumulate(p, w.integrand, w.z)
    tip = complex(math.cos(theta), math.sin(theta)) * w.z[end]
    o[1], o[2], o[3] = tip.real, tip.imag, w.z[end].imag


@inlined
def _curvature_at(p: ClampedParameters, w: ClampedWorkspace, x: float) -> float:
    """The polynomial through the points, at x (Lagrange's form, barycentric)."""
    total = weight = 0.0
    for j in range(len(p.x)):
        if x == p.x[j]:
            return w.integrand[j].real
        share = p.barycentric[j] / (x - p.x[j])
        total += share * w.integrand[j].real
        weight += share
    return total / weight
