"""Columns of trajectories as curves, engines over each other."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes

from quickreturn.cases.files.errors import UnknownColumn, known_column
from quickreturn.cases.files.shown import METRIC, Units
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.drawing.style import FONT_SIZE, SAMPLE, Array, Drawing, look, new_figure, tidy

#: Columns that are drawn if the caller names none.
USUAL: Final = ("tip_deflection", "tip_acceleration", "strain_2", "slider_force")

WIDE: Final = 8.0  # in, of several panels
PANEL: Final = 1.9  # in, height


def curves(
    trajectories: Mapping[str, Mapping[str, Array]], columns: Sequence[str] = (), *, title: str = "", units: Units = METRIC
) -> Drawing:
    """Draw columns over time, a panel for each.

    Args:
        trajectories: label -> column -> values; a label that is an engine's name gives the line that engine's look.
        columns: names of columns; empty: those of `USUAL` that exist.
        title: text above the panels.
        units: units of the columns.

    Raises:
        UnknownColumn: no trajectory has a column of that name, or any of `USUAL`.
    """
    available = {name: None for trajectory in trajectories.values() for name in trajectory}
    chosen = [known_column(name, available) for name in columns] or [name for name in USUAL if name in available]
    if not chosen:
        raise UnknownColumn(f"none of the usual columns is there; name some of {', '.join(name for name in available if name != 'time')}")
    figure = new_figure(0.8 + PANEL * len(chosen), WIDE)
    panels = figure.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(panels, chosen, strict=True):
        _panel(axes, trajectories, name, "time", units)
    panels[-1].set_xlabel("time [s]", fontsize=FONT_SIZE)
    _finish(figure, panels[0], title)
    return figure


def stacked(cycles: Mapping[str, Mapping[str, Mapping[str, Array]]], columns: Sequence[str]) -> Drawing:
    """Draw cycles (case -> label -> column -> values) over the crank angle: a row for each case, in it a panel for each column."""
    figure = new_figure(0.8 + PANEL * len(cycles), max(WIDE, 4.0 * len(columns)))
    grid = figure.subplots(len(cycles), len(columns), squeeze=False, sharex=True)
    for row, (case, runs) in zip(grid, cycles.items(), strict=True):
        for axes, name in zip(row, columns, strict=True):
            _panel(axes, runs, name, "crank_angle", METRIC)
        row[0].set_title(case, fontsize=FONT_SIZE, loc="left")
    for axes in grid[-1]:
        axes.set_xlabel("crank angle from the farthest place [deg], quick return at 180", fontsize=FONT_SIZE)
    _finish(figure, grid[0, 0], "")
    return figure


def _panel(axes: Axes, trajectories: Mapping[str, Mapping[str, Array]], column: str, over: str, units: Units) -> None:
    unit = units.column(COLUMNS[column].unit)
    for label, trajectory in trajectories.items():
        if column in trajectory:
            along: Any = trajectory["time"]
            if over == "crank_angle":
                angle = trajectory["crank_angle"]
                along = np.degrees(np.abs(angle - angle[0]))
            axes.plot(along, trajectory[column] / unit.size, label=label, **look(label))
    if over == "crank_angle":
        axes.set_xticks(range(0, 361, 90))
        axes.axvline(180.0, color="#444444", linewidth=0.8, linestyle=(0, (2, 2)), zorder=1.5)
    tidy(axes, f"{column.replace('_', ' ')} [{unit.sign}]")


def _finish(figure: Drawing, first: Axes, title: str) -> None:
    if title:
        figure.suptitle(title, fontsize=FONT_SIZE + 1.0)
    handles, labels = first.get_legend_handles_labels()
    if len(handles) > 1:
        figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=FONT_SIZE, frameon=False, handlelength=SAMPLE)
