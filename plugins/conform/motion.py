"""Checks of a trajectory: its columns, two identities, another output step, pieces, the first row, a bent start in motion.

A wrong column is left out of later checks, so that each mistake is reported once.
"""

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import join, rms, scale
from quickreturn.plugins.conform.bench import (
    Array,
    Bench,
    Check,
    Fault,
    Motion,
    Unjudged,
    bent_start,
    check_by,
    compared_columns,
    ended,
    solution,
    some,
)
from quickreturn.plugins.conform.columns import examined, look_at
from quickreturn.plugins.conform.scenes import OUTPUT_STEP, SOFT
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import changed

_BENT_DURATION: Final = 0.25  # s
#: Another output step, s, which no usual step of an engine divides; and its duration, s.
_ODD_STEP: Final = 1.3 * OUTPUT_STEP
_ODD_DURATION: Final = 120 * _ODD_STEP
#: Part of a column's size that may change from piece to piece: without a claim, and with one.
_SAME: Final = (0.02, 1e-3)
#: Largest part of the right bow that counts as a straight line; part of the base's acceleration that differences of its rate may be off.
_STRAIGHT: Final = 0.3
_DIFFERENCES: Final = 0.05
#: Columns that a start determines.
_AT_THE_START: Final = ("crank_angle", "crank_speed", "follower_angle", "slider_position", "tip_x", "tip_y", "tip_deflection")


def motion(bench: Bench) -> Iterator[Check]:
    """All checks of a trajectory."""
    try:
        mild = examined(bench, bench.mild)
    except EngineFailure as failure:
        yield ended("a trajectory", failure)
        return
    wrong = frozenset(mild.wrong)
    if mild.motion:
        yield check_by("columns together", mild.raise_fault)
    else:
        for name, words in mild.wrong.items():
            yield Check(f"column {name}", "failed", f"{name} {words}")
        yield check_by("columns", look_at, bench, bench.mild, wrong)
    yield check_by("pieces continue", _pieces, bench, wrong)
    odd = Motion(bench.scene, _ODD_DURATION, _ODD_STEP)
    yield check_by("the same with 1.3 ms between rows", look_at, bench, odd, wrong)
    yield check_by("first row of the standard start", check_first_row, bench, bench.mild, wrong)
    yield check_by("identity: follower_acceleration from follower_rate", _acceleration_of_the_base, bench, wrong)
    soft = changed(bench.scene, SOFT)
    bent = Motion(soft, _BENT_DURATION, start=bent_start(soft))
    yield check_by("identity: bow and chord", _bow_and_chord, bench, bent, wrong)
    yield check_by("a bent, moving start", look_at, bench, bent, wrong)


def _pieces(bench: Bench, wrong: frozenset[str]) -> None:
    """Check that a simulation in three pieces continues from its state."""
    rows, scene, run, claims = 60, bench.scene, bench.run(bench.mild), bench.tolerances(bench.mild)
    simulation = bench.engine.prepare(scene, standard_start(scene), bench.settings(scene))
    part = _SAME[claims is not None]
    pieces = join([simulation.advance(rows * OUTPUT_STEP, OUTPUT_STEP) for _ in range(3)])
    times = OUTPUT_STEP * np.arange(3 * rows + 1)
    if (
        len(pieces) != len(times)
        or np.abs(np.append(pieces["time"], simulation.time) - np.append(times, times[-1])).max() > 0.1 * OUTPUT_STEP
    ):
        raise Fault(f"three pieces of {rows} ms have {len(pieces)} rows that end at {pieces['time'][-1]:.4g} s")
    allowed = {name: 3.0 * (claims or {}).get(name, 0.0) + part * scale(name, run.columns) for name in compared_columns(run)}
    off = [name for name in allowed if name not in wrong and rms(pieces[name] - run[name][: len(times)]) > allowed[name]]
    if off:
        raise Fault(f"in three pieces {some(off)} goes another way than in one go")


def check_first_row(bench: Bench, motion: Motion, wrong: frozenset[str]) -> None:
    """Check the first row: crank, follower and slider at the start, to a millionth of a metre or radian, or as claimed."""
    run, right, allowed = bench.run(motion), solution(motion), bench.tolerances(motion) or {}
    for name in _AT_THE_START:
        first, due = float(run[name][0]), float(right[name][0])
        if name not in wrong and abs(first - due) > max(1e-6 * max(abs(due), 1.0), allowed.get(name, 0.0)):
            raise Fault(f"{name} is {first:.6g} in the first row, the start puts it at {due:.6g}")


def _bow_and_chord(bench: Bench, bent: Motion, wrong: frozenset[str]) -> None:
    """Check that the arc length to the slider exceeds its straight distance from the pivot."""
    if {"slider_position", "crank_angle"} & wrong:
        raise Unjudged("slider_position or crank_angle is wrong already")
    if rms(_bow(bench.run(bent).columns, bench.scene)) < _STRAIGHT * rms(_bow(solution(bent), bench.scene)):
        raise Fault("slider_position is the straight distance from the pivot, not the arc length")


def _bow(columns: Mapping[str, Array], scene: Mechanism) -> Array:
    """By how much the arc length to the slider exceeds its straight distance from the pivot, m."""
    crank, angle = scene.crank.length, columns["crank_angle"]
    return columns["slider_position"] - np.hypot(crank * np.cos(angle) - scene.pivot_distance, crank * np.sin(angle))


def _acceleration_of_the_base(bench: Bench, wrong: frozenset[str]) -> None:
    """Check that the base's acceleration is the derivative of its rate."""
    run, inner = bench.run(bench.mild), slice(3, -3)  # differences are one-sided at the ends
    if not {"follower_rate", "follower_acceleration"} <= run.columns.keys() - wrong:
        return
    derivative, found = np.gradient(run["follower_rate"], OUTPUT_STEP)[inner], run["follower_acceleration"][inner]
    if (off := rms(found - derivative)) > _DIFFERENCES * rms(derivative) + 2.0 * _roughness(found):
        raise Fault(f"follower_acceleration differs by {100.0 * off / rms(derivative):.3g} % from the derivative of follower_rate")


def _roughness(values: Array) -> float:
    """Departure of every second row from a spline through the others: shocks fall between rows."""
    rows = np.arange(len(values))
    return rms(values[1:-1:2] - CubicSpline(rows[::2], values[::2])(rows[1:-1:2]))
