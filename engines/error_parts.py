"""Parts of an error, from differences of runs whose errors stand in a known ratio (`engines.base.Comparison`)."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.base import Comparison, EngineFailure
from quickreturn.engines.relative import rms
from quickreturn.engines.settings import Settings
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.columns import BEARINGS, BENDING

R = TypeVar("R")
Q = TypeVar("Q")

#: Columns with an error estimate of their own.
ESTIMATED: Final = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")
#: Columns that have one, too, where the engine gives them: what a part must bear or a drive must give.
LOADS: Final = (*BENDING, *BEARINGS, "crank_torque", "base_torque")

#: The least factor that differences in a row are credited with: the error is at most 1.4 times the difference from the coarser run.
#: Two runs that err by as much in unrelated ways differ by more than either errs; in 17 scenes the errors of unresolved motions were at
#: most 1.07 times the difference.
LEAST_FACTOR: Final = 1.7
#: The largest part of an error that a finer run is taken to leave, however slowly the differences fall: the error is at most four times
#: the larger of them.
LARGEST_REST: Final = 0.75
#: A tip deflection of less than this part of the follower's length is no deflection: the follower is rigid.
NO_DEFLECTION: Final = 1e-12


@dataclass(frozen=True)
class Compared(Generic[R]):
    """Results of the runs of a `Comparison`: trajectories, or what is computed from them."""

    run: R  # the run in question, or one with the same error in this part
    other: R  # the one that `run` is compared with
    factor: float  # error of `other` over that of `run`, not 1
    # the run that `other` is compared with in turn, and the error of that over the one of `other`; None where there is none
    before: tuple[R, float] | None = None

    def part(self, difference: Callable[[R, R], float]) -> float:
        """The part of an error that the runs show, from the size of the difference of two of them."""
        shown = difference(self.run, self.other)
        if self.before is None:
            return shown / abs(self.factor - 1.0)
        further = difference(self.other, self.before[0])
        factor = shown_factor(self.factor, self.before[1], shown, further)
        return (shown if factor > 1.0 else max(shown, further)) / abs(factor - 1.0)

    def made_of(self, make: Callable[[R], Q]) -> "Compared[Q]":
        """The same comparison of what `make` computes from each run."""
        before = None if self.before is None else (make(self.before[0]), self.before[1])
        return Compared(make(self.run), make(self.other), self.factor, before)


def compared(pair: Comparison, run: Callable[[Settings], R]) -> Compared[R]:
    """The results of a comparison, each made by `run`; those of its `instead` where a run breaks down.

    Raises:
        EngineFailure: of `run`, where there is no `instead`.
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
    except EngineFailure:
        return Compared(first, second, min(pair.factor, LEAST_FACTOR))


def estimated_part(delivered: Trajectory, runs: Compared[Trajectory], length: float) -> tuple[float, dict[str, float | None]]:
    """A part of the error of `delivered`, from two or three runs on the same output grid (see `Comparison`).

    Args:
        delivered: the run in question; differences are taken relative to the size of its columns.
        runs: that are compared.
        length: follower length, m.

    Returns:
        The part of the tip (see `Result.error_estimate`), and one for each column of `ESTIMATED` and `LOADS` that there is.
    """

    def part(name: str) -> float:
        return runs.part(lambda a, b: rms(a[name] - b[name]))

    known: list[str] = [name for name in (*ESTIMATED, *LOADS) if name in delivered.columns]
    each = {name: relative_size(part(name), rms(delivered[name])) for name in known}
    deflection = each["tip_deflection"]
    if deflection is None or rms(delivered["tip_deflection"]) < NO_DEFLECTION * length:
        return runs.part(lambda a, b: rms(np.hypot(a["tip_x"] - b["tip_x"], a["tip_y"] - b["tip_y"]))) / length, each
    return deflection, each


def shown_factor(factor: float, factor_before: float, difference: float, difference_before: float) -> float:
    """The factor that two differences in a row support: from `LEAST_FACTOR` to `factor`, or from `factor` to `LARGEST_REST` if below 1.

    Runs that converge as the factors f and f' say, the errors being e, f e and f' f e, differ by (f - 1) e and (f' - 1) f e. The less
    the second difference exceeds the first, the less the error falls from run to run; where a fast motion is not resolved at all, as
    under a sudden load or where the slider shakes the cable, it does not fall.
    """
    expected = factor * (factor_before - 1.0) / (factor - 1.0)
    shown = math.inf if difference == 0.0 else factor * difference_before / (difference * expected)
    if factor < 1.0:
        return min(max(factor, shown), max(factor, LARGEST_REST))
    return max(min(factor, shown), min(factor, LEAST_FACTOR))


def same_motion(run: Mapping[str, NDArray[np.float64]], other: Mapping[str, NDArray[np.float64]]) -> bool:
    """Whether two runs agree to the last bit, so that their difference says nothing of their error; False where nothing bends."""
    deflection = run["tip_deflection"]
    return bool(np.any(deflection) and np.array_equal(deflection, other["tip_deflection"]))


def relative_size(difference: float, size: float) -> float | None:
    """One over the other; None where the size is zero."""
    return difference / size if size != 0.0 and math.isfinite(difference / size) else None
