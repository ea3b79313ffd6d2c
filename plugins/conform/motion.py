"""Checks of a trajectory: its columns, two identities, other output steps, pieces, the first row, a bent start in motion.

A wrong column is left out of later checks, so that each mistake is reported once.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.relative import rms, scale
from quickreturn.engines.start import standard_start
from quickreturn.plugins.conform.bench import (
    MEND_FIRST,
    Array,
    Bench,
    Check,
    Fault,
    Motion,
    Unjudged,
    bent_start,
    check_by,
    compared_columns,
    share_of,
    solution,
    some,
    truth,
)
from quickreturn.plugins.conform.columns import Examined, examined, wrong_in
from quickreturn.plugins.conform.scenes import OUTPUT_STEP, SOFT
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import changed

_BENT_DURATION: Final = 0.25  # s
#: Largest number of wrong columns that are reported one by one.
_ONE_BY_ONE: Final = 8
#: Further output steps, as multiples of the usual one: coarser, finer, and one that no usual step of an engine divides; and their rows.
_STEPS: Final = (2.5, 0.5, 1.3)
_ROWS: Final = 120
#: Part of a column's range that may change with the output step: without a claim, and with one.
_SAME: Final = (0.02, 1e-4)
#: Largest part of the right bow that counts as a straight line; part of the base's acceleration that differences of its rate may be off.
_STRAIGHT: Final = 0.3
_DIFFERENCES: Final = 0.05
#: Columns that a start determines.
_AT_THE_START: Final = ("crank_angle", "crank_speed", "follower_angle", "slider_position", "tip_x", "tip_y", "tip_deflection")
_KEEP: Final = "keep state and time in the simulation and begin each piece with the row that the one before ended with"
_AT_ITS_INSTANT: Final = "compute it from the state at the instant of the row: end a step of the solver there, or interpolate"


def motion(bench: Bench) -> Iterator[Check]:
    """All checks of a trajectory."""
    try:
        mild = examined(bench, bench.mild)
    except EngineFailure as failure:
        yield Check("a trajectory", "failed", f"none is delivered in a mild scene: {failure.cause}", failure.advice)
        return
    wrong = set(mild.wrong)
    yield from _columns(bench, mild)
    yield check_by("pieces continue", _pieces, bench, wrong)
    for times in _STEPS:
        yield check_by(f"the same with {times * OUTPUT_STEP * 1e3:g} ms between rows", _output_step, bench, times, wrong)
    yield check_by("identity: follower_acceleration from follower_rate", _acceleration_of_the_base, bench, wrong)
    yield check_by("first row of the standard start", check_first_row, bench, bench.mild, wrong)
    yield check_by("identity: bow and chord", _bow_and_chord, bench, wrong)
    yield check_by("a bent, moving start: first row", _bent_first_row, bench, wrong)
    yield check_by("a bent, moving start", look_at, bench, _bent(bench), frozenset(wrong))


def look_at(bench: Bench, motion: Motion, skipped: frozenset[str]) -> str:
    """Check the columns of a motion but for those that are `skipped`."""
    found, off = examined(bench, motion, skipped), bench.errors(motion)
    found.raise_fault(off)
    if not (judged := [part for name, part in off.items() if name not in skipped]):
        raise Unjudged("every column is wrong already", MEND_FIRST)
    return f"{len(judged)} columns, the worst off by {share_of(max(judged))}"


def _columns(bench: Bench, mild: Examined) -> Iterator[Check]:
    """A check of each wrong column of the mild scene, unless one explains them or they are many; and one of the others."""
    if mild.model or len(mild.wrong) > _ONE_BY_ONE:
        yield check_by("columns together", mild.raise_fault, bench.errors(bench.mild))
        return
    for name, words in mild.wrong.items():
        yield Check(f"column {name}", "failed", f"{name} {words}", "compare it with reference where it departs first")
    yield check_by("columns", look_at, bench, bench.mild, frozenset(mild.wrong))


def _output_step(bench: Bench, times: float, wrong: set[str]) -> None:
    """Check that another output step shows the same motion: the same errors, at other instants."""
    step = times * OUTPUT_STEP
    motion = replace(bench.mild, duration=step * _ROWS, output_step=step)
    there, exact, run, right = bench.run(motion), solution(motion), bench.run(bench.mild), solution(bench.mild)
    tolerances, at = bench.tolerances(bench.mild), times * np.arange(_ROWS + 1)
    part, changed_columns = _SAME[tolerances is not None], dict[str, float]()
    for name in compared_columns(run, right=right):
        error, swing = run[name] - right[name], _swing(name, right)
        off = rms(there[name] - exact[name] - CubicSpline(np.arange(len(error)), error)(at))
        if off > max((tolerances or {}).get(name, 0.0), part * swing) + 2.0 * _roughness(error) and name not in wrong:
            changed_columns[name] = off / swing
    if changed_columns:
        worst = sorted(changed_columns, key=lambda name: -changed_columns[name])
        wrong.update(worst)
        raise Fault(f"columns change: {some([f'{name} by {share_of(changed_columns[name])}' for name in worst])}", _AT_ITS_INSTANT)


def _roughness(values: Array) -> float:
    """Departure of every second row from a spline through the others: jumps cannot be interpolated, and shocks fall between rows."""
    rows = np.arange(len(values))
    return rms(values[1:-1:2] - CubicSpline(rows[::2], values[::2])(rows[1:-1:2]))


def _swing(name: str, columns: Mapping[str, Array]) -> float:
    """Range of a column in its unit; of a moment or force at an end, which may be tiny, that along the arm."""
    values = columns[name]
    return max(rms(values - np.mean(values)), scale(name, columns) - rms(values), 1e-300)


def _pieces(bench: Bench, wrong: set[str]) -> None:
    """Check that a simulation in three pieces continues from its state."""
    rows, scene, run, tolerances = 60, bench.scene, bench.run(bench.mild), bench.tolerances(bench.mild)
    simulation = bench.engine.prepare(scene, standard_start(scene), bench.settings(scene))
    for number in range(3):
        piece, begin = simulation.advance(rows * OUTPUT_STEP, OUTPUT_STEP), number * rows
        if len(piece) != rows + 1:
            raise Fault(f"piece {number + 1} has {len(piece)} rows in place of {rows + 1}", _KEEP)
        if abs(piece["time"][0] - begin * OUTPUT_STEP) > 0.1 * OUTPUT_STEP:
            raise Fault(f"the time of piece {number + 1} begins at {piece['time'][0]:.4g} s, not where the one before ended", _KEEP)
        off = [
            name
            for name in compared_columns(run)
            if rms(piece[name] - run[name][begin : begin + rows + 1])
            > max(3.0 * (tolerances or {}).get(name, 0.0), (1e-3 if tolerances else _SAME[0]) * _swing(name, run.columns), 1e-12)
            if name not in wrong
        ]
        if off:
            raise Fault(f"in pieces {some(off)} goes another way than in one go, from {begin} ms on", _KEEP)
    if abs(simulation.time - 3 * rows * OUTPUT_STEP) > 0.1 * OUTPUT_STEP:
        raise Fault(f"`time` of the simulation is {simulation.time:.4g} s after {3 * rows} ms", _KEEP)


def check_first_row(bench: Bench, motion: Motion, wrong: set[str], part: float = 1e-6) -> None:
    """Check the first row: crank, follower and slider at the start, to `part` of the follower's length or of a radian, or as claimed."""
    run, right, allowed = bench.run(motion), solution(motion), bench.tolerances(motion) or {}
    for name in _AT_THE_START:
        first, due = float(run[name][0]), float(right[name][0])
        if name not in wrong and abs(first - due) > max(part * (abs(due) if name == "crank_speed" else 1.0), allowed.get(name, 0.0)):
            cause = f"{name} is {first:.6g} in the first row, the start puts it at {due:.6g}"
            raise Fault(cause, "deliver the state of the start as the first row, before any step; see engines.start_state.reconstruct")


