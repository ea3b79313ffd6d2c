"""Compares recorded tables with the engines, number by number."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from quickreturn.cases.case import Case
from quickreturn.cases.measures.cycle import ChannelMeasures
from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.runs.request import Run


@dataclass(frozen=True)
class MeasuredHalf:
    """One half of a recorded table's measured turn, in one channel, beside the engines."""

    case: Case
    table: Run  # the recorded table
    measure: ChannelMeasures  # of the table
    engines: Mapping[str, ChannelMeasures]  # engine -> the same measure of its cycle


def measured_halves(results: Sequence[CaseResult]) -> list[MeasuredHalf]:
    """All recorded tables that can be compared with the engines, both halves of each channel."""
    halves = []
    for result in results:
        for table in (run for run in result.recorded.values() if run.usable):
            for measure in (measure for measure in table.measured.measures if measure.channel in CHANNELS):
                same = {name: run.measure(measure.half, measure.channel) for name, run in result.runs.items() if run.usable}
                engines = {name: of_engine for name, of_engine in same.items() if of_engine is not None}
                halves.append(MeasuredHalf(result.case, table, measure, engines))
    return halves
