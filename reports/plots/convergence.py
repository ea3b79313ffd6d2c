"""How far the reference has converged."""

from typing import Final

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from reports.plots.picture import Picture, picture
from reports.plots.style import (
    BLACK,
    BLUE,
    GREEN,
    PURPLE,
    SKY_BLUE,
    VERMILION,
    legend_above,
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
        table: of `engines.convergence.convergence_table`.

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
