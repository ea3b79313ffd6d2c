"""Trajectories for `simulate`, `plot` and `animate`, and natural frequencies for `modes`, computed in processes of their own."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from quickreturn.arguments import check, settings_of
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Rows
from quickreturn.cases.motion.solving import Answer, TrajectoryRequest, frequencies_job
from quickreturn.cases.running import fork_server
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.job import Job, Outcome, T
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import outcomes_of
from quickreturn.commands.console import Call, tell, tell_doubts, write
from quickreturn.descriptions import EngineDied, value_of
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.registry import is_foreign
from quickreturn.engines.trajectory import Trajectory
from quickreturn.readings import readings
from quickreturn.reference_model.errors import ToldError
from quickreturn.reports.words import within_turn
from quickreturn.solution import Solution, as_csv, opened_store, request_of

#: The solution of an engine on a case, or why there is none.
Found = Solution | ToldError

_ADVICE: Final = "see the limits of time and memory, or report this to the author of the engine"

#: Further keys of a simulation's JSON document, with the values that they have after a failure without any.
NOTHING: Final[dict[str, Any]] = dict.fromkeys((
    "version", "stored", "rows", "reached", "error_estimate", "error_estimates", "error_parts", "estimate_of", "further_run_skipped",
    "remark", "settings", "setup_seconds", "compile_seconds", "solve_seconds", "estimate_seconds", "statistics", "bodies", "joints",
    "degrees_of_freedom", "failure",
)) | {"stored": False, "rows": 0, "reached": False, "error_estimates": {}, "error_parts": (), "remark": "", "statistics": {}} | {
    "bodies": (), "joints": (),
}  # fmt: skip


def solved(call: Call, cases: Sequence[Case], *, estimate: bool = True) -> list[tuple[Case, str, Outcome[Answer], Found]]:
    """Each case and engine with the outcome of its job and the solution, after all checks. Raises as `check`."""
    texts = settings_of(call.settings, call.engines)
    pairs = list(itertools.product(cases, call.engines))
    for case, name in pairs:
        check(name, case.scene, texts[name])
    tell_doubts(cases)
    requests = [request_of(case, name, texts[name], call.accuracy, estimate, call.limits.seconds) for case, name in pairs]
    jobs = [request.job(f"{case.name} {name}") for (case, name), request in zip(pairs, requests, strict=True)]
    outcomes, store = _outcomes(call, jobs, "simulating")

    def found(case: Case, request: TrajectoryRequest, outcome: Outcome[Answer]) -> Found:
        try:
            return Solution.of(case, request, value_of(outcome), store if outcome.job.lasts else None, outcome.stored)
        except ToldError as error:
            return error

    return [(*pair, outcome, found(pair[0], request, outcome)) for pair, request, outcome in zip(pairs, requests, outcomes, strict=True)]


def trajectories(call: Call, cases: Sequence[Case]) -> dict[tuple[str, str], Trajectory]:
    """Trajectories by case and engine; a message names each missed accuracy.

    Raises:
        Refusal, SettingError, UnknownEngine, EngineFailure, EngineDied: an engine cannot simulate a case, or failed.
    """
    by_name = {}
    for case, name, _, found in solved(call, cases):
        if isinstance(found, ToldError):
            raise found
        if not found.reached:
            tell(f"{case.name}: engine {name}: {found.remark}")
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
        write(path, lambda ending: as_csv(trajectory))
        known |= {"rows": len(trajectory), "solve_seconds": trajectory.solve_seconds, "statistics": dict(trajectory.statistics)}
    if isinstance(found, EngineFailure):
        failure = {"time": found.time, "cause": found.cause, "advice": found.advice}
        return known | {"remark": str(found), "failure": failure}
    same = {name: getattr(found.result, name) for name in ("accuracy", *NOTHING) if hasattr(found.result, name)}
    more = {
        "error_parts": [vars(part) for part in found.error_parts],
        **{name: each.document(found.readings[name]) for name, each in readings().items()},
        **vars(found.result.description),
    }
    return known | same | more


def frequencies(call: Call, cases: Sequence[Case], angles: Sequence[float], count: int) -> list[list[dict[str, Any]]]:
    """For each case and engine a document for each angle (rad), after all checks.

    Raises as `check`, and EngineDied if an engine failed.
    """
    texts = settings_of(call.settings, call.engines)
    pairs = list(itertools.product(cases, call.engines))
    for case, name in pairs:
        check(name, case.mechanism, texts[name])
    tell_doubts(cases)
    jobs = [frequencies_job(f"{case.name} {name}", case.mechanism, name, angles, count, texts[name]) for case, name in pairs]
    rows = []
    for (case, name), outcome in zip(pairs, _outcomes(call, jobs, "natural frequencies")[0], strict=True):
        try:
            each = value_of(outcome)
        except EngineFailure as failure:  # its own text names an instant, but there is none here
            raise EngineDied(f"{case.name}: engine {name}: {failure.cause}; {failure.advice}") from failure
        about = {"case": case.name, "engine": name, "version": each.version, "settings": each.settings}
        rows.append([about | {"crank_angle": angle, "frequencies": row} for angle, row in zip(angles, each.values, strict=True)])
    return rows


def frequency_lines(angled: list[dict[str, Any]]) -> list[str]:
    """One angle: a line for each mode; several: a line for each angle."""
    degrees = [f"{within_turn(math.degrees(each['crank_angle'])):g}" for each in angled]
    first = angled[0]
    if not any(each["frequencies"] for each in angled):
        rows, last = [], ["no natural frequency: nothing in this model can vibrate with the crank held"]
    else:
        rows, last = [[str(number), f"{value:.6g} Hz"] for number, value in enumerate(first["frequencies"], 1)], []
    if len(angled) == 1:
        head = f"{first['case']}, crank at {degrees[0]} deg, {first['engine']} ({first['version']})"
        return [head, *([Rows(rows).text()] if rows else []), *last]
    most = max(len(each["frequencies"]) for each in angled)
    rows = [[angle, *(f"{value:.6g}" for value in each["frequencies"])] for angle, each in zip(degrees, angled, strict=True)]
    table = Rows([row + ["-"] * (most + 1 - len(row)) for row in rows], ["crank deg", *map(str, range(1, most + 1))])
    return [f"{first['case']}, {first['engine']} ({first['version']}): natural frequencies in Hz", table.text(), *last]


def _outcomes(call: Call, jobs: Sequence[Job[T]], title: str) -> tuple[list[Outcome[T]], Store | None]:
    """The outcomes of jobs, and the store, if there is one; a message names stored results."""
    # of a foreign engine the version and code, which the key contains, would load its library here
    jobs = [replace(job, lasts=None) if any(map(is_foreign, job.engines)) else job for job in jobs]
    store = None if call.no_store or not any(job.lasts for job in jobs) else opened_store(tell)
    call.keep_in(store)
    executor = LocalProcesses(limits=call.limits, preload=fork_server.COMPUTING, quiet=call.quiet)
    outcomes = outcomes_of(jobs, title, executor, store)
    if store is not None and (known := [outcome.job.name for outcome in outcomes if outcome.stored]):
        call.begin(f"{', '.join(known)}: computed before and kept in {store.folder}; --no-store computes anew")
    return outcomes, store
