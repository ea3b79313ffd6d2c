"""Contradictions and gaps of the thesis, found from its own tables, and the values used instead.

Nothing is corrected silently: every replacement and every unusable channel is listed here, and shown with the results.
"""

import functools
from dataclasses import dataclass
from typing import Final

from quickreturn.cases.files.units import in_si
from quickreturn.cases.library.thesis import RUNS, read_table, run_case

#: GPa. No wrought aluminium alloy carries more before it yields (7075-T6: 0.50 GPa).
_HIGHEST_YIELD_STRESS: Final = 0.55


@dataclass(frozen=True)
class Inconsistency:
    """A contradiction or a gap in the thesis, and the value used instead."""

    runs: tuple[int, ...]  # numbers of the runs concerned
    what: str  # the quantity
    published: str  # what the thesis says
    used: str  # what is used here
    reason: str  # why

    @property
    def sentence(self) -> str:
        """The inconsistency in one sentence."""
        return f"{self.what}: published {self.published}; used {self.used}, because {self.reason}"


@functools.cache
def inconsistencies() -> tuple[Inconsistency, ...]:
    """All findings, in the order of the runs; those on every run last."""
    runs = RUNS.values()
    no_speed = [
        Inconsistency(
            (run.number,),
            "crank speed",
            "no speed (tables 3.1 and 5.2 say N/A)",
            f"{run.crank_speed} rad/s, torque over damping",
            "the published torque and damping lead to this speed; it is one turn a second",
        )
        for run in runs
        if run.measured_speed is None
    ]
    lost = Inconsistency(
        tuple(run.number for run in runs if not run.strain_usable and not run.acceleration_usable),
        "experiment",
        "no measurement",
        "the simulation alone",
        "the data were corrupted in transfer (section 3.5)",
    )
    noisy = Inconsistency(
        tuple(run.number for run in runs if run.strain_usable and not run.acceleration_usable),
        "measured tip acceleration",
        "plotted",
        "the strain alone",
        "its electronic noise could not be filtered (section 3.5); the strain of these runs is valid",
    )
    other_damping = [
        Inconsistency(
            (run.number,),
            "crank damping",
            f"{run.published_damping} lbf in s (table 5.2), which with {run.torque} lbf in gives {run.steady_speed:.8g} rad/s,"
            f" where {run.measured_speed} rad/s is printed",
            f"{run.damping} lbf in s, torque over printed speed",
            f"it is off by a factor of {run.steady_speed / float(run.measured_speed or 'nan'):.6f}, while in the other runs torque over"
            " damping is the printed speed to 5e-7, and the figures show the printed one",
        )
        for run in runs
        if not run.damping_is_consistent
    ]
    second_mode = Inconsistency(
        (24,),
        "mode at 132 Hz",
        "second mode, strains 1 and 3 in phase against strain 2 (section 3.4)",
        "both readings",
        "with the crank frozen the third converged mode lies at 113 to 135 Hz and has these signs, the second at 46 to 64 Hz",
    )
    labels = [abs(float(label)) for row in read_table("figure_axes.csv") for label in row["strain_labels_as_printed"].split()]
    stress = max(labels) * run_case(24).scene.follower.elastic_modulus
    strain_unit = Inconsistency(
        tuple(RUNS),
        "unit of the printed strain",
        f"strain, axes up to {max(labels)}",
        "percent of surface strain",
        f"as plain strain the largest label means {stress / in_si('GPa'):.2g} GPa in an aluminium strip that yields below"
        f" {_HIGHEST_YIELD_STRESS:g} GPa, while as percent it is what the simulations show",
    )
    return (*no_speed, lost, noisy, *other_damping, second_mode, strain_unit)
