"""Compares simulated peaks with the axes of the thesis' figures, whose largest legible label bounds the plotted curves from below."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.library.thesis import RUNS, run_name
from quickreturn.engines.registry import MODEL
from quickreturn.plugins.thesis.experiment import AxisLabels, axis_labels
from quickreturn.reports.page.content import of_library


def thesis_runs(results: Sequence[CaseResult]) -> dict[int, CaseResult]:
    """The runs of the thesis among the cases shown, by number."""
    results_by_number = ((number, of_library(results, run_name(number))) for number in RUNS)
    return {number: result for number, result in results_by_number if result is not None}


#: Channel of an axis -> trajectory columns that it shows.
COLUMNS = {"tip_acceleration": ("tip_acceleration",), "strain": ("strain_1", "strain_2", "strain_3")}


@dataclass(frozen=True)
class AxisComparison:
    """One axis of a figure, compared with simulated peaks."""

    figure: str  # name in the thesis, e.g. "A.24"
    run: int
    channel: str  # key of `COLUMNS`
    largest_label: float  # largest magnitude among its legible labels, SI
    ratios: Mapping[str, float]  # engine -> its peak over the cycle, over that label


def axis_comparisons(results: Sequence[CaseResult]) -> list[AxisComparison]:
    """Comparisons with the appendix' figures, which show simulated and measured curves except that of run 1: the simulated ones alone."""
    return _compared(results, lambda labels: labels.figure.startswith("A."))


def measured_alone(results: Sequence[CaseResult]) -> list[AxisComparison]:
    """Comparisons with the figures that show measured curves but no simulated ones."""
    return _compared(results, lambda labels: labels.has_experiment and not labels.has_simulation)


def misfit(ratios: Sequence[float]) -> float:
    """Median factor, at least 1, between simulated peaks and labels: a ratio of 1/2 counts as one of 2."""
    return float(np.exp(np.median(np.abs(np.log(ratios)))))


def fits_worse(axes: Sequence[AxisComparison]) -> bool:
    """Whether the reference's peaks of strain have a larger `misfit` than those of the thesis' model."""
    misfits = [misfit(ratios) for name in (REFERENCE, MODEL) if (ratios := ratios_of(axes, "strain", name))]
    return len(misfits) == 2 and misfits[0] > misfits[1]


def ratios_of(axes: Sequence[AxisComparison], channel: str, engine: str) -> list[float]:
    """An engine's peaks over the labels of a channel's axes."""
    return [axis.ratios[engine] for axis in axes if axis.channel == channel and engine in axis.ratios]


def _compared(results: Sequence[CaseResult], wanted: Callable[[AxisLabels], bool]) -> list[AxisComparison]:
    comparisons = []
    for number, result in thesis_runs(results).items():
        for labels in filter(wanted, axis_labels(number)):
            if labels.largest > 0.0:
                peaks = {name: max(map(run.peak, COLUMNS[labels.channel])) for name, run in result.runs.items() if run.usable}
                ratios = {name: peak / labels.largest for name, peak in peaks.items()}
                comparisons.append(AxisComparison(labels.figure, number, labels.channel, labels.largest, ratios))
    return comparisons
