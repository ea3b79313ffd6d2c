"""The 24 runs of the thesis, made from its tables (3.1, 5.1 and 5.2) and its shared scene (3.2 and 5.3), which are in `data/`."""

import csv
import functools
import tomllib
from dataclasses import dataclass
from importlib.resources import files
from types import MappingProxyType
from typing import Any, Final

from quickreturn.cases.files.case import Case, case_of
from quickreturn.cases.files.document import Document
from quickreturn.reference_model.scene_values import changed_values


@functools.cache
def read_table(name: str) -> tuple[MappingProxyType[str, str], ...]:
    """The rows of a CSV file of the folder `data`, column -> text. Lines that begin with # are remarks."""
    lines = (files(__name__) / "data" / name).read_text("utf-8").splitlines()
    return tuple(MappingProxyType(row) for row in csv.DictReader(line for line in lines if not line.startswith("#")))


@functools.cache
def read_toml(name: str) -> MappingProxyType[str, Any]:
    """The content of a TOML file of the folder `data`."""
    return MappingProxyType(tomllib.loads((files(__name__) / "data" / name).read_text("utf-8")))


TAG: Final = "thesis"

#: Tolerance between printed crank speed and torque / damping: they agree to 5e-7, the printed digits, unless the table is wrong.
SPEED_AGREEMENT: Final = 1e-6

_COUNTS: Final = MappingProxyType({0: "no plates", 2: "two plates", 4: "four plates", 6: "six plates"})


@dataclass(frozen=True)
class ThesisRun:
    """A row of tables 3.1 and 5.2, with the texts as printed."""

    number: int
    crank_length: str  # in
    plates: int
    torque: str  # lbf in
    published_damping: str  # lbf in s
    measured_speed: str | None  # rad/s, table 3.1; None where it says N/A
    simulated_speed: str | None  # rad/s, table 5.2
    acceleration_usable: bool  # section 3.5
    strain_usable: bool

    @property
    def steady_speed(self) -> float:
        """Torque over the published damping, rad/s."""
        return float(self.torque) / float(self.published_damping)

    @property
    def damping_is_consistent(self) -> bool:
        """Whether torque / damping gives the crank speed printed in both tables; true where none is printed."""
        printed = [float(speed) for speed in (self.measured_speed, self.simulated_speed) if speed]
        return all(abs(self.steady_speed / speed - 1.0) <= SPEED_AGREEMENT for speed in printed)

    @property
    def damping(self) -> str:
        """The damping to use, lbf in s: the published one, or torque / speed to 8 digits where that contradicts the speed."""
        if self.damping_is_consistent or self.measured_speed is None:
            return self.published_damping
        return f"{float(self.torque) / float(self.measured_speed):.8g}"

    @property
    def crank_speed(self) -> str:
        """Mean crank speed, rad/s: the measured one, or torque / damping to 8 digits where there is none."""
        return self.measured_speed or f"{self.steady_speed:.8g}"


def _run(row: MappingProxyType[str, str]) -> ThesisRun:
    return ThesisRun(
        number=int(row["run"]),
        crank_length=row["crank_length_in"],
        plates=int(row["mass_plates"]),
        torque=row["simulation_torque_lbf_in"],
        published_damping=row["simulation_crank_damping_lbf_in_s"],
        measured_speed=row["experiment_crank_speed_rad_s"] or None,
        simulated_speed=row["simulation_crank_speed_rad_s"] or None,
        acceleration_usable=row["acceleration_usable"] == "1",
        strain_usable=row["strain_usable"] == "1",
    )


#: Number -> run.
RUNS: Final = MappingProxyType({run.number: run for run in map(_run, read_table("runs.csv"))})


def run_name(number: int) -> str:
    """The name of a run's case, e.g. "thesis-07"."""
    return f"thesis-{number:02d}"


def run_title(number: int) -> str:
    """The distinguishing features of a run, in one line."""
    run = RUNS[number]
    return f"Run {number}: crank {run.crank_length} in, {_COUNTS[run.plates]}, {float(run.crank_speed):.1f} rad/s"


def run_document(number: int) -> Document:
    """A run as in a case file: the common values, and its row of the tables. Raises KeyError unless 1 <= number <= 24."""
    run = RUNS[number]
    of_run = {
        "crank.length": f"{run.crank_length} in",
        "crank.torque": f"{run.torque} lbf*in",
        "crank.damping": f"{run.damping} lbf*in*s/rad",
        "crank.initial_speed": f"{run.crank_speed} rad/s",
    }
    header = {"name": run_name(number), "title": run_title(number), "tags": [TAG]}
    return Document(run_name(number), header, changed_values(read_toml("scene.toml"), {**of_run, **tip_body(run.plates)}))


def run_case(number: int) -> Case:
    """The case of a run. Raises KeyError unless 1 <= number <= 24."""
    return case_of(run_document(number))


def tip_body(plates: int) -> dict[str, str]:
    """Mass and inertia of the tip with 0, 2, 4 or 6 plates (table 5.1), by key."""
    (tip,) = (row for row in read_table("tip_bodies.csv") if int(row["mass_plates"]) == plates)
    return {"tip.mass": f"{tip['mass_lbf_s2_per_in']} lbf*s^2/in", "tip.inertia": f"{tip['rotary_inertia_lbf_s2_in']} lbf*s^2*in"}
