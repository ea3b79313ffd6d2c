"""Gathers the evidence for a verdict: one engine on one scene at several settings, without the right answer.

The engine is asked for an accuracy as by a user (`engines.accurate.simulate`): its settings become finer until its own estimate is good
enough. Its result is then compared with finer settings and judged by its balances (`cases.motion.balances`); while these leave a doubt, a
smaller error is asked for. If the slider reaches the follower's end, the run is judged up to shortly before. With finer settings a
numerical breakdown moves or disappears, but the end of a scene stays.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from quickreturn.cases.motion.balances import Balances
from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.one_run import run_once
from quickreturn.engines.registry import usable_engine
from quickreturn.engines.relative import relative_error
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.judging.conditioning import later_differences
from quickreturn.plugins.methods.judging.verdicts import Breakdown, Evidence, judge
from quickreturn.reference_model.mechanism import Mechanism

#: Errors asked of the engine while a doubt remains, as parts of the requested one.
ASKED: Final = (1.0, 0.3, 0.1)
#: A run that breaks down is judged on this part of the time until then: runs with other settings may break down a little earlier.
BEFORE_BREAKDOWN: Final = 0.95
#: Largest number of times that this stretch is shortened because finer settings find an earlier end.
_CUTS: Final = 3


@dataclass(frozen=True, kw_only=True)
class TrialScene:
    """A scene to be judged; `horizon` is the stretch (s) on which its motion is well conditioned, at most the duration."""

    mechanism: Mechanism
    duration: float
    output_step: float
    horizon: float

    def evidence(self, requested: float, **known: Any) -> Evidence:
        """The evidence before any run."""
        return Evidence(requested=requested, duration=self.duration, stretch=0.0, row=self.output_step, **known)


def gather(
    engine: str, scene: TrialScene, requested: float, usable: Callable[[str], AnyEngine] = usable_engine, asked: Sequence[float] = ASKED
) -> Evidence:
    """The evidence on an engine (a name, which `usable` finds) in a scene from the standard start.

    `requested`: error of the tip deflection asked for; `asked`: see `ASKED`.
    """
    found = scene.evidence(requested)
    try:
        chosen = usable(engine)
        for share in asked:
            run = _Request(chosen, scene, requested, share * requested).run()
            if found.columns and run.breakdown is not None and not run.breakdown.at_the_end:
                break  # a breakdown with finer settings does not replace a completed run
            found, estimate = run, run.error_estimate
            if judge(run).claimed_error is not None or estimate is None or estimate > share * requested:
                break  # no doubt left, or the ladder ends here
    except (Refusal, SettingError) as refusal:
        return scene.evidence(requested, refused=str(refusal))
    return found


class _Request:
    """An engine that is asked for `accuracy` in a scene; its evidence is judged by `requested`, which is no smaller."""

    def __init__(self, engine: AnyEngine, scene: TrialScene, requested: float, accuracy: float) -> None:
        self._engine, self._scene, self._accuracy = engine, scene, accuracy
        self._start = standard_start(scene.mechanism)
        self._nothing = scene.evidence(requested)

    def run(self) -> Evidence:
        """All runs that the evidence needs. Refusal, SettingError: the engine does not take this scene."""
        scene = self._scene
        stretch, result, failure = self._delivered()
        if failure is not None and (result is None or not self._at_the_end(failure.partial)):
            columns = dict(failure.partial.columns) if failure.partial else {}
            return replace(self._nothing, breakdown=Breakdown(time=failure.time, cause=failure.cause), columns=columns)
        assert result is not None
        trajectory, failure = (result.trajectory, None) if stretch == scene.duration else self._once(result.delivered)
        columns = dict(trajectory.columns) if trajectory is not None else {}
        known: dict[str, Any] = {"stretch": stretch, "settings": result.settings, "columns": columns}
        evidence = replace(self._nothing, error_estimate=result.error_estimate, remark=result.remark, **known)
        if failure is not None:
            breakdown = Breakdown(time=failure.time, cause=failure.cause, at_the_end=self._at_the_end(trajectory))
            evidence = replace(evidence, breakdown=breakdown)
        estimate = result.error_estimate
        if estimate is not None and estimate <= evidence.requested and trajectory is not None:
            evidence = self._balanced(evidence, *self._finer(result.delivered))
        return evidence

    def _delivered(self) -> tuple[float, Result | None, EngineFailure | None]:
        """The user's result on the longest possible stretch, and why it is not the whole duration."""
        scene, stretch = self._scene, self._scene.horizon
        first: EngineFailure | None = None
        for _ in range(1 + _CUTS):
            try:
                result = simulate(self._engine, scene.mechanism, self._start, stretch, scene.output_step, accuracy=self._accuracy)
            except EngineFailure as error:
                failure = error
            else:
                # without an estimate the runs for it broke down: finer settings may find an end that these do not
                ended = self._finer(result.delivered)[1] if result.error_estimate is None else None
                if ended is None or not self._at_the_end(ended.partial):
                    return stretch, result, first
                failure = ended
            first = failure
            stretch = scene.output_step * math.floor(BEFORE_BREAKDOWN * min(failure.time, stretch) / scene.output_step)
            if stretch <= 0.0 or not self._at_the_end(failure.partial):
                break
        return stretch, None, first

    def _balanced(self, evidence: Evidence, finer: Trajectory | None, finer_failure: EngineFailure | None) -> Evidence:
        """The evidence with finer settings and balances."""
        columns, rows = evidence.columns, round(evidence.stretch / evidence.row) + 1
        shown = {name: values[:rows] for name, values in columns.items()}
        difference, later, breakdown, broken = None, None, evidence.breakdown, ""
        if finer is not None and len(finer) >= rows:
            difference = relative_error(finer["tip_deflection"][:rows], shown["tip_deflection"])
        elif finer_failure is not None:
            broken = str(finer_failure)
        if breakdown is not None and finer_failure is not None and self._at_the_end(finer):
            breakdown = replace(breakdown, finer_time=finer_failure.time)
        if breakdown is None and finer is not None and rows < len(columns["time"]) == len(finer):
            later = later_differences(columns, dict(finer.columns), evidence.stretch)
        return replace(
            evidence,
            breakdown=breakdown,
            finer_difference=difference,
            finer_failure=broken,
            later=later,
            balances=Balances.of(columns if breakdown is None else shown, self._scene.mechanism),
        )

    def _once(self, settings: Settings) -> tuple[Trajectory | None, EngineFailure | None]:
        """A run over the whole duration, or its rows up to a failure, and the failure."""
        scene = self._scene
        try:
            return run_once(self._engine, scene.mechanism, self._start, scene.duration, scene.output_step, settings).trajectory, None
        except EngineFailure as failure:
            return failure.partial, failure

    def _finer(self, settings: Settings) -> tuple[Trajectory | None, EngineFailure | None]:
        finer = self._engine.finer(settings, {}, self._scene.output_step)
        return (None, None) if finer is None else self._once(finer)

    def _at_the_end(self, trajectory: Trajectory | None) -> bool:
        """Whether the slider reaches an end of the follower within two more rows, if it goes on as in the last one."""
        if trajectory is None or len(trajectory) < 2:
            return False
        place = trajectory["slider_position"]
        return not 0.0 < place[-1] + 2.0 * (place[-1] - place[-2]) < self._scene.mechanism.follower.length
