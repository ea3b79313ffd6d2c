"""All measures of one cycle: both halves, every channel, simulated and measured signals alike."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.motion.extremes import extremes, low_pass
from quickreturn.cases.motion.first_mode import FirstMode, agreeing, fit_first_modes, second_mode_frequency
from quickreturn.cases.motion.number import Consensus, Number, consensus, or_nan
from quickreturn.cases.motion.time_scale import SAMPLES, ChannelHalf, TimeScale, channel_half, half_cycle
from quickreturn.engines.error_parts import ErrorPart
from quickreturn.reference_model.arrays import Array

HALVES = ("pre", "post")
#: Quantities of each channel, by the names of the fields of `ChannelMeasures`.
VIBRATION: Final = ("first_mode_frequency", "first_mode_amplitude")
EXTREMES: Final = ("minimum", "maximum")
NO_VIBRATION = (FirstMode("the model has no vibration in this channel"), None)
END_TOLERANCE = np.radians(5.0)  # largest distance, rad, of the first and last crank angle from that of the slider's farthest place


@dataclass(frozen=True)
class ChannelMeasures:
    """Measures of one channel in one half cycle; None if not resolvable: frequency and amplitude each by itself.

    `..._estimate` is an engine's estimate of the error of a number, in its unit, None if there is none; `parts` has by quantity the parts
    that add up to it, with the runs that show them.
    """

    half: str  # "pre" (slider from farthest to nearest) or "post"
    channel: str  # name of the channel
    first_mode_frequency: float | None  # Hz, time mean over the half
    first_mode_frequency_uncertainty: float | None  # Hz, one standard deviation
    first_mode_amplitude: float | None  # RMS of the envelope over the half, in the channel's unit
    first_mode_amplitude_uncertainty: float | None  # the same unit, one standard deviation
    second_mode_frequency: float | None  # Hz, time mean over the half
    minimum: float  # least value in the half, of the raw signal if simulated, of the low-passed one if measured
    minimum_uncertainty: float  # its uncertainty from the spacing of samples, the same unit
    maximum: float  # greatest value, likewise
    maximum_uncertainty: float
    reason: str  # why the first mode's frequency, its amplitude or both are not resolvable, empty if both are
    first_mode_frequency_estimate: float | None = None
    first_mode_amplitude_estimate: float | None = None
    minimum_estimate: float | None = None
    maximum_estimate: float | None = None
    parts: dict[str, tuple[ErrorPart, ...]] = field(default_factory=dict)
    variation: float = 0.0  # RMS of the signal less its mean in the half, in the channel's unit
    first_mode_frequency_gain: float | None = None  # see `FirstMode.frequency_gain`; None where it is not resolvable
    first_mode_amplitude_gain: float | None = None

    def response(self, quantity: str) -> float:
        """Largest change of a number of `VIBRATION` by an RMS change of the signal, in the number's unit over the channel's."""
        value, gain = (getattr(self, f"{quantity}{of}") or 0.0 for of in ("", "_gain"))
        return float(gain * value / self.variation) if self.variation > 0.0 else 0.0

    def number(self, quantity: str) -> Number | None:
        """The number called `quantity`, one of `VIBRATION` and `EXTREMES`, with its claims; None where it is not resolvable."""
        value, estimate, uncertainty = (getattr(self, f"{quantity}{of}") for of in ("", "_estimate", "_uncertainty"))
        return None if value is None else Number(value, estimate, or_nan(uncertainty), parts=self.parts.get(quantity, ()))


@dataclass(frozen=True)
class CycleMeasures:
    """Measures of a cycle: per half and channel, and the consensus per half, pre-return first."""

    measures: tuple[ChannelMeasures, ...]
    consensus: tuple[Consensus, ...]


def measure_cycle(
    scale: TimeScale | None, time: Array, crank_angle: Array, channels: Mapping[str, Array], measured: bool = False
) -> CycleMeasures:
    """Measures one full cycle.

    Args:
        scale: time scale of the mechanism; None for a rigid follower: only its extremes are measured.
        time: s, increasing, uniform or not, shape (n,).
        crank_angle: rad, shape (n,), from the slider's farthest place (180° + k 360°) to the next, in either direction.
        channels: values over the cycle, each of shape (n,); any of "tip_acceleration" (m/s²), "strain_1" to "strain_3".
        measured: whether the extremes are taken after a zero-phase periodic low-pass at 200 Hz.

    Raises:
        ValueError: fewer than 16 samples, unequal lengths, values that are not finite, a time that does not increase, a crank that
            turns back, or ends that are not the farthest place.
    """
    return measure_cycles(scale, [(time, crank_angle, channels)], measured)[0]


def measure_cycles(
    scale: TimeScale | None, cycles: Sequence[tuple[Array, Array, Mapping[str, Array]]], measured: bool = False
) -> list[CycleMeasures]:
    """Measures several cycles side by side, which takes less time; each as by `measure_cycle`, whose arguments and errors are the same."""
    halves: list[Mapping[str, ChannelHalf]] = []
    ends: list[Mapping[str, Sequence[tuple[Number, Number]]]] = []
    for time, crank_angle, channels in cycles:
        _check(time, crank_angle, channels)
        boundaries = _boundaries(time, crank_angle)
        filtered = {name: low_pass(time, values) if measured else values for name, values in channels.items()}
        ends.append({name: extremes(time, values, boundaries) for name, values in filtered.items()})
        halves += _channel_halves(scale, time, crank_angle, channels, boundaries)
    vibrations = _vibrations(halves)
    return [_of_cycle(of_channels, vibrations[2 * at : 2 * at + 2]) for at, of_channels in enumerate(ends)]


def _channel_halves(
    scale: TimeScale | None, time: Array, crank_angle: Array, channels: Mapping[str, Array], boundaries: Array
) -> list[dict[str, ChannelHalf]]:
    """The channels that vibrate, in each half."""
    if scale is None:
        return [{}, {}]
    angle = CubicSpline(time, crank_angle)
    signals = {name: CubicSpline(time, values) for name, values in channels.items() if name in scale.channels}
    halves = [half_cycle(scale, start, end, angle) for start, end in itertools.pairwise(boundaries)]
    return [{name: channel_half(scale, half, name, signal) for name, signal in signals.items()} for half in halves]


def _of_cycle(
    ends: Mapping[str, Sequence[tuple[Number, Number]]], vibrations: Sequence[Mapping[str, tuple[FirstMode, float | None]]]
) -> CycleMeasures:
    """The measures of a cycle from its channels' extremes and vibrations in each half."""
    measures: list[ChannelMeasures] = []
    for at, (half, fitted) in enumerate(zip(HALVES, vibrations, strict=True)):
        for name, of_halves in ends.items():
            first, second = fitted.get(name, NO_VIBRATION)
            low, high = of_halves[at]
            vibration = first.frequency, first.frequency_uncertainty, first.amplitude, first.amplitude_uncertainty
            found = low.value, low.uncertainty, high.value, high.uncertainty
            gains: dict[str, Any] = {"first_mode_frequency_gain": first.frequency_gain, "first_mode_amplitude_gain": first.amplitude_gain}
            measures.append(ChannelMeasures(half, name, *vibration, second, *found, first.reason, variation=first.variation, **gains))
    return CycleMeasures(tuple(measures), tuple(consensus_of(half, [each for each in measures if each.half == half]) for half in HALVES))


