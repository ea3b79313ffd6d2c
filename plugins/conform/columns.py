"""Columns of a motion against `reference`: which are wrong, and which single relation or quantity of the scene explains it."""

import contextlib
import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.relative import rms, scale
from quickreturn.engines.trajectory import REQUIRED
from quickreturn.plugins.conform.bench import DECISIVE, Array, Bench, Fault, Motion, compared_columns, share_of, solution, some, truth
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.scene_values import changed, value_at

#: Largest part of a difference that what explains it may leave; that for an engine whose own error is unknown.
UNEXPLAINED: Final = 0.15
COARSELY: Final = 0.4
#: Of a column without a claim: part of its size from which a difference is examined, and from which it is wrong whatever the reason (one
#: cubic is 43 % off in a strain); factors that no model is too coarse for; and the part of its size below which it lacks its numbers.
_GROSS: Final = 0.2
_HOPELESS: Final = 1.2
_POSSIBLE: Final = (0.2, 5.0)
_LIFELESS: Final = 0.05
#: Largest lateness that is tried, in rows.
_LATEST: Final = 3
#: A difference of which a finer rung leaves at most this part comes from the resolution; and the number of rungs above the default that are
#: tried, because on a ladder of small steps one rung changes little.
_FALLS: Final = 0.7
_SHARPENED: Final = 3
#: Largest number of columns that may be wrong for reasons of their own: if more are, the motion is wrong.
_OF_ITS_OWN: Final = 2

#: Factor by which a quantity is changed to see its effect; that of base and tip is small.
_TRIED: Final = 1.02
_TRIED_OF_SMALL: Final = 2.0
#: Factors from which the search for a quantity begins. The others are tried if the first leads to nothing and a column is off by more
#: than the part `_SMALL` of itself, because only small mistakes have a proportional effect.
_BEGIN: Final = (1.0, 1.3, 0.75)
_SMALL: Final = 0.1
#: Number of steps of the search; largest part of the difference that a step may leave for the next one, and the part at which it ends.
_ROUNDS: Final = 6
_PROMISING: Final = 0.9
_EXPLAINED: Final = 0.02
_SCALED: Final = (
    "follower.bending_stiffness", "follower.mass_per_length", "follower.length", "mechanism.pivot_distance", "crank.length", "crank.mass",
    "crank.inertia", "crank.center_of_mass", "crank.torque", "crank.damping", "crank.initial_speed", "tip.mass", "tip.inertia",
    "base.inertia", "base.spin_up_speed", "base.spin_up_time",
)  # fmt: skip


@dataclass(frozen=True)
class Relation:
    """How a column follows from the right one."""

    words: str
    left: float  # RMS of the difference that it leaves, in the column's unit
    gross: bool  # whether no model is so coarse


@dataclass(frozen=True)
class Model:
    """A quantity of the scene that explains a wrong motion."""

    words: str
    scaled: tuple[str, float]  # key, and the factor by which it is wrong

    def of(self, scene: Scene) -> Scene:
        """The scene that the engine computes in place of this one. ImpossibleMechanism: there is none."""
        key, factor = self.scaled
        return changed(scene, {key: factor * value_at(scene, key)})


@dataclass(frozen=True)
class Examined:
    """Wrong columns of a motion, with what is wrong in words; and the quantity that explains them together."""

    wrong: Mapping[str, str]
    rows: frozenset[str]  # columns that are wrong for reasons of their own
    model: Model | None = None

    @property
    def motion(self) -> bool:
        """Whether the motion itself is wrong, not only the rows of some columns."""
        return len(self.rows) < len(self.wrong)

    def raise_fault(self, off: Mapping[str, float]) -> None:
        """Raise a Fault if a column is wrong. `off`: relative errors of the columns."""
        if not self.wrong:
            return
        if self.model:
            raise Fault(self.model.words, f"look where {self.model.scaled[0]} enters")
        worst = sorted(self.wrong, key=lambda name: -off[name])
        raise Fault(some([f"{name} {self.wrong[name]}" for name in worst]), "compare it with reference where it departs first")


