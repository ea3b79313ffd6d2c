"""One loop for all studies of methods: engines in a scene, over their settings and asked for errors, against the solution of the scene.

Each engine has a process of its own, one after the other, pinned to one processor; a crash loses its rows alone. The search for settings
takes the same number of runs for every combination (`search`). Then all runs on the fronts are made again in turns, so that a drift of the
machine's speed affects all alike, and times follow from counts of calls (`fronts.paced`).
"""

import os
import platform
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.motion.solving import inputs_of
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import SettingError, Settings, as_texts
from quickreturn.plugins.methods.asked import asked, takes_longer
from quickreturn.plugins.methods.fronts import CRITERIA, front, paced
from quickreturn.plugins.methods.row import LEVELS, REFUSED, Row, errors_of, variant_of
from quickreturn.plugins.methods.search import RUNS, combinations, search
from quickreturn.plugins.methods.signed import Line, settings_for
from quickreturn.plugins.methods.truth import CONFIRMING_ONE, TRUTH, Truth, run_of, truth_by_itself, truth_of

#: Solve time (s) beyond which a run is not made, as its first part foretells.
LONG: Final = 4.0
#: Processor time (s) for the answer to a request for an error.
PATIENCE: Final = 10.0
#: Repetitions of a run on a front in turns, and the largest sum of their solve times, s.
REPETITIONS: Final = 5
BUDGET: Final = 2.0
SLOW: Final = f"a run of more than {LONG:g} s"


@dataclass(frozen=True)
class Contest:
    """What is tried in a scene."""

    engines: tuple[str, ...]
    levels: tuple[float, ...] = LEVELS  # of the error
    runs: int = RUNS  # of each combination at most; 0: the engines are only asked for the levels
    usual: bool = False  # only the usual one of an engine's choices is tried
    lines: tuple[Line, ...] = ()  # settings that somebody chose
    patience: float = PATIENCE  # processor time (s) for an answer


@dataclass(frozen=True)
class Race:
    """What came of a contest in a scene."""

    case: str  # its name
    title: str  # its title
    duration: float  # s
    truth: dict[str, Any]  # settings of the solution that defines errors
    until: float  # s, up to where that solution is known
    confirmation: Row  # a second formulation
    runs: int  # of each combination at most
    machine: dict[str, str]  # processor, system and versions
    rows: tuple[Row, ...] = ()
    failures: dict[str, str] = field(default_factory=dict)  # engine -> why it was left out: it died, was stopped, or cannot be used

    @property
    def given(self) -> list[Row]:
        """The rows whose settings were given; the others are answers to requests."""
        return [row for row in self.rows if row.level is None]


def race(case: Case, contest: Contest, workshop: Workshop) -> Race | None:
    """A contest in a scene, from the store as far as it is there; None if the workshop lacks it and does not compute.

    Raises:
        EngineFailure, Refusal: there is no solution of the scene.
        KeyboardInterrupt: Ctrl-C; finished engines are stored.
    """
    failures = {name: reason for name in contest.engines if (reason := engine(name).unavailable())}
    (solution,) = workshop.outcomes([_truth_job(case, contest)], case.name)
    if solution.missing:
        return None
    truth = solution.value
    if truth is None:
        if isinstance(solution.error, EngineFailure | Refusal):
            raise solution.error
        raise EngineFailure(0.0, solution.explanation, "try another scene")
    rows = list[Row]()
    for name in [each for each in contest.engines if each not in failures]:
        (outcome,) = workshop.outcomes([_engine_job(case, name, contest, truth)], case.name)
        if outcome.missing:
            return None
        rows += outcome.value or ()
        if outcome.value is None:
            failures[name] = outcome.explanation
    outcomes = workshop.outcomes([_turns_job(case, contest, rows, truth)], case.name) if contest.runs else []
    rows = next((outcome.value for outcome in outcomes if outcome.value), rows)
    return Race(
        case=case.name,
        title=case.title,
        duration=case.duration,
        truth=dict(TRUTH[1]),
        until=truth.until,
        confirmation=truth.confirmation,
        runs=contest.runs,
        machine=_machine([name for name in contest.engines if name not in failures]),
        rows=tuple(rows),
        failures=failures,
    )


def _truth_job(case: Case, contest: Contest) -> Job[Truth]:
    find, engines = (truth_of, (TRUTH[0], CONFIRMING_ONE)) if contest.runs else (truth_by_itself, TRUTH[:1])
    return Job(f"solution of {case.name}", find, (case,), "truth", engines, inputs=inputs_of(case))


