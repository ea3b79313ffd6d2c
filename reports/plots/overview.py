"""The answer in one picture: how far each engine lies from the reference, run by run."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from cases.runs.comparison import CONSENSUS, HALVES, REFERENCE, CaseResult, Check, largest_differences, values
from cases.runs.estimates import EXTREMES
from reports.plots.picture import Picture, picture
from reports.plots.style import FONT_SIZE, GREY, LIGHT, SMALL, legend_above, look, new_figure, number, tidy
from reports.tables.claims import score

PERCENT: Final = 100.0
LINEAR: Final = 1.0  # %: the frequency axis is linear within, logarithmic beyond
FREQUENCY_TICKS: Final = (-50, -10, -5, -1, 0, 1, 5, 10, 20, 50)  # %
EXTREME_TICKS: Final = (0.01, 0.1, 1.0, 10.0, 100.0)  # %
SMALLEST: Final = 0.02  # %: smaller differences of extremes are drawn here, at the edge
ROW: Final = 0.185  # in
MARKER: Final = 4.6  # pt
RING: Final[dict[str, Any]] = {"color": "black", "markerfacecolor": "none", "markersize": 2.0 * MARKER, "markeredgewidth": 0.9}
HALF_OFFSET: Final = {"pre": -0.2, "post": 0.2}  # of a row


def overview_figure(results: Sequence[CaseResult]) -> Picture | None:
    """Per run: first-mode frequency of each half and largest difference of extremes, engines against the reference, with their claims.

    Returns:
        None where no run can be compared with a reference.
    """
    figure = draw_overview(results)
    if figure is None:
        return None
    return picture(
        figure,
        "Difference of each engine from the reference, run by run: "
        + "; ".join(f"{name} {score(results, name)}" for name in _engines(results)),
    )


def draw_overview(results: Sequence[CaseResult]) -> Figure | None:
    """The figure before it is rendered; see `overview_figure`."""
    engines = _engines(results)
    if not engines:
        return None
    figure = new_figure(1.5 + 0.22 * len(engines) + ROW * len(results))
    frequencies, extremes = figure.subplots(1, 2, sharey=True, width_ratios=[1.5, 1.0])
    for row, result in enumerate(results):
        _band(frequencies, row, [check for check in result.checks if check.quantity == CONSENSUS])
        for name in engines:
            _frequencies(frequencies, row, result, name)
            _extremes(extremes, row, result, name)
        trouble = ", ".join(f"{name}: {run.status}" for name, run in result.runs.items() if not run.usable)
        if trouble:
            extremes.text(SMALLEST * 1.3, row, trouble, fontsize=SMALL - 1.5, va="center", color="black", zorder=5.0)
    _axes(frequencies, extremes, results)
    legend_above(figure, _handles(engines, results), 2)
    return figure


def _engines(results: Sequence[CaseResult]) -> list[str]:
    """The engines that can be held against the reference somewhere, in their order."""
    compared = [r for r in results if REFERENCE in r.runs and r.runs[REFERENCE].usable]
    return list(dict.fromkeys(name for result in compared for name, run in result.runs.items() if name != REFERENCE and run.usable))


def _frequencies(axes: Axes, row: int, result: CaseResult, name: str) -> None:
    run, reference = result.runs.get(name), result.runs.get(REFERENCE)
    if run is None or reference is None:
        return
    for half in HALVES:
        pair = values(run, reference, CONSENSUS, half, None)
        if pair is not None:
            value, wanted = pair
            style = look(name)
            face = style.colour if half == "pre" else "white"
            axes.plot(
                PERCENT * (value / wanted - 1.0), row + HALF_OFFSET[half], style.marker, color=style.colour, markerfacecolor=face,
                markersize=MARKER, markeredgewidth=0.9, zorder=style.order + 1.0,
            )  # fmt: skip


def _extremes(axes: Axes, row: int, result: CaseResult, name: str) -> None:
    run, reference = result.runs.get(name), result.runs.get(REFERENCE)
    if run is None or reference is None or not (run.usable and reference.usable):
        return
    difference = largest_differences(run, reference)["extremes"]
    if difference is None:
        return
    style = look(name)
    axes.plot(max(PERCENT * difference, SMALLEST), row, style.marker, color=style.colour, markersize=MARKER, zorder=style.order + 1.0)
    checks = [check for check in result.checks if check.engine == name and check.quantity in EXTREMES]
    if not checks:
        return
    largest = max(checks, key=lambda check: abs(check.difference) / check.scale)
    claimed = max(PERCENT * largest.tolerance / largest.scale, SMALLEST)
    axes.plot(claimed, row, "|", color=style.colour, markersize=1.6 * MARKER, markeredgewidth=1.2, zorder=style.order + 1.0)
    if any(not check.passed for check in checks):
        axes.plot(max(PERCENT * difference, SMALLEST), row, "o", **RING, zorder=style.order + 2.0)


def _band(axes: Axes, row: int, checks: Sequence[Check]) -> None:
    """What the engines and the reference claim together of a run's frequencies, in percent: the widest, the rest is but little less."""
    if not checks:
        return
    width = max(PERCENT * check.tolerance / check.scale for check in checks)
    axes.add_patch(Rectangle((-width, row - 0.5), 2.0 * width, 1.0, facecolor=LIGHT, edgecolor="none", zorder=0.6))
    for check in checks:
        if not check.passed:
            place = row + HALF_OFFSET[check.half]
            axes.plot(PERCENT * check.difference / check.scale, place, "o", **RING, zorder=look(check.engine).order + 2.0)


