"""Compares recorded tables with the engines, number by number; and evaluates the thesis' statements from recordings of its experiment."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from quickreturn.cases.experiment import channel_is_usable
from quickreturn.cases.measures.cycle import Measure, consensus_of
from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.comparison import HALVES, CaseResult
from quickreturn.cases.runs.request import Run
from quickreturn.reports.findings.runs import run_number


@dataclass(frozen=True)
class MeasuredHalf:
    """One half of the turn that is measured in a recorded table, in one channel."""

    case: str
    run: int | None  # number of the thesis' run that the case is; None for any other
    table: Run  # the recorded table
    measure: Measure  # of the table
    engines: Mapping[str, Measure]  # engine -> the same measure of its cycle

    @property
    def counts(self) -> bool:
        """Whether it is a genuine recording of the experiment, in a channel that section 3.5 calls valid."""
        recording = self.table.recording
        if recording is None or self.run is None or not recording.of_experiment or recording.declared.get("origin") == "synthetic":
            return False
        return channel_is_usable(self.run, self.measure.channel)


def measured_halves(results: Sequence[CaseResult]) -> list[MeasuredHalf]:
    """All recorded tables that can be compared with the engines, both halves of each channel."""
    found = []
    for result in results:
        number = run_number(result.case.name) if result.case.source == "library" else None
        for table in (run for run in result.recorded.values() if run.usable):
            for measure in (each for each in table.measures if each.channel in CHANNELS):
                pairs = {name: run.measure(measure.half, measure.channel) for name, run in result.runs.items() if run.usable}
                engines = {name: its for name, its in pairs.items() if its is not None}
                found.append(MeasuredHalf(result.case.name, number, table, measure, engines))
    return found


def statement_values(comparisons: Sequence[MeasuredHalf], engine: str) -> dict[str, dict[int, float]]:
    """Ratios simulation / experiment for the thesis' relations: quantity of a statement -> run -> ratio.

    Only recordings of the experiment count; made-up curves and channels that the thesis calls unusable do not.
    """
    values: dict[str, dict[int, float]] = {}
    valid = [item for item in comparisons if item.counts and engine in item.engines]
    for run in sorted({item.run for item in valid if item.run is not None}):
        for half in HALVES:
            here = [item for item in valid if item.run == run and item.measure.half == half]
            frequency = _frequency_ratio(here, engine)
            amplitude = _amplitude_ratio(here, engine)
            if frequency is not None:
                values.setdefault(f"{half}_frequency", {})[run] = frequency
            if amplitude is not None:
                values.setdefault(f"{half}_amplitude", {})[run] = amplitude
    pre, post = values.get("pre_frequency", {}), values.get("post_frequency", {})
    both = {run: post[run] / pre[run] for run in pre if run in post}
    return values | ({"post_over_pre_frequency": both} if both else {})


def _frequency_ratio(items: Sequence[MeasuredHalf], engine: str) -> float | None:
    """Ratio of the consensus over the engine's channels to that over the same measured channels."""
    pairs = [(item.engines[engine], item.measure) for item in items]
    both = [pair for pair in pairs if all(measure.first_mode_frequency is not None for measure in pair)]
    simulated, measured = (consensus_of("", [pair[side] for pair in both]).first_mode_frequency for side in (0, 1))
    return None if simulated is None or measured is None else simulated / measured


def _amplitude_ratio(items: Sequence[MeasuredHalf], engine: str) -> float | None:
    """Ratio of amplitudes, as the geometric mean over the channels."""
    pairs = [(item.engines[engine].first_mode_amplitude, item.measure.first_mode_amplitude) for item in items]
    known = [mine / its for mine, its in pairs if mine is not None and its]
    return float(np.exp(np.mean(np.log(known)))) if known else None
