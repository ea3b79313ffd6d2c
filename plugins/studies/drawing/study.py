"""Draws a study over one or two keys, as lines or heat maps, and the scatter of measures.

Marks and hatches show the status of points that did not settle. Of a scatter it draws how many machines lie below a value, the band, and
the share of each uncertain quantity.
"""

import itertools
import textwrap
from collections.abc import Iterator, Sequence
from typing import Any, Final

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.stability import NOT_CONVERGED, UNSTABLE
from quickreturn.plugins.studies.drawing import key_words, measure_words
from quickreturn.plugins.studies.sweep.grid import Axis
from quickreturn.plugins.studies.sweep.rows import LEFT, OPEN
from quickreturn.plugins.studies.sweep.study import Study
from quickreturn.plugins.studies.uncertainty.scatter import Scatter, Share
from quickreturn.reports.drawing.curves import PANEL, WIDE
from quickreturn.reports.drawing.style import (
    BAND,
    FONT_SIZE,
    GREY,
    LETTERS,
    LIGHT,
    QUICK,
    SMALL,
    Array,
    Drawing,
    legend_above,
    logarithmic,
    new_figure,
    note,
    tidy,
)

#: Largest number of values of a second key that are drawn as lines; with more values a map is drawn.
LINES: Final = 6
#: Ratio of the largest to the smallest value above which their axis is logarithmic.
DECADE: Final = 10.0
#: Approximate number of colours of a map; a logarithmic scale has at least as many.
COLOURS: Final = 10
#: Steps of a logarithmic scale within a decade, from coarse to fine.
STEPS: Final = ((1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 5.0, 7.0))
#: Status of a point that did not settle -> its hatch in maps and its mark on lines.
ENDINGS: Final = {
    UNSTABLE.format("period doubling"): ("////", "o"),
    UNSTABLE.format("torus"): ("xxxx", "s"),
    UNSTABLE.format("fold"): ("----", "D"),
    LEFT: ("....", "X"),
    NOT_CONVERGED: ("\\\\\\\\", "v"),
    OPEN: ("oooo", "^"),
    Ending.NEUTRAL: ("**", "h"),
    Ending.REFUSED: ("||||", "P"),
    Ending.FAILED: ("++++", "*"),
}
#: Colours of a map from low to high: those of viridis that are bright enough for a dark hatch.
BRIGHT: Final = matplotlib.colormaps["viridis"](np.linspace(0.25, 1.0, 256))
_DARK: Final = "#222222"


def drawable(axes: Sequence[Axis]) -> bool:
    """Whether a study can be drawn: over one key with finite numbers in order, and at most one more, with such numbers or few texts."""
    numbers = [np.array(axis.values, dtype=float) for axis in axes if axis.unit]
    ordered = all(np.isfinite(values).all() and len(set(np.sign(np.diff(values)))) == 1 for values in numbers)
    return bool(numbers) and ordered and len(axes) <= 2 and all(bool(axis.unit) or len(axis.texts) <= LINES for axis in axes)


def draw(study: Study) -> Figure:
    """Draw a panel for each measure. The study must be `drawable`."""
    axes = study.grid.axes
    along = max((place for place, each in enumerate(axes) if each.unit), key=lambda place: len(axes[place].texts))
    mapped = len(axes) == 2 and len(axes[1 - along].texts) > LINES
    measures = study.asked.measures
    figure = new_figure(0.6 + (2.3 if mapped else 2.0) * len(measures))
    statuses = [each for each in ENDINGS if each in study.statuses]
    handles: list[Artist] = []
    panels = figure.subplots(len(measures), 1, sharex=True, squeeze=False)[:, 0]
    for place, (name, panel) in enumerate(zip(measures, panels, strict=True)):
        about = MEASURES[name]
        unit = study.grid.case.units.of(about.unit)
        label, shown = textwrap.fill(f"{measure_words(about)} [{unit.sign}]", LETTERS), study.values[..., place] / unit.size
        if mapped:
            values, endings = np.moveaxis(shown, along, 1), np.moveaxis(study.statuses, along, 1)
            handles = _map(panel, axes[along], axes[1 - along], values, endings, statuses, label)
        else:
            handles = _lines(panel, study, along, shown, statuses)
            tidy(panel, label)
    panel.set_xlabel(_scaled(axes[along])[1], fontsize=FONT_SIZE)
    figure.axes[0].set_title(f"{study.grid.case.name}, settled motion", fontsize=FONT_SIZE)
    if handles:
        legend_above(figure, handles, 3)
    return figure


def _scaled(axis: Axis) -> tuple[Array, str]:
    """The values in the unit in which they were given, or in SI if there are several units, and the label with the unit."""
    unit, size = axis.given
    return np.array(axis.values, dtype=float) / size, f"{key_words(axis.key)} [{unit}]"


def _spans_decade(values: Array) -> bool:
    """Whether the values are positive and span more than `DECADE`, so that their axis is logarithmic."""
    finite = values[np.isfinite(values)]
    return bool(finite.size and finite.min() > 0.0 and finite.max() > DECADE * finite.min())


