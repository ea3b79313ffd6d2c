"""A number computed by two engines: both claims, and the largest difference that they allow.

Most of a frequency's or an amplitude's uncertainty lies in what the first mode is taken to be, which is the same in two signals that are
alike. So it counts as far as the signals differ: with their RMS difference in the half over the RMS of the signal less its mean, at most 1.
Where the stiffness of the thesis' machines changes by 0.5 to 10 %, the change of a frequency that is found departs from the true one by no
more than that in 80 to 89 % of the half cycles, by twice as much in 89 to 99 %: it is a standard deviation, as the uncertainty is. A
recorded table that is near an engine is compared as sharply, and one that is far from it, as an experiment is, with the whole of both.

Waveforms are compared at equal crank angles in every half and channel, whether or not a mode is resolvable: the RMS of the difference and
its largest magnitude, against 0. Between rows they are splines, whose error counts as what every second row alone would change: a strain
has a kink when the slider passes its gauge, where the error falls with the first power of the rows' distance, elsewhere faster.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, Literal

import numpy as np

from quickreturn.cases.motion.cycle import EXTREMES, HALVES, VIBRATION, signals_by_half
from quickreturn.cases.motion.marching import channels_of
from quickreturn.cases.motion.number import TELLING, TELLING_OF_AMPLITUDES, TELLING_OF_FREQUENCIES, Number, Verdict, consensus, or_nan
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.settling import GRID, Cycle, on_common_grid
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.engines.trajectory import rms
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS

#: Differences of two signals in a half, at equal crank angles: their RMS, and their largest magnitude.
WAVEFORM: Final = ("waveform", "largest_difference")
#: Quantities of each channel that are judged, besides the consensus of the channels' frequencies.
QUANTITIES: Final = (*VIBRATION, *EXTREMES, *WAVEFORM)
CONSENSUS: Final = "consensus_frequency"
#: Kinds of differences; "frequency" is the consensus of a half over its channels.
Kind = Literal["frequency", "channel frequency", "amplitude", "extreme", "waveform"]
KINDS: Final[Mapping[Kind, tuple[str, ...]]] = {
    "frequency": (CONSENSUS,),
    "channel frequency": VIBRATION[:1],
    "amplitude": VIBRATION[1:],
    "extreme": EXTREMES,
    "waveform": WAVEFORM,
}
#: Largest tolerance, over the scale, of a comparison that says something, if it is not `TELLING`.
LIMITS: Final[Mapping[str, float]] = {
    CONSENSUS: TELLING_OF_FREQUENCIES,
    VIBRATION[0]: TELLING_OF_FREQUENCIES,
    VIBRATION[1]: TELLING_OF_AMPLITUDES,
}


@dataclass(frozen=True)
class Difference:
    """A number computed by two engines, and whether they agree within their claims.

    Attributes:
        case: name of the scene.
        engine: name of the engine that is judged.
        other: name of the engine that it is compared with.
        quantity: one of `QUANTITIES`, or `CONSENSUS`.
        half: "pre" or "post".
        channel: trajectory column; None for the consensus.
        number: the engine's number; of a waveform the size of the difference.
        other_number: the other engine's; of a waveform 0.
        scale: divisor of relative differences: magnitude of the other's value; for an extreme and the largest difference of two waveforms
            the channel's largest in the other's cycle, for their RMS difference the channel's RMS in the half.
        unshared: the part of the tolerance for the measurements: their uncertainties as far as the signals differ.
    """

    case: str
    engine: str
    other: str
    quantity: str
    half: str
    channel: str | None
    number: Number
    other_number: Number
    scale: float
    unshared: float

    @property
    def difference(self) -> float:
        """Engine minus other."""
        return self.number.value - self.other_number.value

    @property
    def unit(self) -> str:
        """SI unit of both numbers."""
        return "Hz" if self.channel is None or self.quantity == VIBRATION[0] else COLUMNS[self.channel].unit

    @property
    def relative(self) -> float:
        """The difference over the scale."""
        return self.difference / self.scale

    @property
    def ratio(self) -> float:
        """The engine's number over the other's."""
        return self.number.value / self.other_number.value

    @property
    def tolerance(self) -> float:
        """Largest difference within both claims: estimates, what is left to the steady state, and `unshared`."""
        both = (self.number, self.other_number)
        return sum(or_nan(number.estimate) + number.settling for number in both) + self.unshared

    @property
    def passed(self) -> bool:
        """Whether the difference is within the tolerance; False for NaN."""
        return abs(self.difference) <= self.tolerance

    @property
    def verdict(self) -> Verdict:
        """Whether the two agree; a tolerance beyond the limit (`LIMITS`) would hide any mistake."""
        if not self.passed:
            return "disagrees"
        return "agrees" if self.tolerance <= LIMITS.get(self.quantity, TELLING) * self.scale else "says nothing"

    @property
    def why(self) -> tuple[str, ...]:
        """The parts of both estimates, with the runs that show them, in words."""
        return tuple(
            f"{name}: {part}" for name, number in ((self.engine, self.number), (self.other, self.other_number)) for part in number.parts
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON and CSV."""
        names = ("engine", "other", "quantity", "half", "channel", "difference", "tolerance", "unshared", "scale", "passed", "verdict")
        claims = {"": self.number, "other_": self.other_number}.items()
        parts = ("value", "estimate", "uncertainty", "measurement", "settling")
        numbers = {f"{whose}{part}": getattr(claim, part) for whose, claim in claims for part in parts}
        return {name: getattr(self, name) for name in names} | numbers


