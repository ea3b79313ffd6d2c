"""Half cycles with a known vibration, for measuring how far the measures can be trusted.

Slow part: the quasi-static response of the channel, modulated by up to 10 %, plus 4 % low harmonics of the crank and 2 % offset. First
mode: RMS times sqrt(2) a given ratio of the slow part's peak, at 0.85 to 1.12 times the mechanism's own frequency, with a drift
off by up to 6 % at the ends and an envelope that slopes by up to 50 %. Second and third mode: 15 % and 7.5 % of the first. Noise:
3 % of the signal's RMS, below 200 Hz. The crank's speed varies by up to 4 % within a turn.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_simpson

from quickreturn.cases.motion.time_scale import TimeScale
from quickreturn.reference_model.arrays import Array

SAMPLES = 481  # per half cycle, before the measures resample it
NOISE_LIMIT = 200.0  # Hz


@dataclass(frozen=True)
class SyntheticHalf:
    """A half cycle made to measure."""

    time: Array  # s, shape (481,)
    crank_angle: Array  # rad, shape (481,)
    signals: dict[str, Array]  # per channel, arbitrary unit, shape (481,)
    first_mode_frequency: float  # Hz, time mean over the half, of all channels
    first_mode_amplitudes: dict[str, float]  # per channel the RMS of the envelope over the half


@dataclass(frozen=True)
class _Course:
    """How a mode vibrates in all channels: frequency factor, relative drift and slope of the envelope at the ends, phase, drift scale."""

    factor: float
    drift: float
    slope: float
    start: float
    drift_scale: float = 1.0


def synthetic_half(
    scale: TimeScale,
    half: str,
    crank_speed: float,
    vibration: float,
    random: np.random.Generator,
    noise: float = 0.03,
    drift_scale: float = 1.0,
) -> SyntheticHalf:
    """Draw one half cycle, "pre" or "post".

    `vibration`: amplitude of the first mode over the slow part's peak; `noise`: its RMS over the signal's; `drift_scale`: how many times as
    far from its mean the first mode's frequency goes as the frozen crank's.
    """
    crank_angle = np.pi * (np.linspace(1.0, 2.0, SAMPLES) + (half == "post"))
    time = _time(crank_angle, crank_speed, random)
    uniform = np.linspace(time[0], time[-1], SAMPLES)
    crank_angle = np.interp(uniform, time, crank_angle)
    time = uniform

    def course(factor: float, drift: float, drift_scale: float = 1.0) -> _Course:
        return _Course(factor, drift, random.uniform(-0.5, 0.5), random.uniform(0.0, 2.0 * np.pi), drift_scale)

    first = course(random.uniform(0.85, 1.12), random.uniform(-0.06, 0.06), drift_scale)
    courses = {1.0: first, 0.15: course(random.uniform(0.9, 1.1), 0.0), 0.075: course(random.uniform(0.9, 1.1), 0.0)}
    modulation = 1.0 + random.uniform(-0.1, 0.1) * np.cos(crank_angle + random.uniform(0.0, 2.0 * np.pi))
    signals, amplitudes = {}, {}
    for channel in scale.channels:
        slow = _slow_part(scale, channel, crank_angle, modulation, random)
        amplitudes[channel] = vibration * np.abs(slow).max()
        signal = slow
        for mode, (share, one) in enumerate(courses.items()):
            oscillation, envelope = _mode(scale, channel, mode, time, crank_angle, one)
            signal = signal + share * amplitudes[channel] / np.sqrt(np.mean(envelope**2)) * oscillation
        signals[channel] = signal + noise * np.sqrt(np.mean(signal**2)) * _noise(time, random)
    speed = np.gradient(crank_angle, time)
    mean_frequency = np.trapezoid(scale.running_frequencies(crank_angle, speed)[:, 0], time) / (time[-1] - time[0])
    return SyntheticHalf(time, crank_angle, signals, first.factor * mean_frequency, amplitudes)


def _time(crank_angle: Array, crank_speed: float, random: np.random.Generator) -> Array:
    variation = random.uniform(0.0, 0.04) * np.cos(2.0 * crank_angle + random.uniform(0.0, 2.0 * np.pi))
    return np.asarray(cumulative_simpson(1.0 / (crank_speed * (1.0 + variation)), x=crank_angle, initial=0.0))


def _slow_part(scale: TimeScale, channel: str, crank_angle: Array, modulation: Array, random: np.random.Generator) -> Array:
    quasi_static = scale.slow_shapes[channel](crank_angle)
    peak = np.abs(quasi_static).max()
    orders = np.arange(1, 5)
    strengths = random.uniform(0.0, 1.0, orders.size)
    strengths *= 0.04 * peak / strengths.sum()
    harmonics = np.cos(orders * crank_angle[:, None] + random.uniform(0.0, 2.0 * np.pi, orders.size)) @ strengths
    return np.asarray(quasi_static * modulation + harmonics + 0.02 * peak * random.uniform(-1.0, 1.0))


def _mode(scale: TimeScale, channel: str, mode: int, time: Array, crank_angle: Array, course: _Course) -> tuple[Array, Array]:
    """Oscillation and envelope of one mode in a channel."""
    speed = np.gradient(crank_angle, time)
    rate = 2.0 * np.pi * scale.running_frequencies(crank_angle, speed)[:, mode]
    theta = cumulative_simpson(rate, x=time, initial=0.0)
    uniform = theta[-1] * (time - time[0]) / (time[-1] - time[0])
    sigma = 2.0 * theta / theta[-1] - 1.0
    # a rate of factor (1 + drift sigma) times the mechanism's own: its time mean is the factor times the mechanism's, exactly;
    # that of the drift from the mean is zero, however much it is scaled
    phase = course.factor * theta[-1] / 2.0 * (sigma + course.drift * sigma**2 / 2.0)
    phase += course.factor * (course.drift_scale - 1.0) * (theta - uniform) + course.start
    growth = 1.0 + course.slope * sigma
    envelope = scale.templates[channel](crank_angle)[:, mode] * growth
    oscillation = envelope * np.cos(phase)
    if mode == 0:
        oscillation += scale.quadratures[channel](crank_angle) * speed * growth * np.sin(phase)
    return np.asarray(oscillation), np.asarray(envelope)


def _noise(time: Array, random: np.random.Generator) -> Array:
    """White noise below 200 Hz, unit RMS."""
    step = (time[-1] - time[0]) / (time.size - 1)
    spectrum = np.fft.rfft(random.standard_normal(2 * time.size))
    spectrum[np.fft.rfftfreq(2 * time.size, step) > NOISE_LIMIT] = 0.0
    values = np.fft.irfft(spectrum, 2 * time.size)[: time.size]
    return np.asarray(values / np.sqrt(np.mean(values**2)))
