"""The matrix of verdicts: every engine on every hard scene, each verdict checked afterwards against a converged solution."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Final

import numpy as np

from cases.case import Case
from cases.judging.conditioning import Conditioning
from cases.judging.evidence import Columns, Run, Scene, relative_difference
from cases.judging.results import conditioning_of, conditioning_work, evidence_work, results, run_of
from cases.judging.spectrum import later_differences
from cases.judging.verdicts import ACCURATE, ENDED, LATER, Verdict, compared, judge
from cases.store import Store
from cases.stored_jobs import Work
from engines.registry import MAIN

#: Error of the tip deflection asked of every engine.
REQUESTED: Final = 0.01
#: The engine that the converged solution comes from, and the error asked of it.
CONVERGED: Final = ("reference", 1e-3)
#: The engine whose discretization is its model: it is held against its own equations, and their distance to the others told apart.
MODEL: Final = "thesis"
#: The error asked of its equations' converged solution.
MODEL_CONVERGED: Final = 1e-4


@dataclass(frozen=True, kw_only=True)
class Cell:
    """An engine in a scene.

    Attributes:
        scene: name of the case.
        engine: name.
        verdict: after the comparison with the other engines.
        settings: of the run judged.
        true_error: of the tip deflection over the stretch, against the converged solution; None where nothing is claimed or known.
        true_later: likewise beyond the stretch (`cases.judging.spectrum.later_differences`); None where there is no such part.
        holds: whether the claim (error, time, what is said of the part beyond the stretch) holds against the converged solution, whose
            own claimed error is allowed for; None where nothing is claimed or the scene has no converged solution.
        model_error: of an engine that is held against its own equations: the distance of these to the converged solution.
    """

    scene: str
    engine: str
    verdict: Verdict
    settings: Mapping[str, Any]
    true_error: float | None = None
    true_later: Mapping[str, float] | None = None
    holds: bool | None = None
    model_error: float | None = None

    @property
    def silently_wrong(self) -> bool:
        """Whether the cell claims what is not so."""
        return self.holds is False


@dataclass(frozen=True)
class Matrix:
    """All of it.

    Attributes:
        cases: the scenes, in order.
        engines: names.
        cells: (scene, engine) -> cell; those that have been computed.
        conditionings: scene -> its conditioning, where it could be computed.
        converged: scene -> claimed error of its converged solution; None where there is none.
    """

    cases: tuple[Case, ...]
    engines: tuple[str, ...]
    cells: Mapping[tuple[str, str], Cell]
    conditionings: Mapping[str, Conditioning]
    converged: Mapping[str, float | None]

    @property
    def silently_wrong(self) -> tuple[Cell, ...]:
        """Cells that claim what is not so: there must be none."""
        return tuple(cell for cell in self.cells.values() if cell.silently_wrong)


def judge_scenes(
    cases: Sequence[Case], store: Store, engines: Sequence[str] = MAIN, jobs: int | None = None, *, compute: bool = True
) -> Matrix:
    """The matrix, from the store where it is there.

    Args:
        cases: the scenes.
        store: results are taken from here and kept here.
        engines: names.
        jobs: processes at a time; None: one per core.
        compute: False: what is not stored is left out.

    Raises:
        UnknownEngine: a name that is no engine's.
        StoreError: see `cases.store`.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    conditions = [conditioning_work(case.name, case.mechanism, case.duration, case.output_step) for case in cases]
    known = {name[1]: conditioning_of(stored) for name, stored in results(conditions, store, jobs, compute=compute).items()}
    conditionings = {name: found for name, found in known.items() if found is not None}
    work = {item.name: item for case in cases for item in _work_on(case, conditionings.get(case.name), engines)}
    found = results(list(work.values()), store, jobs, compute=compute)
    runs = {name: run_of(stored, work[name]) for name, stored in found.items()}
    cells: dict[tuple[str, str], Cell] = {}
    converged: dict[str, float | None] = {}
    for case in cases:
        truth = runs.get(("converged", case.name))
        of_case = {name: runs["cell", case.name, name] for name in engines if ("cell", case.name, name) in runs}
        cells |= {(case.name, cell.engine): cell for cell in _cells(case.name, of_case, truth, runs.get(("model", case.name)))}
        converged[case.name] = judge(truth.evidence).claimed_error if truth else None
    return Matrix(tuple(cases), tuple(engines), cells, conditionings, converged)


