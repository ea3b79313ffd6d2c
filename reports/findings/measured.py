"""Compares recorded tables with the engines, number by number."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from quickreturn.cases.case import Case
from quickreturn.cases.measures.cycle import Measure
from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.runs.request import Run


@dataclass(frozen=True)
class MeasuredHalf:
    """One half of the turn that is measured in a recorded table, in one channel."""

    case: Case
    table: Run  # the recorded table
    measure: Measure  # of the table
    engines: Mapping[str, Measure]  # engine -> the same measure of its cycle


def measured_halves(results: Sequence[CaseResult]) -> list[MeasuredHalf]:
    """All recorded tables that can be compared with the engines, both halves of each channel."""
    found = []
    for result in results:
        for table in (run for run in result.recorded.values() if run.usable):
            for measure in (each for each in table.measures if each.channel in CHANNELS):
                pairs = {name: run.measure(measure.half, measure.channel) for name, run in result.runs.items() if run.usable}
                engines = {name: its for name, its in pairs.items() if its is not None}
                found.append(MeasuredHalf(result.case, table, measure, engines))
    return found