def _engine_job(case: Case, name: str, contest: Contest, truth: Truth) -> Job[list[Row]]:
    alone = replace(contest, engines=(name,), lines=tuple(line for line in contest.lines if line.engine == name))
    return Job(f"{name} in {case.name}", raced, (case, alone, truth), "race", (name,), inputs=(inputs_of(case), alone))


def _turns_job(case: Case, contest: Contest, rows: list[Row], truth: Truth) -> Job[list[Row]]:
    return Job(f"{case.name} in turns", in_turns, (case, rows, truth), "turns", contest.engines, inputs=(inputs_of(case), contest))


def raced(case: Case, contest: Contest, truth: Truth) -> list[Row]:
    """The rows of the only engine of a contest, in this process."""
    chosen = engine(contest.engines[0])
    try:
        chosen.check(case.mechanism)
    except Refusal as refusal:
        return [Row(scene=case.name, engine=chosen.name, level=level, status=REFUSED, remark=str(refusal)) for level in contest.levels]
    rows = list[Row]()
    if contest.runs:
        _pin()
        rows += [replace(tried(chosen, case, settings_for(line, case.mechanism), truth), signed=line.signed_by) for line in contest.lines]
        for combination in combinations(chosen, case.mechanism)[: 1 if contest.usual else None]:
            seeds = combination.seeds(contest.levels, case.mechanism)
            rows += search(seeds, contest.levels, contest.runs, lambda settings: tried(chosen, case, settings, truth), case.output_step)
    levels = {*contest.levels, chosen.default_accuracy} if contest.runs else contest.levels
    return rows + [asked(chosen, case, level, truth, contest.patience) for level in sorted(levels, reverse=True)]


def tried(chosen: AnyEngine, case: Case, settings: Settings, truth: Truth) -> Row:
    """The row of an engine with some settings; a failure is its status."""
    row = Row(scene=case.name, engine=chosen.name, variant=variant_of(chosen, settings), settings=settings.as_dict())
    try:
        if takes_longer(chosen, case, settings, LONG):
            return replace(row, status=SLOW)
        run = run_of(chosen, case, settings)
    except (EngineFailure, Refusal, SettingError) as failure:
        return replace(row, status=str(failure))
    trajectory, known = run.trajectory, run.trajectory.statistics
    calls, integration = known.get("right_hand_side_calls", known.get("steps")), known.get("integration_seconds")
    each = integration / calls if calls and integration is not None else None
    return replace(
        row,
        errors=errors_of(trajectory, truth.trajectory),
        calls=calls,
        call_seconds=each,
        rows_seconds=None if integration is None else trajectory.solve_seconds - integration,
        solve_seconds=trajectory.solve_seconds,
        setup_seconds=run.simulation.setup_seconds,
    )


def in_turns(case: Case, rows: list[Row], truth: Truth) -> list[Row]:
    """The rows, those on a front and the signed ones with the least times of some repetitions in turns, all with `paced` times."""
    _pin()
    methods = dict.fromkeys(row.method for row in rows if row.completed)
    chosen = {id(row): row for method in methods for by in CRITERIA for row in front([each for each in rows if each.method == method], by)}
    chosen |= {id(row): row for row in rows if row.signed and row.completed}
    best, spent = dict(chosen), dict.fromkeys(chosen, 0.0)
    for _ in range(REPETITIONS):
        for key, row in chosen.items():
            if spent[key] + row.seconds <= BUDGET:
                named = engine(row.engine)
                settings = named.settings_for(LEVELS[0], case.mechanism).with_texts(as_texts(row.settings))
                again = tried(named, case, settings, truth)
                spent[key] += again.seconds if again.completed else BUDGET
                best[key] = _least(best[key], again) if again.completed else best[key]
    return paced([best.get(id(row), row) for row in rows])


def _least(one: Row, other: Row) -> Row:
    """A row with the least times of two runs with the same settings."""
    times: dict[str, Any] = {}
    for name in ("call_seconds", "rows_seconds", "solve_seconds", "setup_seconds"):
        times[name] = min((seconds for row in (one, other) if (seconds := getattr(row, name)) is not None), default=None)
    return replace(one, **times)


def _pin() -> None:
    """Pin this process to one processor."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def _machine(names: Sequence[str]) -> dict[str, str]:
    about = {"date": time.strftime("%Y-%m-%d", time.gmtime()), "processor": platform.processor() or platform.machine()}
    return about | {"system": platform.platform(), "python": platform.python_version()} | {name: engine(name).version() for name in names}