def _axes(frequencies: Axes, extremes: Axes, results: Sequence[CaseResult]) -> None:
    tidy(frequencies, "first-mode frequency\nminus reference (%)", None, "x")
    tidy(extremes, "largest difference of\nextremes (% of peak)", None, "x")
    frequencies.set_xscale("symlog", linthresh=LINEAR, linscale=0.55)
    low, high = frequencies.dataLim.intervalx
    frequencies.set_xlim(min(-1.4 * LINEAR, 1.3 * low), max(20.0, 1.3 * high))
    shown = [tick for tick in FREQUENCY_TICKS if frequencies.get_xlim()[0] <= tick <= frequencies.get_xlim()[1]]
    frequencies.set_xticks(shown, [number(tick, "+g") if tick else "0" for tick in shown])
    frequencies.set_xticks([], minor=True)
    frequencies.axvline(0.0, color=look(REFERENCE).colour, linewidth=2.0, zorder=1.0)
    extremes.set_xscale("log")
    extremes.set_xlim(0.8 * SMALLEST, max(150.0, 1.3 * extremes.dataLim.intervalx[1]))
    extremes.set_xticks([tick for tick in EXTREME_TICKS if tick >= SMALLEST], [f"{tick:g}" for tick in EXTREME_TICKS if tick >= SMALLEST])
    extremes.set_xticks([], minor=True)
    frequencies.set_yticks(range(len(results)), run_labels(results))
    frequencies.set_ylim(len(results) - 0.5, -0.5)
    for axes in (frequencies, extremes):
        axes.hlines(np.arange(len(results) - 1) + 0.5, *axes.get_xlim(), color="#E8E8E8", linewidth=0.5, zorder=0.7)
    frequencies.set_ylabel(row_title(results), fontsize=FONT_SIZE)


def run_labels(results: Sequence[CaseResult]) -> list[str]:
    """Names of the cases, numbers alone where all are runs of the thesis."""
    return [result.case.name.removeprefix("thesis-") if _all_of_the_thesis(results) else result.case.name for result in results]


def row_title(results: Sequence[CaseResult]) -> str:
    """What the rows are, as `run_labels` names them."""
    return "run" if _all_of_the_thesis(results) else "case"


def _all_of_the_thesis(results: Sequence[CaseResult]) -> bool:
    return all(result.case.name.startswith("thesis-") for result in results)


def _handles(engines: Sequence[str], results: Sequence[CaseResult]) -> list[Artist]:
    handles: list[Artist] = [Line2D([], [], color=look(REFERENCE).colour, linewidth=2.0, label=f"{REFERENCE}: zero")]
    for name in engines:
        style = look(name)
        handles.append(
            Line2D(
                [],
                [],
                linestyle="none",
                marker=style.marker,
                color=style.colour,
                markersize=MARKER,
                label=_short(results, name),
            )
        )
    for half, face in (("pre", GREY), ("post", "white")):
        handles.append(
            Line2D([], [], linestyle="none", marker="o", color=GREY, markerfacecolor=face, markersize=MARKER, label=f"{half}-return")
        )
    checks = [check for result in results for check in result.checks]
    if checks:
        handles.append(Patch(facecolor=LIGHT, label="claimed together"))
        handles.append(Line2D([], [], linestyle="none", marker="|", color=GREY, markersize=1.6 * MARKER, label="claimed of that extreme"))
    if any(not check.passed for check in checks):
        handles.append(Line2D([], [], linestyle="none", marker="o", **RING, label="beyond what is claimed"))
    return handles


def _short(results: Sequence[CaseResult], name: str) -> str:
    """An engine and its verdict in a few words."""
    checks = [check for result in results for check in result.checks if check.engine == name]
    beyond = sum(not check.passed for check in checks)
    return f"{name}: departs in {beyond or 'none'} of {len(checks)} numbers" if checks else f"{name}: not judged"
