"""What is left of the experiment: printed speeds, channels, axes of figures, and statements; recordings of it belong into `curves`."""

import functools
import math
import os
from dataclasses import dataclass, replace
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Final, Literal

from quickreturn.cases.files import recorded
from quickreturn.cases.files.errors import CaseError, path_shown
from quickreturn.cases.files.recorded import DECLARATIONS, RecordedTable
from quickreturn.cases.files.units import in_si
from quickreturn.cases.library.thesis import RUNS, read_table, read_toml, run_case

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


Kind = Literal["relation", "frequency", "observation", "cause"]


@dataclass(frozen=True)
class Statement:
    """A statement of the thesis, read as a range of numbers."""

    id: str  # short name
    section: str  # of the thesis
    words: str  # the statement in our words
    kind: Kind  # "relation" (a ratio per run), "frequency" (a range in Hz), "observation" or "cause" (words only)
    quantity: str  # what is compared
    runs: tuple[int, ...]  # numbers of the runs that it is about
    low: float = -math.inf  # smallest value that the words mean, -inf if there is none
    high: float = math.inf  # largest value that the words mean, inf if there is none
    share: float = 1.0  # share of the runs that must show it


@functools.cache
def statements() -> tuple[Statement, ...]:
    """All statements in the order of the thesis."""
    listed = []
    for entry in read_toml("statements.toml")["statement"]:
        runs = tuple(RUNS) if entry["runs"] == "all" else tuple(range(entry["runs"][0], entry["runs"][1] + 1))
        listed.append(Statement(**entry | {"runs": runs}))
    return tuple(listed)


#: Environment variable with the folder of recordings, in place of the project's own.
FOLDER_VARIABLE: Final = "QUICKRETURN_CURVES"


def experiment_tables() -> list[RecordedTable]:
    """All tables in the folder of the experiment's recordings, by file name; each declares its case and its origin.

    The environment variable QUICKRETURN_CURVES names the folder; the default is the project's own.

    Raises:
        CaseError: no such folder, or a file is not such a table.
    """
    place = Path(os.environ.get(FOLDER_VARIABLE) or str(files(__package__) / "curves"))
    if not place.is_dir():
        raise CaseError(path_shown(str(place)), None, None, "is no folder", f"{FOLDER_VARIABLE} names a folder of CSV files")
    tables = [replace(recorded.read_table(str(path)), of_experiment=True) for path in sorted(place.glob("*.csv"))]
    for table, key in product(tables, ("case", "origin")):
        if key not in table.declared:
            accepted = f'write "# {key} = ..." above the heading, with {" or ".join(DECLARATIONS[key]) or "the name of a case"}'
            raise CaseError(table.shown, key, None, "this declaration is missing", accepted)
    return tables
