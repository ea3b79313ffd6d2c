"""Frequency and amplitude of the first mode in a half cycle, with uncertainties, or why it cannot be resolved.

Below it is the frequency of the second mode, for the few halves that clearly show one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from quickreturn.cases.motion.drifting_fit import Bounds, Fit, Problem, Waves, left_by, orthonormal, refined, without
from quickreturn.cases.motion.time_scale import SAMPLES, ChannelHalf, polynomials
from quickreturn.reference_model.arrays import Array

SCAN = np.linspace(0.70, 1.35, 27)  # values of alpha at which the fit is tried
SEPARATION = 0.08  # least difference of alpha between the two scanned minima that are refined
MARGIN = 0.05  # of alpha beyond the scan
LEAST_ALPHA, GREATEST_ALPHA = SCAN[0] - MARGIN, SCAN[-1] + MARGIN
MAIN = Bounds(np.array([LEAST_ALPHA, -2.5, 0.0, -0.95, 0.75]), np.array([GREATEST_ALPHA, 2.5, 0.0, 0.95, 1.45]))
FREE_DRIFT = Bounds(np.array([LEAST_ALPHA, -2.5, -0.6, -0.95, 0.75]), np.array([GREATEST_ALPHA, 2.5, 0.6, 0.95, 1.45]))
DEGREE = 5  # of the polynomial that is the slow part
IGNORED_VARIANT = 3.0  # ratio of residuals: a variant that leaves more than this times the main fit's is ignored

FREQUENCY_FLOOR = 0.003  # of the frequency: error of the mechanism's own path, from pure vibrations of six of the thesis' runs
#: Ratio of the true difference of alpha to that in the fit with free drift, whose prior reduces the drift to 0.54 of the true one if
#: vibration is 0.3 of the slow part, and to 0.84 if it is as large.
DRIFT_HELD_BACK = 1.3
SLOW_PART_LEAKAGE = 0.015  # error of the amplitude, as a part of the slow part's peak
NEEDED_RISE = 5.0  # least ratio of the residual sums of squares without and with the oscillation
NEEDED_AMPLITUDE = 3.0  # least ratio of the amplitude to the residual's RMS
#: Relative uncertainty of the amplitude beyond which there may be no vibration, but a slow part of another shape. On pure slow signals it
#: is 1.03 to 1.05.
UNCERTAIN_PRESENCE = 0.6  # of the amplitude
GREATEST_FREQUENCY_UNCERTAINTY = 0.05  # of the frequency
#: The same limit if the amplitude is not resolvable: vibration of 0.03 of the slow part would otherwise be found twice as often.
GREATEST_WITHOUT_AMPLITUDE = 0.04
GREATEST_AMPLITUDE_UNCERTAINTY = 1.0 / 3.0  # of the amplitude


@dataclass(frozen=True)
class FirstMode:
    """The first mode of one channel in one half cycle; a number that is not resolvable is None, with its uncertainty."""

    reason: str  # which of the two is missing and which criteria failed, empty if both are there
    fit: Fit | None = None  # the main fit; None where there is no signal at all
    frequency: float | None = None  # Hz, time mean over the half
    frequency_uncertainty: float | None = None  # Hz, one standard deviation
    amplitude: float | None = None  # RMS of the envelope over the half, the channel's unit
    amplitude_uncertainty: float | None = None  # the same unit, one standard deviation
    variation: float = 0.0  # RMS of the signal less its mean, the channel's unit
    frequency_gain: float | None = None  # largest relative change of the frequency over the RMS change of the signal over `variation`
    amplitude_gain: float | None = None  # the same of the amplitude


@dataclass(frozen=True)
class _Estimate:
    """The estimate from one channel; frequencies in units of alpha, amplitudes in units of the signal's RMS."""

    alpha: float  # factor on the mechanism's own frequency
    alpha_uncertainty: float  # relative, without the part that is due to the drift
    drift_distance: float  # relative difference of alpha in the fit with free drift
    amplitude: float  # RMS of the envelope
    amplitude_uncertainty: float  # one standard deviation
    gains: tuple[float, float]  # of frequency and amplitude, see `FirstMode`
    doubts: tuple[str, ...]  # reasons why there may be no first mode
    fit: Fit  # the main one


