"""One trajectory to an accuracy: run, estimate the error, refine until the estimate is good enough or the ladder ends.

The estimate does not know the answer. It compares runs of the same engine whose errors stand in a known ratio (`Comparison`), so
that error = difference / |factor - 1|: Richardson's estimate, Hairer, Norsett and Wanner, Solving Ordinary Differential Equations
I, section II.4. Errors of different origin are shown by a pair of runs each, and their sizes added: they cannot cancel. The estimate
is as good as the factor: where the runs converge at the engine's stated order it is right to some ten percent, and each engine states
its factors on the safe side (a campaign of the tests measures what comes of it). It sees the engine's own discretization alone: an
engine that converges to a wrong model is found by comparison with other engines only.
"""

import contextlib
import gc
import math
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from quickreturn.engines import progress
from quickreturn.engines.base import (
    AnyEngine,
    Comparison,
    EngineFailure,
    EstimateOf,
    ModelDescription,
    Refusal,
    Simulation,
    first_line,
)
from quickreturn.engines.relative import rms
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.columns import BEARINGS, BENDING
from quickreturn.reference_model.mechanism import Scene

R = TypeVar("R")
Q = TypeVar("Q")

#: Columns with an error estimate of their own.
ESTIMATED: Final = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")
#: Columns that have one, too, where the engine gives them: what a part must bear or a drive must give.
LOADS: Final = (*BENDING, *BEARINGS, "crank_torque", "base_torque")

#: The least factor that differences in a row are credited with: the error is at most 1.4 times the difference from the coarser run.
#: Two runs that err by as much in unrelated ways differ by more than either errs; in 17 scenes the errors of unresolved motions were at
#: most 1.07 times the difference.
LEAST_FACTOR: Final = 1.7
#: The largest part of an error that a finer run is taken to leave, however slowly the differences fall: the error is at most four times
#: the larger of them.
LARGEST_REST: Final = 0.75
#: By how much longer than the longest run so far another may take: one with half the step and twice the elements. It is not begun where
#: less is left of the time limit. Of the limit, the part that imports, compiled code and what is made of the answer leave.
LONGER: Final = 4.0
USABLE: Final = 0.9

#: Remark of a run whose error nobody wanted to know.
NOT_ESTIMATED: Final = "the error is not estimated, as asked"

#: Libraries in which an author's mistake surfaces.
_BELOW: Final = frozenset({"numpy", "scipy"})

#: A tip deflection of less than this part of the follower's length is no deflection: the follower is rigid.
NO_DEFLECTION: Final = 1e-12


@dataclass(frozen=True)
class Made:
    """A run that was made, and the simulation at its end, from where it can go on."""

    trajectory: Trajectory
    simulation: Simulation


@dataclass(frozen=True, kw_only=True)
class Assessment:
    """How far a trajectory can be trusted, and what it took.

    Attributes:
        accuracy: error of the tip deflection that the run aimed at, None where settings were given and no accuracy was asked.
        error_estimate: RMS error of the tip deflection over its RMS; of a rigid follower, RMS error of the tip's place over the
            follower's length; None where it could not be estimated.
        error_estimates: the same for each of `ESTIMATED` and those of `LOADS` that there are; None where unknown or where the column is
            zero throughout.
        estimate_of: what the two are estimates of.
        further_run_skipped: whether the run finer still, which shows how fast the error falls, was not needed.
        hurried: whether the time limit left no time for a run, so that a faster machine would know more.
        reached: False if the estimate misses the accuracy, or if it is unknown or not verified although an accuracy was asked explicitly.
        remark: why not reached or not estimated (a sentence), "" if all is well.
        setup_seconds: building the model of the delivered run.
        solve_seconds: solving the delivered run.
        compile_seconds: compiling or loading machine code before anything was timed.
        estimate_seconds: wall time of all other runs, their setup included: those it was compared with and the rungs climbed.
        description: bodies, joints and degrees of freedom of the delivered run.
    """

    accuracy: float | None
    error_estimate: float | None
    error_estimates: dict[str, float | None]
    estimate_of: EstimateOf
    further_run_skipped: bool
    hurried: bool
    reached: bool
    remark: str
    setup_seconds: float
    solve_seconds: float
    compile_seconds: float
    estimate_seconds: float
    description: ModelDescription


@dataclass(frozen=True, kw_only=True)
class Result(Assessment):
    """A trajectory and how far it can be trusted.

    Attributes:
        trajectory: of the finest run that completed.
        settings: of that run.
        runs: all runs that were made for it, by their settings; the delivered one among them.
    """

    trajectory: Trajectory
    settings: Settings
    runs: Mapping[Settings, Made] = field(default_factory=dict, repr=False)


