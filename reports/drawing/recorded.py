"""Draws recorded tables over the turn that is compared, with the engines that they are compared with."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.runs.recorded import GROWING, VIBRATING
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.drawing.cycle import direction, fraction, stacked_panels
from quickreturn.reports.drawing.style import all_looks, legend_above, new_figure, note, picture

#: Largest number of columns of a table that are drawn.
MOST_PANELS: Final = 8


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
