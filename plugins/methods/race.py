"""One loop for all studies of methods: engines in a scene, over their settings and asked for errors, against the solution of the scene.

Each engine has a process of its own, one after the other, pinned to one processor; a crash loses its rows alone. The search for settings
takes the same number of runs for every combination (`search`). Then all runs on the fronts are made again in turns, so that a drift of the
machine's speed affects all alike, and times follow from counts of calls (`fronts.paced`).
"""

import os
import platform
import time
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.motion.solving import inputs_of
from quickreturn.cases.running.job import Job, Outcome
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.plugins.methods.asked import asked, takes_longer
from quickreturn.plugins.methods.fronts import CRITERIA, front, paced, size_of
from quickreturn.plugins.methods.row import LEVELS, REFUSED, TOO_SLOW, Row, by_method, errors_of
from quickreturn.plugins.methods.search import RUNS, combinations, search, seeds, variant_of
from quickreturn.plugins.methods.signed import Line
from quickreturn.plugins.methods.truth import CONFIRMING, TRUTH, Truth, run_of, truth_of

#: Solve time (s) beyond which a signed line is not tried, as its first part foretells.
LONG: Final = 10.0
#: Time (s) for the answer to a request for an error.
PATIENCE: Final = 10.0
#: Repetitions of a run on a front in turns, and the largest sum of their solve times, s.
REPETITIONS: Final = 5
BUDGET: Final = 0.3
SLOW: Final = "too long a run"


@dataclass(frozen=True)
class Contest:
    """What is tried in a scene."""

    engines: tuple[str, ...]
    levels: tuple[float, ...] = LEVELS  # of the error
    runs: int = RUNS  # of each combination at most; 0: the engines are only asked for the levels
    usual: bool = False  # only the usual one of an engine's choices is tried
    lines: tuple[Line, ...] = ()  # settings that somebody chose
    patience: float = PATIENCE  # time (s) for an answer


@dataclass(frozen=True)
class Race:
    """What came of a contest in a scene."""

    case: str  # its name
    title: str  # its title
    duration: float  # s
    until: float  # s, up to where the solution that defines errors is known
    confirmation: Row  # a second solution
    runs: int  # of each combination at most
    machine: dict[str, str]  # processor, system and versions
    rows: tuple[Row, ...] = ()
    failures: dict[str, str] = field(default_factory=dict)  # engine -> why it was left out: it died, was stopped, or cannot be used

    @property
    def given(self) -> list[Row]:
        """The rows whose settings were given; the others are answers to requests."""
        return [row for row in self.rows if row.level is None]


def race(case: Case, contest: Contest, workshop: Workshop) -> Race:
    """A contest in a scene, from the store as far as it is there.

    Raises:
        EngineFailure, Refusal: there is no solution of the scene.
        LookupError: the workshop lacks a part of it and does not compute.
        KeyboardInterrupt: Ctrl-C; finished engines are stored.
    """

    def computed(job: Job[Any]) -> Outcome[Any]:
        (outcome,) = workshop.outcomes([job], case.name)
        if outcome.missing:
            raise LookupError(job.name)
        return outcome

    failures = {name: reason for name in contest.engines if (reason := engine(name).unavailable())}
    scene, alone = inputs_of(case), contest.runs == 0
    known_by = TRUTH[:1] if alone else (TRUTH[0], CONFIRMING[0])
    solution = computed(Job(f"solution of {case.name}", truth_of, (case, alone), "truth", known_by, inputs=(scene, alone)))
    if isinstance(solution.error, EngineFailure | Refusal):
        raise solution.error
    if solution.value is None:
        raise EngineFailure(0.0, solution.explanation, "try another scene")
    truth: Truth = solution.value
    able, rows = tuple(name for name in contest.engines if name not in failures), list[Row]()
    for name in able:
        own = replace(contest, engines=(name,), lines=tuple(line for line in contest.lines if line.engine == name))
        outcome = computed(Job(f"{name} in {case.name}", raced, (case, own, truth), "race", (name,), inputs=(scene, own)))
        rows += outcome.value or ()
        if outcome.value is None:
            failures[name] = outcome.explanation
    if contest.runs:
        outcome = computed(Job(f"{case.name} in turns", in_turns, (case, rows, truth), "turns", contest.engines, inputs=(scene, contest)))
        rows = outcome.value or rows
    about = {"date": time.strftime("%Y-%m-%d", time.gmtime()), "processor": platform.processor(), "system": platform.platform()}
    machine = about | {name: engine(name).version() for name in able}
    return Race(case.name, case.title, case.duration, truth.until, truth.confirmation, contest.runs, machine, tuple(rows), failures)


