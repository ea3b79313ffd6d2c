"""The mechanism at eight crank angles of the steady cycle, its deflection magnified."""

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from cases.comparison import CaseResult
from engines.trajectory import REQUIRED
from reference_model.mechanism import Mechanism
from reference_model.rigid import rigid_motion
from reports.plots.deflection import Deflection
from reports.plots.picture import Picture, picture
from reports.plots.steady_cycle import best_run, direction, fraction, missing_runs
from reports.plots.style import BLUE, GREY, SMALL, VERMILION, legend_above, new_figure

Array = NDArray[np.float64]

INSTANTS: Final = 8  # of a cycle, evenly in crank angle; half of them before the return
SHOWN: Final = 0.15  # of the follower's length: the magnified deflection is at most that
STEPS: Final = (1.0, 2.0, 5.0)  # of the factor
POINTS: Final = 81  # along the follower
BAR: Final = 0.1  # m, of the scale


def mechanism_figure(result: CaseResult) -> Picture | None:
    """Crank, pivot, slider and follower at eight crank angles; None where no engine has a cycle to show.

    What is magnified is the distance from the straight follower through pivot and slider, so that the loop stays closed.
    """
    figure = draw_mechanism(result)
    best = best_run(result)
    if figure is None or best is None:
        return None
    return picture(
        figure, f"{result.case.name}: the mechanism at eight crank angles of the steady cycle, from engine {best[0]}, deflection magnified"
    )


def draw_mechanism(result: CaseResult) -> Figure | None:
    """The figure before it is rendered; see `mechanism_figure`."""
    best = best_run(result)
    if best is None:
        return None
    name, run = best
    mechanism = result.case.mechanism
    cycle, turning = fraction(run.cycle["crank_angle"]), direction(run)
    instants = np.arange(INSTANTS) / INSTANTS
    rows = {column: np.interp(instants, cycle, run.cycle[column]) for column in REQUIRED}
    arc_lengths = np.linspace(0.0, mechanism.follower.length, POINTS)
    along, across = _about_the_chord(mechanism, rows, arc_lengths)
    everything = {column: run.cycle[column] for column in REQUIRED}
    largest = float(np.max(np.abs(_about_the_chord(mechanism, everything, arc_lengths[-1:])[1]))), float(np.max(np.abs(across)))
    factor = _factor(max(largest), mechanism.follower.length)

    figure = new_figure(6.3)
    panels = figure.subplots(INSTANTS // 2, 2, sharex=True, sharey=True)
    for instant in range(INSTANTS):
        axes = panels[instant % (INSTANTS // 2), instant // (INSTANTS // 2)]
        angle = float(rows["crank_angle"][instant])
        half = "pre-return" if instant < INSTANTS // 2 else "post-return"
        _draw(axes, mechanism, angle, along[instant], factor * across[instant])
        axes.set_title(f"{180 + turning * 360 * instants[instant]:.0f}°", fontsize=SMALL, pad=2.0)
        if instant % (INSTANTS // 2) == 0:
            axes.set_title(f"{half}, {180 + turning * 360 * instants[instant]:.0f}°", fontsize=SMALL, pad=2.0)
    _frame(panels, mechanism)
    shown = "follower (does not bend)" if mechanism.follower.is_rigid else f"follower ({name}), deflection × {factor:g}"
    handles = [
        Line2D([], [], color=BLUE, linewidth=2.0, label=shown),
        Line2D([], [], color=GREY, linewidth=0.8, linestyle=(0, (4, 2)), label="straight follower"),
    ]
    absent = missing_runs(result)
    legend_above(figure, handles + ([Line2D([], [], linestyle="none", label=absent)] if absent else []), 2)
    return figure


def _about_the_chord(mechanism: Mechanism, rows: dict[str, Array], arc_lengths: Array) -> tuple[Array, Array]:
    """Coordinates of the follower's points along and across the straight line from the pivot through the slider, m, shape (n, m)."""
    W = Deflection(mechanism, rows).at(arc_lengths)
    turn = (rows["follower_angle"] - rigid_motion(mechanism, rows["crank_angle"], 0.0).follower_angle)[:, None]
    return np.cos(turn) * arc_lengths - np.sin(turn) * W, np.sin(turn) * arc_lengths + np.cos(turn) * W


def _factor(largest: float, length: float) -> float:
    """A round factor by which the largest deflection (m) becomes at most `SHOWN` of the length; 1 where nothing bends."""
    if not largest > 1e-9 * length:
        return 1.0
    exact = SHOWN * length / largest
    decade = 10.0 ** np.floor(np.log10(exact))
    return float(max(step * decade for step in STEPS if step * decade <= exact))


def _draw(axes: Axes, mechanism: Mechanism, crank_angle: float, along: Array, across: Array) -> None:
    pivot = np.array([mechanism.pivot_distance, 0.0])
    slider = mechanism.crank.length * np.array([np.cos(crank_angle), np.sin(crank_angle)])
    chord = float(rigid_motion(mechanism, np.array(crank_angle), 0.0).follower_angle)
    forward, sideways = np.array([np.cos(chord), np.sin(chord)]), np.array([-np.sin(chord), np.cos(chord)])
    follower = pivot + along[:, None] * forward + across[:, None] * sideways
    straight = np.array([pivot, pivot + mechanism.follower.length * forward])
    round_trip = mechanism.crank.length * np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 73))
    axes.plot(round_trip.real, round_trip.imag, color="#BBBBBB", linewidth=0.6, zorder=1.0)
    axes.plot(*straight.T, color=GREY, linewidth=0.8, linestyle=(0, (4, 2)), zorder=2.0)
    axes.plot(*follower.T, color=BLUE, linewidth=2.0, zorder=3.0)
    axes.plot(*np.array([[0.0, 0.0], slider]).T, color="black", linewidth=2.4, solid_capstyle="round", zorder=4.0)
    axes.plot(0.0, 0.0, "o", color="black", markersize=4.0, zorder=5.0)
    axes.plot(*pivot, "^", color="black", markersize=6.5, zorder=5.0)
    axes.plot(*slider, "s", color=VERMILION, markeredgecolor="black", markeredgewidth=0.6, markersize=5.0, zorder=6.0)
    if mechanism.tip is not None:
        axes.plot(*follower[-1], "o", color=BLUE, markersize=5.0, zorder=5.0)


def _frame(panels: NDArray[Any], mechanism: Mechanism) -> None:
    """Equal scales and room for everything that moves; no ticks but a bar of 100 mm and names in the first panel."""
    d, LA, L = mechanism.pivot_distance, mechanism.crank.length, mechanism.follower.length
    swing = L * LA / d + 0.8 * SHOWN * L
    left = min(d - L, -LA)
    for axes in panels.flat:
        axes.set_aspect("equal")
        axes.set_xlim(left - 0.05 * L, d + 0.06 * L)
        axes.set_ylim(-swing, swing)
        axes.set_xticks([])
        axes.set_yticks([])
        for spine in axes.spines.values():
            spine.set_color("#CCCCCC")
            spine.set_linewidth(0.6)
    first = panels[0, 0]
    first.plot([d - BAR, d], [-0.75 * swing] * 2, color="black", linewidth=1.2)
    first.text(d - 0.5 * BAR, -0.72 * swing, f"{1000 * BAR:.0f} mm", fontsize=SMALL, ha="center", va="bottom")
    first.text(d, 0.12 * swing, "P", fontsize=SMALL, ha="center", va="bottom")
    first.text(0.0, 0.08 * swing, "O", fontsize=SMALL, ha="center", va="bottom")
