"""Studies that the report shows beside the 24 runs: accuracy against a confirmed solution, convergence, and another start."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from quickreturn.cases.case_file import load_case
from quickreturn.cases.jobs.job import Job
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.measures.steady_state import on_common_grid, relative_change
from quickreturn.cases.runs.campaign import Work, carry_out
from quickreturn.cases.runs.marching import Columns, channels_of
from quickreturn.cases.runs.request import Run, RunRequest
from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import AnyEngine
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.relative import relative_error
from quickreturn.engines.settings import Settings, as_texts
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.mechanism import Mechanism

#: The case on which accuracy is shown, and the settings whose three solutions confirm each other.
ACCURACY_CASE: Final = "thesis-24"
CONVERGED: Final = ("reference", {"modes": "9", "tolerance": "1e-9"})
CONFIRMING: Final = {"exudyn": {"elements": "32", "step": "1e-4"}, "mujoco": {"links": "60", "armature": "0"}}
#: Modes and tolerances of the convergence table of the reference; the last of each is the solution it is measured against.
MODES: Final = (1, 2, 3, 4, 5, 6, 7, 9, 11)
TOLERANCES: Final = (1e-5, 1e-7, 1e-9)


@dataclass(frozen=True, kw_only=True)
class StudiedRun:
    """A run from the standard start, what it took, and how far it is from the converged solution."""

    engine: str
    settings: dict[str, Any]
    degrees_of_freedom: int
    solve_seconds: float
    setup_seconds: float
    right_hand_side_calls: float | None = None  # None where the engine counts none
    error_estimate: float | None = None  # of the tip deflection, the engine's own, where it runs to an accuracy
    remark: str = ""
    errors: dict[str, float] = field(default_factory=dict)  # of each column of `ESTIMATED`
    is_reference: bool = False  # whether the errors of others are against this one


@dataclass(frozen=True)
class StudiedTrajectory:
    """A run and its motion."""

    run: StudiedRun
    columns: Columns

    def against(self, truth: Columns) -> StudiedRun:
        """The run with its errors."""
        errors = {column: relative_error(self.columns[column], truth[column]) for column in ESTIMATED}
        return replace(self.run, errors=errors, is_reference=self.columns is truth)


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
    converged: StudiedRun | None  # what that is measured against; None where it could not be computed
    confirming: Sequence[StudiedRun]  # solutions of others that confirm it, where they are stored (see `confirming`)
    convergence: Sequence[StudiedRun]  # of the engine `reference`, over modes and tolerances
    both_starts: Sequence[BothStarts]  # of each package that marches
    failures: Sequence[str]  # sentences on what could not be computed


def work() -> Work:
    """All that the studies need, to be computed with other runs; `run_studies` then finds it in the store."""
    return Work(_requests(), list(_solutions().values()))


def confirming(workshop: Workshop) -> list[StudiedRun]:
    """Solutions of others that confirm the converged one; they take half a minute. KeyboardInterrupt: Ctrl-C; what is there is stored."""
    jobs = [_solution("converged", *CONVERGED), *(_solution("confirming", *other) for other in CONFIRMING.items())]
    converged, *others = [outcome.value for outcome in workshop.outcomes(jobs, "confirmation")]
    return [each.against(converged.columns) for each in others if each] if converged else []


def run_studies(workshop: Workshop) -> Studies:
    """All studies, from the store where they are there. KeyboardInterrupt: Ctrl-C; what was computed is stored."""
    jobs = _solutions()
    solutions = dict(zip(jobs, workshop.outcomes(list(jobs.values()), "studies"), strict=True))
    failures = [f"study {outcome.job.name}: {outcome.explanation}" for outcome in solutions.values() if not outcome.completed]
    convergence = solutions.pop(_CONVERGENCE).value
    found = {name: outcome.value for name, outcome in solutions.items() if outcome.value is not None}
    converged = found.get(_CONVERGED)
    results = carry_out(_requests(), workshop, "another start")

    return Studies(
        accuracy=[found["default", name].against(converged.columns) for name in MAIN if ("default", name) in found] if converged else [],
        converged=converged and converged.run,
        confirming=confirming(workshop.as_it_is),
        convergence=convergence or (),
        both_starts=_both_starts(results, failures),
        failures=failures,
    )


_CODE: Final = ("quickreturn.cases.studies",)

Name = tuple[str, ...]
Runs = Mapping[Name, Run]
_CONVERGED: Final = ("converged", CONVERGED[0])
_CONVERGENCE: Final = ("convergence", "reference")


def _solutions() -> dict[Name, Job[Any]]:
    """Trajectories of one case, and the convergence of the reference there."""
    solutions: dict[Name, Job[Any]] = {_CONVERGED: _solution("converged", *CONVERGED)}
    solutions |= {("default", name): _solution("default", name, None) for name in MAIN}
    return solutions | {_CONVERGENCE: Job("convergence", _convergence, _scene(), "study", ("reference",), _CODE)}


def _solution(what: str, name: str, settings: Mapping[str, str] | None) -> Job[StudiedTrajectory]:
    return Job(f"{what} {name}", _trajectory, (*_scene(), name, settings), "study", (name,), _CODE)


def _scene() -> tuple[Mechanism, float, float]:
    case = load_case(ACCURACY_CASE)
    return case.mechanism, case.duration, case.output_step


def _trajectory(
    mechanism: Mechanism, duration: float, output_step: float, name: str, settings: Mapping[str, str] | None
) -> StudiedTrajectory:
    """To the engine's default accuracy, or once with given settings."""
    chosen = engine(name)
    if settings is not None:
        used = chosen.settings_for(chosen.default_accuracy, mechanism).with_texts(dict(settings))
        return _once(chosen, mechanism, duration, output_step, used)
    made = simulate(chosen, mechanism, standard_start(mechanism), duration, output_step)
    known = {"error_estimate": made.error_estimate, "remark": made.remark}
    return _studied(chosen, mechanism, made.settings, made.trajectory, made.setup_seconds, **known)


