"""Gathers the evidence for a verdict: one engine on one scene at several settings, none of which knows the right answer.

The engine climbs its ladder from the settings that it thinks enough until the run's own estimate (coarser settings), the difference
to finer settings and the balances of `cases.verdicts` leave no doubt, or the ladder or the effort ends. A run that breaks down is
climbed likewise: a numerical breakdown moves or goes with finer settings, the end of a scene stays.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cases.spectrum import later_differences
from cases.verdicts import Breakdown, Evidence, judge
from engines.accurate import Result, run_once, simulate
from engines.base import Engine, EngineFailure, Refusal
from engines.registry import usable_engine
from engines.settings import SettingError, Settings
from engines.start import standard_start
from engines.trajectory import Trajectory
from reference_model.mechanism import Mechanism

Columns = dict[str, NDArray[np.float64]]

#: Rungs of an engine's ladder that are tried: enough for two decades of accuracy; the finest take minutes.
MOST_RUNGS: Final = 5
#: Finer settings that are tried after a numerical breakdown: an unstable step is cured by that, a scene that cannot go on is not.
FINER_TRIES: Final = 1
#: A run that breaks down is judged on this part of the time until then: coarser runs may break down a little earlier.
BEFORE_BREAKDOWN: Final = 0.95


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A scene to be judged; `horizon` is the stretch (s) on which its motion is well conditioned, at most the duration."""

    mechanism: Mechanism
    duration: float
    output_step: float
    horizon: float


@dataclass(frozen=True)
class Run:
    """What the climb ended with.

    Attributes:
        evidence: for `cases.verdicts.judge`.
        settings: of the run judged; {} where none ran.
        columns: its trajectory, as far as it goes.
    """

    evidence: Evidence
    settings: dict[str, Any]
    columns: Columns


def gather(engine: str, scene: Scene, requested: float, usable: Callable[[str], Engine] = usable_engine, rungs: int = MOST_RUNGS) -> Run:
    """The evidence on an engine in a scene.

    Args:
        engine: name.
        scene: what to simulate, from the standard start.
        requested: error of the tip deflection asked for.
        usable: finds an engine by its name.
        rungs: of the engine's ladder, at most.
    """
    nothing = Evidence(requested=requested, duration=scene.duration, stretch=0.0, row=scene.output_step)
    try:
        chosen = usable(engine)
        chosen.check(scene.mechanism)
        rung: Settings | None = chosen.settings_for(requested, scene.mechanism)
    except (Refusal, SettingError) as refusal:
        return Run(replace(nothing, refused=str(refusal)), {}, {})
    found, breakdowns = Run(nothing, {}, {}), 0
    for _ in range(rungs):
        if rung is None:
            break
        try:
            run = _Rung(chosen, scene, requested, rung).run()
        except (Refusal, SettingError) as refusal:
            if not found.settings:
                return Run(replace(nothing, refused=str(refusal)), {}, {})
            break
        broken = run.evidence.breakdown
        numerical = broken is not None and not broken.at_the_end
        breakdowns += numerical
        if not numerical or not found.columns:
            found = run
        if judge(found.evidence).claimed_error is not None or breakdowns > FINER_TRIES:
            break
        rung = chosen.finer(rung)
    return found


