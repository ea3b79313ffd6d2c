"""A trial: an engine with some settings, or asked for an accuracy, in a scene. Its row tells the error, the engine's claim, and the cost.

`trial_of` makes the row of a plan. Errors are relative to the truth of the scene (`cases.trials.truth`). Times are as measured, without
scaling.
"""

import contextlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from quickreturn.cases.files.case import Case
from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.one_run import CompletedRun, run_once
from quickreturn.engines.relative import relative_error
from quickreturn.engines.settings import SettingError, Settings, as_texts
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.trials.methods import Plan

COMPLETED: Final = "completed"
#: Largest sum of the solve times of a trial's repetitions, s.
BUDGET: Final = 4.0


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A row of a study. Times are in s. None: not measured, or there is no result."""

    scene: str  # name of the case
    engine: str
    variant: str = ""  # name of the method where it is not that of its engine
    settings: dict[str, Any] = field(default_factory=dict)
    level: float | None = None  # error of the tip deflection that was asked for; None: the settings were given
    status: str = COMPLETED  # or why there is no result
    remark: str = ""
    degrees_of_freedom: int | None = None
    errors: dict[str, float | None] = field(default_factory=dict)  # relative error of each column; None if it is zero throughout
    claim: float | None = None  # the engine's estimate of the error of the tip deflection
    solve_seconds: float | None = None  # the least of the repetitions
    solve_seconds_median: float | None = None
    solve_seconds_largest: float | None = None
    repetitions: int | None = None
    setup_seconds: float | None = None  # the least of the repetitions
    estimate_seconds: float | None = None  # set-up and solve time of the other runs for the engine's estimate
    answer_seconds: float | None = None  # set-up and solve time of all runs of an answer to `level`
    statistics: dict[str, float] = field(default_factory=dict)  # of the engine, and errors of the joint

    @property
    def method(self) -> str:
        """Name of the engine or of the variant."""
        return self.variant or self.engine

    @property
    def completed(self) -> bool:
        """Whether there is a result."""
        return self.status == COMPLETED

    @property
    def seconds(self) -> float:
        """Solve time; infinite without a result."""
        return math.inf if self.solve_seconds is None else self.solve_seconds

    @property
    def waited_seconds(self) -> float | None:
        """Waiting time with compiled code: set-up, solution and error estimate; None if the estimate was not timed."""
        parts = (self.setup_seconds, self.solve_seconds, self.estimate_seconds)
        return self.answer_seconds if None in parts else sum(part or 0.0 for part in parts)

    @property
    def error(self) -> float | None:
        """Relative error of the tip deflection."""
        return self.errors.get("tip_deflection")

    def error_of(self, column: str) -> float | None:
        """Relative error of a column; "strain" is the worst of the three gauges."""
        if column == "strain":
            gauges = [error for name in ("strain_1", "strain_2", "strain_3") if (error := self.errors.get(name)) is not None]
            return max(gauges, default=None)
        return self.errors.get(column)


def trial_of(plan: Plan, truth: Trajectory) -> Trial:
    """Carry out a plan, with errors against `truth`; a failure is the trial's status."""
    case, method, settings = plan.case, plan.method, plan.settings
    trial = Trial(**plan.about)
    try:
        run = run_of(method.engine, case, settings)
    except (EngineFailure, Refusal, SettingError) as failure:
        return replace(trial, status=str(failure))
    seconds = run.trajectory.solve_seconds
    return replace(
        trial,
        degrees_of_freedom=method.engine.describe(case.mechanism, settings).degrees_of_freedom,
        errors=errors_of(run.trajectory, truth),
        solve_seconds=seconds,
        solve_seconds_median=seconds,
        solve_seconds_largest=seconds,
        repetitions=1,
        setup_seconds=run.simulation.setup_seconds,
        statistics=dict(run.trajectory.statistics) | _errors_of_joint(run.trajectory),
    )


def warm_up(plan: Plan) -> None:
    """Run one output step, so that no measured time contains compilation, loading or the first use of memory."""
    case = plan.case
    with contextlib.suppress(EngineFailure, Refusal, SettingError):  # errors show in the trial
        run_once(plan.method.engine, case.mechanism, standard_start(case.mechanism), case.output_step, case.output_step, plan.settings)


def worth_repeating(trials: Sequence[Trial]) -> bool:
    """Whether a trial is to be repeated after these repetitions: none failed, and together they stay within `BUDGET`."""
    seconds = [trial.seconds for trial in trials]
    return all(trial.completed for trial in trials) and sum(seconds) + min(seconds) <= BUDGET


def repeated(trials: Sequence[Trial]) -> Trial:
    """The row of some repetitions of one trial: the fastest, with the times of all; a failed one if there is any."""
    if failed := [trial for trial in trials if not trial.completed]:
        return failed[0]
    seconds = [trial.seconds for trial in trials]
    return replace(
        min(trials, key=lambda trial: trial.seconds),
        solve_seconds_median=float(np.median(seconds)),
        solve_seconds_largest=max(seconds),
        repetitions=len(trials),
        setup_seconds=min(trial.setup_seconds or 0.0 for trial in trials),
    )


def estimate_seconds(plan: Plan) -> float | None:
    """Time to set up and solve the other runs for the error estimate with a plan's settings, s; None if there is no estimate."""
    case, texts = plan.case, as_texts(plan.settings.as_dict())
    try:
        result = simulate(plan.method.engine, case.mechanism, standard_start(case.mechanism), case.duration, case.output_step, texts)
    except (EngineFailure, Refusal, SettingError):
        return None
    if result.error_estimate is None:
        return None
    return seconds_of([run for settings, run in result.runs.items() if settings != result.delivered])


def seconds_of(runs: Sequence[CompletedRun]) -> float:
    """Time to set up and solve some runs, s; parts kept from an earlier run count each time they are used."""
    return sum(run.simulation.setup_seconds + run.trajectory.solve_seconds for run in runs)


def run_of(chosen: AnyEngine, case: Case, settings: Settings) -> CompletedRun:
    """One run of a case from its standard start, over its duration and output step. Raises as `run_once`."""
    return run_once(chosen, case.mechanism, standard_start(case.mechanism), case.duration, case.output_step, settings)


def errors_of(columns: Trajectory | Mapping[str, Any], truth: Trajectory) -> dict[str, float | None]:
    """Relative error of each column of `engines.error_parts.ESTIMATED`; None if the truth is zero throughout."""
    errors = {column: relative_error(columns[column], truth[column]) for column in ESTIMATED}
    return {column: error if math.isfinite(error) else None for column, error in errors.items()}


def _errors_of_joint(trajectory: Trajectory) -> dict[str, float]:
    """Errors of the joint: the largest gap in m, and the spurious work over the drive's, if there are such columns."""
    errors: dict[str, float] = {}
    columns = trajectory.columns
    if "constraint_gap" in columns:
        errors["largest_gap"] = float(np.max(np.abs(columns["constraint_gap"])))
    moved = trajectory.statistics.get("spurious_energy_moved")
    if moved is not None and "drive_work" in columns and columns["drive_work"][-1] != 0.0:
        errors["spurious_share"] = moved / abs(float(columns["drive_work"][-1]))
    return errors
