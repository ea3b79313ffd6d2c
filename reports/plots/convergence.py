"""How far the reference has converged, and what accuracy costs."""

from typing import Final

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from reports.plots.picture import Picture, picture
from reports.plots.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    PURPLE,
    SKY_BLUE,
    VERMILION,
    legend_above,
    look,
    new_figure,
    plain_numbers,
    tidy,
)

#: Column of the tables -> words, colour, marker.
COLUMNS: Final = {
    "tip_deflection": ("tip deflection", BLACK, "o"),
    "tip_acceleration": ("tip acceleration", VERMILION, "D"),
    "strain_1": ("strain 1", BLUE, "^"),
    "strain_2": ("strain 2", SKY_BLUE, "s"),
    "strain_3": ("strain 3", GREEN, "v"),
    "slider_force": ("slider force", PURPLE, "P"),
}
PERCENT: Final = 100.0


def convergence_figure(table: pd.DataFrame) -> Picture | None:
    """Error of each column over the number of modes, at the smallest tolerance of the integration.

    Args:
        table: of `engines.pseudo_coordinate.convergence.convergence_table`.

    Returns:
        None where the table has no row but the one that the errors are taken against.
    """
    figure = draw_convergence(table)
    if figure is None:
        return None
    return picture(figure, "Error of the reference over its number of modes, per observable, both axes logarithmic")


def draw_convergence(table: pd.DataFrame) -> Figure | None:
    """The figure before it is rendered; see `convergence_figure`."""
    if table.empty:
        return None
    tolerance = table["tolerance"].min()
    rows = table[(table["tolerance"] == tolerance) & ~table["is_reference"].astype(bool)].sort_values("modes")
    if rows.empty:
        return None
    figure = new_figure(3.9)
    axes = figure.subplots()
    handles = []
    for column, (words, colour, marker) in COLUMNS.items():
        (line,) = axes.plot(rows["modes"], PERCENT * rows[column], marker=marker, color=colour, linewidth=1.1, markersize=4.5, label=words)
        handles.append(line)
    axes.set_xscale("log")
    axes.set_yscale("log")
    tidy(axes, f"modes (integration tolerance {tolerance:.0e})".replace("e-0", "e-"), "error (% of RMS)")
    axes.set_xticks(rows["modes"].tolist(), [str(modes) for modes in rows["modes"]])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks([], minor=True)
    plain_numbers(axes, "y")
    legend_above(figure, handles, 3)
    return figure


def cost_figure(rows: pd.DataFrame) -> Picture | None:
    """Error against solve time, a point per engine and setting, those of one engine joined by a line.

    Args:
        rows: columns engine, solve_seconds, and the errors of `COLUMNS`.

    Returns:
        None without rows.
    """
    figure = draw_cost(rows)
    if figure is None:
        return None
    engines = ", ".join(dict.fromkeys(rows["engine"]))
    return picture(figure, f"Error of the tip deflection, and largest error of any observable, against solve time, engines {engines}")


def draw_cost(rows: pd.DataFrame) -> Figure | None:
    """The figure before it is rendered; see `cost_figure`."""
    if rows.empty:
        return None
    figure = new_figure(3.4)
    axes = figure.subplots()
    marks: list[Line2D] = []
    for name, points in rows.sort_values("solve_seconds").groupby("engine", sort=False):
        style = look(str(name))
        seconds, deflection = points["solve_seconds"].to_numpy(), PERCENT * points["tip_deflection"].to_numpy()
        worst = PERCENT * points[list(COLUMNS)].max(axis=1).to_numpy()
        axes.vlines(seconds, deflection, worst, color=style.colour, linewidth=1.0)
        axes.plot(seconds, deflection, style.marker, color=style.colour, markersize=6.5)
        axes.plot(seconds, worst, style.marker, color=style.colour, markersize=6.5, markerfacecolor="white")
        if len(points) > 1:
            axes.plot(seconds, deflection, color=style.colour, linewidth=1.0, linestyle=style.line)
        marks.append(Line2D([], [], linestyle="none", marker=style.marker, color=style.colour, markersize=6.0, label=str(name)))
    axes.set_xscale("log")
    axes.set_yscale("log")
    low, high = rows["solve_seconds"].min(), rows["solve_seconds"].max()
    axes.set_xlim(low / 2.0, 2.0 * high)
    tidy(axes, "solve time (s)", "error (% of RMS)")
    for which in ("x", "y"):
        plain_numbers(axes, which)
    axes.tick_params(which="minor", length=1.5, width=0.5)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter(NullFormatter())
    for words, face in (("tip deflection", GREY), ("worst observable", "white")):
        marks.append(Line2D([], [], linestyle="none", marker="o", color=GREY, markerfacecolor=face, markersize=6.0, label=words))
    legend_above(figure, marks, 3)
    return figure
