"""An engine that is asked for an error in a scene, as a user asks: its answer, the time it takes, and whether its claim holds.

The engine finds its settings itself and estimates its error. The row's status is what came of it (`row.MEANINGS`), judged by the truth.
"""

import math
import time
from dataclasses import replace
from typing import Final

from quickreturn.cases.files.case import Case
from quickreturn.engines.accurate import Result, simulate
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


def takes_longer(engine: AnyEngine, case: Case, settings: Settings, limit: float) -> bool:
    """Whether the first part of a run foretells more than `limit` (s) twice: at first it may load or compile machine code."""
    whole = round(case.duration / case.output_step)
    steps = max(1, round(FORETASTE * whole))
    run = (engine, case.mechanism, standard_start(case.mechanism), steps * case.output_step, case.output_step, settings)
    return all(run_once(*run).trajectory.solve_seconds * whole / steps > limit for _ in range(2))


def asked(engine: AnyEngine, case: Case, level: float, truth: Truth, limit: float | None = None) -> Row:
    """The row of an engine that is asked for an error of the tip deflection, with at most `limit` (s) for the answer.

    The run covers the stretch on which the scene's motion is known, or, if the slider leaves the follower, most of the time until then.
    """
    row = Row(scene=case.name, engine=engine.name, level=level)
    try:
        if limit and takes_longer(engine, case, engine.settings_for(level, case.mechanism), limit):
            return replace(row, status=TOO_SLOW, remark="its first run takes too long")
        row = _answered(row, engine, case, case.duration if truth.end is not None else truth.until, truth, limit)
        if truth.end is None or row.claim is not None:
            return row
    except (Refusal, SettingError) as refusal:
        return replace(row, status=REFUSED, remark=str(refusal))
    except EngineFailure as failure:
        row = replace(row, time=float(failure.time), remark=str(failure), status=FAILED)
        if truth.end is None:
            return row
        if abs(failure.time - truth.end) > SAME_END * truth.end + case.output_step:
            return replace(row, remark=f"{failure}; the slider leaves the follower at {truth.end:.4g} s")
    # the run, or one for its estimate, ends because the slider leaves the follower: an answer up to shortly before that counts
    stretch = case.output_step * math.floor(BEFORE_THE_END * min(row.time or truth.until, truth.until) / case.output_step)
    try:
        before = _answered(row, engine, case, stretch, truth, limit)
    except EngineFailure as failure:
        return replace(row, remark=str(failure))
    return replace(before, status=ENDED, remark=row.remark) if before.status == REACHED else before


def _answered(row: Row, engine: AnyEngine, case: Case, duration: float, truth: Truth, limit: float | None) -> Row:
    """The row with an answer over a duration, s. Raises as `simulate`."""
    began = time.perf_counter()
    start = standard_start(case.mechanism)
    result = simulate(engine, case.mechanism, start, duration, case.output_step, accuracy=row.level, time_limit=limit)
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
    return replace(row, status=_status(row, engine, result, truth.uncertainty))


def _status(row: Row, engine: AnyEngine, result: Result, uncertainty: float) -> str:
    error, claim, level = row.error or 0.0, row.claim, row.level or 0.0
    if engine.estimates == "integration":  # the claim is about its own equations
        return REACHED if error <= level else OWN_EQUATIONS if result.reached else NOT_REACHED
    if claim is not None and claim <= level and error > claim + uncertainty:
        return WRONG
    if not result.reached or claim is None:
        return TOO_SLOW if result.hurried else NOT_REACHED
    return REACHED
