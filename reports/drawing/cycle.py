"""The cycle as the axis of pictures: from the slider's farthest place (0) over the quick return (0.5) to the next (1).

Over it are drawn columns of engines, and of recorded tables.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.comparison.tables import GROWING, VIBRATING
from quickreturn.cases.motion.request import Run
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.drawing.style import FONT_SIZE, SMALL, Drawing, all_looks, legend_above, new_figure, note, tidy
from quickreturn.reports.words import angle_text

TICKS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)
#: Largest number of columns of a recorded table that are drawn.
MOST_PANELS: Final = 8


def draw(results: Sequence[CaseResult], columns: Sequence[str] = ()) -> Drawing:
    """Draw columns of each result, those named or those of its recorded tables, over its cycle or the turn that is compared."""
    names = [list(columns) or _names(result) for result in results]
    figure = new_figure(1.2 + 1.25 * sum(map(len, names)))
    panels = list(np.ravel(figure.subplots(sum(map(len, names)), 1, sharex=True, squeeze=False)))
    styles = all_looks(list(dict.fromkeys(name for result in results for name in result.with_tables.runs)))
    handles: dict[str, Artist] = {}
    labels, place, turning = [], 0, 1
    for result, shown in zip(results, names, strict=True):
        units = {name: result.case.units.column(COLUMNS[name].unit) for name in shown}
        for run in (run for run in result.with_tables.runs.values() if run.cycle and (run.usable or run.recording)):
            style, turning = styles[run.engine], direction(run)
            handles[run.engine] = Line2D([], [], label=_plain(run.engine), **style)
            for axes, name in zip(panels[place:], shown, strict=False):
                if name in run.cycle:
                    axes.plot(fraction(run.cycle["crank_angle"]), run.cycle[name] / units[name].size, **style)
        turn = next((run.approach.turn for run in result.recorded.values()), None)
        note(panels[place], 0.01, 0.97, "steady state" if turn is None else f"turn {turn} from the standard start")
        labels += [f"{name.replace('_', ' ')}\n({units[name].sign})" for name in shown]
        place += len(shown)
    stacked_panels(panels, labels, turning)
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