def _once(chosen: AnyEngine, mechanism: Mechanism, duration: float, output_step: float, settings: Settings) -> StudiedTrajectory:
    run = run_once(chosen, mechanism, standard_start(mechanism), duration, output_step, settings)
    return _studied(chosen, mechanism, settings, run.trajectory, run.simulation.setup_seconds)


def _studied(
    chosen: AnyEngine, mechanism: Mechanism, settings: Settings, trajectory: Trajectory, setup_seconds: float, **known: Any
) -> StudiedTrajectory:
    run = StudiedRun(
        engine=chosen.name,
        settings=settings.as_dict(),
        degrees_of_freedom=chosen.describe(mechanism, settings).degrees_of_freedom,
        solve_seconds=trajectory.solve_seconds,
        setup_seconds=setup_seconds,
        right_hand_side_calls=trajectory.statistics.get("right_hand_side_calls"),
        **known,
    )
    return StudiedTrajectory(run, dict(trajectory.columns))


def _convergence(mechanism: Mechanism, duration: float, output_step: float) -> list[StudiedRun]:
    ladder = [ReferenceSettings(modes=modes, tolerance=tolerance) for modes in MODES for tolerance in TOLERANCES]
    return convergence(ReferenceEngine(), mechanism, ladder, duration, output_step)


def convergence(
    chosen: AnyEngine, mechanism: Mechanism, ladder: Sequence[Settings], duration: float, output_step: float
) -> list[StudiedRun]:
    """Runs with several settings, coarse to fine, and their errors against the last, whose own error their fall towards it bounds.

    Raises:
        EngineFailure: a run broke down.
    """
    if chosen.compiles:
        _once(chosen, mechanism, output_step, output_step, ladder[0])  # so that the times below do not count it
    found = [_once(chosen, mechanism, duration, output_step, settings) for settings in ladder]
    return [each.against(found[-1].columns) for each in found]


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
