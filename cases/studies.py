"""Studies that the report shows beside the 24 runs: accuracy against a confirmed solution, convergence, and another start."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from quickreturn.cases.benchmark.findings import Point
from quickreturn.cases.benchmark.measurement import Attempt
from quickreturn.cases.benchmark.methods import Method
from quickreturn.cases.benchmark.truth import CONFIRMING, TRUTH, Confirmation, Converged, confirmation_of, converged, errors_of, truth_of
from quickreturn.cases.case import Case
from quickreturn.cases.case_file import load_case
from quickreturn.cases.jobs.job import Job
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.measures.steady_state import on_common_grid, relative_change
from quickreturn.cases.runs.campaign import Work, carry_out
from quickreturn.cases.runs.marching import channels_of
from quickreturn.cases.runs.request import Run, RunRequest
from quickreturn.cases.solving import TrajectoryRequest
from quickreturn.engines.accurate import Result
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.settings import as_texts
from quickreturn.engines.trajectory import Columns, Trajectory
from quickreturn.reference_model.mechanism import Mechanism

#: The case on which accuracy is shown.
ACCURACY_CASE: Final = "thesis-24"
#: Modes and tolerances of the convergence table of the reference; the last of each is the solution it is measured against.
MODES: Final = (1, 2, 3, 4, 5, 6, 7, 9, 11)
TOLERANCES: Final = (1e-5, 1e-7, 1e-9)


@dataclass(frozen=True, kw_only=True)
class StudiedRun:
    """A run from the standard start at an engine's default accuracy, what it took, and how far it is from the converged solution."""

    engine: str
    settings: dict[str, Any]
    degrees_of_freedom: int
    solve_seconds: float
    setup_seconds: float
    error_estimate: float | None = None  # of the tip deflection, the engine's own
    remark: str = ""
    errors: dict[str, float | None] = field(default_factory=dict)  # of each column of `ESTIMATED`


@dataclass(frozen=True)
class BothStarts:
    """A package that marched from the orbit of the reference and from the standard start.

    `difference`: of the two last cycles, RMS over the channels, relative to theirs.
    """

    engine: str
    orbit: Run
    straight: Run
    difference: float


@dataclass(frozen=True)
class Studies:
    """Rows of all studies."""

    accuracy: Sequence[StudiedRun]  # of each engine at its default accuracy
    converged: Converged | None  # what that is measured against; None where it could not be computed
    confirming: Sequence[Confirmation]  # solutions of others that confirm it, where they are stored (see `confirming`)
    convergence: Sequence[Point]  # of the engine `reference`, over modes and tolerances; errors are those against the last
    both_starts: Sequence[BothStarts]  # of each package that marches
    failures: Sequence[str]  # sentences on what could not be computed


def work() -> Work:
    """All that the studies need, to be computed with other runs; `run_studies` then finds it in the store."""
    return Work(_requests(), _jobs())


def confirming(workshop: Workshop) -> list[Confirmation]:
    """Solutions of others that confirm the converged one; they take a minute. KeyboardInterrupt: Ctrl-C; what is there is stored."""
    case = load_case(ACCURACY_CASE)
    (true,) = workshop.outcomes([_truth(case)], "confirmation")
    if true.value is None:
        return []
    jobs = [
        Job(f"confirming {name}", confirmation_of, (case, true.value, name), "study", (TRUTH[0], name), CODE, _scene(case))
        for name in CONFIRMING
    ]
    return [outcome.value for outcome in workshop.outcomes(jobs, "confirmation") if outcome.value and outcome.value.differences]


def run_studies(workshop: Workshop) -> Studies:
    """All studies, from the store where they are there. KeyboardInterrupt: Ctrl-C; what was computed is stored."""
    case, jobs = load_case(ACCURACY_CASE), _jobs()
    true, convergence, *runs = workshop.outcomes(jobs, "studies")
    failures = [f"study {outcome.job.name}: {outcome.explanation}" for outcome in (true, convergence, *runs) if not outcome.completed]
    answers = {name: outcome.value for name, outcome in zip(MAIN, runs, strict=True) if outcome.value is not None}
    found = {name: answer.result(_at_default(case, name), engine(name)) for name, answer in answers.items()}
    failures += [f"study default {name}: {failure}" for name, failure in found.items() if isinstance(failure, EngineFailure)]
    made = {name: result for name, result in found.items() if isinstance(result, Result)}
    results = carry_out(_requests(), workshop, "another start")
    return Studies(
        accuracy=[_studied(name, result, true.value) for name, result in made.items()] if true.value else [],
        converged=converged(case, true.value) if true.value else None,
        confirming=confirming(workshop.as_it_is),
        convergence=convergence.value or (),
        both_starts=_both_starts(results, failures),
        failures=failures,
    )


