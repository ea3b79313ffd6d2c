"""Frequency and amplitude of the first mode in a half cycle, with uncertainties, or why it cannot be resolved."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.measures.drifting_fit import Bounds, Fit, first_mode_columns, orthonormal, refine, second_mode_columns, without
from cases.measures.half_cycle import ChannelHalf

Array = NDArray[np.float64]

SCAN = np.linspace(0.70, 1.35, 27)  # of alpha
SEPARATION = 0.08  # between the two scanned minima that are refined
MARGIN = 0.05  # of alpha beyond the scan
import os
KB=float(os.environ.get('KB','0.5'))
MAIN = Bounds(np.array([SCAN[0] - MARGIN, -2.5, -KB, -0.95, 0.75]), np.array([SCAN[-1] + MARGIN, 2.5, KB, 0.95, 1.45]))
ALPHA_ALONE = Bounds(np.array([SCAN[0] - MARGIN, 0.0, 0.0, 0.0, 0.75]), np.array([SCAN[-1] + MARGIN, 0.0, 0.0, 0.0, 1.45]))
DEGREE = 5  # of the slow part
IGNORED_VARIANT = 3.0  # times the main fit's residual

FREQUENCY_FLOOR = 0.008  # of the frequency
SLOW_PART_LEAKAGE = 0.015  # of the slow part's peak, in the amplitude
NEEDED_RISE = 5.0  # of the residual sum of squares without the oscillation
NEEDED_AMPLITUDE = 3.0  # times the residual RMS
GREATEST_FREQUENCY_UNCERTAINTY = 0.05  # of the frequency
GREATEST_AMPLITUDE_UNCERTAINTY = 1.0 / 3.0  # of the amplitude


@dataclass(frozen=True)
class FirstMode:
    """The fitted first mode of one channel in one half cycle; numbers are meaningful only where `reason` is empty.

    Attributes:
        frequency: Hz, time mean over the half.
        frequency_uncertainty: Hz, one standard deviation.
        amplitude: RMS of the envelope over the half, the channel's unit.
        amplitude_uncertainty: the same unit, one standard deviation.
        reason: which criteria failed, empty where the mode is resolvable.
        fit: the main fit; None where there is no signal at all.
    """

    frequency: float
    frequency_uncertainty: float
    amplitude: float
    amplitude_uncertainty: float
    reason: str
    fit: Fit | None


def fit_first_mode(channel: ChannelHalf) -> FirstMode:
    """Fit the drifting first mode as the definition of the measures has it."""
    if not channel.unit > 0.0:
        return FirstMode(np.nan, np.nan, np.nan, np.nan, "the signal is constant", None)
    slow = orthonormal(channel.half.polynomials(DEGREE))
    main = _best(channel, slow)
    alpha, amplitude = main.parameters[0], _amplitude(channel, main)
    statistical_alpha, statistical_amplitude = _statistical_uncertainty(channel, main, slow.shape[1])

    variants = [fit for fit in _variants(channel, main) if fit.residual_rms <= IGNORED_VARIANT * main.residual_rms]
    spread_alpha = _spread([fit.parameters[0] for fit in variants], alpha)
    spread_amplitude = _spread([_amplitude(channel, fit) for fit in variants], amplitude)

    relative = float(np.sqrt(statistical_alpha**2 + spread_alpha**2) / alpha)
    relative = float(np.hypot(relative, FREQUENCY_FLOOR))
    slow_peak = np.abs(slow @ (slow.T @ (channel.signal - _oscillation(channel, main)))).max()
    amplitude_uncertainty = float(np.sqrt(statistical_amplitude**2 + spread_amplitude**2 + (SLOW_PART_LEAKAGE * slow_peak) ** 2))

    reason = _why_not(channel, slow, main, amplitude, relative, amplitude_uncertainty)
    frequency = float(alpha * channel.half.mean_frequencies[0])
    return FirstMode(frequency, relative * frequency, amplitude * channel.unit, amplitude_uncertainty * channel.unit, reason, main)


def _best(channel: ChannelHalf, slow: Array) -> Fit:
    costs = _scan(channel, slow)
    best = int(np.argmin(costs))
    apart = np.abs(SCAN - SCAN[best]) >= SEPARATION - 1e-9
    second = int(np.argmin(np.where(apart, costs, np.inf)))
    fits = [refine(channel, slow, np.array([SCAN[index], 0.0, 0.0, 0.0, 1.0]), MAIN) for index in (best, second)]
    return min(fits, key=lambda fit: fit.cost)


def _scan(channel: ChannelHalf, slow: Array) -> Array:
    """Residual sum of squares for each scanned alpha without drift mismatch, shape (27,)."""
    basis = np.hstack([slow, orthonormal(without(slow, second_mode_columns(channel, 1.0)))])
    signal = without(basis, channel.signal)
    columns = np.stack([first_mode_columns(channel, alpha, 0.0, 0.0, 0.0) for alpha in SCAN])
    columns = columns - basis @ (basis.T @ columns)
    gram = np.swapaxes(columns, 1, 2) @ columns
    right = np.swapaxes(columns, 1, 2) @ signal
    return np.asarray(signal @ signal - np.sum(right * np.linalg.solve(gram, right[..., None])[..., 0], axis=1))


def _variants(channel: ChannelHalf, main: Fit) -> list[Fit]:
    half, start = channel.half, main.parameters
    with_slow_shape = np.column_stack([half.polynomials(DEGREE - 1), channel.slow_shape])
    return [
        refine(channel, orthonormal(half.polynomials(DEGREE - 1)), start, MAIN),
        refine(channel, orthonormal(half.polynomials(DEGREE + 1)), start, MAIN),
        refine(channel, orthonormal(half.polynomials(DEGREE)), start, ALPHA_ALONE),
        refine(channel, orthonormal(with_slow_shape), start, MAIN),
    ]


def _spread(values: list[float], main: float) -> float:
    """Greatest distance of a variant from the main fit."""
    return max((abs(value - main) for value in values), default=0.0)


def _envelope(channel: ChannelHalf, fit: Fit) -> Array:
    rho = fit.parameters[3]
    return np.abs(channel.templates[0] * (1.0 + rho * channel.half.places[0])) * np.hypot(fit.weights[0], fit.weights[1])


def _amplitude(channel: ChannelHalf, fit: Fit) -> float:
    return float(np.sqrt(np.mean(_envelope(channel, fit) ** 2)))


def _oscillation(channel: ChannelHalf, fit: Fit) -> Array:
    """First and second mode together, shape (240,)."""
    alpha, beta, kappa, rho, alpha2 = fit.parameters
    first, second = first_mode_columns(channel, alpha, beta, kappa, rho), second_mode_columns(channel, alpha2)
    return np.asarray(first @ fit.weights[:2] + second @ fit.weights[2:])


def _statistical_uncertainty(channel: ChannelHalf, fit: Fit, slow_terms: int) -> tuple[float, float]:
    """Standard deviations of alpha and of the amplitude from the residual and its correlation."""
    residual = fit.residual
    degrees_of_freedom = residual.size - slow_terms - fit.jacobian.shape[1]
    variance = float(residual @ residual) / degrees_of_freedom * _correlation_factor(residual)
    scale = np.linalg.norm(fit.jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    scaled = fit.jacobian / scale
    covariance = variance * np.linalg.pinv(scaled.T @ scaled, rcond=1e-12) / np.outer(scale, scale)

    a, b = fit.weights[:2]
    sigma, rho = channel.half.places[0], fit.parameters[3]
    weight = channel.templates[0] ** 2 * (1.0 + rho * sigma)
    amplitude = _amplitude(channel, fit)
    by_rho = (a**2 + b**2) * np.mean(weight * sigma) / amplitude
    by_weight = np.array([a, b]) * np.mean(weight * (1.0 + rho * sigma)) / amplitude
    gradient = np.zeros(11)
    gradient[[0, 1, 9]] = by_weight[0], by_weight[1], by_rho
    return float(np.sqrt(covariance[6, 6])), float(np.sqrt(gradient @ covariance @ gradient))


def _correlation_factor(residual: Array) -> float:
    """By how much correlation raises the variance of a mean: 1 + 2 sum of the autocorrelation up to its first zero."""
    size = 2 * residual.size
    autocovariance = np.fft.irfft(np.abs(np.fft.rfft(residual, size)) ** 2)[: residual.size // 4]
    if not autocovariance[0] > 0.0:
        return 1.0
    correlation = autocovariance / autocovariance[0]
    negative = np.flatnonzero(correlation <= 0.0)
    return float(1.0 + 2.0 * correlation[1 : negative[0] if negative.size else None].sum())


def _why_not(
    channel: ChannelHalf, slow: Array, main: Fit, amplitude: float, frequency_uncertainty: float, amplitude_uncertainty: float
) -> str:
    second = orthonormal(without(slow, second_mode_columns(channel, main.parameters[4])))
    left_out = without(second, without(slow, channel.signal))
    alpha = main.parameters[0]
    failed = []
    if not left_out @ left_out > NEEDED_RISE * (main.residual @ main.residual):
        failed.append(f"leaving the oscillation out raises the residual less than {NEEDED_RISE:g} times")
    if not amplitude > NEEDED_AMPLITUDE * main.residual_rms:
        failed.append(f"amplitude below {NEEDED_AMPLITUDE:g} times the residual")
    if not frequency_uncertainty < GREATEST_FREQUENCY_UNCERTAINTY:
        failed.append(f"frequency uncertain by more than {GREATEST_FREQUENCY_UNCERTAINTY:.0%}")
    if not amplitude_uncertainty < GREATEST_AMPLITUDE_UNCERTAINTY * amplitude:
        failed.append("amplitude uncertain by more than a third")
    if not MAIN.low[0] + 1e-6 < alpha < MAIN.high[0] - 1e-6:
        failed.append("frequency at the bounds of the search")
    return "; ".join(failed)
