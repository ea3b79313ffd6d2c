"""Tip acceleration and the three surface strains over the steady cycle, as in the thesis' figures A.1 to A.24."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from cases.experiment import AxisLabels
from cases.measures import CHANNELS
from cases.runs.comparison import CaseResult
from reports.plots.picture import Picture, picture
from reports.plots.steady_cycle import Array, direction, drawn_runs, fraction, missing_runs, name_in_legend, stacked_panels
from reports.plots.style import BAND, legend_above, look, new_figure, note, number, padded

ACCELERATION: Final = "tip_acceleration"
PERCENT: Final = 100.0  # strain is shown in percent of surface strain, as the thesis prints it
WIDEST: Final = 2.0  # times the curves' own range: an axis is not widened further to show the printed labels, or curves would lie flat
BEND_IN: Final = 1e-9  # a strain below this in a whole cycle is round-off of a follower that does not bend


def cycle_figure(result: CaseResult, labels: Sequence[AxisLabels] = ()) -> Picture | None:
    """All engines over one cycle, with the range of the printed axis labels where there are any.

    Args:
        result: of a case.
        labels: of the case's run, first choice first (`cases.experiment.axis_labels`).

    Returns:
        None where no engine has a cycle to show.
    """
    figure = draw_cycle(result, labels)
    if figure is None:
        return None
    engines = ", ".join(drawn_runs(result))
    return picture(figure, f"{result.case.name}: tip acceleration and surface strains over the steady cycle, engines {engines}")


def draw_cycle(result: CaseResult, labels: Sequence[AxisLabels]) -> Figure | None:
    """The figure before it is rendered; see `cycle_figure`."""
    runs = drawn_runs(result)
    channels = [name for name in CHANNELS if name == ACCELERATION or any(run.peak(name) > BEND_IN for run in runs.values())]
    if not runs:
        return None
    figure = new_figure(1.4 + 1.25 * len(channels))
    heights = [1.5 if name == ACCELERATION else 1.0 for name in channels]
    panels = np.ravel(figure.subplots(len(channels), 1, sharex=True, height_ratios=heights, squeeze=False))
    for axes, channel in zip(panels, channels, strict=True):
        factor = 1.0 if channel == ACCELERATION else PERCENT
        shown = [(fraction(run.cycle["crank_angle"]), factor * run.cycle[channel], look(name).of_line) for name, run in runs.items()]
        for cycle, values, style in shown:
            axes.plot(cycle, values, **style)
        _limits(axes, [values for _, values, _ in shown], _printed_range(labels, channel), factor)
    gauges = [place / result.case.mechanism.follower.length for place in result.case.mechanism.follower.strain_gauges]
    y_labels = ["tip acceleration (m/s²)" if name == ACCELERATION else f"strain {name[-1]} (%)" for name in channels]
    stacked_panels(list(panels), y_labels, direction(next(iter(runs.values()))))
    for axes, channel in zip(panels, channels, strict=True):
        if channel != ACCELERATION:
            note(axes, 0.01, 0.97, f"gauge at {gauges[int(channel[-1]) - 1]:.3g} L")
    legend_above(figure, _handles(result, labels), 3)
    return figure


def _printed_range(labels: Sequence[AxisLabels], channel: str) -> tuple[float, float] | None:
    kind = ACCELERATION if channel == ACCELERATION else "strain"
    return next((label.range for label in labels if label.channel == kind and label.range[0] < label.range[1]), None)


def _limits(axes: Axes, curves: Sequence[Array], printed: tuple[float, float] | None, factor: float) -> None:
    """Limits of the ordinate around the curves, widened towards the printed range as far as curves stay readable."""
    low, high = padded(min(float(np.min(values)) for values in curves), max(float(np.max(values)) for values in curves))
    if printed is not None:
        bottom, top = factor * printed[0], factor * printed[1]
        axes.axhspan(bottom, top, facecolor=BAND, edgecolor="#C9A227", linewidth=0.6, zorder=0.5)
        room = 0.5 * (WIDEST - 1.0) * (high - low)
        wide = max(low - room, min(low, padded(bottom, top)[0])), min(high + room, max(high, padded(bottom, top)[1]))
        if wide[0] > bottom or wide[1] < top:
            note(axes, 0.99, 0.03, f"printed labels {number(bottom, '.3g')} to {number(top, '.3g')}", ha="right", va="bottom")
        low, high = wide
    axes.set_ylim(low, high)


def _handles(result: CaseResult, labels: Sequence[AxisLabels]) -> list[Artist]:
    handles: list[Artist] = []
    for name, run in drawn_runs(result).items():
        handles.append(Line2D([], [], label=name_in_legend(name, run), **look(name).of_sample))
    if any(_printed_range(labels, channel) for channel in CHANNELS):
        handles.append(Patch(facecolor=BAND, edgecolor="#C9A227", linewidth=0.6, label="printed axis labels"))
    absent = missing_runs(result)
    if absent:
        handles.append(Line2D([], [], linestyle="none", label=absent))
    return handles
