"""Numbers behind verdicts that need more than the steady cycles: natural frequencies of the crank held still."""

import dataclasses
from dataclasses import dataclass
from typing import Any, Final

from cases.comparison import REFERENCE, CaseResult
from cases.store import Store
from cases.workers import Job, Limits, default_limits, run_jobs
from reports.cache import content_of, kept
from reports.findings.frozen_crank import (
    JointEffect,
    Range,
    converged_ranges,
    cubic_ranges,
    excess_of_elements,
    joint_effects,
    share_with_signs,
)

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


def evidence(result: CaseResult, store: Store, limits: Limits | None = None) -> Evidence:
    """Evidence on a run of the thesis, from the store where it is there, else computed in a process of its own.

    Raises:
        NoEvidence: that process failed or was stopped at the limits (None: `cases.workers.default_limits`).
    """
    document = kept(store, "frozen crank", content_of(result), lambda: _computed(result, limits or default_limits()))
    return Evidence(
        converged=tuple(Range(**found) for found in document["converged"]),
        cubic=tuple(Range(**found) for found in document["cubic"]),
        alternating=tuple(document["alternating"]),
        alike=tuple(document["alike"]),
        elements=tuple(document["elements"]),
        joints=tuple(
            JointEffect(
                stiffness=float(found["stiffness"]),
                change_pre=found["change_pre"],
                change_post=found["change_post"],
                third_mode=Range(**found["third_mode"]),
            )
            for found in document["joints"]
        ),
    )


def _computed(result: CaseResult, limits: Limits) -> dict[str, Any]:
    (outcome,) = run_jobs([Job("frozen crank", _document, (result,))], limits=limits)
    if not outcome.completed:
        raise NoEvidence(f"{result.case.name}: the frozen-crank frequencies could not be computed: {outcome.explanation}")
    return dict(outcome.value)


def _document(result: CaseResult) -> dict[str, Any]:
    mechanism = result.case.mechanism
    reference = result.runs.get(REFERENCE)
    joints: list[JointEffect] = []
    if reference is not None and reference.usable:
        joints = joint_effects(mechanism, reference.cycle["crank_angle"], reference.cycle["time"])
    converged = converged_ranges(mechanism)
    return {
        "converged": [dataclasses.asdict(found) for found in converged],
        "cubic": [dataclasses.asdict(found) for found in cubic_ranges(mechanism, 2)],
        "alternating": [share_with_signs(mechanism, mode, ALTERNATING) for mode in range(len(converged))],
        "alike": [share_with_signs(mechanism, mode, ALIKE) for mode in range(len(converged))],
        "elements": [excess_of_elements(mechanism, elements) for elements in ELEMENTS],
        "joints": [dataclasses.asdict(found) | {"stiffness": repr(found.stiffness)} for found in joints],  # JSON has no infinity
    }
