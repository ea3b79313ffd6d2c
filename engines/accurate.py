"""One trajectory to an accuracy: run, estimate the error, refine until the estimate is good enough or the ladder ends.

The estimate does not know the answer. It compares runs of the same engine whose errors stand in a known ratio (`Comparison`), so
that error = difference / |factor - 1|: Richardson's estimate, Hairer, Norsett and Wanner, Solving Ordinary Differential Equations
I, section II.4. Errors of different origin are shown by a pair of runs each, and their sizes added: they cannot cancel. The estimate
is as good as the factor: where the runs converge at the engine's stated order it is right to some ten percent, and each engine states
its factors on the safe side (a campaign of the tests measures what comes of it). It sees the engine's own discretization alone: an
engine that converges to a wrong model is found by comparison with other engines only.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from quickreturn.engines import progress
from quickreturn.engines.base import AnyEngine, Comparison, Engine, EngineFailure, EstimateOf, ModelDescription
from quickreturn.engines.error_parts import (
    ESTIMATED,
    TIP,
    WHERE_GIVEN,
    ErrorPart,
    NoEstimate,
    add_first_row,
    all_compared,
    parts_of,
    relative_size,
    starts_suddenly,
    total,
)
from quickreturn.engines.one_run import CompletedRun, Remembered, compile_seconds, on_one_thread, run_once
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import FollowerTrajectory, Trajectory, rms
from quickreturn.reference_model.mechanism import Scene

#: Assumed time of the next run over that of the longest so far: half the step and twice the elements. It is not begun if less time is left.
LONGER: Final = 4.0
#: Fraction of the time limit for runs; the rest is for imports, compiled code and the use of the answer.
USABLE: Final = 0.9

#: Remark on a run whose error the caller did not ask for.
NOT_ESTIMATED: Final = "the error is not estimated, as asked"


@dataclass(frozen=True, kw_only=True)
class Result:
    """A trajectory, how far it can be trusted, and what it took. It is what the store keeps of a simulation.

    Attributes:
        trajectory: of the finest run that completed.
        settings: of that run, by name.
        accuracy: error of the tip deflection that the run aimed at, None where settings were given and no accuracy was asked.
        error_estimate: RMS error of the tip deflection over its RMS; of a rigid follower, RMS error of the tip's place over the
            follower's length; None where it could not be estimated.
        largest_errors: largest error at any instant of each column with an estimate, in its unit; empty where unknown.
        error_estimates: RMS error over `scale` for each column of `ESTIMATED` and each existing one of `WHERE_GIVEN`; None where unknown or
            where the scale is 0.
        error_parts: the parts of `error_estimate`, which add up to it, and by column those of `error_estimates`, with the runs that show
            them; empty where unknown. Their settings are those that differ from `settings` or from each other.
        estimate_of: the error that is estimated.
        further_run_skipped: whether a still finer run, which checks how fast the error falls, was not needed (`Comparison.alike`).
        hurried: whether the time limit prevented a run, so that a faster machine would give a better answer.
        reached: False if the estimate misses the accuracy, if a run for it broke down on every rung or had no time, or if it is unknown or
            not verified although an accuracy was asked explicitly.
        remark: why not reached, not estimated, or estimated without the run that shows how fast the error falls (a sentence); "" if all is
            well.
        setup_seconds: building the model of the delivered run.
        solve_seconds: solving the delivered run.
        compile_seconds: compiling or loading machine code before anything was timed.
        estimate_seconds: wall time of all other runs, their setup included: those for the estimate, and coarser rungs.
        description: bodies, joints and degrees of freedom of the delivered run.
        runs: all completed runs by their settings, the delivered one among them; empty if the result comes from another process.
    """

    trajectory: Trajectory | FollowerTrajectory
    settings: dict[str, Any]
    accuracy: float | None
    error_estimate: float | None
    error_estimates: dict[str, float | None]
    error_parts: dict[str, tuple[ErrorPart, ...]]
    largest_errors: dict[str, float]
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
    runs: Mapping[Settings, CompletedRun] = field(default_factory=dict, repr=False)

    @property
    def delivered(self) -> Settings:
        """Settings of the delivered run as the engine made them; only where `runs` are."""
        return next(each for each in self.runs if each.as_dict() == self.settings)


@on_one_thread
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

    Without `settings` the engine picks where to begin, and takes finer rungs of its ladder while the error estimate misses the accuracy.
    After a rung that breaks down the next finer one is tried once: it cures an unstable step, but not a scene that cannot go on.

    Args:
        engine: a usable engine.
        scene: of the kind that the engine simulates.
        start: state at time zero; None for a follower alone, which begins straight and at rest.
        duration: s, a multiple of `output_step`.
        output_step: s.
        settings: values by name as text; they override the engine's choice and switch the ladder off, but not the estimate.
        accuracy: error of the tip deflection asked for; None is the engine's default.
        estimate: whether to estimate the error; without an estimate there is one run, and no accuracy can be asked for.
        time_limit: wall time (s) for the answer; None: no limit. A run other than the first is not begun if it could take longer.

    Raises:
        ValueError: an accuracy without an estimate.
        Refusal: the engine cannot model the scene, or the follower alone.
        SettingError: a setting is not acceptable.
        EngineFailure: the run broke down; carries what was computed up to then.
    """
    if accuracy is not None and not estimate:
        raise ValueError(
            f"accuracy={accuracy:g} without an estimate: whether it is reached is known by the estimate alone; give one of them"
        )
    check_scene(engine, scene)
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


