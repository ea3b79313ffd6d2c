"""Columns of a motion, and of one against `reference`: which are wrong, and which relation or quantity of the scene explains it.

Checks of one trajectory: its columns, two identities, another output step, pieces, the first row, a bent start in motion. A wrong column
is left out of later checks, so that each mistake is reported once.
"""

import contextlib
import functools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import REQUIRED, join, rms, scale
from quickreturn.plugins.conform.bench import (
    DECISIVE,
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
from quickreturn.plugins.conform.scenes import OUTPUT_STEP, SOFT
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import changed, value_at

#: Largest part of a difference that what explains it may leave.
UNEXPLAINED: Final = 0.15
#: Of a column without a claim: part of its size by which it may be shifted, and by which it may be off (one cubic is 43 % off in a strain).
_SHIFTED: Final = 0.2
_GROSS: Final = 0.9
#: Largest lateness that is tried, in rows.
_LATEST: Final = 3
#: A difference of which a finer rung leaves at most this part comes from the resolution; and the number of rungs above the default that are
#: tried, because on a ladder of small steps one rung changes little.
_FALLS: Final = 0.7
_SHARPENED: Final = 3
#: Largest number of columns that may be wrong for reasons of their own: if more are, the motion is wrong.
_OF_ITS_OWN: Final = 2
#: Quantities that may explain a wrong motion; logarithm of the factor that shows their effects; number of those whose factor is sought.
_SCALED: Final = (
    "follower.bending_stiffness", "follower.mass_per_length", "follower.length", "mechanism.pivot_distance", "crank.length", "crank.mass",
    "crank.inertia", "crank.center_of_mass", "crank.torque", "crank.damping", "crank.initial_speed", "tip.mass", "tip.inertia",
    "base.inertia", "base.spin_up_speed", "base.spin_up_time",
)  # fmt: skip
_TRIED: Final = 0.1
_PROMISING: Final = 3
#: Number of steps of the search; their largest size in the logarithm, and the one at which it ends.
_ROUNDS: Final = 6
_LARGEST: Final = 1.5
_SETTLED: Final = 2e-3


@dataclass(frozen=True)
class Examined:
    """Columns of a motion against `reference`."""

    errors: Mapping[str, float]  # of each column, relative
    wrong: Mapping[str, str]  # column -> what is wrong
    motion: bool = False  # whether the motion itself is wrong, not only the rows of some columns
    model: str = ""  # the quantity of the scene that explains it

    def raise_fault(self) -> None:
        """Raise a Fault if a column is wrong."""
        worst = sorted(self.wrong, key=lambda name: -self.errors[name])
        if worst:
            raise Fault(self.model or some([f"{name} {self.wrong[name]}" for name in worst]))


def look_at(bench: Bench, motion: Motion, skipped: frozenset[str] = frozenset()) -> None:
    """Check the columns of a motion but for those that are `skipped`."""
    found = examined(bench, motion, skipped)
    found.raise_fault()
    if not found.errors:
        raise Unjudged("every column is wrong already")


def relation(name: str, found: Array, right: Mapping[str, Array]) -> tuple[str, float]:
    """The relation between a column and the right ones that leaves least, and what it leaves: RMS, in the column's unit.

    It is a factor, a shift, a lateness, or another column's values.
    """
    own, rows = right[name], np.arange(len(found), dtype=np.float64)
    factor, shift = float(found @ own / (own @ own)), float(np.mean(found - own))
    spline, step = CubicSpline(rows, own), float(right["time"][1] - right["time"][0])

    def left(lag: float) -> float:
        return rms((found - spline(np.clip(rows - lag, 0.0, rows[-1])))[_LATEST:-_LATEST])

    lag = float(minimize_scalar(left, bounds=(-_LATEST, _LATEST), method="bounded").x)
    others = [other for other in REQUIRED if other not in ("time", name) and other in right]
    tried = {
        f"is {factor:.4g} times the right one": rms(found - factor * own),
        f"is the right one plus {shift:.4g}": rms(found - own - shift),
        f"comes {1e3 * abs(lag) * step:.3g} ms {'late' if lag > 0.0 else 'early'}": left(lag),
        **{f"holds {other}": rms(found - right[other]) for other in others},
    }
    return min(tried.items(), key=lambda each: each[1])


@functools.lru_cache(maxsize=8)
def examined(bench: Bench, motion: Motion, skipped: frozenset[str] = frozenset()) -> Examined:
    """The columns of a motion, but for those that are `skipped`. EngineFailure, Refusal: there is no motion."""
    run, right = bench.run(motion), solution(motion)
    names = [name for name in compared_columns(run, right=right) if name not in skipped]
    errors = {name: rms(run[name] - right[name]) / scale(name, right) for name in names}
    beyond = beyond_claims(bench, [motion], names)
    # at one of many places along the follower a coarse model may be off by any factor
    suspect = [name for name in names if errors[name] > _SHIFTED and (name in REQUIRED or not name[-1].isdigit())]
    wrong, puzzling = dict[str, str](), 0
    for name in suspect if beyond is None else beyond:
        words, left = relation(name, run[name], right)
        explained = left <= UNEXPLAINED * errors[name] * scale(name, right)
        if beyond is not None or errors[name] > _GROSS or (explained and "plus" in words):
            wrong[name] = words if explained else f"is off by {100.0 * errors[name]:.3g} % of its size"
            puzzling += not explained
    if puzzling <= _OF_ITS_OWN:
        return Examined(errors, wrong)
    return Examined(errors, wrong, motion=True, model="" if motion.start else acts_as_if(bench, motion))


def beyond_claims(bench: Bench, motions: Sequence[Motion], names: Iterable[str]) -> list[str] | None:
    """Columns whose errors exceed the engine's claim; of two motions, the errors of their difference. None: the engine claims nothing.

    A column whose error falls with finer settings is not one of them: there the claim is wrong, which another check reports.
    """
    claims = [bench.tolerances(motion) for motion in motions]
    scene = motions[-1].scene
    settings = bench.settings(scene)

    def error(name: str, finer: bool = True) -> float:
        return rms(
            functools.reduce(np.subtract, [bench.run(each, settings if finer else None)[name] - solution(each)[name] for each in motions])
        )

    if any(claim is None for claim in claims):
        return None
    off = {name: error(name, finer=False) for name in names}
    beyond = [name for name in off if off[name] > sum((claim or {}).get(name, 0.0) for claim in claims)]
    with contextlib.suppress(EngineFailure):
        for _ in range(_SHARPENED):
            above = bench.finer(scene, settings) if beyond else None
            if above is None:
                break
            settings = above
            beyond = [name for name in beyond if error(name) > _FALLS * off[name]]
    return beyond


def acts_as_if(bench: Bench, motion: Motion) -> str:
    """The single wrong quantity that explains the motion from the standard start, in words; "" if there is none."""
    run, right, claims = bench.run(motion), solution(motion), bench.tolerances(motion) or {}
    best = dict[str, tuple[float, float]]()
    units = {name: 1e-4 * rms(right[name]) + claims.get(name, 0.01 * rms(right[name])) for name in compared_columns(run, DECISIVE, right)}

    def effect(columns: Mapping[str, Array]) -> Array:
        return np.concatenate([(columns[name] - right[name]) / unit for name, unit in units.items()])

    shown, scene = effect(run.columns), motion.scene
    limit, values = max(UNEXPLAINED * rms(shown), 1.0), {path: value_at(scene, path) for path in _SCALED}

    def of(logarithm: float, path: str) -> Array:
        try:
            return effect(solution(replace(motion, scene=changed(scene, {path: math.exp(logarithm) * values[path]}))))
        except (EngineFailure, ImpossibleMechanism):
            return 1e3 * shown

    slopes = {path: of(_TRIED, path) / _TRIED for path, value in values.items() if isinstance(value, float) and 0.0 < abs(value) < math.inf}
    steps = {path: float(shown @ slope / (slope @ slope or math.inf)) for path, slope in slopes.items()}
    for path in sorted(slopes, key=lambda path: rms(shown - steps[path] * slopes[path]))[:_PROMISING]:
        logarithm, slope, there = 0.0, slopes[path], 0.0 * shown
        for _ in range(_ROUNDS):  # secants
            step = float((shown - there) @ slope / (slope @ slope or math.inf))
            step = min(max(step, -_LARGEST), _LARGEST)
            before, logarithm, there = there, logarithm + step, of(logarithm + step, path)
            if abs(step) < _SETTLED:
                break
            slope = (there - before) / step
        best[path] = rms(shown - there), math.exp(logarithm)
    least = min(best.values())[0]
    if rms(shown) <= 1.0 or least > limit:
        return ""
    alike = sorted((path for path in best if best[path][0] <= max(2.0 * least, 1.0)), key=lambda path: best[path])
    return f"the motion is that with {', or '.join(f'{path} {best[path][1]:.4g} times as large' for path in alike)}"


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
