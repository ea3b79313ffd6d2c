"""Parts of an error, from differences of runs whose errors stand in a known ratio (`engines.base.Comparison`)."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final, Generic, TypeVar

import numpy as np

from quickreturn.engines.base import Comparison, EngineFailure
from quickreturn.engines.settings import Settings
from quickreturn.engines.trajectory import Trajectory, rms, scale
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import AXIAL, BEARINGS, BENDING

R = TypeVar("R")
Q = TypeVar("Q")

#: Key of the parts of the error of the tip, beside those of columns.
TIP: Final = "tip"
#: Columns with an error estimate of their own.
ESTIMATED: Final = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")
#: Columns that also have one where the engine gives them: loads on parts and drive, and the base's motion.
WHERE_GIVEN: Final = (*BENDING, *AXIAL, *BEARINGS, "crank_torque", "base_torque", "follower_rate", "follower_acceleration")

#: Smallest factor that successive differences are credited with: the estimate is at most 1.4 times the difference from the coarser run.
#: Two runs with equal but unrelated errors differ by more than either error; in 17 scenes the errors of unresolved motions were at most
#: 1.07 times the difference.
LEAST_FACTOR: Final = 1.7
#: Largest assumed error of a finer run over that of the run, however slowly the differences fall: the error is at most four times the
#: larger difference.
LARGEST_REST: Final = 0.75
#: Difference of two runs in the first tip acceleration over its RMS, above which a load acts suddenly: it is at most 5e-5 in four of the
#: thesis' runs, and 9e-4 or more with weight.
SUDDEN: Final = 1e-4
#: RMS of the tip deflection over the follower's length below which the follower counts as rigid.
NO_DEFLECTION: Final = 1e-12


@dataclass(frozen=True)
class ErrorPart:
    """A part of an error, and the two runs that show it."""

    of: str  # what it comes from: "time", "space", "modes", "spring" and the like (`Comparison.of`)
    run: dict[str, Any]  # settings of one run, by name: those in which the delivered run and the two differ; see `complete`
    other: dict[str, Any]  # the same settings of the run that it is compared with
    difference: float  # size of the difference of the two, in the unit of the number, or relative where the error is
    factor: float  # error of `other` over that of `run`, as the engine states it
    counted: float  # what counts as error, over the difference: by `factor`, or by what further runs show of it, and by `Compared.growth`

    @property
    def error(self) -> float:
        """The part of the error."""
        return self.counted * self.difference

    def __str__(self) -> str:
        """Such as "3.2e-4 by modes: modes 5 against 7 (0.333 times their difference of 9.6e-4)"."""
        changed = [name for name in self.run if self.run[name] != self.other.get(name)]
        values = ", ".join(f"{name.replace('_', ' ')} {_short(self.run[name])} against {_short(self.other[name])}" for name in changed)
        difference = f"{self.counted:.3g} times their difference of {_short(self.difference, '.1e')}"
        return f"{_short(self.error, '.1e')} by {self.of}: {values} ({difference})"

    def complete(self, delivered: Mapping[str, Any]) -> "ErrorPart":
        """The same part with all settings of the two runs; `delivered`: those of the delivered run."""
        return replace(self, run={**delivered, **self.run}, other={**delivered, **self.other})

    def over(self, size: float) -> "ErrorPart":
        """The same part relative to a size."""
        return replace(self, difference=self.difference / size)


def _short(value: Any, form: str = ".4g") -> str:
    return format(value, form).replace("e-0", "e-").replace("e+00", "") if isinstance(value, float) else str(value).lower()


def total(parts: Iterable[ErrorPart]) -> float | None:
    """The error that parts add up to: they cannot cancel. None if there are none."""
    errors = [part.error for part in parts]
    return sum(errors) if errors else None


@dataclass(frozen=True)
class Compared(Generic[R]):
    """Results of the runs of a `Comparison`: trajectories, or what is computed from them."""

    run: R  # the run in question, or one with the same error in this part
    other: R  # the one that `run` is compared with
    factor: float  # error of `other` over that of `run`, not 1
    # the run that `other` is compared with in turn, and the error of that over the one of `other`; None where there is none
    before: tuple[R, float] | None = None
    # why the run that would have checked `factor` is missing, a clause; the least favourable factor then counts. "" if none is missing
    unchecked: str = ""
    of: str = ""  # what the part of the error comes from, see `ErrorPart`
    settings: tuple[dict[str, Any], ...] = ({}, {}, {})  # of `run`, `other` and `before`, as `ErrorPart` has them
    besides: "Compared[R] | None" = None  # another pair that shows the same part
    growth: float = 1.0  # error in question over the one that the runs show, which has not built up yet

    def part(self, difference: Callable[[R, R], float]) -> ErrorPart:
        """The part of the error that the runs show, the larger of two if another pair shows it as well.

        `difference` gives the size of the difference of two results.
        """
        own = self._part(difference)
        return own if self.besides is None else max(own, self.besides.part(difference), key=lambda part: part.error)

    def _part(self, difference: Callable[[R, R], float]) -> ErrorPart:
        shown, factor, (run, other, before) = difference(self.run, self.other), self.factor, self.settings
        if self.unchecked:
            factor = least_favourable(factor)
        if self.before is not None:
            further = difference(self.other, self.before[0])
            factor = shown_factor(factor, self.before[1], shown, further)
            if factor < 1.0 and further > shown:
                shown, run, other = further, other, before
        return ErrorPart(self.of, run, other, shown, self.factor, counted(factor) * self.growth)

    def mapped(self, compute: Callable[[R], Q]) -> "Compared[Q]":
        """The comparison of what `compute` makes of each result."""
        before = None if self.before is None else (compute(self.before[0]), self.before[1])
        besides: Compared[Q] | None = None if self.besides is None else self.besides.mapped(compute)
        results = compute(self.run), compute(self.other)
        return Compared(*results, self.factor, before, self.unchecked, self.of, self.settings, besides, self.growth)

    def growing(self, growth: Callable[[R, R], float]) -> "Compared[R]":
        """The same runs, whose difference shows only a part of the error: that in question is `growth` of the two times as large."""
        return replace(self, growth=growth(self.run, self.other), besides=self.besides and self.besides.growing(growth))

    @property
    def pairs(self) -> tuple[tuple[R, R], ...]:
        """The results that are compared with each other, without that of `before`."""
        return ((self.run, self.other), *(self.besides.pairs if self.besides else ()))


def comparison_by(pairs: Sequence[Comparison], of: str) -> Comparison:
    """The comparison that shows one part of an error. ValueError: none does, or several do."""
    (pair,) = (pair for pair in pairs if pair.of == of)
    return pair


def counted(factor: float) -> float:
    """What counts as error of the difference of two runs, whose errors stand in the ratio `factor`: Richardson's estimate."""
    return 1.0 / abs(factor - 1.0)