def every_second_row(cycle: Cycle) -> Cycle:
    """The cycle by every second row, and its last."""
    rows = np.union1d(np.arange(0, len(cycle.time), 2), len(cycle.time) - 1)
    return Cycle(cycle.time[rows], cycle.crank_angle[rows], {name: values[rows] for name, values in cycle.channels.items()})


class Pair:
    """Two runs of a case, and the numbers that both have."""

    def __init__(self, run: Run, other: Run, case: str = "", *, claimed: bool = False) -> None:
        """`case`: its name; `claimed`: whether numbers without an error estimate are left out, also from the consensus."""
        self._runs, self._case, self._claimed = (run, other), case, claimed

    def difference(self, quantity: str, half: str, channel: str | None) -> Difference | None:
        """The difference in a number; None if a run lacks it, or if there is no scale.

        Args:
            quantity: `CONSENSUS` or one of `QUANTITIES`.
            half: "pre" or "post".
            channel: a trajectory column; None for the consensus, which is over the channels that both resolve.
        """
        if quantity in WAVEFORM and channel is not None:
            found = self._waveform(quantity, half, channel)
        else:
            found = self._consensus(half) if channel is None else self._of_channel(quantity, half, channel)
        if found is None:
            return None
        number, other_number, unshared, scale = found
        if not scale > 0.0 or (self._claimed and math.isnan(number.error + other_number.error)):
            return None
        run, other = self._runs
        return Difference(self._case, run.engine, other.engine, quantity, half, channel, number, other_number, scale, unshared)

    def numbers(self, quantity: str, half: str, channel: str | None = None) -> tuple[Number, Number] | None:
        """Both runs' numbers; arguments as of `difference`."""
        found = self.difference(quantity, half, channel)
        return None if found is None else (found.number, found.other_number)

    def _of_channel(self, quantity: str, half: str, channel: str) -> tuple[Number, Number, float, float] | None:
        number, other_number = (run.number(quantity, half, channel) for run in self._runs)
        if number is None or other_number is None:
            return None
        measurement = number.measurement + other_number.measurement
        if quantity in EXTREMES:
            return number, other_number, measurement, self._runs[1].peak(channel)
        return number, other_number, self._apart.get((half, channel), 1.0) * measurement, abs(other_number.value)

    def _consensus(self, half: str) -> tuple[Number, Number, float, float] | None:
        """The weighted means of the channels that both resolve; the weights, by the uncertainties, are the same for both runs."""
        found = [pair for channel in CHANNELS if (pair := self.difference(VIBRATION[0], half, channel))]
        if not found:
            return None
        weights = np.array([1.0 / (pair.number.measurement**2 + pair.other_number.measurement**2) for pair in found])
        weights /= weights.sum()

        def mean(numbers: Sequence[Number]) -> Number:
            estimates, settling = ([or_nan(getattr(each, of)) for each in numbers] for of in ("estimate", "settling"))
            values, uncertainties = [each.value for each in numbers], [each.measurement for each in numbers]
            uncertainty = or_nan(consensus(half, values, uncertainties).uncertainty)
            return Number(float(weights @ values), float(weights @ estimates), uncertainty, float(weights @ settling))

        number, other_number = mean([pair.number for pair in found]), mean([pair.other_number for pair in found])
        return number, other_number, float(weights @ [pair.unshared for pair in found]), abs(other_number.value)

    def _waveform(self, quantity: str, half: str, channel: str) -> tuple[Number, Number, float, float] | None:
        if (half, channel) not in self._waveforms:
            return None
        (signal, coarse), (other, other_coarse) = self._waveforms[half, channel]
        by_rms = quantity == WAVEFORM[0]

        def size(of: Array) -> float:
            return rms(of) if by_rms else float(np.max(np.abs(of)))

        def claim(run: Run, value: float, between_rows: float) -> Number:
            estimates = run.measured.waveform_estimates if by_rms else run.measured.extreme_estimates
            over_turn = rms(run.cycle[channel])
            left = (run.approach.settling_error or 0.0) * over_turn if by_rms else run.approach.distance(channel, over_turn)
            return Number(value, estimates.get(channel, {}).get(half), measurement=between_rows, settling=left)

        number = claim(self._runs[0], size(signal - other), size(signal - coarse))
        other_number = claim(self._runs[1], 0.0, size(other - other_coarse))
        scale = rms(other) if by_rms else self._runs[1].peak(channel)
        return number, other_number, number.measurement + other_number.measurement, scale

    @cached_property
    def _apart(self) -> dict[tuple[str, str], float]:
        """By half and channel: RMS difference of the signals less their means, over the RMS of the other's, at most 1."""
        if not self._repeats:
            return {}
        signals = [signals_by_half(run.cycle["time"], run.cycle["crank_angle"], self._channels(run)) for run in self._runs]
        found = {}
        for place, other in signals[1].items():
            if place in signals[0]:
                difference, size = signals[0][place] - other, float(np.std(other))
                found[place] = min(1.0, float(np.std(difference)) / size) if size > 0.0 else 1.0
        return found

    @cached_property
    def _waveforms(self) -> dict[tuple[str, str], tuple[tuple[Array, Array], tuple[Array, Array]]]:
        """By half and channel: for each run the signal at even crank angles, and the same by every second row.

        None of a recorded table, which claims no error of a row.
        """
        if not self._repeats or any(run.recording for run in self._runs):
            return {}
        cycles = [channels_of(run.cycle, self._channels(run)) for run in self._runs]
        (one, one_coarse), (other, other_coarse) = ((on_common_grid(cycle), on_common_grid(every_second_row(cycle))) for cycle in cycles)
        parts = dict(zip(HALVES, (slice(GRID // 2), slice(GRID // 2, None)), strict=True))
        return {
            (half, name): ((one[name][part], one_coarse[name][part]), (other[name][part], other_coarse[name][part]))
            for half, part in parts.items()
            for name in one.keys() & other.keys()
        }

    @property
    def _repeats(self) -> bool:
        """Whether each run has one cycle that repeats, of its own turn: signals are compared, not means over cycles."""
        return all(run.approach.averaged_cycles == 1 and "time" in run.cycle for run in self._runs)

    @staticmethod
    def _channels(run: Run) -> dict[str, Array]:
        return {name: run.cycle[name] for name in CHANNELS if name in run.cycle}