def fit_first_modes(halves: Sequence[Mapping[str, ChannelHalf]]) -> list[dict[str, FirstMode]]:
    """Fit the drifting first mode in the channels of each half cycle.

    The main fit takes the path of the frequency from the mechanism. If that path drifted 1.3 times as much, frequencies would be 3 % off in
    the mean, in all channels alike. A fit with free drift shows this, but is twice as uncertain: its distance from the main fit is a part
    of the uncertainty. As the channels of a half share the path, the root mean square of this distance over the channels with a first mode
    is used for all of them.
    """
    vibrating = [(half, name) for half, channels in enumerate(halves) for name, channel in channels.items() if channel.unit > 0.0]
    estimates = dict(zip(vibrating, _estimates([halves[half][name] for half, name in vibrating]), strict=True))
    return [
        _first_modes_of_half(channels, {name: estimates[half, name] for name in channels if (half, name) in estimates})
        for half, channels in enumerate(halves)
    ]


def _first_modes_of_half(channels: Mapping[str, ChannelHalf], estimates: Mapping[str, _Estimate]) -> dict[str, FirstMode]:
    """The first modes of a half's channels from all their estimates."""
    seen = [estimate for estimate in estimates.values() if not estimate.doubts]
    weights = np.array([estimate.alpha_uncertainty**-2.0 for estimate in seen])
    shared = float(np.sqrt(weights @ np.array([estimate.drift_distance**2 for estimate in seen]) / weights.sum())) if seen else 0.0
    constant = FirstMode("the signal is constant")
    return {
        name: _resolved(channel, estimates[name], float(np.hypot(estimates[name].alpha_uncertainty, DRIFT_HELD_BACK * shared)))
        if name in estimates
        else constant
        for name, channel in channels.items()
    }


def _estimates(channels: Sequence[ChannelHalf]) -> list[_Estimate]:
    """The estimate of each channel: from the best fit, one with free drift, and three with other slow parts."""
    if not channels:
        return []
    slow, less, more = (orthonormal(polynomials(degree)) for degree in (DEGREE, DEGREE - 1, DEGREE + 1))
    best = _best(channels, slow)
    variants = []
    for channel, main in zip(channels, best, strict=True):
        other_slow_parts = (less, more, orthonormal(np.column_stack([less, channel.slow_shape])))
        variants.append(Problem(channel, slow, main.parameters, FREE_DRIFT))
        variants += [Problem(channel, others, main.parameters, MAIN) for others in other_slow_parts]
    fits = refined(variants)
    fits_of_channels = (fits[at : at + 4] for at in range(0, len(fits), 4))
    return [_estimate(channel, slow, main, others) for channel, main, others in zip(channels, best, fits_of_channels, strict=True)]


def _estimate(channel: ChannelHalf, slow: Array, main: Fit, others: Sequence[Fit]) -> _Estimate:
    """The estimate of a channel from its fits; `others`: with free drift, then with other slow parts."""
    free_drift, *variants = others
    alpha, amplitude = main.parameters[0], _amplitude(channel, main)
    by_noise = _responses(channel, main)
    statistical_alpha, statistical_amplitude = np.sqrt(_variance(main, slow.shape[1])) * by_noise
    variants = [fit for fit in variants if fit.residual_rms <= IGNORED_VARIANT * main.residual_rms]
    spread_alpha = _spread([fit.parameters[0] for fit in variants], alpha)
    spread_amplitude = _spread([_amplitude(channel, fit) for fit in (*variants, free_drift)], amplitude)
    slow_peak = np.abs(slow @ (slow.T @ (channel.signal - _oscillation(channel, main)))).max()
    uncertain = float(np.sqrt(statistical_amplitude**2 + spread_amplitude**2 + (SLOW_PART_LEAKAGE * slow_peak) ** 2))
    return _Estimate(
        alpha=alpha,
        alpha_uncertainty=float(np.hypot(np.hypot(statistical_alpha, spread_alpha) / alpha, FREQUENCY_FLOOR)),
        drift_distance=abs(free_drift.parameters[0] / alpha - 1.0),
        amplitude=amplitude,
        amplitude_uncertainty=uncertain,
        gains=(float(np.sqrt(SAMPLES) * by_noise[0] / alpha), float(np.sqrt(SAMPLES) * by_noise[1] / amplitude) if amplitude else 0.0),
        doubts=_doubts(channel, slow, main, amplitude, uncertain),
        fit=main,
    )