def compared(pair: Comparison, delivered: Settings, run: Callable[[Settings], R]) -> Compared[R]:
    """The results of a comparison's runs; `run` makes one from settings. If one breaks down, those of the comparison's `instead`.

    `delivered` are the settings of the run whose error is estimated.

    Without the run that checks the factor nothing shows how fast the error falls, and the least favourable factor counts.

    Raises:
        EngineFailure: a run broke down, and there is no `instead`.
    """
    if pair.besides is not None:
        return replace(compared(replace(pair, besides=None), delivered, run), besides=compared(pair.besides, delivered, run))
    try:
        first, second = run(pair.run), run(pair.other)
    except EngineFailure:
        if pair.instead is None:
            raise
        return compared(pair.instead, delivered, run)
    runs = [pair.run.as_dict(), pair.other.as_dict(), (pair.before.other if pair.before else pair.other).as_dict()]
    differing = [name for name, value in delivered.as_dict().items() if any(each[name] != value for each in runs)]
    names = tuple({name: each[name] for name in differing} for each in runs)
    if pair.before is None:
        return Compared(first, second, pair.factor, of=pair.of, settings=names)
    try:
        before = run(pair.before.other), pair.before.factor
    except EngineFailure as failure:
        return Compared(first, second, pair.factor, None, str(failure), pair.of, names)
    return Compared(first, second, pair.factor, before, "", pair.of, names)


class NoEstimate(Exception):
    """The error cannot be estimated; the text is a clause that says why."""