def relation(name: str, found: Array, right: Mapping[str, Array]) -> Relation:
    """The relation between a column and the right ones that leaves least: a factor, a shift, a lateness, or another column's values."""
    own, rows = right[name], np.arange(len(found), dtype=np.float64)
    factor = float(found @ own / (own @ own))
    shift, step = float(np.mean(found - own)), float(right["time"][1] - right["time"][0])
    spline = CubicSpline(rows, own)

    def late(lag: float) -> Array:
        return np.asarray(spline(np.clip(rows - lag, 0.0, rows[-1])))

    def left(lag: float) -> float:
        return rms((found - late(lag))[_LATEST:-_LATEST])

    nearest = min(np.linspace(-_LATEST, _LATEST, 8 * _LATEST + 1), key=left)
    lag = float(minimize_scalar(left, bounds=(nearest - 0.25, nearest + 0.25), method="bounded").x)
    others = [other for other in REQUIRED if other not in ("time", name) and other in right]
    tried = [
        Relation(f"is {factor:.4g} times the right one", rms(found - factor * own), not _POSSIBLE[0] < factor < _POSSIBLE[1]),
        Relation(f"is the right one plus {shift:.4g}", rms(found - own - shift), True),
        Relation(f"comes {1e3 * abs(lag) * step:.3g} ms {'late' if lag > 0.0 else 'early'}", left(lag), False),
        *(Relation(f"holds {other}", rms(found - right[other]), False) for other in others),
    ]
    return min(tried, key=lambda each: each.left)


def wrong_in(name: str, found: Array, right: Mapping[str, Array], tolerance: float | None) -> tuple[str, bool]:
    """What is wrong in a column, "" if nothing is; and whether a relation explains it.

    Args:
        name: of the column.
        found: its values, shape (n,).
        right: right values of the columns.
        tolerance: allowed RMS error, in the column's unit; None: the engine does not say.
    """
    off, size = rms(found - right[name]), scale(name, right)
    beyond = tolerance is not None and off > tolerance
    if off == 0.0 or (not beyond and off <= _GROSS * size):
        return "", False
    shown = relation(name, found, right)
    if beyond:
        explained = shown.left <= max(UNEXPLAINED * off, min(tolerance or 0.0, 0.5 * off))
        return (shown.words if explained else f"is off by {share_of(off / size)}"), explained
    # at one of many places along the follower a coarse model may be off by any factor
    if shown.gross and shown.left <= UNEXPLAINED * off and (name in REQUIRED or not name[-1].isdigit()):
        return shown.words, True
    lifeless = rms(found) < _LIFELESS * size
    hopeless = tolerance is None and name in REQUIRED and (off > _HOPELESS * size or lifeless)
    return (f"is off by {share_of(off / size)}" if hopeless else ""), False


@functools.lru_cache(maxsize=8)
def examined(bench: Bench, motion: Motion, skipped: frozenset[str] = frozenset()) -> Examined:
    """The wrong columns of a motion, but for those that are `skipped`. EngineFailure, Refusal: there is no motion."""
    run, right, tolerances = bench.run(motion), truth(motion).columns, bench.tolerances(motion)
    found = {
        name: wrong_in(name, run[name], right, None if tolerances is None else tolerances[name])
        for name in compared_columns(run, right=right)
        if name not in skipped
    }
    wrong = {name: words for name, (words, _) in found.items() if words}
    if tolerances is not None and wrong:
        fallen = falling(bench, motion, tuple(wrong))
        wrong = {name: words for name, words in wrong.items() if name not in fallen}
    puzzling = [name for name in wrong if not found[name][1]]
    if len(puzzling) <= _OF_ITS_OWN:
        return Examined(wrong, frozenset(wrong))
    explained = frozenset(wrong) - {*puzzling}
    moves = {name: run[name] for name in compared_columns(run, DECISIVE, right)}
    model = acts_as_if(motion, moves, tolerances) if motion.start is None else None
    return Examined(wrong, frozenset() if model else explained, model)


