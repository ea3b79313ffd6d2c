"""The cycle as the axis of pictures: from the slider's farthest place (0) over the quick return (0.5) to the next (1).

Over it are drawn tip acceleration and the three surface strains, as in the thesis' figures A.1 to A.24.
"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.runs.request import Run
from quickreturn.reports.drawing.style import BAND, FONT_SIZE, SMALL, Array, legend_above, look, new_figure, note, padded, tidy
from quickreturn.reports.words import angle_text, number

ACCELERATION: Final = "tip_acceleration"
PERCENT: Final = 100.0  # strain is shown in percent of surface strain, as the thesis prints it
WIDEST: Final = 2.0  # times the curves' own range: limit of an axis that shows the printed labels, so that curves stay readable
TICKS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)
BEND_IN: Final = 1e-9  # a strain below this in a whole cycle is round-off of a follower that does not bend


#: Range of printed axis labels, SI: of the tip acceleration, and one for all strains.
Printed = Mapping[str, tuple[float, float]]


def draw_cycle(result: CaseResult, printed: Printed = MappingProxyType({})) -> Figure:
    """Draw all engines over one cycle, with the range of the printed axis labels if there are any.

    Args:
        result: of a case, at least one of its runs with a cycle.
        printed: of a figure of this case.
    """
    runs = {name: run for name, run in result.runs.items() if run.usable}
    channels = [name for name in CHANNELS if name == ACCELERATION or any(run.peak(name) > BEND_IN for run in runs.values())]
    figure = new_figure(1.4 + 1.25 * len(channels))
    heights = [1.5 if name == ACCELERATION else 1.0 for name in channels]
    panels = np.ravel(figure.subplots(len(channels), 1, sharex=True, height_ratios=heights, squeeze=False))
    unit = result.case.units.of("m/s^2")
    gauges = [place / result.case.mechanism.follower.length for place in result.case.mechanism.follower.strain_gauges]
    for axes, channel in zip(panels, channels, strict=True):
        factor = 1.0 / unit.size if channel == ACCELERATION else PERCENT
        for name, run in runs.items():
            axes.plot(fraction(run.cycle["crank_angle"]), factor * run.cycle[channel], **look(name))
        _limits(axes, [factor * run.cycle[channel] for run in runs.values()], _printed_range(printed, channel), factor)
        if channel != ACCELERATION:
            note(axes, 0.01, 0.97, f"gauge at {gauges[int(channel[-1]) - 1]:.3g} L")
    y_labels = [f"tip acceleration ({unit.sign})" if name == ACCELERATION else f"strain {name[-1]} (%)" for name in channels]
    stacked_panels(list(panels), y_labels, direction(next(iter(runs.values()))))
    handles: list[Artist] = [Line2D([], [], label=name, **look(name)) for name in runs]
    if any(_printed_range(printed, channel) for channel in CHANNELS):
        handles.append(Patch(facecolor=BAND, edgecolor="#C9A227", linewidth=0.6, label="printed axis labels"))
    legend_above(figure, handles, 3)
    return figure


def _printed_range(printed: Printed, channel: str) -> tuple[float, float] | None:
    return printed.get(ACCELERATION if channel == ACCELERATION else "strain")


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


def fraction(crank_angle: Array) -> Array:
    """Fraction of the cycle, by crank angle (rad, from the slider's farthest place), in either direction of turning."""
    return np.abs(crank_angle - crank_angle[0]) / (2.0 * np.pi)


def direction(run: Run) -> int:
    """+1 where the crank angle grows, -1 where it falls."""
    angle = run.cycle["crank_angle"]
    return 1 if angle[-1] > angle[0] else -1


def stacked_panels(panels: Sequence[Axes], labels: Sequence[str], turning: int) -> None:
    """Arrange quantities over a common axis, each with its label and unit.

    The fraction of the cycle is below the lowest, the crank angle above the uppermost; the quick return is marked in all.
    """
    for axes, label in zip(panels, labels, strict=True):
        tidy(axes, label)
        axes.set_xlim(0.0, 1.0)
        axes.set_xticks(TICKS)
        axes.axvline(0.5, color="#444444", linewidth=0.8, linestyle=(0, (2, 2)), zorder=1.5)
        axes.tick_params(labelbottom=axes is panels[-1])
    panels[-1].set_xlabel("cycle (0.5: quick return)", fontsize=FONT_SIZE)
    above = panels[0].secondary_xaxis("top")
    above.set_xticks(TICKS, [angle_text(180.0 + turning * 360.0 * tick) for tick in TICKS])
    above.tick_params(labelsize=SMALL, length=2.5, width=0.6)
    above.set_xlabel("crank angle", fontsize=FONT_SIZE)
