"""Simulated peaks against the axes of the thesis' figures: the largest label that can be read bounds what was plotted from below."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cases.experiment import axis_labels
from cases.runs.comparison import CaseResult
from reports.findings.runs import thesis_runs

#: Channel of an axis -> trajectory columns that it shows.
COLUMNS = {"tip_acceleration": ("tip_acceleration",), "strain": ("strain_1", "strain_2", "strain_3")}


@dataclass(frozen=True)
class AxisComparison:
    """One axis of a figure: the largest magnitude among its labels, SI, and of each engine the peak over the cycle as a part of it."""

    run: int
    channel: str
    largest_label: float
    ratios: Mapping[str, float]


def axis_comparisons(results: Sequence[CaseResult]) -> list[AxisComparison]:
    """The appendix' figure of each run shown, where its labels are legible."""
    found = []
    for number, result in thesis_runs(results).items():
        for labels in axis_labels(number):
            if labels.figure.startswith("A.") and labels.largest > 0.0:
                peaks = {name: max(map(run.peak, COLUMNS[labels.channel])) for name, run in result.runs.items() if run.usable}
                ratios = {name: peak / labels.largest for name, peak in peaks.items()}
                found.append(AxisComparison(number, labels.channel, labels.largest, ratios))
    return found
