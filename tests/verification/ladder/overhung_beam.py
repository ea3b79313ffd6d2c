"""Closed forms of the standing follower: a uniform beam, hinged at P with a base block, supported at the slider, tip body at the end.

Euler and Bernoulli's beam, small deflections; nothing here is used by an engine. Arc lengths x from P, slider at s, follower length L.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PPoly
from scipy.optimize import brentq

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism


@dataclass(frozen=True)
class Mode:
    """A natural vibration w(x) sin(2 pi f t) of unit modal mass, and the loads that it puts on the beam."""

    frequency: float  # f, Hz
    wave_number: float  # k of the beam's exact solutions, 1/m, from EI k^4 = rho A omega^2
    reaction: float  # of the slider, N
    tip_force: float  # on the beam's end by the tip body, N
    tip_moment: float  # the same, N m
    bending: float  # integral of (w - w'(0) x)^2 over the beam: what a damping relative to the base frame acts on, m/kg


def conditions(mechanism: Mechanism, s: float, frequency: float) -> Array:
    """Matrix (6, 6) of boundary and transition conditions of the two spans in their exact solutions; singular at a natural frequency.

    Span 1, x from P: w = A sin + B sinh + C (cos - cosh), which vanishes at P. Span 2, y from the slider towards the tip:
    w = D (cos - cosh) + E sin + F sinh, which vanishes at the slider. Unknowns A to F: w(s) = 0, moment at P, slope and moment at
    the slider, moment and shear at the tip. Each row is scaled by its largest entry.
    """
    beam, tip, omega = mechanism.follower, mechanism.tip_body, 2.0 * math.pi * frequency
    EI = beam.bending_stiffness
    k = (beam.mass_per_length * omega**2 / EI) ** 0.25
    m, J, e = tip.mass, tip.inertia, tip.center_of_mass
    at_slider = _span(k, k * s)[:, [1, 2, 0]]  # A sin, B sinh, C (cos - cosh)
    w, slope, curvature, third = _span(k, k * (beam.length - s))
    # the tip body: EI w'' = omega^2 (J w' + m e (w + e w')), EI w''' = -omega^2 m (w + e w')
    moment = EI * curvature - omega**2 * (J * slope + m * e * (w + e * slope))
    shear = EI * third + omega**2 * m * (w + e * slope)
    none = np.zeros(3)
    rows = np.array(
        [
            [*at_slider[0], *none],
            # EI w''(0) = -Jb omega^2 w'(0)
            [*([mechanism.base.inertia * omega**2 * k] * 2), -2.0 * EI * k**2, *none],
            [*at_slider[1], 0.0, -k, -k],
            [*at_slider[2], 2.0 * k**2, 0.0, 0.0],
            [*none, *moment],
            [*none, *shear],
        ]
    )
    return np.asarray(rows / np.abs(rows).max(axis=1, keepdims=True), dtype=np.float64)


def determinant(mechanism: Mechanism, s: float, frequency: float) -> float:
    """Of `conditions`: zero at a natural frequency, and only there."""
    return float(np.linalg.det(conditions(mechanism, s, frequency)))


def natural_modes(mechanism: Mechanism, s: float, count: int) -> list[Mode]:
    """The lowest `count` modes, slider standing at `s` (m); found by a scan fine enough to miss none and bisection."""
    beam = mechanism.follower
    unit = math.sqrt(beam.bending_stiffness / beam.mass_per_length) / beam.length**2 / (2.0 * math.pi)
    # the n-th frequency of a beam held at two points is below that of the clamped one, and neighbours differ by more than the first
    scan = unit * np.linspace(0.3, math.pi * (count + 1.0), 200 * (count + 1)) ** 2
    values = [determinant(mechanism, s, f) for f in scan]
    changes = np.flatnonzero(np.sign(values[1:]) != np.sign(values[:-1]))[:count]
    return [_mode(mechanism, s, brentq(lambda f: determinant(mechanism, s, f), scan[i], scan[i + 1], rtol=1e-14)) for i in changes]


def cubic_frequencies(mechanism: Mechanism, s: float) -> Array:
    """The two frequencies (Hz) of a follower that can only bend as one cubic, by Ritz' method with the cubics that vanish at P and s."""
    beam, tip = mechanism.follower, mechanism.tip_body
    x, weights = _gauss(0.0, beam.length)

    def shapes(at: Array, nu: int) -> Array:
        """The cubics x (x - s) and x^2 (x - s)."""
        return np.array([[at * (at - s), 2 * at - s, 2 + 0 * at][nu], [at**2 * (at - s), 3 * at**2 - 2 * at * s, 6 * at - 2 * s][nu]])

    w, bent, end = shapes(x, 0), shapes(x, 2), np.array([0.0, beam.length])
    slope = shapes(end, 1)
    centre = shapes(end, 0)[:, 1] + tip.center_of_mass * slope[:, 1]
    stiffness = beam.bending_stiffness * (bent * weights) @ bent.T
    mass = beam.mass_per_length * (w * weights) @ w.T + tip.mass * np.outer(centre, centre)
    mass += mechanism.base.inertia * np.outer(slope[:, 0], slope[:, 0]) + tip.inertia * np.outer(slope[:, 1], slope[:, 1])
    return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)) / (2.0 * math.pi)


