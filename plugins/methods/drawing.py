"""Draws the fronts of all methods in a scene: error over solve time."""

from typing import Any, Final

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullFormatter

from quickreturn.plugins.methods.fronts import CRITERIA, DEFLECTION, front
from quickreturn.plugins.methods.race import Race
from quickreturn.plugins.methods.row import Row
from quickreturn.reports.drawing.style import LIGHT, MARKERS, legend_above, look, new_figure, tidy
from quickreturn.reports.line_styles import looks
from quickreturn.reports.words import number

#: Least and largest error that is shown, percent of the RMS.
LOWEST, HIGHEST = 2e-3, 200.0
FRONT_WIDTH: Final = 5.0  # pt, line of the front of all methods


def draw(found: Race) -> Figure:
    """Draw the front of each method, by the worst of four columns and by the deflection alone.

    In the hatched range an error is less than the difference between the two solutions that define it.
    """
    methods = {name: [row for row in found.given if row.method == name] for name in dict.fromkeys(row.method for row in found.given)}
    figure = new_figure(5.0)
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    shown = dict[str, dict[str, Any]]()
    for axes, by in zip(panels, CRITERIA, strict=True):
        x, y = _places(front(found.given, by), by)
        axes.plot(x, y, color=LIGHT, linewidth=FRONT_WIDTH, solid_capstyle="round", solid_joinstyle="round", zorder=1.0)
        if unknowable := found.confirmation.error if by == DEFLECTION else found.confirmation.worst:
            axes.axhspan(1e-9, 100.0 * unknowable, facecolor="none", edgecolor="#BBBBBB", hatch="////", linewidth=0.0, zorder=0.5)
        for name, rows in methods.items():
            if any(error <= HIGHEST for error in _places(rows, by)[1]):
                shown[name] = _look(rows[0])
                axes.plot(*_places(front(rows, by), by), **shown[name], markersize=4.2, markeredgewidth=0.8)
        axes.set_title(by, fontsize=9.0, pad=3.0)
        axes.set(xscale="log", yscale="log", ylim=(LOWEST, HIGHEST))
        tidy(axes)
        axes.tick_params(which="minor", length=1.5, width=0.5)
        axes.set_xlabel("solve time (s)", fontsize=9.0)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(FuncFormatter(lambda value, _: number(value, "g")))  # 0.01, 1, 100
            axis.set_minor_formatter(NullFormatter())
    panels[0].set_ylabel("error (% of RMS)", fontsize=9.0)
    legend_above(figure, [Line2D([], [], **style, markersize=5.0, label=name) for name, style in shown.items()], 4)
    return figure


def _places(rows: list[Row], by: str) -> tuple[list[float], list[float]]:
    """Solve times in s and errors in percent of those rows whose error is known."""
    places = [(row.seconds, 100.0 * error) for row in rows if row.completed and (error := CRITERIA[by](row))]
    return [x for x, _ in places], [y for _, y in places]


def _look(row: Row) -> dict[str, Any]:
    """Line and marks of a method; those of a variant are hollow."""
    style = look(row.engine)
    marker = MARKERS[looks([row.engine])[row.engine].marker]
    return style | {"linestyle": "-", "linewidth": 0.9, "marker": marker, "markerfacecolor": "white" if row.variant else style["color"]}
