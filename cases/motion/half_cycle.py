"""A half cycle on the mechanism's own time scale: 240 instants, the modes' phases by the mechanism, and the channel's templates."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

from quickreturn.cases.motion.time_scale import TimeScale

Array = NDArray[np.float64]

SAMPLES = 240
PROGRESS = np.linspace(-1.0, 1.0, SAMPLES)  # time scaled to [-1, 1]
ROUND_OFF = 1e-12  # a signal that varies less than this, relative to its size, is constant


@dataclass(frozen=True)
class HalfCycle:
    """One half of a cycle, shared by its channels; arrays of shape (240,) unless stated."""

    time: Array  # s, uniform
    crank_angle: Array  # rad
    crank_speed: Array  # rad/s
    mean_frequencies: Array  # time means of f1, f2, f3 over the half, Hz, shape (3,)
    phases: Array  # theta_i = 2 pi times the integral of f_i, zero at the middle of their ranges, rad, shape (3, 240)
    drift: Array  # theta_1 less a phase of constant rate, zero at both ends, rad
    places: Array  # sigma_i = theta_i scaled to [-1, 1], shape (3, 240)


@dataclass(frozen=True)
class ChannelHalf:
    """One channel in a half cycle."""

    half: HalfCycle  # the half cycle
    signal: Array  # the channel minus its mean, in units of `unit`, shape (240,)
    unit: float  # RMS of the channel's deviation from its mean, in its own unit; 0 if it does not vary
    templates: Array  # response to the modes at constant action, shape (3, 240)
    quadrature: Array  # response to the first mode a quarter period late, in the template's unit, shape (240,)
    slow_shape: Array  # quasi-static response to the crank's motion, shape (240,)


@cache
def polynomials(degree: int) -> Array:
    """Legendre polynomials of `PROGRESS`, degrees 0 to `degree`, shape (240, degree + 1)."""
    return np.asarray(legendre.legvander(PROGRESS, degree), dtype=np.float64)


def half_cycle(scale: TimeScale, start: float, end: float, crank_angle: CubicSpline) -> HalfCycle:
    """The half cycle from `start` to `end` (s); `crank_angle` gives rad over time."""
    instants = np.linspace(start, end, SAMPLES)
    angles = crank_angle(instants)
    speeds = crank_angle(instants, 1)
    phases = 2.0 * np.pi * cumulative_simpson(scale.running_frequencies(angles, speeds).T, x=instants, initial=0.0)
    span = phases[:, -1:]
    phases = phases - span / 2.0
    return HalfCycle(
        time=instants,
        crank_angle=angles,
        crank_speed=speeds,
        mean_frequencies=span[:, 0] / (2.0 * np.pi * (end - start)),
        phases=phases,
        drift=phases[0] - span[0] / 2.0 * PROGRESS,
        places=phases / (span / 2.0),
    )


def channel_half(scale: TimeScale, half: HalfCycle, channel: str, signal: CubicSpline) -> ChannelHalf:
    """One channel in the half cycle; `signal` gives it over time."""
    values = signal(half.time)
    deviation = values - values.mean()
    unit = float(np.sqrt(np.mean(deviation**2)))
    constant = unit <= ROUND_OFF * np.abs(values).max()
    return ChannelHalf(
        half=half,
        signal=np.zeros(SAMPLES) if constant else deviation / unit,
        unit=0.0 if constant else unit,
        templates=scale.templates[channel](half.crank_angle).T,
        quadrature=scale.quadratures[channel](half.crank_angle) * half.crank_speed,
        slow_shape=scale.slow_shapes[channel](half.crank_angle),
    )
