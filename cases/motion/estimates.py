"""Error estimate of each measure of the settled cycle, from the engine's own comparisons.

The same measures are taken of the same cycle in the runs that the engine compares (`engines.base.Comparison`); the parts of the error from
their differences are added as for a trajectory (`engines.accurate`). Runs that march from the orbit are compared in their second cycle from
there. An error in the slowest mode has not built up by then: of that mode m remains after a cycle, and the second cycle shows 1 - m^2 of
the error. What it grows by is taken from the first two cycles (`engines.error_parts.Compared.growing`).

Two frequencies or amplitudes of one half can be equal by accident, too. A part of the largest change that the signals' difference can make
in the number (`ChannelMeasures.response`) counts at least.

The root mean square of a column over a turn, its change in a turn and the time of a turn are compared themselves (`turn_estimates`), with
floors, because two numbers can be equal by accident.

Two extremes can be equal by accident, if one run is higher before the peak and the other after it. They differ by at most the signals'
largest difference in the half cycle, and this bound is the estimate for an extreme.

For cycles that repeat in statistics only, means are compared: of the measures, of the extremes, and of the signals at each crank angle.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final

import numpy as np

from quickreturn.cases.motion.cycle import EXTREMES, VIBRATION, ChannelMeasures, CycleMeasures, measure_cycles
from quickreturn.cases.motion.marching import channels_of, mean_measures
from quickreturn.cases.motion.number import Consensus
from quickreturn.cases.motion.of_turn import OfTurn, at_shaft, crank_damping, declared, rms_over_time
from quickreturn.cases.motion.settling import GRID, on_common_grid
from quickreturn.cases.motion.time_scale import CHANNELS, time_scale
from quickreturn.engines.error_parts import Compared, ErrorPart, total
from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism

#: Part of the RMS difference of two signals that counts as error of their root mean squares, besides the difference of these. That is at
#: most the whole; it is less as far as the difference of the signals is at right angles to them.
ASIDE: Final = 0.25
#: Part of the largest change of a frequency or an amplitude by the difference of two signals that counts as its error at least: half of the
#: compared runs of the thesis' machines show more, half less.
AT_LEAST: Final = {"first_mode_frequency": 0.075, "first_mode_amplitude": 0.4}
#: Key of the time of a turn among the estimates of changes.
TIME: Final = "time"
#: Key of the estimate of a number of a turn, `of_turn.declared`.
NUMBER: Final = "number"

#: Column whose difference stands for that of the motion.
MOTION: Final = "tip_deflection"


@dataclass(frozen=True)
class HalfSignal:
    """A column in one half of one or more cycles, in its unit: means of the cycles."""

    values: Array  # at even crank angles, shape (GRID / 2,)
    least: float
    greatest: float

    @classmethod
    def of(cls, cycles: Array) -> "HalfSignal":
        """The means of cycles, shape (cycles, GRID / 2)."""
        return cls(cycles.mean(axis=0), float(cycles.min(axis=1).mean()), float(cycles.max(axis=1).mean()))

    def apart(self, other: "HalfSignal") -> float:
        """Largest difference of the values at one crank angle, or of the extremes."""
        values = float(np.abs(self.values - other.values).max())
        return max(values, abs(self.least - other.least), abs(self.greatest - other.greatest))

    def rms_apart(self, other: "HalfSignal") -> float:
        """RMS difference of the values at equal crank angles."""
        return float(np.sqrt(np.mean((self.values - other.values) ** 2)))


@dataclass(frozen=True)
class MeasuredCycle:
    """One or more cycles, each from the slider's farthest place to the next."""

    measures: CycleMeasures  # their means
    signals: Mapping[tuple[str, str], HalfSignal]  # by half and column
    rms: Mapping[str, float]  # column -> root mean square over time, mean of the cycles
    change: Mapping[str, float]  # column, `TIME` among them -> change in a cycle, mean of the cycles
    numbers: Mapping[str, float]  # name of an `OfTurn` whose columns are there -> number, mean of the cycles

    @classmethod
    def of(cls, cycles: Sequence[Columns], measures: CycleMeasures) -> "MeasuredCycle":
        """Cycles as columns of a trajectory, torque as `at_shaft` gives it, and the means of their measures."""
        grids = [on_common_grid(channels_of(cycle, [name for name in cycle if name not in ("time", "crank_angle")])) for cycle in cycles]
        columns = {name: np.array([grid[name] for grid in grids]) for name in grids[0]}
        halves = {"pre": slice(0, GRID // 2), "post": slice(GRID // 2, None)}
        signals = {(half, name): HalfSignal.of(values[:, part]) for half, part in halves.items() for name, values in columns.items()}
        rms = {name: float(np.mean([rms_over_time(cycle["time"], cycle[name]) for cycle in cycles])) for name in columns}
        change = {name: float(np.mean([cycle[name][-1] - cycle[name][0] for cycle in cycles])) for name in (TIME, *columns)}
        given = [each for each in declared() if all({*each.columns} <= cycle.keys() for cycle in cycles)]
        numbers = {each.name: float(np.mean([each.of(cycle) for cycle in cycles])) for each in given}
        return cls(measures, signals, rms, change, numbers)


def measured_cycles(mechanism: Mechanism, runs: Sequence[tuple[Columns, ...]]) -> list[MeasuredCycle]:
    """The measured cycles of several runs of a mechanism, each with one or more."""
    scale, damping = time_scale(mechanism), crank_damping(mechanism)
    measures: list[list[CycleMeasures]] = [[] for _ in runs]
    for numbered in itertools.zip_longest(*runs):  # all first cycles, then all second ones: all of them at once need much memory
        present = [(of_run, cycle) for of_run, cycle in zip(measures, numbered, strict=True) if cycle is not None]
        parts = [(cycle["time"], cycle["crank_angle"], {name: cycle[name] for name in CHANNELS}) for _, cycle in present]
        for (of_run, _), found in zip(present, measure_cycles(scale, parts), strict=True):
            of_run.append(found)
    shafts = [[at_shaft(cycle, damping) for cycle in cycles] for cycles in runs]
    return [MeasuredCycle.of(cycles, mean_measures(of_run)) for cycles, of_run in zip(shafts, measures, strict=True)]


@dataclass(frozen=True, kw_only=True)
class MeasuredNumbers:
    """The numbers of a cycle, with their error estimates."""

    measures: tuple[ChannelMeasures, ...] = ()
    consensus: tuple[Consensus, ...] = ()
    unestimated: str = "there is no settled cycle"  # why there are no estimates of the measures (a clause), "" if there are
    extreme_estimates: dict[str, dict[str, float]] = field(default_factory=dict)  # column -> half -> error estimate of its extremes
    waveform_estimates: dict[str, dict[str, float]] = field(default_factory=dict)  # column -> half -> RMS of its estimated error
    turn_estimates: dict[str, dict[str, float]] = field(default_factory=dict)  # column -> "rms", "change" -> error estimate over a turn

    @classmethod
    def of(cls, delivered: CycleMeasures, compared: Sequence[Compared[MeasuredCycle]], unestimated: str = "") -> "MeasuredNumbers":
        """Numbers of the cycles that are delivered, with the estimates that the compared runs show; none if these are empty."""
        measures, consensus = with_estimates(delivered, compared)
        return cls(
            measures=measures,
            consensus=consensus,
            unestimated=unestimated,
            extreme_estimates=signal_estimates(compared, HalfSignal.apart),
            waveform_estimates=signal_estimates(compared, HalfSignal.rms_apart),
            turn_estimates=turn_estimates(compared),
        )


def with_estimates(
    delivered: CycleMeasures, compared: Sequence[Compared[MeasuredCycle]]
) -> tuple[tuple[ChannelMeasures, ...], tuple[Consensus, ...]]:
    """Measures and consensus with their estimates.

    An estimate is None if one run resolves the first mode and another does not. That of a consensus is the mean over its channels with an
    estimate, with the weights of their frequencies.

    Args:
        delivered: measures of the run that is delivered.
        compared: the compared runs; if empty, every estimate is None.
    """
    measures = []
    for place, measure in enumerate(delivered.measures):
        parts = {name: _of_vibration(compared, place, name, measure) for name in VIBRATION}
        parts |= dict.fromkeys(EXTREMES, _of_signal(compared, measure.half, measure.channel, HalfSignal.apart))
        estimates: dict[str, Any] = {f"{name}_estimate": total(some) for name, some in parts.items()}
        measures.append(replace(measure, **estimates, parts=parts))
    consensus = (replace(each, first_mode_frequency_estimate=mean_estimate(measures, each.half)) for each in delivered.consensus)
    return tuple(measures), tuple(consensus)


def mean_estimate(measures: Sequence[ChannelMeasures], half: str, channels: Sequence[str] = CHANNELS) -> float | None:
    """Error estimate (Hz) of the weighted mean of some channels' frequencies: the mean of their estimates; None if no channel has one."""
    weighted = [
        (measure.first_mode_frequency_uncertainty**-2.0, measure.first_mode_frequency_estimate)
        for measure in measures
        if measure.half == half and measure.channel in channels
        if measure.first_mode_frequency_uncertainty is not None and measure.first_mode_frequency_estimate is not None
    ]
    if not weighted:
        return None
    weights, estimates = np.array(weighted).T
    return float(weights @ estimates / weights.sum())


def turn_estimates(compared: Sequence[Compared[MeasuredCycle]]) -> dict[str, dict[str, float]]:
    """Column -> "rms" and "change" -> estimate of the error of its root mean square and of its change in a turn, in its unit.

    Name of an `OfTurn` -> `NUMBER` -> estimate of its error. For `TIME` there is the change alone. A change is as good as twice the
    relative difference of the tip's deflection at best, because work is of second order in the motion.
    """
    if not compared:
        return {}
    delivered = compared[0].run
    moves = delivered.rms.get(MOTION, 0.0)
    relative = _total(compared, partial(_rms_apart, MOTION)) / moves if moves > 0.0 else 0.0
    estimates = {TIME: {"change": _total(compared, partial(_apart, "change", TIME))}}
    for name in delivered.rms:
        at_least = 2.0 * relative * abs(delivered.change[name])
        estimates[name] = {
            "change": _total(compared, partial(_apart, "change", name)) + at_least,
            "rms": _total(compared, partial(_apart, "rms", name)) + ASIDE * _total(compared, partial(_rms_apart, name)),
        }
    return estimates | {each.name: {NUMBER: _of_number(compared, each)} for each in declared() if each.name in delivered.numbers}


def _of_number(compared: Sequence[Compared[MeasuredCycle]], measure: OfTurn) -> float:
    """Estimate of the error of a number; at least its size times `ASIDE` of the largest relative difference of its columns."""
    rms, value = compared[0].run.rms, compared[0].run.numbers[measure.name]
    apart = [_total(compared, partial(_rms_apart, name)) / rms[name] for name in measure.columns if rms.get(name, 0.0) > 0.0]
    return _total(compared, partial(_apart, "numbers", measure.name)) + ASIDE * max(apart, default=0.0) * abs(value)


def _total(compared: Sequence[Compared[MeasuredCycle]], apart: Callable[[MeasuredCycle, MeasuredCycle], float]) -> float:
    """The sum of the parts of an error that the compared runs show."""
    return sum(runs.part(apart).error for runs in compared)


def _apart(of: str, name: str, one: MeasuredCycle, other: MeasuredCycle) -> float:
    """Difference of two cycles in one of their numbers: `rms`, `change` or `numbers`."""
    return abs(float(getattr(one, of)[name] - getattr(other, of)[name]))


def _rms_apart(name: str, one: MeasuredCycle, other: MeasuredCycle) -> float:
    """RMS difference of a column at equal crank angles."""
    halves = [one.signals[half, name].values - other.signals[half, name].values for half in ("pre", "post")]
    return float(np.sqrt(np.mean(np.concatenate(halves) ** 2)))


def signal_estimates(
    compared: Sequence[Compared[MeasuredCycle]], apart: Callable[[HalfSignal, HalfSignal], float]
) -> dict[str, dict[str, float]]:
    """Column -> half -> estimate of the error of its signal, in its unit, by the size of the difference of two signals."""
    estimates: dict[str, dict[str, float]] = {}
    for half, name in compared[0].run.signals if compared else ():
        estimates.setdefault(name, {})[half] = sum(part.error for part in _of_signal(compared, half, name, apart))
    return estimates


def _of_signal(
    compared: Sequence[Compared[MeasuredCycle]], half: str, name: str, apart: Callable[[HalfSignal, HalfSignal], float]
) -> tuple[ErrorPart, ...]:
    return tuple(runs.part(lambda one, other: apart(one.signals[half, name], other.signals[half, name])) for runs in compared)


def _of_vibration(compared: Sequence[Compared[MeasuredCycle]], place: int, name: str, measure: ChannelMeasures) -> tuple[ErrorPart, ...]:
    """Parts of the error of a number; none where not every run resolves it. `place` is that of the measure among those of a cycle."""
    signal, at_least = (measure.half, measure.channel), AT_LEAST[name] * measure.response(name)

    def of(run: MeasuredCycle) -> float | None:
        number: float | None = getattr(run.measures.measures[place], name)
        return number

    def apart(one: MeasuredCycle, other: MeasuredCycle) -> float:
        numbers = abs(of(one) - of(other))  # type: ignore[operator]
        return max(numbers, at_least * one.signals[signal].rms_apart(other.signals[signal]) if at_least > 0.0 else 0.0)

    if not compared or getattr(measure, name) is None or any(of(run) is None for runs in compared for pair in runs.pairs for run in pair):
        return ()

    def part(runs: Compared[MeasuredCycle]) -> ErrorPart:
        if runs.before and of(runs.before[0]) is None:
            runs = replace(runs, before=None, unchecked="does not resolve the number")
        return runs.part(apart)

    return tuple(map(part, compared))