def describe_scene(engine: AnyEngine, scene: Scene) -> ModelDescription:
    """Describes what the engine builds for a scene with its default settings. Raises Refusal: it cannot model the scene."""
    check_scene(engine, scene)
    return engine.describe(scene, engine.settings_for(engine.default_accuracy, scene))


def check_scene(engine: AnyEngine, scene: Scene) -> None:
    """Refuse a scene that the engine cannot model. An override of `check` gets a follower alone only if the engine names `SPIN_UP`.

    Raises:
        Refusal: a feature of the scene that the engine does not have.
    """
    if scene.crank is None:
        Engine.check(engine, scene)
    engine.check(scene)


class _NoTime(EngineFailure):
    """A run that was not begun for lack of time."""

    def __str__(self) -> str:
        return self.cause


@dataclass(frozen=True)
class _Judged:
    """A run with the parts of its error estimate; none if the error is unknown, and `remark` says why."""

    settings: Settings
    made: CompletedRun
    parts: dict[str, tuple[ErrorPart, ...]] = field(default_factory=dict)  # `TIP`, and columns
    largest: dict[str, float] = field(default_factory=dict)
    remark: str = ""
    further_run_skipped: bool = False
    broken: bool = False  # whether the error is unknown because a run for its estimate broke down, or was not begun for lack of time

    @property
    def estimate(self) -> float | None:
        return total(self.parts.get(TIP, ()))

    def remarked(self, remark: str) -> "_Judged":
        return replace(self, remark="; ".join(filter(None, (self.remark, remark))))