def _lines(panel: Axes, study: Study, along: int, shown: Array, statuses: Sequence[str]) -> list[Artist]:
    """Draw a measure, `shown` in the unit of its axis, over a key; return the entries of the legend.

    There is a line for each value of the other key.
    """
    x, lines = _scaled(study.grid.axes[along])[0], list(_each_line(study, along))
    colours = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.75, len(lines)))
    handles: list[Artist] = []
    for (label, place), colour, dash in zip(lines, colours, itertools.cycle(("-", "--", "-.", ":"))):
        values = shown[place]
        handles += panel.plot(x, values, color=colour, linestyle=dash, linewidth=1.2, marker=".", markersize=3.5, label=label)
        look: dict[str, Any] = {"linestyle": "none", "markersize": 4.5, "markerfacecolor": "white", "markeredgecolor": colour}
        for status in statuses:
            (_, mark), marked = ENDINGS[status], study.statuses[place] == status
            lost = marked & ~np.isfinite(values)
            panel.plot(x[marked], values[marked], marker=mark, **look)
            panel.plot(x[lost], np.full(lost.sum(), 0.04), marker=mark, transform=panel.get_xaxis_transform(), **look)
    if _spans_decade(shown):
        logarithmic(panel)
    panel.set_xscale("log" if _is_geometric(x) else "linear")
    of_points: dict[str, Any] = {"linestyle": "none", "markerfacecolor": "white", "markeredgecolor": _DARK}
    marks = [Line2D([], [], marker=ENDINGS[status][1], label=status, **of_points) for status in statuses]
    return [*(handles if len(lines) > 1 else []), *marks]


def _each_line(study: Study, along: int) -> Iterator[tuple[str, tuple[int | slice, ...]]]:
    """Label and index in the study's arrays of each line."""
    others = [axis for place, axis in enumerate(study.grid.axes) if place != along]
    for number, text in enumerate(others[0].texts if others else ("",)):
        place: list[int | slice] = [number] * len(others)
        place.insert(along, slice(None))
        yield text, tuple(place)


def _map(
    panel: Axes, across: Axis, up: Axis, values: Array, endings: NDArray[np.object_], statuses: Sequence[str], label: str
) -> list[Artist]:
    """Draw a measure, shape (up, across), in steps of colour, with cells hatched that did not settle; return the legend's entries."""
    (x, _), (y, y_label) = _scaled(across), _scaled(up)
    columns, rows = _edges(x), _edges(y)
    if np.isfinite(values).any():
        levels = _levels(values)
        colours = ListedColormap(BRIGHT).resampled(len(levels) - 1)
        mesh = panel.pcolormesh(columns, rows, values, cmap=colours, norm=BoundaryNorm(levels, len(levels) - 1))
        bar = panel.figure.colorbar(mesh, ax=panel, ticks=levels, format="%g", pad=0.02)
        bar.set_label(label, fontsize=SMALL)
        bar.ax.tick_params(labelsize=SMALL)
        bar.minorticks_off()
    handles: list[Artist] = []
    for status in statuses:
        (hatch, _), marked = ENDINGS[status], endings == status
        drawn = bool(np.isfinite(values[marked]).all())
        look: dict[str, Any] = {"facecolor": "none" if drawn else LIGHT, "edgecolor": _DARK, "hatch": hatch, "linewidth": 0.0}
        cells = [_cell(columns[j : j + 2], rows[i : i + 2]) for i, j in np.argwhere(marked)]
        if cells:
            panel.add_patch(PathPatch(Path.make_compound_path(*cells), **look))
        handles.append(Patch(label=status, **look))
    tidy(panel, y_label)
    panel.grid(visible=False)
    panel.set(xscale="log" if _is_geometric(x) else "linear", yscale="log" if _is_geometric(y) else "linear")
    panel.set(xlim=(columns[0], columns[-1]), ylim=(rows[0], rows[-1]))
    return handles


def _levels(values: Array) -> Array:
    """Round bounds of the steps of colour."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if not _spans_decade(values):
        return np.asarray(MaxNLocator(COLOURS + 2).tick_values(low, high))
    for steps in STEPS:
        powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
        bounds = np.unique(np.outer(powers, steps))
        first, last = np.searchsorted(bounds, low, "right") - 1, np.searchsorted(bounds, high)
        if last - first >= COLOURS:
            break
    return bounds[first : last + 1]


def _is_geometric(values: Array) -> bool:
    """Whether neighbours have equal ratios."""
    return bool(np.all(values > 0.0) and len(values) > 2 and np.ptp(np.diff(np.log(values))) < 1e-6)


def _edges(values: Array) -> Array:
    """Bounds of the cells around some values, half-way between them."""
    if _is_geometric(values):
        return np.exp(_edges(np.log(values)))
    middle = 0.5 * (values[1:] + values[:-1])
    return np.array([2.0 * values[0] - middle[0], *middle, 2.0 * values[-1] - middle[-1]])


def _cell(x: Array, y: Array) -> Path:
    (left, right), (low, high) = x, y
    return Path([(left, low), (right, low), (right, high), (left, high), (left, low)], closed=True)


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
