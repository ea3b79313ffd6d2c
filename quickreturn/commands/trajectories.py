"""Gets the trajectories for `simulate`, `plot` and `animate`, and the JSON document of each."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from quickreturn.cases.case import Case
from quickreturn.cases.jobs.job import Outcome
from quickreturn.cases.jobs.store import Store
from quickreturn.cases.solving import Answer, TrajectoryRequest
from quickreturn.commands import console, options
from quickreturn.commands.answers import answered
from quickreturn.engine_choice import check, settings_of
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.trajectory import Trajectory
from quickreturn.questions import EngineDied, value_of
from quickreturn.reports.output import write_file
from quickreturn.reports.results.loads import loads_document
from quickreturn.solution import Solution, as_csv

Found = Solution | EngineFailure | EngineDied

_ADVICE: Final = "see the limits of time and memory, or report this to the author of the engine"

#: Further keys of a simulation's JSON document, with the values that they have after a failure without any.
NOTHING: Final[dict[str, Any]] = {
    "version": None,
    "stored": False,
    "rows": 0,
    "reached": False,
    "error_estimate": None,
    "error_estimates": {},
    "error_parts": (),
    "estimate_of": None,
    "further_run_skipped": None,
    "remark": "",
    "settings": None,
    "loads": {},
    "setup_seconds": None,
    "compile_seconds": None,
    "solve_seconds": None,
    "estimate_seconds": None,
    "statistics": {},
    "bodies": (),
    "joints": (),
    "degrees_of_freedom": None,
    "failure": None,
}


@dataclass(frozen=True)
class Attempt:
    """The outcome of an engine on a case."""

    case: Case
    engine: str
    request: TrajectoryRequest
    outcome: Outcome[Answer]
    store: Store | None

    def answer(self) -> Answer:
        """The answer. Raises as `value_of`."""
        return value_of(self.outcome)

    def solution(self) -> Solution:
        """The solution. Raises as `answer`, and EngineFailure if the run failed."""
        return Solution.of(self.case, self.request, self.answer(), self.store if self.outcome.job.lasts else None, self.outcome.stored)


def attempts(
    cases: Sequence[Case],
    engines: Sequence[str],
    settings: Mapping[str, Mapping[str, str]],
    accuracy: float | None,
    estimate: bool = True,
) -> list[Attempt]:
    """The outcome of each engine on each case, after all checks. Raises as `check`."""
    texts = settings_of(settings, engines)
    pairs = list(itertools.product(cases, engines))
    for case, name in pairs:
        check(name, case.scene, texts[name])
    options.tell_doubts(cases)
    requests = [
        TrajectoryRequest(
            scene=case.scene,
            duration=case.duration,
            output_step=case.output_step,
            engine=name,
            settings=texts[name],
            accuracy=accuracy,
            estimate=estimate,
            time_limit=options.limits().seconds,
        )
        for case, name in pairs
    ]
    jobs = [request.job(f"{case.name} {name}") for (case, name), request in zip(pairs, requests, strict=True)]
    outcomes, store = answered(jobs, "simulating")
    return [Attempt(*pair, request, outcome, store) for pair, request, outcome in zip(pairs, requests, outcomes, strict=True)]


def trajectories(
    cases: Sequence[Case], engines: Sequence[str], settings: Mapping[str, Mapping[str, str]], accuracy: float | None
) -> dict[tuple[str, str], Trajectory]:
    """Trajectories by case and engine; a message names each missed accuracy.

    Raises:
        Refusal, SettingError, UnknownEngine, EngineFailure, EngineDied: an engine cannot simulate a case, or failed.
    """
    found = {}
    for each in attempts(cases, engines, settings, accuracy):
        solution = each.solution()
        if not solution.reached:
            console.tell(f"{each.case.name}: engine {each.engine}: {solution.remark}")
        found[each.case.name, each.engine] = solution.trajectory
    return found


def written(attempt: Attempt, path: str | None) -> tuple[dict[str, Any], Found]:
    """Write the trajectory, if there is one and a file is named; return its JSON document and the solution.

    Raises as `Attempt.answer`.
    """
    found: Found
    trajectory: Trajectory | None
    try:
        known: dict[str, Any] = {"version": attempt.answer().version, "stored": attempt.outcome.stored}
        found = attempt.solution()
        trajectory = found.trajectory
    except EngineFailure as failed:
        found, trajectory = failed, failed.partial
    except EngineDied as death:
        failure: dict[str, Any] = {"time": None, "cause": attempt.outcome.explanation, "advice": _ADVICE}
        return {"remark": f"{attempt.outcome.explanation}; {_ADVICE}", "failure": failure}, death
    if trajectory is not None:
        if path is not None:
            write_file(Path(path), as_csv(trajectory))
        known |= {"rows": len(trajectory), "solve_seconds": trajectory.solve_seconds, "statistics": dict(trajectory.statistics)}
    if isinstance(found, EngineFailure):
        failure = {"time": found.time, "cause": found.cause, "advice": found.advice}
        return known | {"remark": str(found), "failure": failure}, found
    same = {name: getattr(found.result, name) for name in ("accuracy", *NOTHING) if hasattr(found.result, name)}
    more = {
        "settings": found.settings,
        "error_parts": [vars(part) for part in found.error_parts],
        "loads": loads_document(found.loads),
        **vars(found.result.description),
    }
    return known | same | more, found
