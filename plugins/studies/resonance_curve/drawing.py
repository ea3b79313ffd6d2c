"""Draws a resonance curve: stable parts as lines, unstable ones dashed, special points as marks, peaks with their orders."""

import textwrap
from typing import Final

from matplotlib.axes import Axes

from quickreturn.cases.files.shown import Units
from quickreturn.cases.motion.measure import Measure
from quickreturn.plugins.studies.resonance_curve.curve import SPEED, ResonanceCurve
from quickreturn.plugins.studies.resonance_curve.search import OF_CURVE
from quickreturn.reports.drawing.curves import PANEL, WIDE
from quickreturn.reports.drawing.style import (
    FONT_SIZE,
    GREY,
    LETTERS,
    MARKERS,
    POINTS_PER_INCH,
    SMALL,
    Drawing,
    logarithmic,
    look,
    new_figure,
    tidy,
)
from quickreturn.reports.line_styles import looks

#: Largest number of letters of an axis' label: two lines.
LABEL: Final = 72
LINE: Final = 1.3  # font sizes from one line of text to the next
MARGIN: Final = 0.9  # in, of a figure's width that axes do not have


def resonance_figure(curve: ResonanceCurve, case: str, units: Units, mark: float | None = None) -> Drawing:
    """A panel for each measure over the varied quantity.

    Args:
        curve: the curve.
        case: name of its case.
        units: units of the measures.
        mark: value of the varied quantity (SI) at which the machine runs; None: no mark.
    """
    figure = new_figure(2.2 + 1.4 * PANEL * len(curve.measures), WIDE)
    panels = figure.subplots(len(curve.measures), 1, sharex=True, squeeze=False)[:, 0]
    shown = curve.values / curve.range.size
    for axes, (name, found) in zip(panels, curve.measures.items(), strict=True):
        unit = units.of(OF_CURVE[name].unit)
        heights = found / unit.size
        for part, unstable in curve.stretches():
            kind = "unstable" if unstable else "stable"
            labelled = axes.get_legend_handles_labels()[1]
            axes.plot(shown[part], heights[part], label="" if kind in labelled else kind, **look(kind))
        for kind in dict.fromkeys(point.kind for point in curve.special):
            places, style = [point.at for point in curve.special if point.kind == kind], looks([kind])[kind]
            axes.plot(shown[places], heights[places], MARKERS[style.marker], markersize=4.0, color=style.light, label=kind, zorder=3.0)
        if mark is not None:
            axes.axvline(mark / curve.range.size, color="#444444", linewidth=0.8, linestyle=":", label="the machine runs here")
        logarithmic(axes)
        axes.margins(y=0.1)
        tidy(axes, textwrap.fill(f"{measure_words(OF_CURVE[name])} [{unit.sign}], logarithmic", LETTERS))
        if name == next(iter(curve.measures)):
            _name_peaks(axes, curve, unit.size, figure.get_figwidth() - MARGIN)
    panels[-1].set_xlabel(f"{key_words(curve.range.key)} [{curve.range.unit}]", fontsize=FONT_SIZE)
    panels[0].legend(fontsize=SMALL, frameon=False)
    figure.suptitle(f"{case}: resonance curve, each point a periodic motion", fontsize=FONT_SIZE)
    return figure


def _name_peaks(axes: Axes, curve: ResonanceCurve, size: float, width: float) -> None:
    """Write the harmonic and the mode of each peak above the axes, at least `width` in wide, upright and apart, with a line to the peak."""
    peaks = sorted(curve.peaks, key=lambda peak: peak.value)
    low, high = axes.get_xlim()
    axes.set_xlim(low, high)
    places = [(peak.value / curve.range.size - low) / (high - low) for peak in peaks]
    apart = LINE * FONT_SIZE / POINTS_PER_INCH / width
    for at in range(1, len(places)):
        places[at] = max(places[at], places[at - 1] + apart)
    if places and places[-1] > 1.0:
        places[-1] = 1.0
        for at in reversed(range(len(places) - 1)):
            places[at] = min(places[at], places[at + 1] - apart)
    for peak, place in zip(peaks, places, strict=True):
        axes.annotate(
            peak.name.replace(" x ", " × "),
            (peak.value / curve.range.size, peak.height / size),
            (place, 1.02),
            textcoords="axes fraction",
            ha="center",
            va="bottom",
            rotation=90,
            fontsize=SMALL,
            arrowprops={"arrowstyle": "-", "linewidth": 0.5, "color": GREY, "relpos": (0.5, 0.0), "shrinkB": 1.0},
        )


def key_words(key: str) -> str:
    """A key of a case file as the label of an axis: "tip mass"."""
    return "crank speed" if key == SPEED else key.removeprefix("mechanism.").replace(".", " ").replace("_", " ")


def measure_words(measure: Measure) -> str:
    """A measure as the label of an axis: "largest magnitude of tip acceleration"; its name where that takes more than `LABEL` letters."""
    words = measure.meaning.replace("_", " ").removesuffix(" in a turn").rstrip(",")
    return words if len(words) <= LABEL else measure.name.replace("_", " ").replace(".", " ")
