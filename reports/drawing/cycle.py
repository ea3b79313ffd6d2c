"""The cycle as the axis of pictures: from the slider's farthest place (0) over the quick return (0.5) to the next (1).

Over it are drawn tip acceleration and the three surface strains, as in the thesis' figures A.1 to A.24, or recorded tables.
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

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.comparison.tables import GROWING, VIBRATING
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.drawing.style import (
    BAND,
    FONT_SIZE,
    SMALL,
    Array,
    all_looks,
    legend_above,
    look,
    new_figure,
    note,
    padded,
    picture,
    tidy,
)
from quickreturn.reports.words import angle_text, number

ACCELERATION: Final = "tip_acceleration"
PERCENT: Final = 100.0  # strain is shown in percent of surface strain, as the thesis prints it
WIDEST: Final = 2.0  # times the curves' own range: limit of an axis that shows the printed labels, so that curves stay readable
TICKS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)
BEND_IN: Final = 1e-9  # a strain below this in a whole cycle is round-off of a follower that does not bend


#: Largest number of columns of a recorded table that are drawn.
MOST_PANELS: Final = 8
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


def drawn(results: Sequence[CaseResult], ending: str) -> bytes:
    """The content of a picture file with the recorded tables of the results; `ending` is ".png", ".svg" or ".pdf"."""
    return picture(draw_recorded(results), ending)


def draw_recorded(results: Sequence[CaseResult]) -> Figure:
    """Draw the columns of the tables of each result over the turn that is compared."""
    names = [_names(result) for result in results]
    figure = new_figure(1.2 + 1.25 * sum(map(len, names)))
    panels = list(np.ravel(figure.subplots(sum(map(len, names)), 1, sharex=True, squeeze=False)))
    styles = all_looks(list(dict.fromkeys(name for result in results for name in result.with_tables.runs)))
    handles: dict[str, Artist] = {}
    labels, place = [], 0
    for result, shown in zip(results, names, strict=True):
        units = {name: result.case.units.column(COLUMNS[name].unit) for name in shown}
        for run in (run for run in result.with_tables.runs.values() if run.cycle and (run.usable or run.recording)):
            style = styles[run.engine]
            handles[run.engine] = Line2D([], [], label=_plain(run.engine), **style)
            for axes, name in zip(panels[place:], shown, strict=False):
                if name in run.cycle:
                    axes.plot(fraction(run.cycle["crank_angle"]), run.cycle[name] / units[name].size, **style)
        turn = next(iter(result.recorded.values())).approach.turn
        note(panels[place], 0.01, 0.97, "steady state" if turn is None else f"turn {turn} from the standard start")
        labels += [f"{name.replace('_', ' ')}\n({units[name].sign})" for name in shown]
        place += len(shown)
    stacked_panels(panels, labels, direction(next(iter(results[0].recorded.values()))))
    legend_above(figure, list(handles.values()), 3)
    return figure


def _names(result: CaseResult) -> list[str]:
    """The columns of a result's recorded tables that are drawn, those that show vibration first."""
    names = [name for name in (*VIBRATING, *COLUMNS) if name not in GROWING and any(name in run.cycle for run in result.recorded.values())]
    return list(dict.fromkeys(names))[:MOST_PANELS]


def _plain(name: str) -> str:
    """The name as plain text: matplotlib would read text between dollar signs as a formula, and hide names that begin with _."""
    return name.replace("$", r"\$").lstrip("_")


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
