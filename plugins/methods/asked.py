"""An engine that is asked for an error in a scene, as a user asks: its answer, the time it takes, and whether its claim holds.

The engine finds its settings itself and estimates its error. The row's status is what came of it (`row.MEANINGS`), judged by the truth.
"""

import math
import time
from dataclasses import replace
from typing import Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.one_run import run_once
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.engines.start import standard_start
from quickreturn.plugins.methods.row import ENDED, FAILED, NOT_REACHED, OWN_EQUATIONS, REACHED, REFUSED, TOO_SLOW, WRONG, Row, errors_of
from quickreturn.plugins.methods.truth import Truth

#: Part of the time until the slider leaves the follower on which a run is judged.
BEFORE_THE_END: Final = 0.95
#: Largest difference (relative) of two times at which the slider leaves the follower, beside a row.
SAME_END: Final = 0.01


#: Part of the duration by which the time of a run is foretold.
FORETASTE: Final = 0.02


def first_part(engine: AnyEngine, case: Case, settings: Settings) -> float:
    """The solve time (s) that the first part of a run foretells for the whole. Raises as `run_once`."""
    steps, whole = max(1, round(FORETASTE * case.duration / case.output_step)), round(case.duration / case.output_step)
    run = run_once(engine, case.mechanism, standard_start(case.mechanism), steps * case.output_step, case.output_step, settings)
    return run.trajectory.solve_seconds * whole / steps


def takes_longer(engine: AnyEngine, case: Case, settings: Settings, limit: float) -> bool:
    """Whether the first part of a run foretells more than `limit` (s) twice: at first it may load or compile machine code."""
    return all(first_part(engine, case, settings) > limit for _ in range(2))


class Clock:
    """Tells whether the next run would end after a limit of processor time (s) if it took as long as the one before."""

    def __init__(self, limit: float) -> None:
        self.limit = limit
        self.began = self.last = time.process_time()
        self.ran_out = False

    @property
    def late(self) -> bool:
        """Whether the next run must not begin; to be asked once before each run."""
        now = time.process_time()
        self.ran_out = self.ran_out or (now - self.began) + (now - self.last) > self.limit
        self.last = now
        return self.ran_out


class _Limited:
    """An engine that begins a run only if the time suffices."""

    def __init__(self, engine: AnyEngine, clock: Clock) -> None:
        self._engine, self._clock = engine, clock

    def __getattr__(self, name: str) -> Any:
        return getattr(self._engine, name)

    def prepare(self, *arguments: Any) -> Any:
        """As the engine's `prepare`. EngineFailure: the time does not suffice."""
        if self._clock.late:
            raise EngineFailure(0.0, "time has run out", "ask for less")
        return self._engine.prepare(*arguments)


def asked(engine: AnyEngine, case: Case, level: float, truth: Truth, limit: float = math.inf) -> Row:
    """The row of an engine that is asked for an error of the tip deflection, with at most `limit` (s) of processor time.

    The run covers the stretch on which the scene's motion is known, or, if the slider leaves the follower, most of the time until then.
    """
    row, clock = Row(scene=case.name, engine=engine.name, level=level), Clock(limit)
    duration = case.duration if truth.end is not None else truth.until
    try:
        if math.isfinite(limit) and takes_longer(engine, case, engine.settings_for(level, case.mechanism), limit):
            return replace(row, status=TOO_SLOW, remark="its first run takes too long")
        row = _answered(row, engine, case, duration, truth, clock)
        if truth.end is None or row.claim is not None:
            return row
    except (Refusal, SettingError) as refusal:
        return replace(row, status=REFUSED, remark=str(refusal))
    except EngineFailure as failure:
        row = replace(row, time=float(failure.time), remark=str(failure), status=TOO_SLOW if clock.ran_out else FAILED)
        if clock.ran_out or truth.end is None:
            return row
        if abs(failure.time - truth.end) > SAME_END * truth.end + case.output_step:
            return replace(row, remark=f"{failure}; the slider leaves the follower at {truth.end:.4g} s")
    return _before_the_end(row, engine, case, truth, clock)


def _before_the_end(row: Row, engine: AnyEngine, case: Case, truth: Truth, clock: Clock) -> Row:
    """The row of a run that ends, or whose estimate does, because the slider leaves the follower: by an answer up to shortly before."""
    stretch = case.output_step * math.floor(BEFORE_THE_END * min(row.time or truth.until, truth.until) / case.output_step)
    try:
        before = _answered(row, engine, case, stretch, truth, clock)
    except EngineFailure as failure:
        return replace(row, remark=str(failure))
    return replace(before, status=ENDED, remark=row.remark) if before.status == REACHED else before


def _answered(row: Row, engine: AnyEngine, case: Case, duration: float, truth: Truth, clock: Clock) -> Row:
    """The row with an answer over a duration, s. Raises as `simulate`."""
    limited: Any = _Limited(engine, clock)
    began = time.perf_counter()
    result = simulate(limited, case.mechanism, standard_start(case.mechanism), duration, case.output_step, accuracy=row.level)
    took = time.perf_counter() - began - result.compile_seconds
    row = replace(
        row,
        settings=result.settings,
        errors=errors_of(result.trajectory, truth.trajectory),
        claim=result.error_estimate,
        remark=result.remark,
        solve_seconds=result.solve_seconds,
        setup_seconds=result.setup_seconds,
        answer_seconds=max(took, result.setup_seconds + result.solve_seconds),
    )
    return replace(row, status=_status(row, engine, result.reached, truth.uncertainty, clock))


def _status(row: Row, engine: AnyEngine, reached: bool, uncertainty: float, clock: Clock) -> str:
    error, claim, level = row.error or 0.0, row.claim, row.level or 0.0
    if engine.estimates == "integration":  # the claim is about its own equations
        return REACHED if error <= level else OWN_EQUATIONS if reached else NOT_REACHED
    if claim is not None and claim <= level and error > claim + uncertainty:
        return WRONG
    if not reached or claim is None:
        return TOO_SLOW if clock.ran_out else NOT_REACHED
    return REACHED
