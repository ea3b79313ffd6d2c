"""Slider force, torque on the crank and crank speed over the steady cycle."""

from typing import Any, Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from cases.runs.comparison import CaseResult
from cases.runs.request import Run
from reference_model.mechanism import Mechanism, TorqueDrive
from reference_model.rigid import rigid_kinetostatics
from reports.plots.deflection import Deflection
from reports.plots.picture import Picture, picture
from reports.plots.steady_cycle import best_run, direction, drawn_runs, fraction, missing_runs, name_in_legend, stacked_panels
from reports.plots.style import GREY, legend_above, look, new_figure

Array = NDArray[np.float64]

RIGID: Final[dict[str, Any]] = {"color": GREY, "linewidth": 0.9, "linestyle": "-", "zorder": 1.8}
MOTOR: Final[dict[str, Any]] = {"color": "black", "linewidth": 0.9, "linestyle": (0, (1, 1.5)), "zorder": 1.9}


def force_figure(result: CaseResult) -> Picture | None:
    """Slider force, torque, crank speed of all engines, beside the rigid mechanism's; None where no engine has a cycle to show."""
    figure = draw_forces(result)
    if figure is None:
        return None
    engines = ", ".join(drawn_runs(result))
    return picture(
        figure, f"{result.case.name}: slider force, torque on the crank and crank speed over the steady cycle, engines {engines}"
    )


def draw_forces(result: CaseResult) -> Figure | None:
    """The figure before it is rendered; see `force_figure`."""
    runs, best, mechanism = drawn_runs(result), best_run(result), result.case.mechanism
    if best is None:
        return None
    figure = new_figure(5.6)
    panels = figure.subplots(3, 1, sharex=True, height_ratios=[1.2, 1.2, 1.0])
    for name, run in runs.items():
        cycle, style = fraction(run.cycle["crank_angle"]), look(name).of_line
        for axes, values in zip(panels, (run.cycle["slider_force"], _torque(mechanism, run), run.cycle["crank_speed"]), strict=True):
            axes.plot(cycle, values, **style)
    cycle = fraction(best[1].cycle["crank_angle"])
    force, load = _rigid(mechanism, best[1])
    panels[0].plot(cycle, force, **RIGID)
    panels[1].plot(cycle, load, **RIGID)
    if isinstance(mechanism.crank.drive, TorqueDrive):
        panels[1].axhline(mechanism.crank.drive.torque, **MOTOR)
    else:
        speed = abs(mechanism.crank.drive.speed)
        panels[2].set_ylim(*sorted((0.99 * direction(best[1]) * speed, 1.01 * direction(best[1]) * speed)))
    torque = "load torque (N m)" if mechanism.crank_is_free else "drive torque (N m)"
    stacked_panels(list(panels), ["slider force (N)", torque, "crank speed (rad/s)"], direction(best[1]))
    figure.align_ylabels(panels)
    legend_above(figure, _handles(result, mechanism), 3)
    return figure


def load_torque(mechanism: Mechanism, columns: dict[str, Array]) -> Array:
    """Torque with which the slider force holds the crank back, LA N cos(q1 - q2 - theta), N m, shape (n,); theta: tangent at the slider.

    A free crank obeys I q1'' = torque - c q1' - load torque (massless slider, no gravity).
    """
    tangent = columns["follower_angle"] + np.arcsin(np.clip(Deflection(mechanism, columns).slope_at_slider(), -1.0, 1.0))
    return mechanism.crank.length * columns["slider_force"] * np.cos(columns["crank_angle"] - tangent)


def _torque(mechanism: Mechanism, run: Run) -> Array:
    """What asks to be looked at: the load on a motor of constant torque, or the torque that a prescribed speed takes."""
    if not mechanism.crank_is_free and "crank_torque" in run.cycle:
        return run.cycle["crank_torque"]
    return load_torque(mechanism, run.cycle)


def _rigid(mechanism: Mechanism, run: Run) -> tuple[Array, Array]:
    """Slider force (N) and torque of the slider force (N m) if the follower were rigid and the crank turned evenly at its mean speed."""
    angle, time = run.cycle["crank_angle"], run.cycle["time"]
    speed = (angle[-1] - angle[0]) / (time[-1] - time[0])
    force, torque = rigid_kinetostatics(mechanism, angle, speed)
    if isinstance(mechanism.crank.drive, TorqueDrive):
        torque = torque - mechanism.crank.drive.damping * speed
    return force, torque


def _handles(result: CaseResult, mechanism: Mechanism) -> list[Artist]:
    handles: list[Artist] = [
        Line2D([], [], label=name_in_legend(name, run), **look(name).of_sample) for name, run in drawn_runs(result).items()
    ]
    handles.append(Line2D([], [], label="rigid follower, even speed", **RIGID))
    if mechanism.crank_is_free:
        handles.append(Line2D([], [], label="motor torque", **MOTOR))
    absent = missing_runs(result)
    if absent:
        handles.append(Line2D([], [], linestyle="none", label=absent))
    return handles