def _resolved(channel: ChannelHalf, estimate: _Estimate, uncertainty: float) -> FirstMode:
    """Judge frequency, with its relative uncertainty, and amplitude, each by itself."""
    if estimate.doubts:
        return FirstMode(f"no frequency, no amplitude: {'; '.join(estimate.doubts)}", estimate.fit, variation=channel.unit)
    reasons, limit = [], GREATEST_FREQUENCY_UNCERTAINTY
    numbers: dict[str, float] = {"variation": channel.unit}
    if estimate.amplitude_uncertainty < GREATEST_AMPLITUDE_UNCERTAINTY * estimate.amplitude:
        numbers |= {"amplitude": estimate.amplitude * channel.unit, "amplitude_uncertainty": estimate.amplitude_uncertainty * channel.unit}
        numbers["amplitude_gain"] = estimate.gains[1]
    else:
        limit = GREATEST_WITHOUT_AMPLITUDE
        reasons.append("no amplitude: uncertain by more than a third")
    if uncertainty < limit:
        frequency = float(estimate.alpha * channel.half.mean_frequencies[0])
        numbers |= {"frequency": frequency, "frequency_uncertainty": uncertainty * frequency, "frequency_gain": estimate.gains[0]}
    else:
        reasons.insert(0, f"no frequency: uncertain by more than {limit:.0%}")
    return FirstMode("; ".join(reasons), estimate.fit, **numbers)


def _best(channels: Sequence[ChannelHalf], slow: Array) -> list[Fit]:
    """The better of two fits of each channel, which begin at the two best frequencies of the scan."""
    problems = []
    for channel in channels:
        costs = _scan(channel, slow)
        best = int(np.argmin(costs))
        apart = np.abs(SCAN - SCAN[best]) >= SEPARATION - 1e-9
        second = int(np.argmin(np.where(apart, costs, np.inf)))
        problems += [Problem(channel, slow, np.array([SCAN[at], 0.0, 0.0, 0.0, 1.0]), MAIN) for at in (best, second)]
    fits = refined(problems)
    return [min(pair, key=lambda fit: fit.cost) for pair in zip(fits[::2], fits[1::2], strict=True)]


def _scan(channel: ChannelHalf, slow: Array) -> Array:
    """Residual sum of squares for each scanned alpha without drift mismatch, shape (27,)."""
    waves = Waves.of(channel)
    basis = np.hstack([slow, orthonormal(without(slow, waves.second_mode(1.0)))])
    signal = _signal_without(basis, channel)
    return left_by(without(basis, waves.first_mode(SCAN)), signal)


def _signal_without(basis: Array, channel: ChannelHalf) -> Array:
    return without(basis, channel.signal[:, None])[:, 0]


def _spread(values: list[float], main: float) -> float:
    """Greatest distance of a variant from the main fit."""
    return max((abs(value - main) for value in values), default=0.0)


def _amplitude(channel: ChannelHalf, fit: Fit) -> float:
    """RMS of the envelope."""
    rho = fit.parameters[3]
    envelope = np.abs(channel.templates[0] * (1.0 + rho * channel.half.places[0])) * np.hypot(fit.weights[0], fit.weights[1])
    return float(np.sqrt(np.mean(envelope**2)))


def _oscillation(channel: ChannelHalf, fit: Fit) -> Array:
    """First and second mode together, shape (240,)."""
    alpha, beta, kappa, rho, alpha2 = fit.parameters
    waves = Waves.of(channel)
    return np.asarray(waves.first_mode(alpha, beta, kappa, rho) @ fit.weights[:2] + waves.second_mode(alpha2) @ fit.weights[2:])


def _variance(fit: Fit, slow_terms: int) -> float:
    """Variance of the noise by the residual; its correlation counts as more of it."""
    residual = fit.residual
    degrees_of_freedom = residual.size - slow_terms - 6 - np.count_nonzero(MAIN.free)
    return float(residual @ residual) / degrees_of_freedom * _correlation_factor(residual)


def _responses(channel: ChannelHalf, fit: Fit) -> Array:
    """Standard deviations of alpha and of the amplitude, in units of the signal's RMS, by independent noise of variance 1, shape (2,).

    They are also the norms of their derivatives by the signal's 240 values.
    """
    covariance = fit.covariance(1.0, MAIN)
    a, b = fit.weights[:2]
    sigma, rho = channel.half.places[0], fit.parameters[3]
    weight = channel.templates[0] ** 2 * (1.0 + rho * sigma)
    amplitude = _amplitude(channel, fit)
    by_rho = (a**2 + b**2) * np.mean(weight * sigma) / amplitude
    by_weight = np.array([a, b]) * np.mean(weight * (1.0 + rho * sigma)) / amplitude
    gradient = np.zeros(11)
    gradient[[0, 1, 9]] = by_weight[0], by_weight[1], by_rho
    return np.sqrt([covariance[6, 6], gradient @ covariance @ gradient])


