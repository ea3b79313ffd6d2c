"""Computes many runs: their starts, their order, and the outcome of those whose process died; and compares them, case by case."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final, TypeVar

from quickreturn.cases.comparison.engines import CaseResult, compare
from quickreturn.cases.comparison.tables import recorded_run
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.estimates import MeasuredNumbers
from quickreturn.cases.motion.orbit import begins_in_orbit, orbits
from quickreturn.cases.motion.request import LARGEST_PERIOD_RATIO, Run, RunRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import MAIN, engine
from quickreturn.reference_model.mechanism import PrescribedMotion
from quickreturn.reference_model.rigid import crank_pace

#: Engines whose runs come first, the slowest before the others, so that no core waits for one of them at the end.
_SLOWEST: Final = ("exudyn", "mujoco", "reference")
#: Name of a request: the case, and further parts that distinguish it from others of the case.
Name = TypeVar("Name", bound=tuple[str, ...])


def carry_out(requests: Mapping[Name, RunRequest], workshop: Workshop, title: str = "runs") -> dict[Name, Run]:
    """Runs by the names of their requests. Equal requests are computed once.

    Args:
        requests: what to run; those that shall begin in the orbit of `reference` get it.
        workshop: where the runs are computed.
        title: title of all runs, for the display of progress.

    Raises:
        UnknownEngine: no engine has the name in a request.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    reasons = {name: engine(name).unavailable() for name in {request.engine for request in requests.values()}}
    usable = {name: request for name, request in requests.items() if not reasons[request.engine]}
    marching = [name for name, request in usable.items() if _marches_from_orbit(request)]
    for name, orbit in zip(marching, orbits([usable[name].mechanism for name in marching], workshop), strict=True):
        usable[name] = replace(usable[name], orbit=orbit)
    order = _order(usable)
    jobs = [Job(" ".join(name), steady_state, (usable[name],), kind="steady state", engines=(usable[name].engine,)) for name in order]
    of_runs = zip(order, workshop.outcomes(jobs, title), strict=True)
    runs = {name: outcome.value or _without(usable[name], Ending.FAILED, outcome.explanation) for name, outcome in of_runs}
    return {name: runs.get(name) or _without(requests[name], Ending.UNAVAILABLE, reasons[requests[name].engine] or "") for name in requests}


def cross_validate(
    cases: Sequence[Case],
    workshop: Workshop,
    engines: Sequence[str] = MAIN,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, str]] | None = None,
    tables: Mapping[str, Sequence[RecordedTable]] | None = None,
) -> list[CaseResult]:
    """Bring every engine to its steady state on every case and compare.

    Args:
        cases: what to run.
        workshop: where the runs are computed.
        engines: names of engines.
        accuracy: error of the tip deflection asked of every engine; None: each engine's default.
        settings: engine -> setting -> value as text.
        tables: case -> its recorded tables.

    Raises:
        CaseError: a case without crank and slider: there is no cycle to measure; a table that is not of its case.
        ValueError: two of the cases or of the engines have the same name.
        UnknownEngine: there is no engine of a name.
    """
    recorded = {case.name: {table.name: recorded_run(table, case) for table in (tables or {}).get(case.name, ())} for case in cases}
    requests = {(case.name, name): _request(case, name, accuracy, settings) for case in cases for name in engines}
    if len(requests) < len(cases) * len(engines):
        raise ValueError("two cases or two engines have one name")
    runs = carry_out(requests, workshop, "engines on cases")
    return [compare(case, {name: runs[case.name, name] for name in engines}, recorded[case.name]) for case in cases]


def hold_against_engines(
    case: Case,
    tables: Sequence[RecordedTable],
    workshop: Workshop,
    engines: Sequence[str] = MAIN,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, str]] | None = None,
) -> list[CaseResult]:
    """Compare recorded tables with engines in the state that the tables show (`cases.comparison.tables`), but no engines with each other.

    Arguments and errors are those of `cross_validate`.

    Returns:
        One result for the steady state and one for each turn on the way to it that a table shows.
    """
    groups: dict[int | None, dict[str, Run]] = {}
    for table in tables:
        run = recorded_run(table, case)
        groups.setdefault(run.approach.turn, {})[table.name] = run
    requests = {}
    for turn, group in groups.items():
        end = LARGEST_PERIOD_RATIO * max(float(run.cycle["time"][-1]) for run in group.values())
        for name in engines:
            request = _request(case, name, accuracy, settings)
            state = "steady state" if turn is None else f"turn {turn}"
            requests[case.name, name, state] = request if turn is None else replace(request, turn=turn, duration=end)
    runs = iter(carry_out(requests, workshop, "engines on the case").values())
    results = [compare(case, {name: next(runs) for name in engines}, group) for group in groups.values()]
    return [replace(result, checks=()) for result in results]


def _request(case: Case, name: str, accuracy: float | None, settings: Mapping[str, Mapping[str, str]] | None) -> RunRequest:
    texts = dict((settings or {}).get(name, {}))
    if not crank_pace(case.mechanism):
        raise CaseError(case.name, "[crank]", None, "the crank stands still: there is no cycle", "give it a torque or a speed")
    if isinstance(drive := case.mechanism.crank.drive, PrescribedMotion) and not drive.speed_table.over_turn:
        problem, accepted = "prescribes a speed over time, which has no cycle", "use simulate, or give the speed over crank_angle"
        raise CaseError(case.name, "crank.speed_table", str(drive.speed_table), problem, accepted)
    return RunRequest(mechanism=case.mechanism, duration=case.duration, engine=name, accuracy=accuracy, settings=texts)


def _order(requests: Mapping[Name, RunRequest]) -> list[Name]:
    """The order of requests: one of each engine first, so that the others load its compiled code instead of compiling the same."""
    by_engine: dict[str, list[Name]] = {}
    for name, request in requests.items():
        by_engine.setdefault(request.engine, []).append(name)
    slowest = sorted(by_engine, key=lambda name: _SLOWEST.index(name) if name in _SLOWEST else len(_SLOWEST))
    return [by_engine[engine][0] for engine in reversed(slowest)] + [name for engine in slowest for name in by_engine[engine][1:]]


def _marches_from_orbit(request: RunRequest) -> bool:
    chosen = engine(request.engine)
    if request.orbit is not None or not begins_in_orbit(chosen):
        return False
    try:
        chosen.check(request.mechanism)
    except Exception:  # it refuses the scene, or will report the error in its own process
        return False
    return True


def _without(request: RunRequest, status: str, why: str) -> Run:
    """The run of a request that produced no result."""
    begun, measured = Run.begun(request, engine(request.engine)), MeasuredNumbers(unestimated=why)
    return replace(begun, status=status, remark=why, cause=why, measured=measured)
