"""Draws a resonance curve: stable parts as lines, unstable ones dashed, special points as marks, peaks with their orders."""

from matplotlib.figure import Figure

from quickreturn.cases.resonance_curve.curve import ResonanceCurve
from quickreturn.cases.resonance_curve.search import OF_CURVE
from quickreturn.cases.shown import Units
from quickreturn.reports.drawing.curves import PANEL, WIDE
from quickreturn.reports.drawing.style import FONT_SIZE, MARKERS, SMALL, Drawing, logarithmic, look, new_figure, tidy
from quickreturn.reports.line_styles import looks


def resonance_figure(curve: ResonanceCurve, case: str, units: Units, mark: float | None = None) -> Drawing:
    """A figure of the curve, as `draw` draws it."""
    figure = new_figure(0.9 + 1.4 * PANEL * len(curve.measures), WIDE)
    draw(figure, curve, case, units, mark)
    return figure


def draw(figure: Figure, curve: ResonanceCurve, case: str, units: Units, mark: float | None = None) -> None:
    """Draw a panel for each measure over the varied quantity.

    Args:
        figure: an empty figure.
        curve: the curve.
        case: name of its case.
        units: units of the measures.
        mark: value of the varied quantity (SI) at which the machine runs; None: no mark.
    """
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
        for peak in curve.peaks if name == next(iter(curve.measures)) else ():
            place = (peak.value / curve.range.size, peak.height / unit.size)
            axes.annotate(f"{peak.order}×", place, (0, 3), textcoords="offset points", ha="center", fontsize=FONT_SIZE)
        if mark is not None:
            axes.axvline(mark / curve.range.size, color="#444444", linewidth=0.8, linestyle=":", label="the machine runs here")
        logarithmic(axes)
        axes.margins(y=0.1)
        tidy(axes, f"{name} [{unit.sign}]")
    panels[-1].set_xlabel(f"{curve.range.key} [{curve.range.unit}]", fontsize=FONT_SIZE)
    panels[0].legend(fontsize=SMALL, frameon=False)
    figure.suptitle(f"{case}; at peaks the multiple of the crank's speed", fontsize=FONT_SIZE)
