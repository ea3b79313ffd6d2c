"""How first-mode frequency and amplitude answer to what the thesis leaves open."""

import textwrap
from typing import Final

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from reports.plots.picture import Picture, picture
from reports.plots.style import BLUE, FONT_SIZE, GREY, SMALL, VERMILION, legend_above, new_figure, tidy

FREQUENCY: Final = "first_mode_frequency"
AMPLITUDE: Final = "first_mode_amplitude"
TITLES: Final = {FREQUENCY: "first-mode frequency", AMPLITUDE: "first-mode amplitude"}
LOOKS: Final = ((BLUE, "o"), (VERMILION, "s"), (GREY, "^"))  # of the runs, in their order
LINE: Final = 26  # letters in a line of a row's label
ROW: Final = 0.42  # in
PERCENT: Final = 100.0
MARKER: Final = 4.8  # pt


def sensitivity_figure(table: pd.DataFrame) -> Picture | None:
    """Relative changes of frequency and amplitude per change of the scene: runs by colour, halves by filling.

    Where there are several channels (amplitude), the mark is their median and the line reaches over all of them.

    Args:
        table: columns run, change, half ("pre", "post"), quantity, relative_change (NaN where not resolvable).

    Returns:
        None without a single change that could be resolved.
    """
    figure = draw_sensitivity(table)
    if figure is None:
        return None
    return picture(
        figure,
        "Relative change of first-mode frequency and amplitude with what the thesis leaves open: " + "; ".join(table["change"].unique()),
    )


def draw_sensitivity(table: pd.DataFrame) -> Figure | None:
    """The figure before it is rendered; see `sensitivity_figure`."""
    if table.empty:
        return None
    known = table.dropna(subset=["relative_change"])
    quantities = [quantity for quantity in TITLES if (known["quantity"] == quantity).any()]
    if not quantities:
        return None
    changes, runs = list(table["change"].unique()), list(table["run"].unique())
    figure = new_figure(1.1 + ROW * len(changes))
    panels = figure.subplots(1, len(quantities), sharey=True, squeeze=False)[0]
    for axes, quantity in zip(panels, quantities, strict=True):
        tidy(axes, f"change of\n{TITLES[quantity]} (%)", None, "x")
        axes.axvline(0.0, color="black", linewidth=0.8, zorder=1.0)
        for (run, change, half), rows in known[known["quantity"] == quantity].groupby(["run", "change", "half"], sort=False):
            place = changes.index(change) + _offset(runs.index(run), len(runs), str(half))
            _mark(axes, place, PERCENT * rows["relative_change"].to_numpy(dtype=float), *LOOKS[runs.index(run) % len(LOOKS)], str(half))
        axes.margins(x=0.08)
        axes.hlines(np.arange(len(changes) - 1) + 0.5, 0.0, 1.0, color="#DDDDDD", linewidth=0.5, transform=axes.get_yaxis_transform())
    panels[0].set_yticks(range(len(changes)), [textwrap.fill(change, LINE) for change in changes], fontsize=SMALL)
    panels[0].set_ylim(len(changes) - 0.5, -0.5)
    panels[0].set_ylabel("changed", fontsize=FONT_SIZE)
    legend_above(figure, _handles(runs), len(runs) + 2)
    return figure


def _offset(run: int, runs: int, half: str) -> float:
    """Place within a row: each run and half on a line of its own."""
    lines = 2 * runs
    return (2 * run + (half == "post") + 0.5) / lines * 0.8 - 0.4


def _mark(axes: Axes, place: float, changes: np.ndarray, colour: str, marker: str, half: str) -> None:
    if changes.size > 1:
        axes.plot([changes.min(), changes.max()], [place, place], color=colour, linewidth=1.0, zorder=2.0)
    face = colour if half == "pre" else "white"
    axes.plot(np.median(changes), place, marker, color=colour, markerfacecolor=face, markersize=MARKER, zorder=3.0)


def _handles(runs: list[str]) -> list[Line2D]:
    def point(label: str, colour: str, marker: str, face: str) -> Line2D:
        return Line2D([], [], linestyle="none", marker=marker, color=colour, markerfacecolor=face, markersize=MARKER, label=label)

    of_runs = [point(run, LOOKS[i % len(LOOKS)][0], LOOKS[i % len(LOOKS)][1], LOOKS[i % len(LOOKS)][0]) for i, run in enumerate(runs)]
    return [*of_runs, point("pre-return", GREY, "o", GREY), point("post-return", GREY, "o", "white")]