class _Runs:
    """The runs of one scene, by settings: a run for the estimate of one rung may serve as the next rung."""

    def __init__(
        self, engine: AnyEngine, scene: Scene, start: Start | None, duration: float, output_step: float, time_limit: float | None
    ) -> None:
        self.engine, self.scene = engine, scene
        self._run = (start, duration, output_step)
        self._made = Remembered(self._new)
        self.compile_seconds = 0.0
        self._rung = 0
        self._begin = time.perf_counter()
        self._seconds: dict[Settings, float] = {}  # wall time of each run, whether it failed or not
        self._time_limit, self._has_estimate, self._hurried = time_limit, False, False

    def run(self, settings: Settings) -> CompletedRun:
        """The run with some settings. Raises EngineFailure: it broke down, now or before."""
        if self.engine.compiles and not self._seconds and not self.compile_seconds:
            self.compile_seconds = compile_seconds(self.engine, self.scene, self._run[0], self._run[-1], settings)
            progress.tell(phase="simulating", rung=self._rung)
        return self._made(settings)

    def _new(self, settings: Settings) -> CompletedRun:
        began, limit = time.perf_counter(), self._time_limit
        if self._made.results and limit and began - self._begin + LONGER * max(self._seconds.values()) > USABLE * limit:
            self._hurried = True
            raise _NoTime(0.0, f"could take longer than is left of the time limit of {limit:g} s", "")
        try:
            return run_once(self.engine, self.scene, *self._run, settings)
        finally:
            self._seconds[settings] = time.perf_counter() - began

    def judged(self, settings: Settings) -> _Judged:
        """The run of a rung with its error estimate. Raises EngineFailure: it broke down."""
        self._rung += 1
        progress.tell(engine=self.engine.name, phase="simulating", rung=self._rung)
        made = self.run(settings)
        progress.tell(phase="estimating the error", rung=self._rung)
        try:
            judged = self._compared(settings, made)
        except (NoEstimate, EngineFailure) as reason:
            if isinstance(reason, _NoTime) and self._has_estimate:  # a coarser rung with an estimate is worth more than this one
                raise
            why = f"the run for its estimate {reason}" if isinstance(reason, EngineFailure) else str(reason)
            return _Judged(settings, made, remark=f"the error is unknown: {why}", broken=isinstance(reason, EngineFailure))
        self._has_estimate = True
        return judged

    def _compared(self, settings: Settings, made: CompletedRun) -> _Judged:
        """A completed run with the parts of its error. NoEstimate, EngineFailure: as `all_compared`."""
        pairs, follower = self.engine.comparisons(settings, self.scene, self._run[-1]), self.scene.follower
        trusted = [pair.before is not None and pair.alike > 0.0 and self._converge_alike(pair) for pair in pairs]
        pairs = tuple(replace(pair, before=None) if alone else pair for pair, alone in zip(pairs, trusted, strict=True))
        bends = not follower.is_rigid
        runs = all_compared(pairs, settings, lambda other: self.run(other).trajectory, lambda run: run.columns, bends=bends)
        parts, largest = parts_of(made.trajectory, runs, follower.length)
        if starts_suddenly(made.trajectory, runs):
            place = float(made.trajectory["slider_position"][0])
            finest = self.engine.first_row(self.scene, self._run[0], settings, place)
            if finest is not None:
                add_first_row(parts, largest, made.trajectory, finest)
        unchecked = next((each.unchecked for each in runs if each.unchecked), "")
        remark = f"the estimate assumes the slowest convergence: the run that would show how fast the error falls {unchecked}"
        return _Judged(settings, made, parts, largest, remark if unchecked else "", any(trusted))

    def _converge_alike(self, pair: Comparison) -> bool:
        """Whether the differences between the two runs are within what `Comparison.alike` allows."""
        try:
            coarse, fine = (self.run(settings).trajectory for settings in (pair.run, pair.other))
        except EngineFailure:
            return False
        differences = {
            name: relative_size(rms(coarse[name] - fine[name]), rms(coarse[name])) for name in ESTIMATED if name in coarse.columns
        }
        deflection = differences["tip_deflection"]
        return deflection is not None and max(d for d in differences.values() if d is not None) <= pair.alike * deflection

    def finer(self, judged: _Judged | None, rung: Settings, target: float) -> Settings | None:
        """The engine's next rung after `rung`, by its estimate if `judged` is that rung."""
        excess: dict[str, float] = {}
        for part in judged.parts.get(TIP, ()) if judged is not None and judged.settings == rung else ():
            excess[part.of] = excess.get(part.of, 0.0) + part.error / target
        return self.engine.finer(rung, excess, self._run[-1])

    def result(self, judged: _Judged, target: float | None, *, asked: bool) -> Result:
        """The delivered run, held against the accuracy `target`; `asked`: whether the caller asked for it explicitly."""
        columns = (*ESTIMATED, *(name for name in WHERE_GIVEN if name in judged.parts))
        estimate, remark, reached = judged.estimate, judged.remark, True
        if estimate is None:
            reached = not asked and not (judged.broken and target is not None)
        elif target is not None and estimate > target:
            reached = False
            error = "integration error" if self.engine.estimates == "integration" else "error"
            missed = f"the estimated {error} {estimate:.2g} misses the accuracy {target:g}"
            remark = f"{missed}; {remark}" if remark else missed
        elif asked and self.engine.estimates == "unverified":
            reached = False
            within = f"the estimated error {estimate:.2g} is within the accuracy {target:g}, but estimates of {self.engine.name}"
            remark = f"{within} are not verified; ask an engine whose estimates are, such as reference"
        return Result(
            trajectory=judged.made.trajectory,
            settings=judged.settings.as_dict(),
            accuracy=target,
            error_estimate=estimate,
            error_estimates={name: total(judged.parts.get(name, ())) for name in columns},
            error_parts=judged.parts,
            largest_errors=judged.largest,
            estimate_of=self.engine.estimates,
            further_run_skipped=judged.further_run_skipped,
            hurried=self._hurried,
            reached=reached,
            remark=remark,
            setup_seconds=judged.made.simulation.setup_seconds,
            solve_seconds=judged.made.trajectory.solve_seconds,
            compile_seconds=self.compile_seconds,
            estimate_seconds=sum(seconds for settings, seconds in self._seconds.items() if settings != judged.settings),
            description=self.engine.describe(self.scene, judged.settings),
            runs=self._made.results,
        )


def _climbed(runs: _Runs, first: Settings, target: float) -> _Judged:
    """The first rung, from `first` on, whose estimate is within `target`; else the finest rung that ran."""
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
