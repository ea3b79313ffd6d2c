"""Numbers behind verdicts that need more than the steady cycles: natural frequencies of the crank held still."""

from dataclasses import dataclass
from typing import Final

from cases.frozen_crank import (
    JointEffect,
    Range,
    converged_ranges,
    cubic_ranges,
    excess_of_elements,
    joint_effects,
    share_with_signs,
)
from cases.jobs.job import Job
from cases.jobs.workshop import Workshop
from cases.runs.comparison import REFERENCE, CaseResult
from cases.runs.marching import Columns
from reference_model.mechanism import Mechanism

#: Signs of strains 1, 2, 3.
ALTERNATING: Final = (1, -1, 1)
ALIKE: Final = (1, 1, 1)
#: "Doubling or tripling": numbers of cubic elements.
ELEMENTS: Final = (1, 2, 3)


@dataclass(frozen=True)
class Evidence:
    """Of one run.

    Attributes:
        converged: ranges of the first three converged modes over the crank angle, Hz.
        cubic: ranges of the modes of the thesis' single cubic, Hz.
        alternating: per converged mode the share of crank angles at which strains 1 and 3 have one sign and strain 2 the other.
        alike: the same for all three of one sign.
        elements: largest excess of the first frequency with one, two and three cubic elements over the converged one, relative.
        joints: what a soft slider joint does; empty where there is no reference cycle.
    """

    converged: tuple[Range, ...]
    cubic: tuple[Range, ...]
    alternating: tuple[float, ...]
    alike: tuple[float, ...]
    elements: tuple[float, ...]
    joints: tuple[JointEffect, ...]


class NoEvidence(Exception):
    """The evidence could not be computed; the text is one sentence."""


def evidence(result: CaseResult, workshop: Workshop) -> Evidence:
    """Evidence on a run of the thesis, from the store where it is there, else computed in a process of its own.

    Raises:
        NoEvidence: that process failed or was stopped at its limits.
    """
    reference = result.runs.get(REFERENCE)
    cycle = {name: reference.cycle[name] for name in ("crank_angle", "time")} if reference is not None and reference.usable else {}
    arguments = (result.case.mechanism, cycle)
    job = Job("frozen crank", frozen_crank, arguments, kind="frozen crank", code=("cases.frozen_crank", "reports.findings.evidence"))
    (outcome,) = workshop.outcomes([job], "frozen-crank frequencies")
    if outcome.value is None:
        raise NoEvidence(f"{result.case.name}: the frozen-crank frequencies could not be computed: {outcome.explanation}")
    return outcome.value


def frozen_crank(mechanism: Mechanism, cycle: Columns) -> Evidence:
    """The evidence; `cycle`: crank angle (rad) and time (s) over the reference's steady cycle, or empty."""
    converged = converged_ranges(mechanism)
    return Evidence(
        converged=tuple(converged),
        cubic=tuple(cubic_ranges(mechanism, 2)),
        alternating=tuple(share_with_signs(mechanism, mode, ALTERNATING) for mode in range(len(converged))),
        alike=tuple(share_with_signs(mechanism, mode, ALIKE) for mode in range(len(converged))),
        elements=tuple(excess_of_elements(mechanism, elements) for elements in ELEMENTS),
        joints=tuple(joint_effects(mechanism, cycle["crank_angle"], cycle["time"])) if cycle else (),
    )
