"""Lagrange's equations by differences of energies: an oracle for the accelerations of the one beam, whatever its shapes and treatment.

Kinetic energy T and potential energy V of a state are asked of the model; what is tested is everything that the equations of motion do
with them. With momenta p = dT/du, which polarisation of the quadratic T gives exactly, and the power P that the dampings take,

    dp/dt - dT/dq + dV/dq + 1/2 dP/du = Q,

where Q holds the drive's torque and the slider's force. All derivatives by coordinates close the loop anew: the slider's place follows.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference_model.model import BeamModel
from reference_model.motion.equations import evaluate, kernel
from reference_model.motion.layout import BASE, MISSED

Array = NDArray[np.float64]

#: Step of the differences relative to the coordinates' sizes: order four leaves 1e-10 of smooth energies, rounding as much.
STEP = 1e-3


@dataclass
class Point:
    """A state of a model, its loop closed, and the rate that the model gives.

    Attributes:
        model: the model.
        y: the state.
        rate: dy/dt.
    """

    model: BeamModel
    y: Array
    rate: Array

    @property
    def m(self) -> int:
        """Number of speeds."""
        return self.model.parameters.speeds

    @property
    def acceleration(self) -> Array:
        """Of the speeds, shape (m,)."""
        return self.rate[self.m + 1 : 2 * self.m + 1]


def closed(model: BeamModel, y: Array) -> Array:
    """The state with the slider at the foot of the crank tip, or where the loop closes."""
    y, m = y.copy(), model.parameters.speeds
    if model.parameters.treatment == BASE:
        return y
    for _ in range(60):
        assert model.can_move(y)
        missed = float(model.workspace.facts[MISSED])
        y[m] += missed
        if abs(missed) < 1e-15:
            break
    return y


def point(model: BeamModel, y: Array) -> Point:
    """Close the loop and evaluate the equations."""
    y = closed(model, y)
    rate = np.empty_like(y)
    p, w = model._at
    assert evaluate(kernel(), p.address, w.address, y, rate)
    return Point(model, y, rate)


def _asked(model: BeamModel, q: Array, u: Array, like: Array) -> tuple[float, float, float]:
    """Kinetic and potential energy (J) and dissipated power (W) for coordinates and speeds."""
    m = model.parameters.speeds
    y = like.copy()
    y[:m], y[m + 1 : 2 * m + 1] = q, u
    y = closed(model, y)
    seen = model.observe(y[None])
    rate = np.empty_like(y)
    p, w = model._at
    assert evaluate(kernel(), p.address, w.address, y, rate)
    return float(seen["kinetic_energy"][0]), float(seen["strain_energy"][0] + seen["gravity_energy"][0]), float(rate[2 * m + 1])


def residual(at: Point) -> tuple[Array, Array]:
    """Left side of the equations less the drive's torque, for the free speeds: generalised forces of the slider; and its size, (m,)."""
    model, m = at.model, at.m
    q, u = at.y[:m], at.y[m + 1 : 2 * m + 1]
    p = model.parameters
    unit = np.eye(m)

    def momenta(q: Array, u: Array) -> Array:
        size = np.abs(u) + 1e-3
        return np.array(
            [
                (_asked(model, q, u + size[k] * unit[k], at.y)[0] - _asked(model, q, u - size[k] * unit[k], at.y)[0]) / (2 * size[k])
                for k in range(m)
            ]
        )

    # along the course of the model's own accelerations
    h = 2e-5
    before, after = (momenta(q + s * h * u + 0.5 * (s * h) ** 2 * at.acceleration, u + s * h * at.acceleration) for s in (-1.0, 1.0))
    wide = [momenta(q + s * h * u + 0.5 * (s * h) ** 2 * at.acceleration, u + s * h * at.acceleration) for s in (-2.0, 2.0)]
    change = (8.0 * (after - before) - (wide[1] - wide[0])) / (12.0 * h)
    parts = [change]
    by_place, by_speed = np.zeros(m), np.zeros(m)
    for k in range(p.first, m):
        step = STEP * (abs(q[k]) + 1e-3)

        def lagrangian(shift: float, k: int = k) -> float:
            kinetic, potential, _ = _asked(model, q + shift * unit[k], u, at.y)
            return kinetic - potential

        by_place[k] = fourth_order(lagrangian, step)
        rate = abs(u[k]) + 1e-3
        powers = [_asked(model, q, u + s * rate * unit[k], at.y)[2] for s in (-1.0, 1.0)]
        by_speed[k] = 0.5 * (powers[1] - powers[0]) / (2.0 * rate)
    parts += [-by_place, by_speed]
    total = sum(parts, np.zeros(m))
    total[0] -= p.torque
    return total, np.max(np.abs(parts), axis=0)


def fourth_order(function: Callable[[float], float], step: float) -> float:
    """Derivative at zero by differences of order four."""
    values = [function(s * step) for s in (-2.0, -1.0, 1.0, 2.0)]
    return (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * step)


def second_difference(function: Callable[[float], float], step: float) -> float:
    """Second derivative at zero by differences of order four."""
    values = [function(s * step) for s in (-2.0, -1.0, 0.0, 1.0, 2.0)]
    return (-values[0] + 16.0 * values[1] - 30.0 * values[2] + 16.0 * values[3] - values[4]) / (12.0 * step * step)


def course(at: Point, time: float) -> Array:
    """The state a little later (s), its loop closed: a parabola through place, speed and acceleration."""
    m, y = at.m, at.y.copy()
    q, u = at.y[:m], at.y[m + 1 : 2 * m + 1]
    y[:m], y[m + 1 : 2 * m + 1] = q + time * u + 0.5 * time * time * at.acceleration, u + time * at.acceleration
    return closed(at.model, y)


def angle_of_base(model: BeamModel, y: Array) -> float:
    """Tangent's angle at the base, rad, within 90 deg of 180 deg; evaluates the state."""
    from reference_model.motion.layout import COS_Q2, SIN_Q2

    assert model.can_move(y)
    facts = model.workspace.facts
    return math.pi + math.atan2(-float(facts[SIN_Q2]), -float(facts[COS_Q2]))
