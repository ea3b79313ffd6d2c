"""Verdicts on runs from their own evidence, and from contradictions between engines.

Nothing here uses the right answer. The evidence is the difference from runs with coarser and finer settings, the energy balance, the
slider's distance from the follower's centre line, and whether the crank angle is the integral of the crank speed. This finds runs that are
too coarse, unstable or broken. An engine that converges to another solution (a wrong parameter, a missing term) passes all of it; only the
comparison with other engines finds that (`contradicted`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any, Final

from quickreturn.cases.motion.balances import Balances
from quickreturn.engines.trajectory import Columns

ACCURATE: Final = "accurate"
NOT_CONVERGED: Final = "not converged"
CONTRADICTED: Final = "contradicted"
ENDED: Final = "ended"
DIVERGED: Final = "diverged"
REFUSED: Final = "refused"
#: Kind for an engine whose discretization is its model; only the matrix can tell (`cases.judging.matrix.Judged.kind`), not the run.
OWN_EQUATIONS: Final = "solves its own equations"

#: Kind -> its meaning for a reader.
MEANINGS: Final = {
    ACCURATE: "the run's own error estimate is within the error asked, and nothing contradicts it",
    OWN_EQUATIONS: "the run solves the equations of its model as accurately as asked, but their solution is further off than asked",
    ENDED: "the slider leaves the follower; the time does not depend on the settings, and up to shortly before it the run is accurate",
    NOT_CONVERGED: "a result that is not reliable: its own estimate says that it is not as accurate as asked",
    CONTRADICTED: "its own estimate is satisfied, but another engine, confirmed by as many others, differs by more than both claim",
    DIVERGED: "the run broke down; time and cause are known",
    REFUSED: "the engine says that it cannot model this scene, and why",
}

#: Largest ratio of an error to the difference from finer settings: these at least halve the error, on every ladder once it converges.
ERROR_PER_DIFFERENCE: Final = 2.0
#: Largest relative difference of energy, extremes and spectrum of the tip deflection, beyond the stretch, of an accurate run.
LATER: Final = 0.1


@dataclass(frozen=True, kw_only=True)
class Breakdown:
    """The breakdown of a run, and that with finer settings."""

    time: float  # s, last instant known to be good; zero where there is none
    cause: str  # a clause
    at_the_end: bool = False  # whether the slider was about to reach the follower's end
    # s, time at which the slider reaches the follower's end with finer settings; None if it does not, or there are no finer settings
    finer_time: float | None = None


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """The evidence of a run on itself: with the settings that reach the accuracy asked for, or the finest that the engine has."""

    requested: float  # error of the tip deflection asked for
    duration: float  # s, of the scene
    # s from the start on which the error is judged: the whole duration, the horizon of an ill-conditioned scene, or most of the time
    # until the run broke down. Zero where there is no such run.
    stretch: float
    row: float  # s, between two rows of the trajectory
    refused: str = ""  # the engine's sentence, or ""
    breakdown: Breakdown | None = None  # if the run did not reach the duration
    error_estimate: float | None = None  # of the tip deflection over `stretch`, from coarser settings; None where unknown
    finer_difference: float | None = None  # RMS difference to finer settings over `stretch`, relative; None where there are none that ran
    finer_failure: str = ""  # why finer settings broke down within the stretch, or ""
    remark: str = ""  # what the engine's run says about its estimate, or ""
    balances: Balances = field(default_factory=Balances)  # of the whole run; of one that broke down over the stretch
    # what is compared beyond the stretch -> relative difference to finer settings; None where there is no such part or run
    later: Mapping[str, float] | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)  # of the run; empty if none ran
    columns: Columns = field(default_factory=dict, compare=False, repr=False)  # its trajectory, as far as it goes

    @property
    def claimed_error(self) -> float | None:
        """The larger of the error estimates from coarser and from finer settings; None without the first."""
        if self.error_estimate is None:
            return None
        return max(self.error_estimate, ERROR_PER_DIFFERENCE * (self.finer_difference or 0.0))


@dataclass(frozen=True)
class Verdict:
    """A cell of the matrix."""

    kind: str  # one of the constants of this module
    reason: str  # one sentence
    claimed_error: float | None = None  # of the tip deflection, relative, over `stretch`; None where nothing is claimed
    stretch: float | None = None  # s; None where nothing is claimed
    time: float | None = None  # s, when the run broke down or the scene ended; None where it reached its end
    time_uncertainty: float | None = None  # s, of the end of a scene


def judge(evidence: Evidence) -> Verdict:
    """The verdict on a run from its own evidence."""
    if evidence.refused:
        return Verdict(REFUSED, evidence.refused)
    doubt = _doubt(evidence)
    broken = evidence.breakdown
    if broken is None:
        return Verdict(NOT_CONVERGED, doubt) if doubt else _accurate(evidence)
    if broken.time == 0.0:
        return Verdict(DIVERGED, broken.cause)
    if not broken.at_the_end:
        return Verdict(DIVERGED, f"failed at t = {broken.time:.4g} s: {broken.cause}", time=broken.time)
    left = f"the slider leaves the follower at t = {broken.time:.4g} s"
    if broken.finer_time is None:
        return Verdict(NOT_CONVERGED, f"{left}, finer settings do not confirm it", time=broken.time)
    apart = abs(broken.finer_time - broken.time)
    if apart > evidence.requested * broken.time + evidence.row:
        return Verdict(NOT_CONVERGED, f"{left}, with finer settings at {broken.finer_time:.4g} s", time=broken.time)
    if doubt:
        return Verdict(NOT_CONVERGED, f"{left}; before that {doubt}", time=broken.time)
    uncertainty = apart + evidence.row
    reason = f"{left} (± {uncertainty:.1g} s)"
    return replace(_accurate(evidence), kind=ENDED, reason=reason, time=broken.time, time_uncertainty=uncertainty)


def _accurate(evidence: Evidence) -> Verdict:
    claimed, stretch = evidence.claimed_error, evidence.stretch
    reason = f"estimated error {claimed:.2g}"
    if evidence.breakdown is None and stretch < evidence.duration:
        within = ", ".join(f"{name} to {difference:.2g}" for name, difference in (evidence.later or {}).items())
        reason += f" up to {stretch:.4g} s; beyond, where the scene is ill-conditioned: {within}"
    return Verdict(ACCURATE, reason, claimed, stretch)


def _doubt(evidence: Evidence) -> str:
    """The first reason not to believe the run, or ""."""
    claimed, asked = evidence.claimed_error, evidence.requested
    if claimed is None:
        return evidence.remark or "the error cannot be estimated"
    if evidence.finer_failure:
        return f"with finer settings it {evidence.finer_failure}"
    if not claimed <= asked:  # also where it is no number
        return f"the estimated error {claimed:.2g} exceeds the {asked:g} asked"
    if violated := evidence.balances.violated(asked):
        return violated
    if evidence.breakdown is None and evidence.stretch < evidence.duration:
        return _later_doubt(evidence)
    return ""


def _later_doubt(evidence: Evidence) -> str:
    """The doubt about the part beyond the stretch, or ""."""
    if evidence.later is None:
        return f"nothing confirms its motion beyond {evidence.stretch:.4g} s"
    name, worst = max(evidence.later.items(), key=lambda item: item[1])
    if not worst <= LATER:
        return f"beyond {evidence.stretch:.4g} s its {name} changes by {worst:.2g} with finer settings"
    return ""


def contradicted(verdicts: Mapping[str, Verdict], differences: Mapping[tuple[str, str], float]) -> dict[str, Verdict]:
    """The verdicts after a comparison of the claims of engines on one scene.

    Each run claims to be within its claimed error of the same right answer, so two of them may differ by the sum of their claims.
    If they differ by more, at least one is wrong: the one that fewer others confirm. If that does not decide, both are called contradicted.

    Args:
        verdicts: engine -> its own verdict; engines whose model differs on purpose are left out.
        differences: pair of engines -> RMS difference of their tip deflections relative to the RMS, over the stretch that both claim.
    """
    claims = {name: v.claimed_error for name, v in verdicts.items() if v.kind in (ACCURATE, ENDED) and v.claimed_error is not None}
    confirmations = dict.fromkeys(claims, 0)
    too_far: dict[tuple[str, str], float] = {}
    for pair in combinations(claims, 2):
        difference = differences.get(pair, differences.get(pair[::-1]))
        if difference is None:
            continue
        if difference > claims[pair[0]] + claims[pair[1]]:
            too_far[pair] = difference
            continue
        for name in pair:
            confirmations[name] += 1
    judged = dict(verdicts)
    for pair, difference in too_far.items():
        weaker = [name for name in pair if confirmations[name] == min(confirmations[other] for other in pair)]
        for name in weaker:
            other = pair[1 - pair.index(name)]
            reason = f"differs from {other} by {difference:.2g}, more than both claim ({claims[name]:.2g}, {claims[other]:.2g})"
            judged[name] = replace(verdicts[name], kind=CONTRADICTED, reason=reason)
    return judged
