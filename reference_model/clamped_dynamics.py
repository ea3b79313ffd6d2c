"""Equations of motion of the follower alone in its clamped modes, compiled (DERIVATION.md, section 14).

State vector and its rate (equation 14.9), length 2 n + 4: t, eta (n), 1, etadot (n), dissipated energy, work of the drive. Time takes the
place of the crank angle in the state of the mechanism: it is the coordinate that is prescribed, and its rate is 1.
"""

import math

import numpy as np
from numpy.typing import NDArray

from reference_model.clamped_parameters import ClampedParameters, ClampedWorkspace
from reference_model.compilation import compiled, inlined
from reference_model.dynamics import factorize, substitute
from reference_model.spin_up import base_motion

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: Places of the base's motion in `ClampedWorkspace.facts`.
ANGLE, RATE, ACCELERATION, END_TURN = range(4)
#: Largest angle (rad) between a tangent and the base at which a state is accepted.
LARGEST_ANGLE = 2.0 * math.pi


@compiled
def dot(a: complex, b: complex) -> float:
    """Scalar product of planar vectors."""
    return a.real * b.real + a.imag * b.imag


@compiled
def cross(a: complex, b: complex) -> float:
    """Product a1 b2 - a2 b1 of planar vectors."""
    return a.real * b.imag - a.imag * b.real


@compiled
def cumulate(p: ClampedParameters, f: Complex, out: Complex) -> None:
    """Integrals from the base to every point of a function given at the points."""
    for k in range(len(out)):
        total = 0.0 + 0.0j
        for j in range(len(p.x)):
            total += p.to_points[j, k] * f[j]
        out[k] = total


@inlined
def _kinematics(p: ClampedParameters, w: ClampedWorkspace, y: Array) -> bool:
    """Places, partial velocities and remaining accelerations less gravity (equations 14.3 to 14.5)."""
    n, end = p.n, len(p.x)
    theta, rate, acceleration = base_motion(p.speed, p.time, y[0])
    w.facts[ANGLE], w.facts[RATE], w.facts[ACCELERATION] = theta, rate, acceleration
    for j in range(end + 1):
        angle, turn = 0.0, rate
        for i in range(n):
            angle += p.psi[i, j] * y[1 + i]
            turn += p.psi[i, j] * y[n + 2 + i]
        if not abs(angle) < LARGEST_ANGLE:
            return False
        w.angle[j], w.turn[j], w.e[j] = angle, turn, complex(math.cos(angle), math.sin(angle))
    cumulate(p, w.e, w.z)
    for j in range(end):
        w.integrand[j] = complex(-(w.turn[j] ** 2), acceleration) * w.e[j]
    cumulate(p, w.integrand, w.A)
    weight = complex(math.cos(theta), -math.sin(theta)) * complex(p.gravity_1, p.gravity_2)
    for j in range(end + 1):
        w.A[j] -= weight
        w.relative[j] = 0.0
    arm = p.tip_offset * w.e[end]
    w.tip[0] = w.A[end] + complex(-(w.turn[end] ** 2), acceleration) * arm
    for k in range(n):
        for j in range(end):
            w.integrand[j] = 1.0j * p.psi[k, j] * w.e[j]
        cumulate(p, w.integrand, w.V[k])
        w.T[k] = w.V[k, end] + 1.0j * p.psi[k, end] * arm
        for j in range(end + 1):
            w.relative[j] += y[n + 2 + k] * w.V[k, j]
    return True


@inlined
def _solve(p: ClampedParameters, w: ClampedWorkspace, y: Array) -> bool:
    """Mass matrix, forces and accelerations of the amplitudes (equation 14.6)."""
    n, end = p.n, len(p.x)
    for k in range(n):
        force = -p.squares[k] * y[1 + k] - p.tip_mass * dot(w.T[k], w.tip[0]) - p.tip_inertia * p.psi[k, end] * w.facts[ACCELERATION]
        for j in range(end):
            force -= p.weights[j] * dot(w.V[k, j], p.rhoA * w.A[j] + p.beam_damping * w.relative[j])
        w.acceleration[k] = force
        for m in range(k + 1):
            mass = p.tip_mass * dot(w.T[k], w.T[m]) + p.tip_inertia * p.psi[k, end] * p.psi[m, end]
            for j in range(end):
                mass += p.rhoA * p.weights[j] * dot(w.V[k, j], w.V[m, j])
            w.reduced[k, m] = mass
    if not factorize(w.reduced, n):
        return False
    substitute(w.reduced, w.acceleration, n)
    return True


@compiled
def clamped_motion(p: ClampedParameters, w: ClampedWorkspace, y: Array) -> bool:
    """Solve for the accelerations; leaves those of points, tip body and end in `w`. False where the state cannot be."""
    if not (_kinematics(p, w, y) and _solve(p, w, y)):
        return False
    n, end = p.n, len(p.x)
    w.facts[END_TURN] = w.facts[ACCELERATION]
    for k in range(n):
        w.tip[0] += w.acceleration[k] * w.T[k]
        w.facts[END_TURN] += w.acceleration[k] * p.psi[k, end]
        for j in range(end + 1):
            w.A[j] += w.acceleration[k] * w.V[k, j]
    return True


@compiled
def base_torque(p: ClampedParameters, w: ClampedWorkspace) -> float:
    """Torque that turns the base as prescribed, N m, after `clamped_motion` (equation 14.7)."""
    end = len(p.x)
    torque = p.base_inertia * w.facts[ACCELERATION] + p.base_damping * w.facts[RATE] + p.tip_inertia * w.facts[END_TURN]
    for j in range(end):
        torque += p.rhoA * p.weights[j] * cross(w.z[j], w.A[j])
    return torque + p.tip_mass * cross(w.z[end] + p.tip_offset * w.e[end], w.tip[0])


@compiled
def clamped_right_hand_side(p: ClampedParameters, w: ClampedWorkspace, y: Array, rate: Array) -> bool:
    """dy/dt, written to `rate`; False and all nan where the state cannot be (a rejected step)."""
    n = p.n
    if not clamped_motion(p, w, y):
        rate[:] = math.nan
        return False
    rate[0], rate[n + 1] = y[n + 1], 0.0
    power = p.base_damping * w.facts[RATE] ** 2
    for j in range(len(p.x)):
        power += p.beam_damping * p.weights[j] * dot(w.relative[j], w.relative[j])
    for i in range(n):
        rate[1 + i], rate[n + 2 + i] = y[n + 2 + i], w.acceleration[i]
    rate[2 * n + 2], rate[2 * n + 3] = power, base_torque(p, w) * w.facts[RATE]
    return True