#: Code that the studies depend on.
CODE: Final = ("quickreturn.cases.studies", "quickreturn.cases.benchmark")

Name = tuple[str, ...]
Runs = Mapping[Name, Run]


def _jobs() -> list[Job[Any]]:
    """The truth of the case, the convergence of the reference there, and each engine at its default accuracy."""
    case = load_case(ACCURACY_CASE)
    runs = [_at_default(case, name).job(f"default {name}") for name in MAIN]
    return [_truth(case), Job("convergence", _convergence, (case,), "study", ("reference",), CODE, _scene(case)), *runs]


def _truth(case: Case) -> Job[Trajectory]:
    return Job("converged reference", truth_of, (case,), "study", (TRUTH[0],), CODE, _scene(case))


def _scene(case: Case) -> tuple[Mechanism, float, float]:
    return case.mechanism, case.duration, case.output_step


def _at_default(case: Case, name: str) -> TrajectoryRequest:
    """An engine at its default accuracy."""
    return TrajectoryRequest(scene=case.mechanism, duration=case.duration, output_step=case.output_step, engine=name)


def _studied(name: str, made: Result, true: Trajectory) -> StudiedRun:
    return StudiedRun(
        engine=name,
        settings=made.settings.as_dict(),
        degrees_of_freedom=made.description.degrees_of_freedom,
        solve_seconds=made.solve_seconds,
        setup_seconds=made.setup_seconds,
        error_estimate=made.error_estimate,
        remark=made.remark,
        errors=errors_of(made.trajectory.columns, true),
    )


def _convergence(case: Case) -> list[Point]:
    ladder = [ReferenceSettings(modes=modes, tolerance=tolerance) for modes in MODES for tolerance in TOLERANCES]
    return convergence(Method("reference", ReferenceEngine(), tuple(ladder)), case)


def convergence(method: Method, case: Case) -> list[Point]:
    """Runs of a ladder, coarse to fine, and their errors against the last, whose own error their fall towards it bounds.

    Raises:
        EngineFailure: a run broke down.
    """
    attempts = [Attempt(method, settings) for settings in method.ladder]
    attempts[0].warm_up(case)  # so that the times do not count what is compiled
    found = list[Trajectory]()
    for attempt in attempts:
        attempt.repeat(case, 0)
        if attempt.trajectory is None:
            raise EngineFailure(0.0, attempt.status, "try other settings")
        found.append(attempt.trajectory)
    return [attempt.told(case, found[-1]) for attempt in attempts]


#: Packages that march from the standard start, too, on one run: that they get to the same cycle is seen, not assumed.
PACKAGES: Final = ("exudyn", "mujoco")


def _requests() -> dict[Name, RunRequest]:
    requests = dict[Name, RunRequest]()
    case = load_case(ACCURACY_CASE)
    for name in PACKAGES:
        requests[name, "orbit"] = RunRequest(mechanism=case.mechanism, duration=case.duration, engine=name)
        # with the settings that the run from the orbit begins with; where that needed finer ones the two are no pair
        chosen = engine(name)
        settings = as_texts(chosen.settings_for(chosen.default_accuracy, case.mechanism).as_dict())
        requests[name, "straight"] = replace(requests[name, "orbit"], settings=settings, straight=True, estimated=False)
    return requests


def _both_starts(results: Runs, failures: list[str]) -> list[BothStarts]:
    found: list[BothStarts] = []
    for name in PACKAGES:
        orbit, straight = results[name, "orbit"], results[name, "straight"]
        if not (orbit.usable and straight.usable) or orbit.settings != straight.settings:
            reason = straight.remark or orbit.remark or "the run from the orbit needed finer settings than the other was given"
            failures.append(f"study of {name} from both starts: {reason}")
        else:
            found.append(BothStarts(name, orbit, straight, cycle_difference(straight.cycle, orbit.cycle)))
    return found


def cycle_difference(one: Columns, other: Columns) -> float:
    """RMS over the channels of their difference in two cycles, each relative to its RMS in the first."""
    return relative_change(on_common_grid(channels_of(other)), on_common_grid(channels_of(one)))