def extremes_by_half(time: Array, crank_angle: Array, values: Array, measured: bool = False) -> dict[str, tuple[Number, Number]]:
    """Least and greatest value of any column in each half of a cycle; arguments and errors as of `measure_cycle`."""
    filtered, boundaries = low_pass(time, values) if measured else values, _boundaries(time, crank_angle)
    return dict(zip(HALVES, extremes(time, filtered, boundaries), strict=True))


def signals_by_half(time: Array, crank_angle: Array, columns: Mapping[str, Array]) -> dict[tuple[str, str], Array]:
    """The values from which vibration is measured, by half and column, each of shape (240,); arguments as of `measure_cycle`."""
    instants = [np.linspace(start, end, SAMPLES) for start, end in itertools.pairwise(_boundaries(time, crank_angle))]
    splines = {name: CubicSpline(time, values) for name, values in columns.items()}
    return {(half, name): spline(at) for half, at in zip(HALVES, instants, strict=True) for name, spline in splines.items()}


def consensus_of(half: str, measures: Sequence[ChannelMeasures]) -> Consensus:
    """Consensus of those measures of a half that resolve the first mode's frequency."""
    pairs = [(measure.first_mode_frequency, measure.first_mode_frequency_uncertainty) for measure in measures]
    resolved = [(frequency, uncertainty) for frequency, uncertainty in pairs if frequency is not None and uncertainty is not None]
    return consensus(half, [frequency for frequency, _ in resolved], [uncertainty for _, uncertainty in resolved])


def _vibrations(halves: Sequence[Mapping[str, ChannelHalf]]) -> list[dict[str, tuple[FirstMode, float | None]]]:
    """The first mode and the second mode's frequency, by channel, in each half."""
    vibrations = []
    for channels, first_modes in zip(halves, fit_first_modes(halves), strict=True):
        second_modes = [second_mode_frequency(channels[name], mode.fit) if mode.fit else None for name, mode in first_modes.items()]
        vibrations.append({name: (mode, second) for (name, mode), second in zip(first_modes.items(), agreeing(second_modes), strict=True)})
    return vibrations


def _check(time: Array, crank_angle: Array, channels: Mapping[str, Array]) -> None:
    if time.size < 16:
        raise ValueError(f"a cycle of {time.size} samples cannot be measured; at least 16 are needed")
    for name, values in {"time": time, "crank_angle": crank_angle, **channels}.items():
        if values.shape != time.shape:
            raise ValueError(f"{name} has {values.size} samples, time has {time.size}")
        if not np.all(np.isfinite(values)):
            raise ValueError(f"{name} holds values that are not finite")
    if not np.all(np.diff(time) > 0.0):
        raise ValueError("time does not increase throughout the cycle")


def _boundaries(time: Array, crank_angle: Array) -> Array:
    """Instants of the farthest place, the return and the next farthest place, s, shape (3,)."""
    direction = np.sign(crank_angle[-1] - crank_angle[0])
    progress = direction * (crank_angle - np.pi)  # 0 at the farthest place, modulo a turn
    if not np.all(np.diff(progress) > 0.0):
        raise ValueError("the crank turns back within the cycle")
    first = 2.0 * np.pi * np.round(progress[0] / (2.0 * np.pi))
    if max(abs(progress[0] - first), abs(progress[-1] - first - 2.0 * np.pi)) > END_TOLERANCE:
        raise ValueError(
            "a cycle must run from the slider's farthest place (crank angle 180°) to the next, not from"
            f" {np.degrees(crank_angle[0]):.4g}° to {np.degrees(crank_angle[-1]):.4g}°"
        )
    return np.asarray(CubicSpline(progress, time)(first + np.pi * np.arange(3)))