def _bent(bench: Bench) -> Motion:
    """The motion from a bent start."""
    soft = changed(bench.scene, SOFT)
    return Motion(soft, _BENT_DURATION, start=bent_start(soft))


def _bent_first_row(bench: Bench, wrong: set[str]) -> None:
    """Check the first row of a bent start, which a model reproduces to about its own error of the deflection."""
    motion = _bent(bench)
    deflection, tolerances = rms(truth(motion).columns["tip_deflection"]), bench.tolerances(motion)
    part = 0.5 * deflection if tolerances is None else tolerances["tip_deflection"] + 0.02 * deflection
    check_first_row(bench, motion, wrong, part)


def _bow_and_chord(bench: Bench, wrong: set[str]) -> None:
    """Check that the arc length to the slider exceeds its straight distance from the pivot."""
    if {"slider_position", "crank_angle"} & wrong:
        raise Unjudged("slider_position or crank_angle is wrong already", MEND_FIRST)
    motion = _bent(bench)
    if rms(_bow(bench.run(motion).columns, bench.scene)) < _STRAIGHT * rms(_bow(truth(motion).columns, bench.scene)):
        wrong.add("slider_position")
        cause = "slider_position is the straight distance from the pivot, not the arc length"
        raise Fault(cause, "integrate along the bent centre line")


def _bow(columns: Mapping[str, Array], scene: Mechanism) -> Array:
    """By how much the arc length to the slider exceeds its straight distance from the pivot, m."""
    crank, angle = scene.crank.length, columns["crank_angle"]
    return columns["slider_position"] - np.hypot(crank * np.cos(angle) - scene.pivot_distance, crank * np.sin(angle))


def _acceleration_of_the_base(bench: Bench, wrong: set[str]) -> str:
    """Check that the base's acceleration is the derivative of its rate."""
    run, inner = bench.run(bench.mild), slice(3, -3)  # differences are one-sided at the ends
    if not {"follower_rate", "follower_acceleration"} <= run.columns.keys():
        return "the engine does not deliver them"
    if "follower_rate" in wrong:
        raise Unjudged("follower_rate is wrong already", MEND_FIRST)
    derivative = np.gradient(run["follower_rate"], OUTPUT_STEP)[inner]
    right = {"time": run["time"][inner], "follower_acceleration": derivative}
    found = run["follower_acceleration"][inner]
    words, _ = wrong_in("follower_acceleration", found, right, _DIFFERENCES * rms(derivative) + 2.0 * _roughness(found))
    if words:
        raise Fault(f"follower_acceleration {words}", "it is the derivative of follower_rate")
    return ""
