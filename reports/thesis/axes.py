"""Compares simulated peaks with the axes of the thesis' figures: the largest legible label is a lower bound of the plotted curves."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from quickreturn.cases.runs.comparison import REFERENCE, CaseResult
from quickreturn.cases.thesis.experiment import AxisLabels, axis_labels
from quickreturn.engines.registry import MODEL
from quickreturn.reports.thesis.runs import thesis_runs

#: Channel of an axis -> trajectory columns that it shows.
COLUMNS = {"tip_acceleration": ("tip_acceleration",), "strain": ("strain_1", "strain_2", "strain_3")}


@dataclass(frozen=True)
class AxisComparison:
    """One axis of a figure: the largest magnitude among its labels, SI, and each engine's peak over the cycle relative to it."""

    figure: str
    run: int
    channel: str
    largest_label: float
    ratios: Mapping[str, float]


def axis_comparisons(results: Sequence[CaseResult]) -> list[AxisComparison]:
    """The appendix' figure of each run shown, if its labels are legible. All except that of run 1 show simulated and measured curves."""
    return _compared(results, lambda labels: labels.figure.startswith("A."))


def measured_alone(results: Sequence[CaseResult]) -> list[AxisComparison]:
    """Figures that show measured curves but no simulated ones."""
    return _compared(results, lambda labels: labels.has_experiment and not labels.has_simulation)


def misfit(ratios: Sequence[float]) -> float:
    """Median factor, at least 1, between simulated peaks and labels: a ratio of 1/2 counts as one of 2."""
    return float(np.exp(np.median(np.abs(np.log(ratios)))))


def fits_worse(axes: Sequence[AxisComparison]) -> bool:
    """Whether the converged engine's peaks of strain are further from the labels than those of the thesis' model, in the median."""
    misfits = [misfit(found) for name in (REFERENCE, MODEL) if (found := ratios_of(axes, "strain", name))]
    return len(misfits) == 2 and misfits[0] > misfits[1]


def ratios_of(axes: Sequence[AxisComparison], channel: str, engine: str) -> list[float]:
    """An engine's peaks over the labels of a channel's axes."""
    return [axis.ratios[engine] for axis in axes if axis.channel == channel and engine in axis.ratios]


def _compared(results: Sequence[CaseResult], wanted: Callable[[AxisLabels], bool]) -> list[AxisComparison]:
    found = []
    for number, result in thesis_runs(results).items():
        for labels in filter(wanted, axis_labels(number)):
            if labels.largest > 0.0:
                peaks = {name: max(map(run.peak, COLUMNS[labels.channel])) for name, run in result.runs.items() if run.usable}
                ratios = {name: peak / labels.largest for name, peak in peaks.items()}
                found.append(AxisComparison(labels.figure, number, labels.channel, labels.largest, ratios))
    return found
