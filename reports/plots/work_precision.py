"""Error against solve time, all methods of a benchmark."""

from collections.abc import Sequence
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from cases.benchmark import Benchmark, pareto_front
from cases.benchmark.findings import Point, completed, error_of
from reports.plots.style import LIGHT, legend_above, look, new_figure, plain_numbers, tidy

PERCENT: Final = 100.0
#: Column -> heading of its panel.
PANELS: Final = {
    "tip_deflection": "tip deflection",
    "tip_acceleration": "tip acceleration",
    "strain": "worst strain",
    "slider_force": "slider force",
}
#: Errors beyond these (in percent) say nothing more.
LOWEST, HIGHEST = 1e-3, 300.0
FRONT_WIDTH: Final = 5.0


def draw(table: Benchmark) -> Figure:
    """Error of four observables against solve time, with the Pareto front of each."""
    points = [point for point, _ in completed(table.points)]
    figure = new_figure(5.2)
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, (column, words) in zip(panels.flat, PANELS.items(), strict=True):
        _front(axes, points, column)
        _unknowable(axes, table, column)
        for method in dict.fromkeys(point.method for point in points):
            _method(axes, [point for point in points if point.method == method], column)
        axes.set_title(words, fontsize=9.0, pad=3.0)
    _axes(panels)
    legend_above(figure, _legend(points), 4)
    return figure


def _unknowable(axes: Axes, table: Benchmark, column: str) -> None:
    """Hatch where errors are less than what the two solutions that stand for the truth differ by."""
    difference = error_of(table.confirmation.differences, column)
    if difference:
        axes.axhspan(1e-9, PERCENT * difference, facecolor="none", edgecolor="#BBBBBB", hatch="////", linewidth=0.0, zorder=0.5)


def _front(axes: Axes, points: Sequence[Point], column: str) -> None:
    front = completed(pareto_front(points, column))
    seconds, errors = [measured.solve_seconds for _, measured in front], [PERCENT * (point.error(column) or 0.0) for point, _ in front]
    axes.plot(seconds, errors, color=LIGHT, linewidth=FRONT_WIDTH, solid_capstyle="round", solid_joinstyle="round", zorder=1.0)


def _method(axes: Axes, points: Sequence[Point], column: str) -> None:
    style = look(points[0].engine)
    known = [(measured.solve_seconds, error) for point, measured in completed(points) if (error := point.error(column))]
    if not known:
        return
    x, y = zip(*known, strict=True)
    face = "white" if _is_variant(points[0]) else style.colour
    axes.plot(x, [PERCENT * error for error in y], color=style.colour, linewidth=0.9, linestyle="-", zorder=style.order)
    keywords: dict[str, Any] = {
        "color": style.colour,
        "markersize": 4.2,
        "markerfacecolor": face,
        "markeredgewidth": 0.8,
        "zorder": style.order,
    }
    axes.plot(x, [PERCENT * error for error in y], style.marker, **keywords)


def _is_variant(point: Point) -> bool:
    return point.method != point.engine


def _axes(panels: Any) -> None:
    for axes in panels.flat:
        axes.set_xscale("log")
        axes.set_yscale("log")
        tidy(axes, None, None)
        for which in ("x", "y"):
            plain_numbers(axes, which)
        axes.tick_params(which="minor", length=1.5, width=0.5)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_minor_formatter(NullFormatter())
    panels[0, 0].set_ylim(LOWEST, HIGHEST)
    for axes in panels[1]:
        axes.set_xlabel("solve time (s)", fontsize=9.0)
    for axes in panels[:, 0]:
        axes.set_ylabel("error (% of RMS)", fontsize=9.0)


def _legend(points: Sequence[Point]) -> list[Line2D]:
    marks = []
    for method in dict.fromkeys(point.method for point in points):
        first = next(point for point in points if point.method == method)
        style = look(first.engine)
        face = "white" if _is_variant(first) else style.colour
        words: dict[str, Any] = {"color": style.colour, "markerfacecolor": face, "markersize": 5.0, "label": method}
        marks.append(Line2D([], [], linestyle="-", linewidth=0.9, marker=style.marker, **words))
    return marks
