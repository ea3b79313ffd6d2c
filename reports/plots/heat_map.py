"""Who disagrees with whom: every pair of engines on every run, for frequency, amplitude and extremes."""

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Final

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from cases.runs.comparison import REFERENCE, CaseResult, largest_differences
from reports.plots.overview import row_title, run_labels
from reports.plots.picture import Picture, picture
from reports.plots.style import FONT_SIZE, SMALL, legend_above, new_figure

Array = NDArray[np.float64]

QUANTITIES: Final = ("frequency", "amplitude", "extremes")
PERCENT: Final = 100.0
SHADES: Final = (0.1, 100.0)  # %, ends of the scale
DARK: Final = 0.45  # of lightness: below, numbers are white
ROW: Final = 0.19  # in
BAR: Final = 0.14  # in, height of the scale, of however few rows
NUMBER: Final = 6.5  # pt
COLOURS: Final = 64  # of the picture


def heat_map_figure(results: Sequence[CaseResult]) -> Picture | None:
    """Largest relative difference over halves and channels, in percent; None with fewer than two engines.

    Differences are relative to the second engine of a pair: its frequency, its amplitude, the peak of its channel.
    """
    figure = draw_heat_map(results)
    if figure is None:
        return None
    pairs = ", ".join(f"{first} and {second}" for first, second in _pairs(results))
    return picture(figure, f"Largest difference in percent of {', '.join(QUANTITIES)} between {pairs}, run by run", COLOURS)


def draw_heat_map(results: Sequence[CaseResult]) -> Figure | None:
    """The figure before it is rendered; see `heat_map_figure`."""
    pairs = _pairs(results)
    if not pairs:
        return None
    figure = new_figure(2.3 + ROW * len(results))
    panels = figure.subplots(1, len(QUANTITIES), sharey=True)
    differences = [[_differences(result, *pair) for pair in pairs] for result in results]
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        cells = _percent(differences, quantity)
        image = _cells(axes, cells)
        axes.set_title(quantity, fontsize=FONT_SIZE)
        axes.set_xticks(range(len(pairs)), [f"{first} – {second}" for first, second in pairs], rotation=90, fontsize=SMALL)
        axes.set_yticks(range(len(results)), run_labels(results), fontsize=SMALL)
        axes.tick_params(length=0.0)
    panels[0].set_ylabel(row_title(results), fontsize=FONT_SIZE)
    bar = figure.colorbar(image, ax=panels, location="bottom", fraction=BAR / (ROW * len(results)), pad=0.02, aspect=40)
    bar.set_label("largest difference over halves and channels (%)", fontsize=FONT_SIZE)
    bar.ax.tick_params(labelsize=SMALL)
    bar.ax.set_xticks([0.1, 1.0, 10.0, 100.0], ["≤ 0.1", "1", "10", "≥ 100"])
    legend_above(figure, [Patch(facecolor="white", edgecolor="#888888", hatch="////", linewidth=0.4, label="cannot be compared")], 1)
    return figure


def _pairs(results: Sequence[CaseResult]) -> list[tuple[str, str]]:
    """Pairs of engines, the reference always second, pairs with it first."""
    engines = list(dict.fromkeys(name for result in results for name in result.runs))
    others = [name for name in engines if name != REFERENCE]
    with_reference = [(name, REFERENCE) for name in others] if REFERENCE in engines else []
    return with_reference + list(combinations(others, 2))


def _differences(result: CaseResult, first: str, second: str) -> dict[str, float | None]:
    one, other = result.runs.get(first), result.runs.get(second)
    if one is None or other is None or not (one.usable and other.usable):
        return dict.fromkeys(QUANTITIES)
    return largest_differences(one, other)


def _percent(differences: Sequence[Sequence[Mapping[str, float | None]]], quantity: str) -> Array:
    """Values of a quantity in percent, NaN where there is none, shape (runs, pairs)."""
    values = [[math.nan if (value := cell[quantity]) is None else PERCENT * value for cell in row] for row in differences]
    return np.array(values, dtype=np.float64)


def _cells(axes: Axes, cells: Array) -> AxesImage:
    shades = matplotlib.colormaps["YlGnBu"]
    image = axes.imshow(np.clip(cells, *SHADES), cmap=shades, norm=LogNorm(*SHADES), aspect="auto")
    for row, column in np.ndindex(cells.shape):
        value = float(cells[row, column])
        if np.isnan(value):
            axes.add_patch(
                Rectangle((column - 0.5, row - 0.5), 1.0, 1.0, facecolor="white", edgecolor="#888888", hatch="////", linewidth=0.0)
            )
        else:
            lightness = float(np.dot(image.to_rgba(np.clip(value, *SHADES))[:3], (0.299, 0.587, 0.114)))
            colour = "white" if lightness < DARK else "black"
            axes.text(column, row, _number(value), ha="center", va="center_baseline", fontsize=NUMBER, color=colour)
    for spine in axes.spines.values():
        spine.set_linewidth(0.6)
    return image


def _number(percent: float) -> str:
    if percent >= 999.5:
        return ">999"
    return f"{percent:.1f}" if percent < 9.95 else f"{percent:.0f}"
