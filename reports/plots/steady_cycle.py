"""The cycle as the axis of the pictures: from the slider's farthest place (0) over the quick return (0.5) to the next (1)."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from cases.runs.comparison import CaseResult
from cases.runs.request import NOT_SETTLED, Run
from reports.plots.style import FONT_SIZE, SMALL, number, tidy

Array = NDArray[np.float64]

TICKS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)


def drawn_runs(result: CaseResult) -> dict[str, Run]:
    """The runs that have a whole cycle to show: settled ones, and the last cycle of one that did not settle."""
    return {name: run for name, run in result.runs.items() if (run.usable or run.status == NOT_SETTLED) and run.cycle}


def name_in_legend(name: str, run: Run) -> str:
    """The engine's name, with its status if it did not settle."""
    return name if run.usable else f"{name} ({run.status})"


def missing_runs(result: CaseResult) -> str:
    """A sentence part that names the engines of which nothing can be drawn, empty if there are none."""
    drawn = drawn_runs(result)
    return ", ".join(f"{name}: {run.status}" for name, run in result.runs.items() if name not in drawn)


def fraction(crank_angle: Array) -> Array:
    """Fraction of the cycle, by crank angle (rad, from the slider's farthest place), in either direction of turning."""
    return np.abs(crank_angle - crank_angle[0]) / (2.0 * np.pi)


def direction(run: Run) -> int:
    """+1 where the crank angle grows, -1 where it falls."""
    angle = run.cycle["crank_angle"]
    return 1 if angle[-1] > angle[0] else -1


def cycle_axis(panels: Sequence[Axes], turning: int, mark: str = "#444444") -> None:
    """Fraction of the cycle below the lowest panel, crank angle above the uppermost, the quick return marked in all (in colour `mark`)."""
    for axes in panels:
        axes.set_xlim(0.0, 1.0)
        axes.set_xticks(TICKS)
        axes.axvline(0.5, color=mark, linewidth=0.8, linestyle=(0, (2, 2)), zorder=1.5)
        axes.tick_params(labelbottom=axes is panels[-1])
    panels[-1].set_xlabel("cycle (0.5: quick return)", fontsize=FONT_SIZE)
    above = panels[0].secondary_xaxis("top")
    above.set_xticks(TICKS, [f"{number(180 + turning * 360 * tick)}°" for tick in TICKS])
    above.tick_params(labelsize=SMALL, length=2.5, width=0.6)
    above.set_xlabel("crank angle", fontsize=FONT_SIZE)


def stacked_panels(panels: Sequence[Axes], labels: Sequence[str], turning: int) -> None:
    """Quantities stacked over the common cycle axis, each with its label and unit."""
    for axes, label in zip(panels, labels, strict=True):
        tidy(axes, None, label)
    cycle_axis(panels, turning)
