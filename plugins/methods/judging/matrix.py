"""The matrix of verdicts: every engine on every hard scene, each verdict checked afterwards against a converged solution."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, Final

import numpy as np

from quickreturn.cases.files.case import Case
from quickreturn.cases.motion.balances import Balances
from quickreturn.cases.running.job import Job, Outcome
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import MAIN, MODEL
from quickreturn.engines.relative import relative_error
from quickreturn.engines.trajectory import Columns
from quickreturn.plugins.methods.judging.conditioning import Conditioning, conditioning, later_differences
from quickreturn.plugins.methods.judging.evidence import TrialScene, gather
from quickreturn.plugins.methods.judging.verdicts import (
    ACCURATE,
    ENDED,
    LATER,
    OWN_EQUATIONS,
    Breakdown,
    Evidence,
    Verdict,
    contradicted,
    judge,
)

#: Error of the tip deflection asked of every engine.
REQUESTED: Final = 0.01
#: The engine that the converged solution comes from, and the error asked of it.
CONVERGED: Final = ("reference", 1e-3)
#: The error asked of the converged solution of `MODEL`'s own equations, with which `MODEL` is compared.
MODEL_CONVERGED: Final = 1e-4
#: Columns of a trajectory that are kept.
_KEPT: Final = ("time", "tip_deflection", "strain_energy")
_KIND: Final = "hard scene"


@dataclass(frozen=True, kw_only=True)
class Judged:
    """An engine in a scene."""

    scene: str  # name of the case
    engine: str  # name
    verdict: Verdict  # after the comparison with the other engines
    settings: Mapping[str, Any]  # of the run judged
    # error of the tip deflection over the stretch, against the converged solution; None if nothing is claimed or known
    true_error: float | None = None
    # likewise beyond the stretch (`cases.judging.conditioning.later_differences`); None where there is no such part
    true_later: Mapping[str, float] | None = None
    # whether the claim (error, time, what is said of the part beyond the stretch) holds against the converged solution, whose own
    # claimed error is allowed for; None where nothing is claimed or the scene has no converged solution
    holds: bool | None = None
    model_error: float | None = None  # for an engine that is compared with its own equations: their distance to the converged solution

    @property
    def kind(self) -> str:
        """The verdict for a user of the result: the verdict's kind, but accurate only if the model is accurate, too."""
        good = self.verdict.kind in (ACCURATE, ENDED)
        return OWN_EQUATIONS if good and self.of_own_equations and not self.model_is_near else self.verdict.kind

    @property
    def of_own_equations(self) -> bool:
        """Whether its claim covers only the equations of its model."""
        return self.engine == MODEL

    @property
    def model_is_near(self) -> bool:
        """Whether the solution of its model's equations is known to be as near to the converged solution as was asked."""
        return self.model_error is not None and self.model_error <= REQUESTED

    @property
    def silently_wrong(self) -> bool:
        """Whether the cell's claim is wrong."""
        return self.holds is False


@dataclass(frozen=True)
class Matrix:
    """All verdicts."""

    cases: tuple[Case, ...]  # the scenes, in order
    engines: tuple[str, ...]  # names
    cells: Mapping[tuple[str, str], Judged]  # (scene, engine) -> cell; those that have been computed
    conditionings: Mapping[str, Conditioning]  # scene -> its conditioning, where it could be computed

    @property
    def silently_wrong(self) -> tuple[Judged, ...]:
        """Cells with a wrong claim: there must be none."""
        return tuple(cell for cell in self.cells.values() if cell.silently_wrong)


def judge_scenes(cases: Sequence[Case], workshop: Workshop, engines: Sequence[str] = MAIN) -> Matrix:
    """The matrix of the engines (names) in the scenes; what is missing in the workshop is left out.

    Raises:
        UnknownEngine: a name that is no engine's.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    outcomes = workshop.outcomes([_conditioning_job(case) for case in cases], "hard scenes")
    found = [replace(outcome.value, scene=case.name) for case, outcome in zip(cases, outcomes, strict=True) if outcome.value]
    conditionings = {of_case.scene: of_case for of_case in found}
    horizons = {case.name: case.duration for case in cases} | {name: of_case.horizon for name, of_case in conditionings.items()}
    jobs = {(what, case.name): job for case in cases for what, job in _evidence_jobs(case, horizons[case.name], engines).items()}
    runs: dict[tuple[str, str], Evidence] = {}
    for (what, name), outcome in zip(jobs, workshop.outcomes(list(jobs.values()), "hard scenes"), strict=True):
        if not outcome.missing:
            runs[what, name] = outcome.value or _broken(jobs[what, name], outcome)
    cells: dict[tuple[str, str], Judged] = {}
    for case in cases:
        truth = runs.get(("converged", case.name))
        of_case = {name: runs[name, case.name] for name in engines if (name, case.name) in runs}
        cells |= {(case.name, cell.engine): cell for cell in _cells(case.name, of_case, truth, runs.get(("model", case.name)))}
        if truth and case.name in conditionings:
            conditionings[case.name] = replace(conditionings[case.name], converged=judge(truth).claimed_error)
    return Matrix(tuple(cases), tuple(engines), cells, conditionings)


def _conditioning_job(case: Case) -> Job[Conditioning]:
    arguments = (case.mechanism, case.duration, case.output_step)
    return Job(f"conditioning of {case.name}", conditioning, arguments, kind=_KIND, engines=("reference",))


def _evidence_jobs(case: Case, horizon: float, engines: Sequence[str]) -> dict[str, Job[Evidence]]:
    """The converged solution, that of `MODEL`'s own equations if it is among the engines, and each engine."""
    scene = TrialScene(mechanism=case.mechanism, duration=case.duration, output_step=case.output_step, horizon=horizon)
    wanted = {"converged": CONVERGED} | ({"model": (MODEL, MODEL_CONVERGED)} if MODEL in engines else {})
    wanted |= {name: (name, REQUESTED) for name in engines}
    return {
        what: Job(f"{name} in a hard scene", evidence_of, (name, scene, requested), _KIND, engines=(name,))
        for what, (name, requested) in wanted.items()
    }