def _work_on(case: Case, conditioning: Conditioning | None, engines: Sequence[str]) -> list[Work]:
    horizon = conditioning.horizon if conditioning else case.duration
    scene = Scene(mechanism=case.mechanism, duration=case.duration, output_step=case.output_step, horizon=horizon)
    work = [evidence_work(("converged", case.name), CONVERGED[0], scene, CONVERGED[1])]
    if MODEL in engines:
        work.append(evidence_work(("model", case.name), MODEL, scene, MODEL_CONVERGED))
    return work + [evidence_work(("cell", case.name, name), name, scene, REQUESTED) for name in engines]


def _cells(scene: str, runs: Mapping[str, Run], truth: Run | None, model: Run | None) -> list[Cell]:
    own = {name: judge(run.evidence) for name, run in runs.items()}
    others = {name: verdict for name, verdict in own.items() if name != MODEL}
    verdicts = own | dict(compared(others, _differences(runs, others)).verdicts)
    cells = []
    for name, verdict in verdicts.items():
        right = model if name == MODEL else truth
        check = _checked(verdict, runs[name], right) if right else {}
        distance = _distance(model, truth) if name == MODEL and model and truth else None
        cells.append(Cell(scene=scene, engine=name, verdict=verdict, settings=runs[name].settings, model_error=distance, **check))
    return cells


def _differences(runs: Mapping[str, Run], verdicts: Mapping[str, Verdict]) -> dict[tuple[str, str], float]:
    """Of every two runs that claim something, over the stretch that both claim."""
    claiming = [name for name, verdict in verdicts.items() if verdict.stretch is not None]
    found = {}
    for first, second in combinations(claiming, 2):
        stretch = min(runs[first].evidence.stretch, runs[second].evidence.stretch)
        found[first, second] = _difference(runs[first].columns, runs[second].columns, stretch)
    return found


def _difference(columns: Columns, other: Columns, stretch: float) -> float:
    rows = int(np.searchsorted(columns["time"], stretch * (1.0 + 1e-9), side="right"))
    rows = min(rows, len(other["time"]))
    return relative_difference(columns["tip_deflection"][:rows], other["tip_deflection"][:rows])


def _distance(run: Run, truth: Run) -> float | None:
    """Of two converged solutions, over what both claim."""
    stretches = [judge(each.evidence).stretch for each in (run, truth)]
    known = [stretch for stretch in stretches if stretch is not None]
    return _difference(run.columns, truth.columns, min(known)) if len(known) == 2 else None


def _checked(verdict: Verdict, run: Run, truth: Run) -> dict[str, Any]:
    """What the converged solution says about a claim; empty where there is nothing to say."""
    right = judge(truth.evidence)
    claimed, stretch = verdict.claimed_error, verdict.stretch
    if verdict.kind not in (ACCURATE, ENDED) or claimed is None or stretch is None:
        return {}
    if right.claimed_error is None or right.stretch is None:
        return {}
    error = _difference(run.columns, truth.columns, min(stretch, right.stretch))
    holds = error <= claimed + right.claimed_error
    later = None
    if ENDED in (verdict.kind, right.kind):
        holds = holds and verdict.kind == right.kind and _same_time(verdict, right)
    elif stretch < run.evidence.duration:
        later = later_differences(run.columns, truth.columns, stretch)
        holds = holds and max(later.values()) <= 2.0 * LATER  # the converged solution may be off by as much
    return {"true_error": error, "true_later": later, "holds": holds}


def _same_time(verdict: Verdict, right: Verdict) -> bool:
    """Whether two ends of a scene are the same within what both say of their own."""
    assert verdict.time is not None  # an end has both
    assert right.time is not None
    return abs(verdict.time - right.time) <= (verdict.time_uncertainty or 0.0) + (right.time_uncertainty or 0.0)