class _Rung:
    """An engine with one choice of settings on a scene."""

    def __init__(self, engine: Engine, scene: Scene, requested: float, settings: Settings) -> None:
        self._engine, self._scene, self._requested, self._settings = engine, scene, requested, settings
        self._start = standard_start(scene.mechanism)

    def run(self) -> Run:
        """All runs that the evidence needs; finer ones only if the run's own estimate is good enough.

        Raises:
            Refusal, SettingError: the engine does not take these settings for this scene.
        """
        scene = self._scene
        nothing = Evidence(requested=self._requested, duration=scene.duration, stretch=0.0, row=scene.output_step)
        estimated, failure = self._estimated(scene.horizon)
        if failure is None and scene.horizon < scene.duration:
            whole, failure = self._once(self._settings)
        else:
            whole = estimated.trajectory if estimated else failure.partial if failure else None
        stretch, breakdown, finer = scene.horizon, None, None
        if failure is not None:
            breakdown = Breakdown(time=failure.time, cause=failure.cause, at_the_end=self._at_the_end(whole))
            if not breakdown.at_the_end:
                return self._made(replace(nothing, breakdown=breakdown), whole)
            finer, finer_failure = self._finer()
            if finer_failure is not None and self._at_the_end(finer):
                breakdown = replace(breakdown, finer_time=finer_failure.time)
            if failure.time < scene.horizon:
                stretch = scene.output_step * math.floor(BEFORE_BREAKDOWN * failure.time / scene.output_step)
                estimated, failure = self._estimated(stretch) if stretch > 0.0 else (None, failure)
                if estimated is None:
                    remark = f"up to {stretch:.4g} s it {failure}"
                    return self._made(replace(nothing, breakdown=breakdown, remark=remark), whole)
        assert estimated is not None
        evidence = replace(nothing, breakdown=breakdown, stretch=stretch, error_estimate=estimated.error_estimate, remark=estimated.remark)
        if estimated.error_estimate is None or not estimated.error_estimate <= self._requested or whole is None:
            return self._made(evidence, whole)
        if breakdown is None:
            finer, _ = self._finer()
        return self._made(self._balanced(evidence, dict(whole.columns), finer), whole)

    def _made(self, evidence: Evidence, whole: Trajectory | None) -> Run:
        return Run(evidence, self._settings.as_dict(), dict(whole.columns) if whole is not None else {})

    def _balanced(self, evidence: Evidence, whole: Columns, finer: Trajectory | None) -> Evidence:
        """The evidence with what finer settings and the balances say."""
        rows = round(evidence.stretch / evidence.row) + 1
        shown = {name: values[:rows] for name, values in whole.items()}
        difference, later = None, None
        if finer is not None and len(finer) >= rows:
            difference = relative_difference(finer["tip_deflection"][:rows], shown["tip_deflection"])
        if evidence.breakdown is None and finer is not None and rows < len(whole["time"]) == len(finer):
            later = later_differences(whole, dict(finer.columns), evidence.stretch)
        return replace(
            evidence,
            finer_difference=difference,
            later=later,
            energy_residual=energy_residual(whole if evidence.breakdown is None else shown),
            constraint_gap=float(np.max(np.abs(shown["constraint_gap"]))) if "constraint_gap" in shown else None,
            crank_jump=crank_jump(whole),
        )

    def _once(self, settings: Settings) -> tuple[Trajectory | None, EngineFailure | None]:
        """A run over the whole duration, or what there is of it and why there is no more."""
        scene = self._scene
        try:
            return run_once(self._engine, scene.mechanism, self._start, scene.duration, scene.output_step, settings)[0], None
        except EngineFailure as failure:
            return failure.partial, failure

    def _finer(self) -> tuple[Trajectory | None, EngineFailure | None]:
        finer = self._engine.finer(self._settings)
        return (None, None) if finer is None else self._once(finer)

    def _estimated(self, stretch: float) -> tuple[Result | None, EngineFailure | None]:
        """What a user of these settings is shown of a stretch, with the estimate of its error."""
        scene = self._scene
        texts = {name: _text(value) for name, value in self._settings.as_dict().items()}
        try:
            return simulate(self._engine, scene.mechanism, self._start, stretch, scene.output_step, texts, self._requested), None
        except EngineFailure as failure:
            return None, failure

    def _at_the_end(self, trajectory: Trajectory | None) -> bool:
        """Whether the slider reaches an end of the follower within two more rows, if it goes on as in the last one."""
        if trajectory is None or len(trajectory) < 2:
            return False
        place = trajectory["slider_position"]
        return not 0.0 < place[-1] + 2.0 * (place[-1] - place[-2]) < self._scene.mechanism.follower.length


def relative_difference(values: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
    """RMS of the difference over the RMS of the truth, both of shape (n,); infinite where the truth is zero."""
    size = float(np.sqrt(np.mean(truth**2)))
    return float(np.sqrt(np.mean((values - truth) ** 2))) / size if size > 0.0 else math.inf


def energy_residual(columns: Columns) -> float | None:
    """Largest violation of the energy balance over the largest strain energy; None without the columns or without strain energy."""
    gains = ("kinetic_energy", "strain_energy", "gravity_energy", "dissipated_energy")
    if not {*gains, "drive_work"} <= set(columns):
        return None
    balance = sum((columns[name] for name in gains), start=-columns["drive_work"])
    largest = float(np.max(np.abs(columns["strain_energy"])))
    return float(np.max(np.abs(balance - balance[0]))) / largest if largest > 0.0 else None


def crank_jump(columns: Columns) -> float:
    """Largest deviation of the crank angle's step from row to row from the trapezoidal rule over the crank speed, over a row's turn."""
    speed, rows = columns["crank_speed"], np.diff(columns["time"])
    turned = float(np.max(np.abs(speed))) * float(np.max(rows, initial=0.0))
    missed = np.abs(np.diff(columns["crank_angle"]) - 0.5 * rows * (speed[1:] + speed[:-1]))
    return float(np.max(missed)) / turned if turned > 0.0 and len(missed) else 0.0


def _text(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
