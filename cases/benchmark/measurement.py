"""One scene: error and solve time of every method over its ladder of settings, against a solution that a second engine confirms.

One process, pinned to one processor; the repetitions of all points are interleaved, so that a drift of the machine's speed affects all of
them alike. Times are solve times as measured, without scaling. Points that failed or were not tried stay in the table. An engine that
crashes ends this process: `cases.benchmark.scenes.measure` finds out which engine it was.
"""

import contextlib
import os
import platform
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from quickreturn.cases.benchmark.findings import LEVELS, Measured, Point, fastest_at
from quickreturn.cases.benchmark.methods import Method, methods
from quickreturn.cases.benchmark.truth import Confirmation, Converged, confirmation_of, converged, errors_of, run_of, truth_of
from quickreturn.cases.case import Case
from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.one_run import CompletedRun, run_once
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import SettingError, Settings, as_texts
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.natural_modes import frozen_crank_modes

#: Largest number of repetitions of a point, and largest sum, s, of their solve times.
REPETITIONS: Final = 5
BUDGET: Final = 4.0
#: Solve time (s) beyond which the finer settings of a method are not tried.
LONG: Final = 10.0
COMPLETED: Final = "completed"
NOT_TRIED: Final = "not tried"
_AT_WORK: Final = "at work: "


@dataclass(frozen=True)
class Benchmark:
    """The table of one scene."""

    case: str  # its name
    title: str  # its title
    duration: float  # s
    truth: Converged  # the solution that defines errors
    confirmation: Confirmation  # its confirmation by a second solution
    points: tuple[Point, ...]  # one for each method and settings
    repetitions: int  # largest number of repetitions of a point
    longest: float  # solve time (s) beyond which the finer settings of a method were not tried
    machine: dict[str, str]  # processor, system and versions
    # engine -> why it was left out: it died, was stopped at a limit or cannot be used on this machine
    failures: dict[str, str] = field(default_factory=dict)


def benchmark(
    case: Case,
    names: Sequence[str],
    repetitions: int = REPETITIONS,
    longest: float = LONG,
    announce: Callable[[str], None] = lambda name: None,
) -> Benchmark:
    """Measure engines on a case, in this process.

    Args:
        case: the scene; from its standard start, over its duration and output step.
        names: of engines.
        repetitions: of each point, at most.
        longest: solve time (s) beyond which the finer settings of a method are not tried.
        announce: called with the name of each engine before it runs.

    Raises:
        UnknownEngine: no engine has this name.
        EngineFailure: the solution that defines errors cannot be computed.
        Refusal: the engine of that solution cannot model the scene.
    """
    attempts = [Attempt(method, settings) for method in methods(names, case) for settings in method.ladder]
    truth = truth_of(case)
    confirmation = confirmation_of(case, truth)
    for attempt in {attempt.method.name: attempt for attempt in attempts}.values():
        announce(attempt.method.engine.name)
        attempt.warm_up(case)
    for repetition in range(repetitions):
        slow: set[str] = set()
        for attempt in attempts:
            if repetition == 0 and attempt.method.name in slow:
                attempt.status = f"{NOT_TRIED}: coarser settings took longer than {longest:g} s"
            announce(attempt.method.engine.name)
            attempt.repeat(case, repetition)
            if repetition == 0 and attempt.times and attempt.times[0] > longest:
                slow.add(attempt.method.name)
    return Benchmark(
        case.name,
        case.title,
        case.duration,
        converged(case, truth),
        confirmation,
        _with_estimates(case, attempts, [attempt.point(case, truth) for attempt in attempts], announce),
        repetitions,
        longest,
        _machine(names),
    )


def _with_estimates(
    case: Case, attempts: Sequence["Attempt"], points: Sequence[Point], announce: Callable[[str], None]
) -> tuple[Point, ...]:
    """The points; each method's fastest point within an error of `LEVELS` also has the time of its error estimate."""
    chosen = {id(point) for level in LEVELS for point, _ in fastest_at(points, level).values()}
    timed = []
    for attempt, point in zip(attempts, points, strict=True):
        if id(point) in chosen and point.measured is not None:
            announce(point.engine)
            point = replace(point, measured=replace(point.measured, estimate_seconds=attempt.estimate_seconds(case)))
        timed.append(point)
    return tuple(timed)


def pinned(case: Case, names: Sequence[str], repetitions: int) -> Benchmark:
    """As `benchmark`, with the process pinned to one processor; its output names the engine at work, see `last_at_work`."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    began = time.monotonic()

    def announce(name: str) -> None:
        print(f"\n{_AT_WORK}{time.monotonic() - began:.3f} {name}", flush=True)

    return benchmark(case, names, repetitions, announce=announce)


def last_at_work(output: str) -> tuple[str | None, float]:
    """The engine at work when a process in `pinned` ended, by the process' output, and the time (s) when it began; (None, 0): none yet."""
    announced = [line.removeprefix(_AT_WORK).split(" ", 1) for line in output.splitlines() if line.startswith(_AT_WORK)]
    return (announced[-1][1], float(announced[-1][0])) if announced else (None, 0.0)