# The eigenproblems of the shapes are small: a second thread makes them take three times as much of the processors, and no less time.
@threadpool_limits.wrap(limits=1, user_api="blas")
def simulate(
    engine: AnyEngine,
    scene: Scene,
    start: Start | None,
    duration: float,
    output_step: float,
    settings: Mapping[str, str] | None = None,
    accuracy: float | None = None,
    estimate: bool = True,
    time_limit: float | None = None,
) -> Result:
    """Simulate a scene to an accuracy.

    Without `settings` the engine picks where to begin, and finer rungs of its ladder are taken while the error estimate misses the
    accuracy. A rung that breaks down is given one finer try: an unstable step is cured by that, a scene that cannot go on is not.

    Args:
        engine: a usable engine.
        scene: of the kind that the engine simulates.
        start: state at time zero; None for a follower alone, which begins straight and at rest.
        duration: s, a multiple of `output_step`.
        output_step: s.
        settings: values by name as text; they override the engine's choice and switch the ladder off, the estimate stays.
        accuracy: error of the tip deflection asked for; None is the engine's default.
        estimate: False: make the one run and estimate nothing; no accuracy can be asked for then.
        time_limit: wall time (s) within which to answer, with what is known then: runs that could take longer are not begun, but for the
            first. None: there is none.

    Raises:
        ValueError: an accuracy without an estimate.
        Refusal: the engine cannot model the scene.
        SettingError: a setting is not acceptable.
        EngineFailure: the run broke down; carries what was computed up to then.
    """
    if accuracy is not None and not estimate:
        raise ValueError(
            f"accuracy={accuracy:g} without an estimate: whether it is reached is known by the estimate alone; give one of them"
        )
    engine.check(scene)
    target = accuracy or engine.default_accuracy
    first = engine.settings_for(target, scene)
    if settings:
        first = first.with_texts(dict(settings))
    runs = _Runs(engine, scene, start, duration, output_step, time_limit)
    if not estimate:
        return runs.result(_Judged(first, runs.run(first), remark=NOT_ESTIMATED), None, asked=False)
    if settings:
        return runs.result(runs.judged(first), accuracy, asked=accuracy is not None)
    return runs.result(_climbed(runs, first, target), target, asked=accuracy is not None)


def run_once(engine: AnyEngine, scene: Scene, start: Start | None, duration: float, output_step: float, settings: Settings) -> Made:
    """One run as it comes, checked for completeness and for values that are no numbers.

    Raises:
        Refusal, SettingError: as the engine raises them.
        EngineFailure: the run broke down, in whatever way: an unforeseen exception of an engine is reported as this too.
        MemoryError, OSError: memory, disk or the like are lacking.
    """
    try:
        simulation = engine.prepare(scene, start, settings)
        trajectory = simulation.advance(duration, output_step)
    except (Refusal, SettingError, EngineFailure, MemoryError, OSError):
        raise
    except Exception as error:  # a third-party engine may raise anything
        cause = f"the engine raised {type(error).__name__}{raised_at(error)}: {first_line(error)}"
        raise EngineFailure(0.0, cause, "report this to the author of the engine") from error
    check_trajectory(trajectory, duration, output_step)
    return Made(trajectory, simulation)


