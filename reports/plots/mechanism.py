"""The mechanism at eight crank angles of the steady cycle, its deflection magnified."""

import math
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from cases.runs.comparison import CaseResult
from engines.trajectory import REQUIRED
from reference_model.mechanism import Mechanism
from reference_model.rigid import rigid_motion
from reports.plots.deflection import Deflection
from reports.plots.picture import Picture, picture
from reports.plots.steady_cycle import best_run, direction, fraction, missing_runs
from reports.plots.style import BLUE, GREY, SMALL, VERMILION, WIDTH, legend_above, new_figure, number

Array = NDArray[np.float64]

INSTANTS: Final = 8  # of a cycle, evenly in crank angle; half of them before the return
SHOWN: Final = 0.15  # of the follower's length: the magnified deflection is at most that
STRAIGHT: Final = 1e-6  # of the follower's length: a deflection below is interpolation, not bending
STEPS: Final = (1.0, 2.0, 5.0)  # of the factor
POINTS: Final = 81  # along the follower
BAR: Final = 0.2  # of the follower's length: the scale's bar is a round length of at most that
GAPS: Final = 0.35  # in, beside and between the panels
MARGIN: Final = 0.06  # of the follower's length, around everything
LEAST: Final = 0.06  # of the follower's length, shown on the side that the crank does not pass, for the names
TITLE: Final = 0.24  # in, above a panel


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
    rows = {column: CubicSpline(cycle, run.cycle[column])(instants) for column in REQUIRED}
    arc_lengths = np.linspace(0.0, mechanism.follower.length, POINTS)
    along, across = _about_the_chord(mechanism, rows, arc_lengths)
    of_tip = _about_the_chord(mechanism, {column: run.cycle[column] for column in REQUIRED}, arc_lengths[-1:])[1]
    factor = _factor(float(max(np.max(np.abs(of_tip)), np.max(np.abs(across)))), mechanism.follower.length)
    followers = _placed(mechanism, rows["crank_angle"], along, factor * across)

    sides = np.where(np.arange(INSTANTS) < INSTANTS // 2, -turning, turning)  # of the crank's way, above (1) or below (-1) the pivots
    width, height = _limits(mechanism, followers, sides)
    panel_height = 0.5 * (WIDTH - GAPS) * (height[1] - height[0]) / (width[1] - width[0])
    figure = new_figure(0.5 + (panel_height + TITLE) * (INSTANTS // 2))
    panels = figure.subplots(INSTANTS // 2, 2)
    for instant, axes in enumerate(panels.T.flat):
        _draw(axes, mechanism, float(rows["crank_angle"][instant]), followers[instant], int(sides[instant]))
        angle = f"{number(180 + turning * 360 * instants[instant])}°"
        half = {0: "pre-return, ", INSTANTS // 2: "post-return, "}.get(instant, "")
        axes.set_title(half + angle, fontsize=SMALL, pad=2.0)
        _frame(axes, width, tuple(sorted(sides[instant] * np.array(height))))
    _scale(panels[0, 0], mechanism, int(sides[0]) * height[1])
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
    """A round factor, at least 1, by which the largest deflection (m) becomes at most `SHOWN` of the length; 1 where nothing bends."""
    return max(1.0, _round_below(SHOWN * length / largest)) if largest > STRAIGHT * length else 1.0


def _round_below(value: float) -> float:
    """The largest of 1, 2, 5, 10, ... times a power of ten that does not exceed a value."""
    decade = 10.0 ** math.floor(math.log10(value))
    return max(step * decade for step in STEPS if step * decade <= value)


def _placed(mechanism: Mechanism, crank_angles: Array, along: Array, across: Array) -> Array:
    """Places of the follower's points in the frame of O, m, shape (n, m, 2)."""
    chord = rigid_motion(mechanism, crank_angles, 0.0).follower_angle[:, None]
    x = mechanism.pivot_distance + along * np.cos(chord) - across * np.sin(chord)
    return np.stack([x, along * np.sin(chord) + across * np.cos(chord)], axis=-1)


def _limits(mechanism: Mechanism, followers: Array, sides: Array) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of what is drawn, m, with a margin: along n1, and along n2 counted towards each panel's side."""
    d, LA, L = mechanism.pivot_distance, mechanism.crank.length, mechanism.follower.length
    x, y = followers[..., 0], sides[:, None] * followers[..., 1]
    width = min(-LA, d - L, float(x.min())), max(d, float(x.max()))
    height = min(-LEAST * L, float(y.min())), max(LA, float(y.max()))
    return (width[0] - MARGIN * L, width[1] + MARGIN * L), (height[0] - MARGIN * L, height[1] + MARGIN * L)


def _draw(axes: Axes, mechanism: Mechanism, crank_angle: float, follower: Array, side: int) -> None:
    pivot = np.array([mechanism.pivot_distance, 0.0])
    slider = mechanism.crank.length * np.array([np.cos(crank_angle), np.sin(crank_angle)])
    straight = pivot + mechanism.follower.length * np.array([[0.0], [1.0]]) * (slider - pivot) / np.hypot(*(slider - pivot))
    turn = mechanism.crank.length * np.exp(1j * side * np.linspace(0.0, np.pi, 37))
    axes.plot(turn.real, turn.imag, color="#BBBBBB", linewidth=0.6, zorder=1.0)
    axes.plot(*straight.T, color=GREY, linewidth=0.8, linestyle=(0, (4, 2)), zorder=2.0)
    axes.plot(*follower.T, color=BLUE, linewidth=2.0, zorder=3.0)
    axes.plot([0.0, slider[0]], [0.0, slider[1]], color="black", linewidth=2.4, solid_capstyle="round", zorder=4.0)
    axes.plot(0.0, 0.0, "o", color="black", markersize=4.0, zorder=5.0)
    axes.plot(*pivot, "^", color="black", markersize=6.5, zorder=5.0)
    axes.plot(*slider, "s", color=VERMILION, markeredgecolor="black", markeredgewidth=0.6, markersize=5.0, zorder=6.0)
    if mechanism.tip is not None:
        axes.plot(*follower[-1], "o", color=BLUE, markersize=5.0, zorder=5.0)


def _frame(axes: Axes, width: tuple[float, float], height: tuple[float, ...]) -> None:
    """Equal scales, no ticks: lengths are read off the bar in the first panel."""
    axes.set_aspect("equal")
    axes.set_xlim(*width)
    axes.set_ylim(*height)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_color("#CCCCCC")
        spine.set_linewidth(0.6)


def _scale(axes: Axes, mechanism: Mechanism, far: float) -> None:
    """A bar of round length on the side that reaches out to `far` (m), and the names of the two fixed points."""
    d, bar = mechanism.pivot_distance, _round_below(BAR * mechanism.follower.length)
    axes.plot([d - 1.2 * bar, d - 0.2 * bar], [0.8 * far] * 2, color="black", linewidth=1.2)
    axes.annotate(f"{1000.0 * bar:g} mm", (d - 0.7 * bar, 0.8 * far), (0.0, 2.0), textcoords="offset points", fontsize=SMALL, ha="center")
    for x, name in ((0.0, "O"), (d, "P")):
        axes.annotate(name, (x, 0.0), (0.0, 4.5), textcoords="offset points", fontsize=SMALL, ha="center")
