"""Checks of the rows of a trajectory: with another output step, and in pieces, they show the same motion."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.conformance.bench import Bench, compared_columns, solution
from quickreturn.cases.conformance.checks import Array, Check, Fault, LeftOut, some
from quickreturn.cases.conformance.scenes import OUTPUT_STEP
from quickreturn.cases.mistakes.diagnosis import IN_TIME, lateness, share_of
from quickreturn.cases.mistakes.explanation import explain
from quickreturn.cases.units import in_si
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.relative import rms
from quickreturn.engines.start import standard_start

#: Further output steps, as multiples of the usual one: coarser, finer, and steps that no usual step of an engine divides.
_STEPS: Final = (4.0, 2.5, 0.5, 1.3)
#: Number of rows with the finer and the odd output steps.
_ROWS: Final = 120
#: Part of a column's range that may change with the output step if the engine gives no error.
_SAME: Final = 0.02
#: Allowed departure of a column from its own interpolation, as a multiple of the interpolation error.
_INTERPOLATED: Final = 2.0
#: Largest number of columns that are named.
_NAMED: Final = 3
_AT_ITS_INSTANT: Final = (
    "compute it from the state at the instant of the row, not from rows before and after: end a step of the solver there, or interpolate"
)


def output_steps(bench: Bench) -> tuple[dict[str, Check], dict[str, Check]]:
    """Columns that come late with a coarser output step, and columns that depend on it in another way."""
    late, depending = dict[str, Check](), dict[str, Check]()
    tolerances, run = bench.tolerances(bench.mild), bench.run(bench.mild)
    name = "the same with another output step"
    for times in _STEPS:
        step, ms = times * OUTPUT_STEP, in_si("ms")
        told = f"{step / ms:g} ms between rows in place of {OUTPUT_STEP / ms:g}"
        rows = int((len(run) - 1) // times) if times == _STEPS[0] else _ROWS
        motion = replace(bench.mild, duration=step * rows, output_step=step)
        try:
            there = bench.run(motion)
        except LeftOut as left_out:
            return late, depending or {"": Check(name, left_out.status, left_out.cause, left_out.advice)}
        except EngineFailure as failure:
            return late | {"time": Check(name, "failed", f"with {told}: {failure.cause}", failure.advice)}, depending
        changed = dict[str, float]()
        exact, right = solution(motion), solution(bench.mild)
        for column in compared_columns(run, right=right):
            if column in late or column in depending:
                continue
            fine, at = run[column], times * np.arange(len(there), dtype=np.float64)
            expected = CubicSpline(np.arange(len(fine)), fine)(at)
            off = rms(there[column] - expected)
            blurred = max(rms(exact[column] - CubicSpline(np.arange(len(fine)), right[column])(at)), _roughness(fine) if times % 1 else 0.0)
            if off <= allowed(column, fine, tolerances, 1e-4) + _INTERPOLATED * blurred:
                continue
            mistakes = lateness(there[column], there[column], np.array([at, np.full(len(at), times - 1.0)]), fine)
            if explained := explain(there[column], expected, mistakes, coarse=True):
                late[column] = Check(f"{name}: {column}", "failed", f"{column} {explained.words}", IN_TIME)
            else:
                changed[column] = off / max(_swing(fine), 1e-300)
        worst = sorted(changed, key=lambda column: -changed[column])
        first = ", ".join(f"{column} by {share_of(changed[column])}" for column in worst[:_NAMED])
        more = f", and {len(worst) - _NAMED} more columns" if len(worst) > _NAMED else ""
        depending |= dict.fromkeys(changed, Check(name, "failed", f"with {told} columns change: {first}{more}", _AT_ITS_INSTANT))
    return late, depending or {"": Check(name, "passed" if not late else "not judged")}


def allowed(column: str, values: Array, tolerances: Mapping[str, float] | None, part: float, times: float = 1.0) -> float:
    """Allowed difference of a column from another run's, in its unit: `times` its tolerance, or `part` of its range if that is more."""
    return _SAME * _swing(values) if tolerances is None else max(times * tolerances.get(column, 0.0), part * _swing(values))


def _roughness(values: Array) -> float:
    """Departure of every second row from a spline through the others: jumps cannot be interpolated."""
    rows = np.arange(len(values))
    return rms(values[1:-1:2] - CubicSpline(rows[::2], values[::2])(rows[1:-1:2]))


def _swing(values: Array) -> float:
    return rms(values - np.mean(values))


def pieces(bench: Bench, wrong: Iterable[str]) -> None:
    """Check that a simulation in pieces continues from its state."""
    rows, scene, run, tolerances = 60, bench.scene, bench.run(bench.mild), bench.tolerances(bench.mild)
    assert scene.crank is not None
    span = rows * OUTPUT_STEP
    simulation = bench.engine.prepare(scene, standard_start(scene), bench.settings(scene))
    try:
        parts = [simulation.advance(span, OUTPUT_STEP) for _ in range(3)]
    except Exception as error:  # an author's engine may raise anything
        cause = f"advancing a second time raises {type(error).__name__}: {error}"
        raise Fault(cause, "keep the state between calls of advance") from error
    keep = "keep the state in the simulation and begin each piece with the row that the one before ended with"
    for number, piece in enumerate(parts):
        begin, first = number * rows, piece["time"][0]
        if len(piece) != rows + 1:
            raise Fault(f"piece {number + 1} has {len(piece)} rows in place of {rows + 1}", keep)
        if abs(first - number * span) > 0.1 * OUTPUT_STEP:
            cause = f"the time of piece {number + 1} begins at {first:.4g} s, not where the one before ended"
            if abs(first) < 0.1 * OUTPUT_STEP:
                cause = "the time begins at zero again in each piece"
            raise Fault(cause, "count time in the simulation: `self.time` plus the grid")
        if number and abs(simulation.time - 3 * span) > 0.1 * OUTPUT_STEP:
            cause = f"`time` of the simulation is {simulation.time:.4g} s after {3 * rows} ms"
            raise Fault(cause, "add the duration to it in each advance")
        off = [
            column
            for column in compared_columns(run)
            if rms(piece[column] - run[column][begin : begin + len(piece)])
            > max(allowed(column, run[column], tolerances, 1e-3, 3.0), 1e-12)
            if column not in wrong
        ]
        if off and all(column in ("dissipated_energy", "drive_work") for column in off):
            raise Fault(f"{' and '.join(off)} begins anew in each piece", "sum from the start of the simulation")
        if off and abs(piece["crank_angle"][0] - run["crank_angle"][0]) < 1e-9:
            raise Fault("each piece begins in the start again", keep)
        if off:
            raise Fault(f"in pieces {some(off)} goes another way than in one go, from {begin} ms on", keep)
