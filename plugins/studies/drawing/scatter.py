"""Draws the scatter of measures: how many machines lie below a value, the band, and the share of each uncertain quantity."""

import textwrap
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.plugins.studies.drawing import key_words, measure_words
from quickreturn.plugins.studies.uncertainty.scatter import Scatter, Share
from quickreturn.reports.drawing.curves import PANEL, WIDE
from quickreturn.reports.drawing.style import BAND, FONT_SIZE, GREY, QUICK, Drawing, legend_above, new_figure, note, tidy

BAR: Final = 0.2  # in, height of the two bars of a quantity
LINE: Final = 45  # largest number of characters in a line of a note
DARK: Final = "#1062c8"  # of lines and bars


def scatter_figure(scatter: Scatter) -> Drawing:
    """A row for each measure: the distribution of its values with the band; beside it, where known, the shares of its variance."""
    height = max(PANEL, 0.8 + BAR * len(scatter.distributions))
    figure = new_figure(0.8 + height * len(scatter.measures), WIDE)
    shares = {name: [] if scatter.lacking(name) else scatter.shares(name) for name in scatter.measures}
    ratios = (3, 2) if any(shares.values()) else (1,)
    panels = figure.subplots(len(scatter.measures), len(ratios), squeeze=False, width_ratios=ratios)
    for name, row in zip(scatter.measures, panels, strict=True):
        _distribution(row[0], scatter, name)
        if len(ratios) == 2:
            _shares(row[1], shares[name])
    handles: list[Line2D | Patch] = [
        Line2D([], [], linestyle="none", marker=".", color=GREY, label="points"),
        Patch(color=BAND, label="nine of ten machines"),
        Line2D([], [], marker="|", color=DARK, label="5, 50, 95 %, both errors"),
    ]
    if len(ratios) == 2:
        handles += [Patch(color=DARK, label="share by this quantity alone"), Patch(color=QUICK, label="with its interactions")]
    legend_above(figure, handles, len(handles))
    counts = ", ".join(f"{count} {status}" for status, count in scatter.counts.items())
    panels[0, 0].set_title(f"{scatter.case.name}: {len(scatter.statuses)} points, {counts}", fontsize=FONT_SIZE)
    return figure


def _distribution(axes: Axes, scatter: Scatter, name: str) -> None:
    """Draw the share of the points below each value, the band, and the three quantiles with both errors."""
    unit, size = (shown := scatter.case.units.of(MEASURES[name].unit)).sign, shown.size
    _, values = scatter.of(name)
    values = np.sort(values) / size
    axes.plot(values, 100.0 * (np.arange(len(values)) + 0.5) / max(len(values), 1), ".", color=GREY, markersize=3.0)
    if lacking := scatter.lacking(name):
        note(axes, 0.98, 0.06, textwrap.fill(f"no band: {lacking}", LINE), ha="right", va="bottom")
    else:
        low, high = (end / size for end in scatter.band(name))
        axes.axvspan(low, high, color=BAND, zorder=0.5)
        found = scatter.quantiles(name)
        best = [each.value / size for each in found]
        errors = [each.whole / size for each in found]
        levels = [100.0 * each.probability for each in found]
        axes.errorbar(best, levels, xerr=errors, fmt="|", color=DARK, capsize=3.0, zorder=3.0)
    axes.set_ylim(0.0, 100.0)
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.set_xlabel(f"{measure_words(MEASURES[name])} [{unit}]", fontsize=FONT_SIZE)
    tidy(axes, "machines below [%]")


def _shares(axes: Axes, shares: Sequence[Share]) -> None:
    """Draw two bars for each uncertain quantity: its share of the variance alone, and in all."""
    if not shares:
        axes.set_axis_off()
        note(axes, 0.02, 0.96, "no share can be told")
        return
    places = np.arange(len(shares))[::-1]
    look: dict[str, Any] = {"height": 0.36, "error_kw": {"elinewidth": 0.8, "capsize": 2.0, "ecolor": "#333333"}}
    axes.barh(places + 0.19, [each.first for each in shares], xerr=[each.first_error for each in shares], color=DARK, **look)
    axes.barh(
        places - 0.19,
        [each.total for each in shares],
        xerr=[each.total_error for each in shares],
        color=QUICK,
        **look,
    )
    axes.set_yticks(places, [key_words(each.key) for each in shares])
    axes.set_xlim(0.0, 1.05)
    axes.set_xlabel("share of the variance", fontsize=FONT_SIZE)
    tidy(axes)
