"""Columns of trajectories as curves, engines over each other."""

from collections.abc import Mapping, Sequence
from typing import Final

from matplotlib.axes import Axes

from quickreturn.cases.files.errors import UnknownColumn, known_column
from quickreturn.cases.files.shown import METRIC, Units
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.drawing.style import FONT_SIZE, SAMPLE, Drawing, look, new_figure, tidy

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
        _panel(axes, trajectories, name, units)
    panels[-1].set_xlabel("time [s]", fontsize=FONT_SIZE)
    if title:
        figure.suptitle(title, fontsize=FONT_SIZE + 1.0)
    handles, labels = panels[0].get_legend_handles_labels()
    if len(handles) > 1:
        figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=FONT_SIZE, frameon=False, handlelength=SAMPLE)
    return figure


def _panel(axes: Axes, trajectories: Mapping[str, Mapping[str, Array]], column: str, units: Units) -> None:
    unit = units.column(COLUMNS[column].unit)
    for label, trajectory in trajectories.items():
        if column in trajectory:
            axes.plot(trajectory["time"], trajectory[column] / unit.size, label=label, **look(label))
    tidy(axes, f"{column.replace('_', ' ')} [{unit.sign}]")
