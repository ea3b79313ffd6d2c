"""Columns of a motion against `reference`: which are wrong, and which single relation or quantity of the scene explains it."""

import contextlib
import functools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.trajectory import REQUIRED, rms, scale
from quickreturn.plugins.conform.bench import (
    DECISIVE,
    Array,
    Bench,
    Fault,
    Motion,
    Unjudged,
    compared_columns,
    solution,
    some,
)
from quickreturn.reference_model.errors import ImpossibleMechanism
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