@dataclass(frozen=True)
class Sag:
    """The follower at rest under its weight across the chord from P to the slider."""

    tip_deflection: float  # of x = L from the base tangent, m
    turn: float  # of the base tangent from the chord, rad
    curvatures: Array  # at the gauges, 1/m, shape (3,)
    slider_force: float  # on the follower, N
    shape: PPoly  # W(x) from the base tangent, m, with derivatives, in the form of a start (`engines.start.Field`)


def sag(mechanism: Mechanism, s: float, weight: float) -> Sag:
    """Of a follower whose weight (m/s^2, along b2) acts across it: EI w'' is the moment of what lies outboard.

    Uniform load q = rho A weight, tip weight at L + e, slider force at s.
    """
    beam, tip = mechanism.follower, mechanism.tip_body
    L, q, P, reach = beam.length, beam.mass_per_length * weight, tip.mass * weight, beam.length + tip.center_of_mass
    force = -(0.5 * q * L**2 + P * reach) / s  # moments about P

    # EI w'' as a polynomial in each span, highest power first: both loads' moments, and inboard that of the slider force
    outboard = np.polyadd(0.5 * q * np.polymul([-1.0, L], [-1.0, L]), P * np.array([-1.0, reach]))
    inboard = np.polyadd(outboard, force * np.array([-1.0, s]))
    shifted = [np.polyval(np.polyder(outboard, k), s) / math.factorial(k) for k in (2, 1, 0)]  # in powers of x - s
    shape = PPoly(np.column_stack([inboard, shifted]) / beam.bending_stiffness, [0.0, s, L]).antiderivative(2)
    return Sag(float(shape(L)), -float(shape(s)) / s, shape(np.array(beam.strain_gauges), 2), force, shape)


def cubic_sag(mechanism: Mechanism, s: float, weight: float) -> Sag:
    """The same of a follower that can only bend as one cubic: moments averaged with the curvatures 1 and x (Galerkin)."""
    exact = sag(mechanism, s, weight)
    beam, tip = mechanism.follower, mechanism.tip_body
    L, reach = beam.length, beam.length + tip.center_of_mass
    moments = np.zeros(2)
    for low, high in ((0.0, s), (s, L)):
        x, weights = _gauss(low, high)
        bending = 0.5 * beam.mass_per_length * weight * (L - x) ** 2 + tip.mass * weight * (reach - x)
        bending += exact.slider_force * np.maximum(0.0, s - x)
        moments += np.array([weights @ bending, weights @ (x * bending)])
    a, b = np.linalg.solve([[L, L**2 / 2], [L**2 / 2, L**3 / 3]], moments) / beam.bending_stiffness
    shape = PPoly(np.array([[b], [a]]), [0.0, L]).antiderivative(2)
    return Sag(float(shape(L)), -float(shape(s)) / s, shape(np.array(beam.strain_gauges), 2), exact.slider_force, shape)


def _mode(mechanism: Mechanism, s: float, frequency: float) -> Mode:
    beam, tip = mechanism.follower, mechanism.tip_body
    EI, L, omega = beam.bending_stiffness, beam.length, 2.0 * math.pi * frequency
    k = (beam.mass_per_length * omega**2 / EI) ** 0.25
    A, B, C, D, E, F = np.linalg.svd(conditions(mechanism, s, frequency))[2][-1]

    def shape(inboard: bool, x: Array) -> Array:
        span: Sequence[float] = (C, A, B) if inboard else (D, E, F)
        return np.asarray(np.array([_span(k, k * at) for at in x]) @ span, dtype=np.float64)  # (points, derivatives)

    (x, weights), (y, more) = _gauss(0.0, s), _gauss(0.0, L - s)
    base, end = shape(True, np.zeros(1))[0], shape(False, np.array([L - s]))[0]
    centre = end[0] + tip.center_of_mass * end[1]
    inboard, outboard = shape(True, x)[:, 0], shape(False, y)[:, 0]
    mass = beam.mass_per_length * (weights @ inboard**2 + more @ outboard**2)
    mass += mechanism.base.inertia * base[1] ** 2 + tip.mass * centre**2 + tip.inertia * end[1] ** 2
    jump = shape(False, np.zeros(1))[0, 3] - shape(True, np.array([s]))[0, 3]
    reaction, force, moment = EI * np.array([jump, end[3], end[2]]) / math.sqrt(mass)
    bending = (weights @ (inboard - base[1] * x) ** 2 + more @ (outboard - base[1] * (s + y)) ** 2) / mass
    return Mode(frequency, k, abs(float(reaction)), abs(float(force)), abs(float(moment)), float(bending))


def _span(k: float, a: float) -> Array:
    """Value and three derivatives with respect to x (rows) of cos - cosh, sin, sinh of a = k x."""
    sin, cos, sinh, cosh = math.sin(a), math.cos(a), math.sinh(a), math.cosh(a)
    rows = [[cos - cosh, sin, sinh], [-sin - sinh, cos, cosh], [-cos - cosh, -sin, sinh], [sin - sinh, -cos, cosh]]
    return np.array(rows) * (k ** np.arange(4.0))[:, None]


def _gauss(low: float, high: float) -> tuple[Array, Array]:
    points, weights = np.polynomial.legendre.leggauss(40)
    return low + 0.5 * (high - low) * (points + 1.0), 0.5 * (high - low) * weights
