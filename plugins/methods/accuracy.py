"""Two studies that the report shows: accuracy against a confirmed solution, and convergence."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from quickreturn.cases.comparison.campaign import Work
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.motion.solving import Answer, TrajectoryRequest, inputs_of
from quickreturn.cases.running.job import MISSING, Job, Outcome
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import MAIN
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.trials.methods import Method
from quickreturn.plugins.methods.trials.trial import Trial, errors_of, run_of, trial_of, warm_up
from quickreturn.plugins.methods.trials.truth import CONFIRMING, TRUTH, Truth, confirmation_of, truth_of

#: The case on which accuracy is shown.
ACCURACY_CASE: Final = "thesis-24"
#: The same machine with its mean crank speed prescribed.
PRESCRIBED_CASE: Final = "hard-prescribed-speed"
#: An engine that requires a prescribed crank speed, and the settings that select each of its models.
PRESCRIBED: Final[tuple[str, tuple[dict[str, str], ...]]] = ("moving-boundaries", ({}, {"foreshortening": "true"}))
#: Modes and tolerances in the convergence table of the reference. The last pair gives the solution against which errors are measured.
MODES: Final = (1, 2, 3, 4, 5, 6, 7, 9, 11)
TOLERANCES: Final = (1e-5, 1e-7, 1e-9)


@dataclass(frozen=True)
class Prescribed:
    """The effect of a prescribed crank speed, and the runs of models that require one.

    `changed`: column -> difference between the converged solutions at the prescribed speed and with the driven crank, relative to the
    second. `runs`: their errors are against the converged solution at the same speed.
    """

    changed: dict[str, float | None]
    runs: Sequence[Trial]


@dataclass(frozen=True)
class Studies:
    """Rows of all studies."""

    accuracy: Sequence[Trial]  # each engine at its default accuracy
    converged: Truth | None  # the solution against which their errors are measured; None if it could not be computed
    confirming: Sequence[Trial]  # stored solutions of other engines that confirm it (see `confirming`)
    prescribed: Prescribed | None  # None if a converged solution could not be computed
    convergence: Sequence[Trial]  # runs of `reference` over modes and tolerances, with errors against the last run
    failures: Sequence[str]  # a sentence on each part that could not be computed


def work(engines: Sequence[str] = MAIN) -> Work:
    """What `run_studies` would compute, for computing it together with other runs; it then finds the results in the store."""
    return _of(_wanted(engines), _jobs())


def confirming(workshop: Workshop) -> list[Trial]:
    """Solutions of other engines that confirm the converged solution. Computing them takes a minute. KeyboardInterrupt: Ctrl-C."""
    case = load_case(ACCURACY_CASE)
    (true,) = workshop.outcomes([_truth(case)], "confirmation")
    if true.value is None:
        return []
    jobs = [
        Job(f"confirming {name}", confirmation_of, (case, true.value, name), "study", (TRUTH[0], name), inputs=inputs_of(case))
        for name in CONFIRMING
    ]
    return [outcome.value for outcome in workshop.outcomes(jobs, "confirmation") if outcome.value and outcome.value.completed]


def run_studies(workshop: Workshop, engines: Sequence[str] = MAIN) -> Studies:
    """All studies; stored results are not computed again.

    Parts on engines that are not asked for are not computed. The studies of all main engines include the models that require a prescribed
    crank speed.

    Raises:
        KeyboardInterrupt: Ctrl-C; finished results are stored.
    """
    case, (defaults, models), jobs = load_case(ACCURACY_CASE), _trajectory_requests(), _jobs()
    planned = _of(_wanted(engines), jobs)
    computed = dict(zip(map(id, planned.jobs), workshop.outcomes(planned.jobs, "studies"), strict=True))
    outcomes = [computed.get(id(job)) or Outcome[Any](job, failure=MISSING) for job in jobs]
    true, convergence, at_speed, *runs = outcomes
    failures = [f"study {outcome.job.name}: {outcome.explanation}" for outcome in outcomes if not (outcome.completed or outcome.missing)]
    accuracy = _studied(defaults, runs[: len(defaults)], true.value, failures)
    of_models = _studied(models, runs[len(defaults) :], at_speed.value, failures)
    return Studies(
        accuracy=accuracy,
        converged=Truth.of(case, true.value) if true.value else None,
        confirming=confirming(workshop.as_it_is),
        prescribed=Prescribed(errors_of(at_speed.value, true.value), of_models) if true.value and at_speed.value else None,
        convergence=convergence.value or (),
        failures=failures,
    )


def _wanted(engines: Sequence[str]) -> set[str]:
    """The engines whose parts of the studies belong to a report on some engines."""
    return {*engines, PRESCRIBED[0]} if set(MAIN).issubset(engines) else {*engines}


def _of(engines: set[str], jobs: Sequence[Job[Any]]) -> Work:
    """The part of `jobs` that needs no other engines."""
    return Work({}, [job for job in jobs if engines.issuperset(job.engines)])


def _jobs() -> list[Job[Any]]:
    """Jobs for the converged solution, the convergence table, the converged solution at the prescribed speed, and the requested runs."""
    case, (defaults, models) = load_case(ACCURACY_CASE), _trajectory_requests()
    runs = [request.job(f"default {request.engine}") for request in (*defaults, *models)]
    convergence = Job("convergence", _convergence, (case,), "study", ("reference",), inputs=inputs_of(case))
    return [_truth(case), convergence, _truth(load_case(PRESCRIBED_CASE)), *runs]


def _truth(case: Case) -> Job[Trajectory]:
    return Job("converged reference", truth_of, (case,), "study", (TRUTH[0],), inputs=inputs_of(case))


def _trajectory_requests() -> tuple[list[TrajectoryRequest], list[TrajectoryRequest]]:
    """Requests for each engine at its default accuracy, and for the models of `PRESCRIBED`."""
    case, at_speed = load_case(ACCURACY_CASE), load_case(PRESCRIBED_CASE)
    name, choices = PRESCRIBED
    return [_at_default(case, each) for each in MAIN], [replace(_at_default(at_speed, name), settings=settings) for settings in choices]


def _at_default(case: Case, name: str) -> TrajectoryRequest:
    return TrajectoryRequest(scene=case.mechanism, duration=case.duration, output_step=case.output_step, engine=name)


def _studied(
    requests: Iterable[TrajectoryRequest],
    outcomes: Iterable[Outcome[Answer]],
    true: Trajectory | None,
    failures: list[str],
) -> list[Trial]:
    """The completed runs with their errors against the converged solution. Appends a sentence on each failed run to `failures`."""
    runs = []
    for request, outcome in zip(requests, outcomes, strict=True):
        name = str(request.engine)
        result = outcome.value and outcome.value[1]
        if isinstance(result, EngineFailure):
            failures.append(f"study {outcome.job.name}: {result}")
        elif result and true:
            runs.append(
                Trial(
                    scene=ACCURACY_CASE,
                    engine=name,
                    settings=result.settings,
                    remark=result.remark,
                    degrees_of_freedom=result.description.degrees_of_freedom,
                    errors=errors_of(result.trajectory.columns, true),
                    claim=result.error_estimate,
                    solve_seconds=result.solve_seconds,
                    setup_seconds=result.setup_seconds,
                )
            )
    return runs


def _convergence(case: Case) -> list[Trial]:
    ladder = [ReferenceSettings(modes=modes, tolerance=tolerance) for modes in MODES for tolerance in TOLERANCES]
    return convergence(Method("reference", ReferenceEngine(), tuple(ladder)), case)


def convergence(method: Method, case: Case) -> list[Trial]:
    """A ladder, coarse to fine, with errors against its last settings. The decrease of these errors bounds the last one's error.

    Raises:
        EngineFailure: a run broke down.
    """
    plans = list(method.plans(case))
    warm_up(plans[0])  # compiles, so that the times do not contain the compilation
    finest = run_of(method.engine, case, method.ladder[-1]).trajectory
    trials = [trial_of(plan, finest) for plan in plans]
    for trial in trials:
        if not trial.completed:
            raise EngineFailure(0.0, trial.status, "try other settings")
    return trials
