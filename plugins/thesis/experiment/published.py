"""Numbers of the experiment that the thesis prints: crank speeds, valid channels, and the axes of its figures."""

import functools
from dataclasses import dataclass
from typing import Final

from quickreturn.cases.files.units import in_si
from quickreturn.cases.library.thesis.data import read_table
from quickreturn.cases.library.thesis.runs import RUNS, run_case

#: Young's modulus of common wrought aluminium alloys, Pa: 6061 and 2024, 10.0 and 10.6 million psi.
ALUMINIUM: Final = (10.0e6 * in_si("psi"), 10.6e6 * in_si("psi"))


@dataclass(frozen=True)
class AxisLabels:
    """Legible labels of one figure's axis, in SI units."""

    figure: str  # e.g. "A.24"
    run: int  # number of the run
    channel: str  # "tip_acceleration" (m/s^2) or "strain" (1; one axis for the three gauges)
    values: tuple[float, ...]  # in the order printed
    has_experiment: bool  # whether the figure shows measured curves
    has_simulation: bool  # whether it shows curves that the thesis simulated

    @property
    def largest(self) -> float:
        """Largest magnitude among the labels."""
        return max(abs(value) for value in self.values)

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest legible label; the axis itself may reach further, because labels are missing."""
        return min(self.values), max(self.values)


@functools.cache
def axis_labels(run: int | None = None) -> tuple[AxisLabels, ...]:
    """All legible axes, or those of one run, figures in the appendix first."""
    axes_of_figures = []
    for row in read_table("figure_axes.csv"):
        axes = (
            ("tip_acceleration", row["tip_acceleration_labels_in_s2"], in_si("in/s^2")),
            ("strain", row["strain_labels_as_printed"], in_si("percent")),  # see `inconsistencies`
        )
        for channel, labels, unit in axes:
            if labels and run in (None, int(row["run"])):
                values = tuple(float(label) * unit for label in labels.split())
                shown = [kind in row["curves"] for kind in ("experiment", "simulation")]
                axes_of_figures.append(AxisLabels(row["figure"], int(row["run"]), channel, values, *shown))
    return tuple(axes_of_figures)


def printed_ranges(run: int) -> dict[str, tuple[float, float]]:
    """Channel -> range of the labels of its axis, in the first figure of a run that has more than one label there."""
    return {each.channel: each.range for each in reversed(axis_labels(run)) if each.range[0] < each.range[1]}


def measured_crank_speed(run: int) -> float | None:
    """Mean crank speed of an experiment in rad/s (table 3.1); None for run 1, where none is printed. Raises KeyError."""
    speed = RUNS[run].measured_speed
    return None if speed is None else float(speed)


def channel_is_usable(run: int, channel: str) -> bool:
    """Whether section 3.5 calls the measurement of a channel valid: none of run 1, strain alone in runs 2 to 8. Raises KeyError."""
    return RUNS[run].acceleration_usable if channel == "tip_acceleration" else RUNS[run].strain_usable


def below_aluminium() -> tuple[float, float]:
    """Relative distance of the modulus that the printed stiffness and the nominal section mean below aluminium's, least and greatest."""
    low, high = sorted(1.0 - run_case(24).scene.follower.elastic_modulus / ordinary for ordinary in ALUMINIUM)
    return low, high
