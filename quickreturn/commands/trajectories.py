"""Gets the trajectories for `simulate`, `plot` and `animate`, and the JSON document of each."""

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from quickreturn.cases.case import Case
from quickreturn.cases.jobs.job import Outcome
from quickreturn.cases.solving import Answer, TrajectoryRequest
from quickreturn.commands import console, options
from quickreturn.commands.answers import answered
from quickreturn.engine_choice import check, settings_of
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.trajectory import Trajectory
from quickreturn.questions import EngineDied, value_of
from quickreturn.reference_model.errors import ToldError
from quickreturn.reports.output import write_file
from quickreturn.reports.results.loads import loads_document
from quickreturn.solution import Solution, as_csv

#: The solution of an engine on a case, or why there is none.
Found = Solution | ToldError

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


def solved(
    cases: Sequence[Case],
    engines: Sequence[str],
    settings: Mapping[str, Mapping[str, str]],
    accuracy: float | None,
    estimate: bool = True,
) -> list[tuple[Case, str, Outcome[Answer], Found]]:
    """Each case and engine with the outcome of its job and the solution, after all checks. Raises as `check`."""
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

    def found(case: Case, request: TrajectoryRequest, outcome: Outcome[Answer]) -> Found:
        try:
            return Solution.of(case, request, value_of(outcome), store if outcome.job.lasts else None, outcome.stored)
        except ToldError as error:
            return error

    return [(*pair, outcome, found(pair[0], request, outcome)) for pair, request, outcome in zip(pairs, requests, outcomes, strict=True)]


def trajectories(
    cases: Sequence[Case], engines: Sequence[str], settings: Mapping[str, Mapping[str, str]], accuracy: float | None
) -> dict[tuple[str, str], Trajectory]:
    """Trajectories by case and engine; a message names each missed accuracy.

    Raises:
        Refusal, SettingError, UnknownEngine, EngineFailure, EngineDied: an engine cannot simulate a case, or failed.
    """
    by_name = {}
    for case, name, _, found in solved(cases, engines, settings, accuracy):
        if isinstance(found, ToldError):
            raise found
        if not found.reached:
            console.tell(f"{case.name}: engine {name}: {found.remark}")
        by_name[case.name, name] = found.trajectory
    return by_name


def written(outcome: Outcome[Answer], found: Found, path: str | None) -> dict[str, Any]:
    """Write the trajectory, if there is one and a file is named; return its JSON document. Raises `found` if the engine never began."""
    if isinstance(found, EngineDied):
        failure: dict[str, Any] = {"time": None, "cause": outcome.explanation, "advice": _ADVICE}
        return {"remark": f"{outcome.explanation}; {_ADVICE}", "failure": failure}
    if not isinstance(found, (Solution, EngineFailure)):
        raise found
    known: dict[str, Any] = {"version": value_of(outcome)[0], "stored": outcome.stored}
    trajectory = found.partial if isinstance(found, EngineFailure) else found.trajectory
    if trajectory is not None:
        if path is not None:
            write_file(Path(path), as_csv(trajectory))
        known |= {"rows": len(trajectory), "solve_seconds": trajectory.solve_seconds, "statistics": dict(trajectory.statistics)}
    if isinstance(found, EngineFailure):
        failure = {"time": found.time, "cause": found.cause, "advice": found.advice}
        return known | {"remark": str(found), "failure": failure}
    same = {name: getattr(found.result, name) for name in ("accuracy", *NOTHING) if hasattr(found.result, name)}
    more = {
        "error_parts": [vars(part) for part in found.error_parts],
        "loads": loads_document(found.loads),
        **vars(found.result.description),
    }
    return known | same | more