def falling(bench: Bench, motion: Motion, names: tuple[str, ...]) -> set[str]:
    """Columns whose error falls with finer settings: their mistake is an estimate that is too small, which another check reports."""
    run, right, fallen = bench.run(motion), truth(motion).columns, set[str]()
    settings = bench.settings(motion.scene)
    with contextlib.suppress(EngineFailure):
        for _ in range(_SHARPENED):
            above = bench.finer(motion.scene, settings)
            if above is None or fallen == {*names}:
                break
            settings, finer = above, bench.run(motion, above)
            fallen |= {name for name in names if rms(finer[name] - right[name]) <= _FALLS * rms(run[name] - right[name])}
    return fallen


def acts_as_if(motion: Motion, moves: Mapping[str, Array], tolerances: Mapping[str, float] | None) -> Model | None:
    """The single wrong quantity that explains the motion from the standard start, if there is one.

    Args:
        motion: the motion asked for.
        moves: columns of the engine.
        tolerances: tolerances of the columns; None: the engine does not say.
    """
    right, scene = solution(motion), motion.scene
    part, allowed = (0.01, dict[str, float]()) if tolerances is None else (1e-4, tolerances)
    sizes = {name: rms(right[name]) for name in moves}

    def stacked(columns: Mapping[str, Array]) -> Array:
        weighted = [(columns[name] - right[name]) / (part * size + allowed.get(name, 0.0)) for name, size in sizes.items()]
        return np.concatenate(weighted)

    def effect(model: Model) -> Array:
        return stacked(solution(replace(motion, scene=model.of(scene))))

    shown = stacked(moves)
    if rms(shown) <= 1.0:  # these columns are as good as they may be
        return None
    small = all(rms(moves[name] - right[name]) <= _SMALL * size for name, size in sizes.items())
    for begin in _BEGIN[:1] if small else _BEGIN:
        found = {path: _search(path, shown, effect, begin) for path in _SCALED if _may_be_scaled(value_at(scene, path))}
        left = {path: max(left, 1.0) for path, (_, left) in found.items()}
        best = min(left, key=lambda path: left[path])
        if left[best] <= max(UNEXPLAINED * rms(shown), 1.0):
            alike = sorted((path for path in left if left[path] <= 2.0 * left[best]), key=lambda path: left[path])
            words = ", or ".join(f"{path} {found[path][0]:.4g} times as large" for path in alike)
            return Model(f"the motion is that with {words}", (best, found[best][0]))
    return None


def _may_be_scaled(value: Any) -> bool:
    return isinstance(value, float) and math.isfinite(value) and value != 0.0


def _search(path: str, shown: Array, effect: Callable[[Model], Array], begin: float) -> tuple[float, float]:
    """The factor of a quantity that explains most, by secants from `begin`, and the RMS that it leaves; infinite if there is none."""

    def times(factor: float) -> Array:
        return effect(Model("", (path, factor)))

    with contextlib.suppress(EngineFailure, ImpossibleMechanism):
        tried = begin * (_TRIED_OF_SMALL if path in ("base.inertia", "tip.inertia") else _TRIED)
        factor, there = begin, times(begin)
        slope, left = (times(tried) - there) / (tried - begin), shown - there
        for _ in range(_ROUNDS):
            step = float(left @ slope / (slope @ slope or math.inf))
            if step == 0.0 or rms(left - step * slope) > _PROMISING * rms(left):
                break
            before, factor = there, factor + step
            there = times(factor)
            left = shown - there
            if rms(left) <= _EXPLAINED * rms(shown):
                break
            slope = (there - before) / step
        if factor > 0.0:
            return factor, rms(left)
    return 1.0, math.inf
