"""Draws error against solve time for all methods of a benchmark."""

from collections.abc import Sequence
from typing import Any, Final

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullFormatter

from quickreturn.plugins.methods.benchmark import Benchmark
from quickreturn.plugins.methods.trials.queries import pareto_front
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.reports.drawing.style import LIGHT, MARKERS, legend_above, look, new_figure, tidy
from quickreturn.reports.line_styles import looks
from quickreturn.reports.words import number

#: Column -> heading of its panel.
PANELS: Final = {
    "tip_deflection": "tip deflection",
    "tip_acceleration": "tip acceleration",
    "strain": "worst strain",
    "slider_force": "slider force",
}
#: Least and largest error that is shown, percent of the RMS.
LOWEST, HIGHEST = 1e-3, 300.0
FRONT_WIDTH: Final = 5.0  # pt, line of the Pareto front


def draw(table: Benchmark) -> Figure:
    """Draw the error of four observables against solve time, with the Pareto front of each.

    In the hatched range an error is less than the difference between the two solutions that define it.
    """
    methods: dict[str, list[Trial]] = {}
    for trial in table.trials:
        if trial.completed:
            methods.setdefault(trial.method, []).append(trial)
    figure = new_figure(5.2)
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, (column, words) in zip(panels.flat, PANELS.items(), strict=True):
        x, y = _places(pareto_front(table.trials, column), column)
        axes.plot(x, y, color=LIGHT, linewidth=FRONT_WIDTH, solid_capstyle="round", solid_joinstyle="round", zorder=1.0)
        if unknowable := table.confirmation.error_of(column):
            axes.axhspan(1e-9, 100.0 * unknowable, facecolor="none", edgecolor="#BBBBBB", hatch="////", linewidth=0.0, zorder=0.5)
        for trials in methods.values():
            axes.plot(*_places(trials, column), **_look(trials[0]), markersize=4.2, markeredgewidth=0.8)
        axes.set_title(words, fontsize=9.0, pad=3.0)
    _axes(panels)
    legend_above(figure, [Line2D([], [], **_look(trials[0]), markersize=5.0, label=method) for method, trials in methods.items()], 4)
    return figure


def _places(trials: Sequence[Trial], column: str) -> tuple[list[float], list[float]]:
    """Solve times in s and errors in percent of those trials whose error is known."""
    places = [(trial.seconds, 100.0 * error) for trial in trials if (error := trial.error_of(column))]
    return [x for x, _ in places], [y for _, y in places]


def _look(trial: Trial) -> dict[str, Any]:
    """Line and marks of a method; those of a variant are hollow."""
    style = look(trial.engine)
    face = style["color"] if trial.method == trial.engine else "white"
    marker = MARKERS[looks([trial.engine])[trial.engine].marker]
    return style | {"linestyle": "-", "linewidth": 0.9, "marker": marker, "markerfacecolor": face}


def _axes(panels: Any) -> None:
    for axes in panels.flat:
        axes.set_xscale("log")
        axes.set_yscale("log")
        tidy(axes)
        axes.tick_params(which="minor", length=1.5, width=0.5)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(FuncFormatter(lambda value, _: number(value, "g")))  # 0.01, 1, 100
            axis.set_minor_formatter(NullFormatter())
    panels[0, 0].set_ylim(LOWEST, HIGHEST)
    for axes in panels[1]:
        axes.set_xlabel("solve time (s)", fontsize=9.0)
    for axes in panels[:, 0]:
        axes.set_ylabel("error (% of RMS)", fontsize=9.0)