def _machine(names: Sequence[str]) -> dict[str, str]:
    return {
        "date": time.strftime("%Y-%m-%d", time.gmtime()),
        "processor": platform.processor() or platform.machine(),
        "system": platform.platform(),
        "python": platform.python_version(),
        **{name: engine(name).version() for name in names if not engine(name).unavailable()},
    }


def seconds_of(runs: Iterable[CompletedRun]) -> float:
    """Time to set up and solve some runs, s; parts kept from an earlier run count each time they are used."""
    return sum(run.simulation.setup_seconds + run.trajectory.solve_seconds for run in runs)


class Attempt:
    """A method with one set of settings: its repeated runs of a case, and their measurements.

    Attributes:
        status: "" before the first run, `COMPLETED`, or why there is no result.
        times: solve times of its runs, s.
    """

    def __init__(self, method: Method, settings: Settings) -> None:
        self.method, self.settings, self.status = method, settings, ""
        self.times: list[float] = []
        self.setup: list[float] = []
        self.trajectory: Trajectory | None = None

    def warm_up(self, case: Case) -> None:
        """Run one output step, so that no measured time contains compilation, loading or the first use of memory."""
        with contextlib.suppress(EngineFailure, Refusal, SettingError):  # errors show in the timed runs
            run_once(self.method.engine, case.mechanism, standard_start(case.mechanism), case.output_step, case.output_step, self.settings)

    def repeat(self, case: Case, repetition: int) -> None:
        """Run once more (`repetition` 0 is the first), unless it has failed or its repetitions have taken long enough."""
        if self.status not in ("", COMPLETED):
            return
        if repetition and sum(self.times) + min(self.times) > BUDGET:
            return
        try:
            run = run_of(self.method.engine, case, self.settings)
        except (EngineFailure, Refusal, SettingError) as failure:
            self.status = str(failure)
            return
        self.status, self.trajectory = COMPLETED, run.trajectory
        self.times.append(run.trajectory.solve_seconds)
        self.setup.append(run.simulation.setup_seconds)

    def estimate_seconds(self, case: Case) -> float | None:
        """Time to set up and solve the other runs for the error estimate with these settings, s; None if there is no estimate."""
        start, texts = standard_start(case.mechanism), as_texts(self.settings.as_dict())
        try:
            result = simulate(self.method.engine, case.mechanism, start, case.duration, case.output_step, texts)
        except (EngineFailure, Refusal, SettingError):
            return None
        if result.error_estimate is None:
            return None
        return seconds_of(run for settings, run in result.runs.items() if settings != result.settings)

    def point(self, case: Case, truth: Trajectory) -> Point:
        """The attempt as a point of the table, with errors against `truth`."""
        return Point(
            method=self.method.name,
            engine=self.method.engine.name,
            settings=self.settings.as_dict(),
            changing=self.method.changing(self.settings),
            status=self.status,
            measured=self._measured(case, truth),
        )

    def _measured(self, case: Case, truth: Trajectory) -> Measured | None:
        if self.trajectory is None or self.status != COMPLETED:
            return None
        return Measured(
            degrees_of_freedom=self.method.engine.describe(case.mechanism, self.settings).degrees_of_freedom,
            errors=errors_of(self.trajectory, truth),
            solve_seconds=min(self.times),
            solve_seconds_median=float(np.median(self.times)),
            solve_seconds_largest=max(self.times),
            repetitions=len(self.times),
            setup_seconds=min(self.setup),
            statistics=dict(self.trajectory.statistics) | _joint(self.trajectory),
            calls_per_period=self._calls_per_period(case, self.trajectory.statistics),
        )

    def _calls_per_period(self, case: Case, statistics: Mapping[str, float]) -> float | None:
        """Right-hand sides per period of the highest mode that `reference` keeps, at the start's crank angle; None for other methods."""
        modes, calls = self.settings.as_dict().get("modes"), statistics.get("right_hand_side_calls")
        if self.method.engine.name != "reference" or modes is None or calls is None or case.mechanism.follower.is_rigid:
            return None
        highest = frozen_crank_modes(case.mechanism, case.mechanism.crank.initial_angle, modes).frequencies[-1]
        return calls / (case.duration * float(highest))


def _joint(trajectory: Trajectory) -> dict[str, float]:
    """Errors of the joint: the largest gap in m, and the spurious work over the drive's, if there are such columns."""
    errors: dict[str, float] = {}
    columns = trajectory.columns
    if "constraint_gap" in columns:
        errors["largest_gap"] = float(np.max(np.abs(columns["constraint_gap"])))
    moved = trajectory.statistics.get("spurious_energy_moved")
    if moved is not None and "drive_work" in columns and columns["drive_work"][-1] != 0.0:
        errors["spurious_share"] = moved / abs(float(columns["drive_work"][-1]))
    return errors