def raised_at(error: BaseException) -> str:
    """Where an exception came from, for the author of an engine: " at my_engine.py, line 12"; his line, not that of numpy below it."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not _BELOW & set(Path(frame.filename).parts)] or frames
    return f" at {Path(own[-1].filename).name}, line {own[-1].lineno}" if own else ""


def check_trajectory(trajectory: Trajectory, duration: float, output_step: float) -> None:
    """Raise `EngineFailure` unless the trajectory is complete, on its grid and finite.

    The time grid may start anywhere; it must have `duration / output_step` steps of `output_step`.
    """
    lengths = {len(values) for values in trajectory.columns.values()}
    if len(lengths) != 1:
        raise EngineFailure(0.0, "the engine returned columns of different lengths", "report this to the author of the engine")
    finite = np.logical_and.reduce([np.isfinite(values) for values in trajectory.columns.values()])
    if not finite.all():
        bad = int(np.argmin(finite))
        name = next(name for name, values in trajectory.columns.items() if not np.isfinite(values[bad]))
        good = float(trajectory["time"][bad - 1]) if bad else 0.0
        head = {name: values[:bad] for name, values in trajectory.columns.items()}
        partial = replace(trajectory, columns=head) if bad else None
        raise EngineFailure(good, f"{name} is no longer a finite number", "try finer settings", partial)
    times, rows = trajectory["time"], round(duration / output_step) + 1
    # A grid built by repeated addition may drift by some rounding errors, never by a thousandth of a step.
    on_grid = np.allclose(np.diff(times), output_step, rtol=1e-3, atol=0.0)
    if len(times) != rows or not on_grid:
        raise EngineFailure(
            float(times[-1]) if len(times) else 0.0,
            f"the engine returned {len(times)} rows that are not the {rows} of the output grid{_of_time(times, output_step)}",
            "try finer settings",
            trajectory if len(times) and on_grid else None,
        )


def _of_time(times: NDArray[np.float64], output_step: float) -> str:
    """What is wrong with a column of times, as far as that can be said."""
    step = float(np.median(np.diff(times))) if len(times) > 1 else output_step
    if math.isclose(step, 1e3 * output_step, rel_tol=1e-3):
        return "; the time column is in milliseconds, not in s"
    return "" if math.isclose(step, output_step, rel_tol=1e-3) else f"; its time steps are {step:.4g}, not {output_step:.4g} s"


@dataclass(frozen=True)
class Compared(Generic[R]):
    """What came of the runs of a `Comparison`: trajectories, or whatever else is made of them."""

    run: R  # the run in question, or one with the same error in this part
    other: R  # the one that `run` is compared with
    factor: float  # error of `other` over that of `run`, not 1
    # the run that `other` is compared with in turn, and the error of that over the one of `other`; None where there is none
    before: tuple[R, float] | None = None

    def part(self, difference: Callable[[R, R], float]) -> float:
        """The part of an error that the runs show, from the size of the difference of two of them."""
        shown = difference(self.run, self.other)
        if self.before is None:
            return shown / abs(self.factor - 1.0)
        further = difference(self.other, self.before[0])
        factor = shown_factor(self.factor, self.before[1], shown, further)
        return (shown if factor > 1.0 else max(shown, further)) / abs(factor - 1.0)

    def made_of(self, make: Callable[[R], Q]) -> "Compared[Q]":
        """The same of what is made of each run."""
        before = None if self.before is None else (make(self.before[0]), self.before[1])
        return Compared(make(self.run), make(self.other), self.factor, before)


def compared(pair: Comparison, run: Callable[[Settings], R]) -> Compared[R]:
    """Make the runs of a pair, by `run`; those of the pair that counts instead where one of them breaks down.

    Raises:
        EngineFailure: of `run`, where there is no other pair.
    """
    try:
        first, second = run(pair.run), run(pair.other)
    except EngineFailure:
        if pair.instead is None:
            raise
        return compared(pair.instead, run)
    if pair.before is None:
        return Compared(first, second, pair.factor)
    try:
        return Compared(first, second, pair.factor, (run(pair.before.other), pair.before.factor))
    except EngineFailure:
        return Compared(first, second, min(pair.factor, LEAST_FACTOR))


def estimated_part(delivered: Trajectory, runs: Compared[Trajectory], length: float) -> tuple[float, dict[str, float | None]]:
    """A part of the error of `delivered`, from two or three runs on the same output grid (see `Comparison`).

    Args:
        delivered: the run in question; differences are taken relative to the size of its columns.
        runs: that are compared.
        length: follower length, m.

    Returns:
        The part of the tip (see `Result.error_estimate`), and one for each column of `ESTIMATED` and `LOADS` that there is.
    """

    def part(name: str) -> float:
        return runs.part(lambda a, b: rms(a[name] - b[name]))

    known: list[str] = [name for name in (*ESTIMATED, *LOADS) if name in delivered.columns]
    each = {name: _relative(part(name), rms(delivered[name])) for name in known}
    deflection = each["tip_deflection"]
    if deflection is None or rms(delivered["tip_deflection"]) < NO_DEFLECTION * length:
        return runs.part(lambda a, b: rms(np.hypot(a["tip_x"] - b["tip_x"], a["tip_y"] - b["tip_y"]))) / length, each
    return deflection, each


def shown_factor(factor: float, factor_before: float, difference: float, difference_before: float) -> float:
    """The factor that two differences in a row support: from `LEAST_FACTOR` to `factor`, or from `factor` to `LARGEST_REST` if below 1.

    Runs that converge as the factors f and f' say, the errors being e, f e and f' f e, differ by (f - 1) e and (f' - 1) f e. The less
    the second difference exceeds the first, the less the error falls from run to run; where a fast motion is not resolved at all, as
    under a sudden load or where the slider shakes the cable, it does not fall.
    """
    expected = factor * (factor_before - 1.0) / (factor - 1.0)
    shown = math.inf if difference == 0.0 else factor * difference_before / (difference * expected)
    if factor < 1.0:
        return min(max(factor, shown), max(factor, LARGEST_REST))
    return max(min(factor, shown), min(factor, LEAST_FACTOR))


class _NoEstimate(Exception):
    """There is nothing to estimate an error with; the text is a clause that says why."""


class _NoTime(EngineFailure):
    """A run was not begun."""

    def __str__(self) -> str:
        return self.cause


@dataclass(frozen=True)
class _Judged:
    """A run with its estimate and the parts of it; `remark` says why there is none."""

    settings: Settings
    made: Made
    parts: tuple[float, ...] = ()
    estimates: dict[str, float | None] = field(default_factory=lambda: dict.fromkeys(ESTIMATED))
    remark: str = ""
    further_run_skipped: bool = False

    @property
    def estimate(self) -> float | None:
        return sum(self.parts) if self.parts else None

    def remarked(self, remark: str) -> "_Judged":
        return replace(self, remark="; ".join(filter(None, (self.remark, remark))))


class _Runs:
    """Runs of one scene by settings: what was computed for the estimate of one rung serves the next."""

    def __init__(
        self, engine: AnyEngine, scene: Scene, start: Start | None, duration: float, output_step: float, time_limit: float | None
    ) -> None:
        self.engine, self.scene = engine, scene
        self._run = (start, duration, output_step)
        self._done: dict[Settings, Made] = {}
        self._failed: dict[Settings, EngineFailure] = {}
        self.compile_seconds = 0.0
        self._rung = 0
        self._begin = self._first_begin = time.perf_counter()
        self._time_limit, self._longest, self._is_known, self._hurried = time_limit, 0.0, False, False

    def run(self, settings: Settings) -> Made:
        if self.engine.compiles and not self._done and not self._failed and not self.compile_seconds:
            self._compile(settings)
        if settings in self._failed:
            raise self._failed[settings]
        if settings not in self._done:
            began = time.perf_counter()
            self._find_time(began)
            try:
                self._done[settings] = run_once(self.engine, self.scene, *self._run, settings)
            except EngineFailure as failure:
                self._failed[settings] = failure
                raise
            self._longest = max(self._longest, time.perf_counter() - began)
        return self._done[settings]

    def _find_time(self, now: float) -> None:
        """Raise `_NoTime` where another run could take longer than is left."""
        if self._done and self._time_limit and now - self._first_begin + LONGER * self._longest > USABLE * self._time_limit:
            self._hurried = True
            raise _NoTime(0.0, f"could take longer than is left of the time limit of {self._time_limit:g} s", "")

    def _compile(self, settings: Settings) -> None:
        """One output step, so that all code is there before times are taken; what fails here fails again where it counts."""
        start, _, output_step = self._run
        progress.tell(engine=self.engine.name, phase=progress.COMPILING)
        began = time.perf_counter()
        with contextlib.suppress(EngineFailure), _no_garbage_collection():
            run_once(self.engine, self.scene, start, output_step, output_step, settings)
        self.compile_seconds = time.perf_counter() - began
        progress.tell(phase="simulating", rung=self._rung)
        self._begin = time.perf_counter()

    def judged(self, settings: Settings) -> _Judged:
        self._rung += 1
        progress.tell(engine=self.engine.name, phase="simulating", rung=self._rung)
        made = self.run(settings)
        progress.tell(phase="estimating the error", rung=self._rung)
        try:
            parts, skipped = self._parts(settings, made.trajectory)
        except (_NoEstimate, EngineFailure) as reason:
            if isinstance(reason, _NoTime) and self._is_known:  # of a coarser rung, which is worth more than this one
                raise
            told = f"the run for its estimate {reason}" if isinstance(reason, EngineFailure) else str(reason)
            return _Judged(settings, made, remark=f"the error is unknown: {told}")
        self._is_known = True
        names = (*ESTIMATED, *(name for name in LOADS if name in made.trajectory.columns))
        columns = {name: _sum([each.get(name) for _, each in parts]) for name in names}
        return _Judged(settings, made, tuple(tip for tip, _ in parts), columns, further_run_skipped=skipped)

    def _parts(self, settings: Settings, trajectory: Trajectory) -> tuple[list[tuple[float, dict[str, float | None]]], bool]:
        """The parts of the error, and whether a run finer still was not needed for one of them."""
        pairs, follower = self.engine.comparisons(settings, self.scene, self._run[-1]), self.scene.follower
        if any(pair.run == pair.other for pair in pairs):
            raise _NoEstimate("these settings leave no others to compare with")
        parts, skipped = [], False
        for pair in pairs:
            alone = pair.before is not None and pair.alike > 0.0 and self._converge_alike(pair)
            skipped |= alone
            runs = compared(replace(pair, before=None) if alone else pair, lambda other: self.run(other).trajectory)
            if not follower.is_rigid and same_motion(runs.run.columns, runs.other.columns):
                raise _NoEstimate("the run to compare with is the same to the last digit")
            parts.append(estimated_part(trajectory, runs, follower.length))
        return parts, skipped

    def _converge_alike(self, pair: Comparison) -> bool:
        """Whether the first two runs of a pair differ by no more than `Comparison.alike` says."""
        try:
            coarse, fine = (self.run(settings).trajectory for settings in (pair.run, pair.other))
        except EngineFailure:
            return False
        apart = {name: _relative(rms(coarse[name] - fine[name]), rms(coarse[name])) for name in ESTIMATED if name in coarse.columns}
        deflection = apart["tip_deflection"]
        return deflection is not None and max(each for each in apart.values() if each is not None) <= pair.alike * deflection

    def finer(self, judged: _Judged | None, rung: Settings, target: float) -> Settings | None:
        excess = tuple(part / target for part in judged.parts) if judged is not None and judged.settings == rung else ()
        return self.engine.finer(rung, excess, self._run[-1])

    def result(self, judged: _Judged, target: float | None, *, asked: bool) -> Result:
        estimate, remark, reached = judged.estimate, judged.remark, True
        if estimate is None:
            reached = not asked
        elif target is not None and estimate > target:
            reached = False
            error = "integration error" if self.engine.estimates == "integration" else "error"
            missed = f"the estimated {error} {estimate:.2g} misses the accuracy {target:g}"
            remark = f"{missed}; {remark}" if remark else missed
        elif asked and self.engine.estimates == "unverified":
            reached = False
            within = f"the estimated error {estimate:.2g} is within the accuracy {target:g}, but estimates of {self.engine.name}"
            remark = f"{within} are not verified; ask an engine whose estimates are, such as reference"
        trajectory, setup_seconds = judged.made.trajectory, judged.made.simulation.setup_seconds
        others = time.perf_counter() - self._begin - setup_seconds - trajectory.solve_seconds
        return Result(
            trajectory=trajectory,
            settings=judged.settings,
            accuracy=target,
            error_estimate=estimate,
            error_estimates=judged.estimates,
            estimate_of=self.engine.estimates,
            further_run_skipped=judged.further_run_skipped,
            hurried=self._hurried,
            reached=reached,
            remark=remark,
            setup_seconds=setup_seconds,
            solve_seconds=trajectory.solve_seconds,
            compile_seconds=self.compile_seconds,
            estimate_seconds=max(0.0, others),
            description=self.engine.describe(self.scene, judged.settings),
            runs=self._done,
        )


def same_motion(run: Mapping[str, NDArray[np.float64]], other: Mapping[str, NDArray[np.float64]]) -> bool:
    """Whether two runs with different settings are one, which says nothing of their error; not where nothing bends."""
    deflection = run["tip_deflection"]
    return bool(np.any(deflection) and np.array_equal(deflection, other["tip_deflection"]))


def _climbed(runs: _Runs, first: Settings, target: float) -> _Judged:
    """The first rung from `first` on whose estimate is within `target`, else the finest one that ran."""
    best: _Judged | None = None
    failure: EngineFailure | None = None
    rung: Settings | None = first
    while rung is not None:
        try:
            best = runs.judged(rung)
        except EngineFailure as error:
            if best is not None:
                return best.remarked(f"the next finer settings {error}")
            if failure is not None:
                raise error from failure
            failure = error
        if best is not None and best.estimate is not None and best.estimate <= target:
            return best
        rung = runs.finer(best, rung, target)
    if best is not None:
        return best.remarked("these are the finest settings of the engine's ladder")
    raise failure if failure is not None else AssertionError("a ladder has at least one rung")


@contextlib.contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Compiling makes millions of small objects; looking through them again and again takes an eighth of the time."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def _sum(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) if known and len(known) == len(values) else None


def _relative(difference: float, size: float) -> float | None:
    return difference / size if size != 0.0 and math.isfinite(difference / size) else None