def all_compared(
    pairs: Sequence[Comparison],
    delivered: Settings,
    run: Callable[[Settings], R],
    signals: Callable[[R], Mapping[str, Array]],
    *,
    bends: bool,
) -> list[Compared[R]]:
    """The results of all comparisons of an error estimate.

    Args:
        pairs: the comparisons.
        delivered: settings of the run whose error is estimated.
        run: makes a result from settings; EngineFailure: it breaks down.
        signals: the columns of a result.
        bends: whether the follower does: its deflection then differs between any two runs.

    Raises:
        NoEstimate: there is nothing to compare with.
        EngineFailure: see `compared`.
    """
    if any(pair.run == pair.other for pair in pairs):
        raise NoEstimate("these settings leave no others to compare with")
    found = [compared(pair, delivered, run) for pair in pairs]
    if bends and any(same_motion(signals(one), signals(other)) for runs in found for one, other in runs.pairs):
        raise NoEstimate("the run to compare with is the same to the last digit")
    return found


def parts_of(
    delivered: Trajectory, runs: Sequence[Compared[Trajectory]], length: float
) -> tuple[dict[str, tuple[ErrorPart, ...]], dict[str, float]]:
    """The parts of the error of a trajectory by the runs that show them, all on its output grid.

    Args:
        delivered: the run; differences are relative to the scale of its columns.
        runs: two or three runs for each part (see `Comparison`).
        length: follower length, m.

    Returns:
        Parts, by column and of the tip (see `engines.accurate.Result`): RMS over `scale`, none where that is 0. And the largest error of
        each column at any instant, in its unit. Columns are those of `ESTIMATED` and the existing ones of `WHERE_GIVEN`.
    """

    def part(pair: Compared[Trajectory], name: str) -> ErrorPart | None:
        found, size = pair.part(lambda a, b: rms(a[name] - b[name])), scale(name, delivered.columns)
        return None if relative_size(found.error, size) is None else found.over(size)

    def of_tip(pair: Compared[Trajectory]) -> ErrorPart:
        return pair.part(lambda a, b: rms(np.hypot(a["tip_x"] - b["tip_x"], a["tip_y"] - b["tip_y"]))).over(length)

    names: list[str] = [name for name in (*ESTIMATED, *WHERE_GIVEN) if name in delivered.columns]
    parts = {name: [part(pair, name) for pair in runs] for name in names}
    known = {name: tuple(each for each in some if each is not None) for name, some in parts.items()}
    rigid = rms(delivered["tip_deflection"]) < NO_DEFLECTION * length
    tip = tuple(of_tip(pair) if each is None or rigid else each for pair, each in zip(runs, parts["tip_deflection"], strict=True))
    largest = {name: sum(pair.part(partial(_largest_difference, name)).error for pair in runs) for name in names}
    return {TIP: tip} | {name: some if len(some) == len(runs) else () for name, some in known.items()}, largest


def starts_suddenly(delivered: Trajectory, runs: Sequence[Compared[Trajectory]]) -> bool:
    """Whether the first row depends on the resolution: a load acts at once on the straight follower of a scene with a slider."""
    if "slider_position" not in delivered.columns:
        return False
    name = "tip_acceleration"
    apart = max((abs(float(pair.run[name][0] - pair.other[name][0])) for pair in runs), default=0.0)
    return apart > SUDDEN * rms(delivered[name])


def add_first_row(parts: dict[str, tuple[ErrorPart, ...]], largest: dict[str, float], delivered: Trajectory, finest: Trajectory) -> None:
    """Add to the parts of each column that of the first row, of which `finest` shows a part; arguments as of `parts_of` and from it.

    Accelerations of the first row approach their limit no faster than `LARGEST_REST` says. The place of the tip is given by the start.
    """
    counts = counted(LARGEST_REST)
    for name, known in parts.items():
        if not known or name in (TIP, "tip_deflection"):
            continue
        apart = abs(float(delivered[name][0] - finest[name][0]))
        share = relative_size(apart / math.sqrt(len(delivered)), scale(name, delivered.columns))
        if share:
            parts[name] = (*known, ErrorPart("start", {}, {}, share, LARGEST_REST, counts))
            largest[name] = max(largest[name], counts * apart)


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


def same_motion(run: Mapping[str, Array], other: Mapping[str, Array]) -> bool:
    """Whether two runs agree to the last bit, so that their difference says nothing of their error; False if nothing bends."""
    deflection = run["tip_deflection"]
    return bool(np.any(deflection) and np.array_equal(deflection, other["tip_deflection"]))


def relative_size(difference: float, size: float) -> float | None:
    """The difference over the size; None if the size is zero or the ratio overflows."""
    return difference / size if size != 0.0 and math.isfinite(difference / size) else None