def evidence_of(engine: str, scene: TrialScene, requested: float) -> Evidence:
    """The evidence on an engine in a scene as it is stored: NaN, which the store refuses, becomes infinity, which fails every test."""
    found = gather(engine, scene, requested)
    numbers, balances, later = (_without_nan(each) for each in (vars(found), vars(found.balances), found.later or {}))
    columns: Columns = {name: found.columns[name] for name in _KEPT if name in found.columns}
    numbers |= {"columns": columns, "balances": Balances(**balances), "later": found.later and later}
    return replace(found, **numbers)


def _without_nan(numbers: Mapping[str, Any]) -> dict[str, Any]:
    return {name: math.inf if isinstance(value, float) and math.isnan(value) else value for name, value in numbers.items()}


def _broken(job: Job[Evidence], outcome: Outcome[Evidence]) -> Evidence:
    """The evidence of a process that ended without a result."""
    _, scene, requested = job.arguments
    broken: Evidence = scene.evidence(requested, breakdown=Breakdown(time=0.0, cause=outcome.explanation))
    return broken


def _cells(scene: str, runs: Mapping[str, Evidence], truth: Evidence | None, model: Evidence | None) -> list[Judged]:
    """The cells of a scene, from its runs by engine, its converged solution and that of `MODEL`'s own equations."""
    own = {name: judge(run) for name, run in runs.items()}
    others = {name: verdict for name, verdict in own.items() if name != MODEL}
    verdicts = own | contradicted(others, _differences(runs, others))
    cells = []
    for name, verdict in verdicts.items():
        right = model if name == MODEL else truth
        check = _checked(verdict, runs[name], right) if right else {}
        distance = _distance(model, truth) if name == MODEL and model and truth else None
        cells.append(Judged(scene=scene, engine=name, verdict=verdict, settings=runs[name].settings, model_error=distance, **check))
    return cells


def _differences(runs: Mapping[str, Evidence], verdicts: Mapping[str, Verdict]) -> dict[tuple[str, str], float]:
    """The difference of every two runs that claim something, over the stretch that both claim."""
    claiming = [name for name, verdict in verdicts.items() if verdict.stretch is not None]
    differences = {}
    for first, second in combinations(claiming, 2):
        stretch = min(runs[first].stretch, runs[second].stretch)
        differences[first, second] = _difference(runs[first].columns, runs[second].columns, stretch)
    return differences


def _difference(columns: Columns, other: Columns, stretch: float) -> float:
    """Relative RMS difference of the tip deflections of two runs from the start over a stretch, s."""
    rows = int(np.searchsorted(columns["time"], stretch * (1.0 + 1e-9), side="right"))
    rows = min(rows, len(other["time"]))
    return relative_error(columns["tip_deflection"][:rows], other["tip_deflection"][:rows])


def _distance(run: Evidence, truth: Evidence) -> float | None:
    """The difference of two converged solutions over the stretch that both claim; None if one claims nothing."""
    stretches = [stretch for each in (run, truth) if (stretch := judge(each).stretch) is not None]
    return _difference(run.columns, truth.columns, min(stretches)) if len(stretches) == 2 else None


def _checked(verdict: Verdict, run: Evidence, truth: Evidence) -> dict[str, Any]:
    """The check of a claim by the converged solution; empty if nothing can be checked."""
    right = judge(truth)
    claimed, stretch = verdict.claimed_error, verdict.stretch
    if verdict.kind not in (ACCURATE, ENDED) or claimed is None or stretch is None:
        return {}
    if right.claimed_error is None or right.stretch is None:
        return {}
    error = _difference(run.columns, truth.columns, min(stretch, right.stretch))
    holds = error <= claimed + right.claimed_error
    later = None
    if ENDED in (verdict.kind, right.kind):
        apart = abs((verdict.time or 0.0) - (right.time or 0.0))  # an end has a time
        within = (verdict.time_uncertainty or 0.0) + (right.time_uncertainty or 0.0)
        holds = holds and verdict.kind == right.kind and apart <= within
    elif stretch < run.duration:
        later = later_differences(run.columns, truth.columns, stretch)
        holds = holds and max(later.values()) <= 2.0 * LATER  # the converged solution may be off by as much
    return {"true_error": error, "true_later": later, "holds": holds}
