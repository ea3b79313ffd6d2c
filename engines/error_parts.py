"""Parts of an error, from differences of runs whose errors stand in a known ratio (`engines.base.Comparison`)."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.base import Comparison, EngineFailure
from quickreturn.engines.relative import rms, scale
from quickreturn.engines.settings import Settings
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.columns import BEARINGS, BENDING

R = TypeVar("R")
Q = TypeVar("Q")

#: Columns with an error estimate of their own.
ESTIMATED: Final = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")
#: Loads on parts and drive, which also have an error estimate where the engine gives them.
LOADS: Final = (*BENDING, *BEARINGS, "crank_torque", "base_torque")

#: Smallest factor that successive differences are credited with: the estimate is at most 1.4 times the difference from the coarser run.
#: Two runs with equal but unrelated errors differ by more than either error; in 17 scenes the errors of unresolved motions were at most
#: 1.07 times the difference.
LEAST_FACTOR: Final = 1.7
#: Largest assumed error of a finer run over that of the run, however slowly the differences fall: the error is at most four times the
#: larger difference.
LARGEST_REST: Final = 0.75
#: RMS of the tip deflection over the follower's length below which the follower counts as rigid.
NO_DEFLECTION: Final = 1e-12


@dataclass(frozen=True)
class Compared(Generic[R]):
    """Results of the runs of a `Comparison`: trajectories, or what is computed from them."""

    run: R  # the run in question, or one with the same error in this part
    other: R  # the one that `run` is compared with
    factor: float  # error of `other` over that of `run`, not 1
    # the run that `other` is compared with in turn, and the error of that over the one of `other`; None where there is none
    before: tuple[R, float] | None = None
    # why the run that would have checked `factor` is missing, a clause; `factor` is then the least favourable one. "" if none is missing
    unchecked: str = ""

    def part(self, difference: Callable[[R, R], float]) -> float:
        """The part of the error that the runs show; `difference` gives the size of the difference of two results."""
        shown = difference(self.run, self.other)
        if self.before is None:
            return shown / abs(self.factor - 1.0)
        further = difference(self.other, self.before[0])
        factor = shown_factor(self.factor, self.before[1], shown, further)
        return (shown if factor > 1.0 else max(shown, further)) / abs(factor - 1.0)

    def mapped(self, compute: Callable[[R], Q]) -> "Compared[Q]":
        """The comparison of what `compute` makes of each result."""
        before = None if self.before is None else (compute(self.before[0]), self.before[1])
        return Compared(compute(self.run), compute(self.other), self.factor, before, self.unchecked)


def compared(pair: Comparison, run: Callable[[Settings], R]) -> Compared[R]:
    """The results of a comparison's runs; `run` makes one from settings. If one breaks down, those of the comparison's `instead`.

    Without the run that checks the factor nothing shows how fast the error falls, and the least favourable factor counts.

    Raises:
        EngineFailure: a run broke down, and there is no `instead`.
    """
    try:
        first, second = run(pair.run), run(pair.other)
    except EngineFailure:
        if pair.instead is None:
            raise
        return compared(pair.instead, run)
    if pair.before is None:
        return Compared(first, second, pair.factor)
    try:
        return Compared(first, second, pair.factor, (run(pair.before.other), pair.before.factor))
    except EngineFailure as failure:
        return Compared(first, second, least_favourable(pair.factor), unchecked=str(failure))


class EstimatedPart(NamedTuple):
    """A part of the error of a trajectory."""

    tip: float  # relative, see `Assessment.error_estimate`
    columns: dict[str, float | None]  # of `ESTIMATED` and the existing ones of `LOADS`: RMS error over `scale`; None where that is 0
    largest: dict[str, float]  # of the same: largest error at any instant, in the column's unit


def estimated_part(delivered: Trajectory, runs: Compared[Trajectory], length: float) -> EstimatedPart:
    """A part of the error of `delivered`, from two or three runs on the same output grid (see `Comparison`).

    Args:
        delivered: the run; differences are relative to the scale of its columns.
        runs: the runs that show the part.
        length: follower length, m.
    """

    def part(name: str) -> float:
        return runs.part(lambda a, b: rms(a[name] - b[name]))

    names: list[str] = [name for name in (*ESTIMATED, *LOADS) if name in delivered.columns]
    parts = {name: relative_size(part(name), scale(name, delivered.columns)) for name in names}
    largest = {name: runs.part(partial(_largest_difference, name)) for name in names}
    tip = parts["tip_deflection"]
    if tip is None or rms(delivered["tip_deflection"]) < NO_DEFLECTION * length:
        tip = runs.part(lambda a, b: rms(np.hypot(a["tip_x"] - b["tip_x"], a["tip_y"] - b["tip_y"]))) / length
    return EstimatedPart(tip, parts, largest)


def _largest_difference(name: str, run: Trajectory, other: Trajectory) -> float:
    return float(np.max(np.abs(run[name] - other[name])))


def least_favourable(factor: float) -> float:
    """The factor nearest to 1 that differences may support in place of `factor`, which gives the largest estimate."""
    return max(factor, LARGEST_REST) if factor < 1.0 else min(factor, LEAST_FACTOR)


def shown_factor(factor: float, factor_before: float, difference: float, difference_before: float) -> float:
    """The factor that two successive differences support: from `factor` to `least_favourable(factor)`.

    Runs whose errors are e, f e and f' f e, with f = `factor` and f' = `factor_before`, differ by (f - 1) e and (f' - 1) f e. The less
    the second difference exceeds the first, the less the error falls from run to run. It does not fall where a fast motion is not
    resolved at all, as under a sudden load or where the slider shakes the cable.
    """
    expected = factor * (factor_before - 1.0) / (factor - 1.0)
    shown = math.inf if difference == 0.0 else factor * difference_before / (difference * expected)
    least = least_favourable(factor)
    return min(max(factor, shown), least) if factor < 1.0 else max(min(factor, shown), least)


def same_motion(run: Mapping[str, NDArray[np.float64]], other: Mapping[str, NDArray[np.float64]]) -> bool:
    """Whether two runs agree to the last bit, so that their difference says nothing of their error; False if nothing bends."""
    deflection = run["tip_deflection"]
    return bool(np.any(deflection) and np.array_equal(deflection, other["tip_deflection"]))


def relative_size(difference: float, size: float) -> float | None:
    """The difference over the size; None if the size is zero or the ratio overflows."""
    return difference / size if size != 0.0 and math.isfinite(difference / size) else None