def _correlation_factor(residual: Array) -> float:
    """Factor by which correlation raises the variance of a mean: 1 + 2 sum of the autocorrelation up to its first zero."""
    size = 2 * residual.size
    autocovariance = np.fft.irfft(np.abs(np.fft.rfft(residual, size)) ** 2)[: residual.size // 4]
    if not autocovariance[0] > 0.0:
        return 1.0
    correlation = autocovariance / autocovariance[0]
    negative = np.flatnonzero(correlation <= 0.0)
    return float(1.0 + 2.0 * correlation[1 : negative[0] if negative.size else None].sum())


def _doubts(channel: ChannelHalf, slow: Array, main: Fit, amplitude: float, amplitude_uncertainty: float) -> tuple[str, ...]:
    """Reasons why there may be no first mode; none if it stands out."""
    second = orthonormal(without(slow, Waves.of(channel).second_mode(main.parameters[4])))
    left_out = _signal_without(np.hstack([slow, second]), channel)
    failed = []
    if not left_out @ left_out > NEEDED_RISE * (main.residual @ main.residual):
        failed.append(f"leaving the oscillation out raises the residual less than {NEEDED_RISE:g} times")
    if not amplitude > NEEDED_AMPLITUDE * main.residual_rms:
        failed.append(f"amplitude below {NEEDED_AMPLITUDE:g} times the residual")
    if not amplitude_uncertainty < UNCERTAIN_PRESENCE * amplitude:
        failed.append(f"amplitude uncertain by more than {UNCERTAIN_PRESENCE:.0%}")
    if not LEAST_ALPHA + 1e-6 < main.parameters[0] < GREATEST_ALPHA - 1e-6:
        failed.append("frequency at the bounds of the search")
    return tuple(failed)


SECOND_DEGREE = 9  # of the polynomial that is the slow part
SECOND_SCAN = np.linspace(0.80, 1.50, 71)  # tried factors on the mechanism's own second frequency
NEEDED_FALL = 2.0  # least ratio of the residual sums of squares without and with the second mode
NEEDED_LEAD = 1.4  # least ratio of the second best minimum of this sum, or of its ends, to the best
AGREEMENT = 0.06  # largest relative difference of two channels' frequencies that agree


def second_mode_frequency(channel: ChannelHalf, first_mode: Fit) -> float | None:
    """Time mean of the second mode's frequency in Hz, None where it does not stand out in this channel alone.

    Slow part and first mode are fitted with more freedom than in the first mode's own fit, so that neither is taken for a second mode: the
    first mode keeps its phase but its envelope may bend, each of its two components by itself.
    """
    waves = Waves.of(channel)
    sigma = waves.sigma[:, None]
    alpha, beta, kappa, _, _ = first_mode.parameters
    oscillation = waves.first_mode(alpha, beta, kappa)
    basis = orthonormal(np.hstack([polynomials(SECOND_DEGREE), oscillation, oscillation * sigma, oscillation * sigma**2]))
    signal = without(basis, channel.signal[:, None])[:, 0]
    residuals = left_by(without(basis, waves.second_mode(SECOND_SCAN)), signal)

    best = int(np.argmin(residuals))
    if best in (0, SECOND_SCAN.size - 1) or not np.sum(signal**2) > NEEDED_FALL * residuals[best]:
        return None
    minima = np.flatnonzero((residuals[1:-1] < residuals[:-2]) & (residuals[1:-1] <= residuals[2:])) + 1
    rivals = np.concatenate([residuals[minima[minima != best]], residuals[[0, -1]]])
    if not rivals.min() > NEEDED_LEAD * residuals[best]:
        return None
    return float(_vertex(SECOND_SCAN[best - 1 : best + 2], residuals[best - 1 : best + 2]) * channel.half.mean_frequencies[1])


def agreeing(frequencies: list[float | None]) -> list[float | None]:
    """Keep the frequencies (Hz, one per channel) that at least one other channel confirms."""
    return [
        value
        if value is not None
        and any(other is not None and abs(other - value) <= AGREEMENT * value for j, other in enumerate(frequencies) if j != i)
        else None
        for i, value in enumerate(frequencies)
    ]


def _vertex(x: Array, y: Array) -> float:
    """Abscissa of the vertex of the parabola through three equidistant points, the middle one lowest."""
    return float(x[1] + (x[1] - x[0]) * (y[0] - y[2]) / (2.0 * (y[0] - 2.0 * y[1] + y[2])))