def raced(case: Case, contest: Contest, truth: Truth) -> list[Row]:
    """The rows of the only engine of a contest, in this process."""
    chosen, machine, rows = engine(contest.engines[0]), case.mechanism, list[Row]()
    run = partial(tried, chosen, case, truth)
    try:
        chosen.check(machine)
    except Refusal as refusal:
        return [Row(scene=case.name, engine=chosen.name, level=level, status=REFUSED, remark=str(refusal)) for level in contest.levels]
    if contest.runs:
        _pin()
        rows += [replace(run(line.settings_for(machine), LONG), signed=line.signed_by) for line in contest.lines]
        for choices in combinations(chosen, machine)[: 1 if contest.usual else None]:
            first = seeds(chosen, choices, contest.levels, machine)
            rows += search(first, contest.levels, contest.runs, run, case.output_step)
    levels = {*contest.levels, chosen.default_accuracy} if contest.runs else contest.levels
    for level in sorted(levels, reverse=True):
        if rows and rows[-1].status == TOO_SLOW:
            rows.append(Row(scene=case.name, engine=chosen.name, level=level, status=TOO_SLOW, remark="as is a larger error"))
        else:
            rows.append(asked(chosen, case, level, truth, contest.patience))
    return rows


def tried(chosen: AnyEngine, case: Case, truth: Truth, settings: Settings, limit: float) -> Row:
    """The row of an engine with some settings, unless its first part foretells a solve time of more than `limit` (s)."""
    row = Row(scene=case.name, engine=chosen.name, variant=variant_of(chosen, settings), settings=settings.as_dict())
    try:
        if takes_longer(chosen, case, settings, limit):
            return replace(row, status=SLOW)
        run = run_of(chosen, case, settings)
    except (EngineFailure, Refusal, SettingError) as failure:
        return replace(row, status=str(failure))
    trajectory, known = run.trajectory, run.trajectory.statistics
    calls, integration = known.get("right_hand_side_calls", known.get("steps")), known.get("integration_seconds")
    if calls and integration is not None:
        row = replace(row, call_seconds=integration / calls, rows_seconds=trajectory.solve_seconds - integration)
    errors, setup_seconds = errors_of(trajectory, truth.trajectory), run.simulation.setup_seconds
    return replace(row, errors=errors, calls=calls, solve_seconds=trajectory.solve_seconds, setup_seconds=setup_seconds)


def in_turns(case: Case, rows: list[Row], truth: Truth) -> list[Row]:
    """The rows with `paced` times: the fastest of each size on a front, and of those signed, has the least of some repetitions in turns."""
    _pin()
    on_fronts = {id(row) for of_method in by_method(rows).values() for by in CRITERIA for row in front(of_method, by)}
    chosen = [row for row in rows if id(row) in on_fronts or (row.signed and row.completed)]
    fastest = {id(row) if row.call_seconds is None else size_of(row): row for row in sorted(chosen, key=lambda row: -row.seconds)}
    best, spent = {id(row): row for row in fastest.values()}, dict.fromkeys(map(id, fastest.values()), 0.0)
    for _ in range(REPETITIONS):
        for key, row in best.items():
            if spent[key] + row.seconds <= BUDGET:
                settings = Line(row.engine, "", row.settings).settings_for(case.mechanism)
                again = tried(engine(row.engine), case, truth, settings, LONG)
                spent[key] += again.seconds if again.completed else BUDGET
                best[key] = _least(row, again) if again.completed else row
    return paced([best.get(id(row), row) for row in rows])


def _least(one: Row, other: Row) -> Row:
    """A row with the least times of two runs with the same settings."""
    names = [name for name in ("call_seconds", "rows_seconds", "solve_seconds", "setup_seconds") if getattr(one, name) is not None]
    return replace(one, **{name: min(getattr(one, name), getattr(other, name)) for name in names})


def _pin() -> None:
    """Pin this process to one processor."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
