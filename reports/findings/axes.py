"""Simulated peaks against the axes of the thesis' figures: the largest label that can be read bounds what was plotted from below."""

from collections.abc import Sequence
from dataclasses import dataclass

from cases.experiment import axis_labels
from cases.runs.comparison import CaseResult
from cases.runs.request import Run
from reports.findings.runs import thesis_runs

#: Channel of an axis -> trajectory columns that it shows.
COLUMNS = {"tip_acceleration": ("tip_acceleration",), "strain": ("strain_1", "strain_2", "strain_3")}


@dataclass(frozen=True)
class AxisComparison:
    """One axis of a figure: the largest magnitude among its labels and each engine's peak over the cycle, both SI."""

    run: int
    figure: str
    channel: str
    largest_label: float
    has_experiment: bool
    peaks: dict[str, float]

    def ratio(self, engine: str) -> float | None:
        """Simulated peak over largest label."""
        return self.peaks[engine] / self.largest_label if engine in self.peaks else None


def axis_comparisons(results: Sequence[CaseResult]) -> list[AxisComparison]:
    """The appendix' figure of each run shown, where its labels are legible."""
    found = []
    for number, result in thesis_runs(results).items():
        for labels in axis_labels(number):
            if labels.figure.startswith("A.") and labels.largest > 0.0:
                peaks = {name: _peak(run, labels.channel) for name, run in result.runs.items() if run.usable}
                found.append(AxisComparison(number, labels.figure, labels.channel, labels.largest, labels.has_experiment, peaks))
    return found


def _peak(run: Run, channel: str) -> float:
    return max(run.peak(column) for column in COLUMNS[channel])
