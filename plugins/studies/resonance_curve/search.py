"""Follows the periodic motion of a machine over one of its quantities, and measures it, each number with its error claim."""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final, Protocol, TypeVar

import numpy as np

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError, nearest_or_all
from quickreturn.cases.motion.catalogue import ARGUMENT, MEASURES
from quickreturn.cases.motion.measure import Measure
from quickreturn.cases.motion.resonance import resonance
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.store import Pieces
from quickreturn.engines import progress
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.error_parts import comparison_by, counted
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.plugins.studies.resonance_curve.curve import (
    MULTIPLIER_TOLERANCE,
    SPEED,
    Range,
    ResonanceCurve,
    ResonancePeak,
    SpecialPoint,
    claims_on,
    driven,
    numbers_of,
    topped,
)
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import OBSERVED
from quickreturn.reference_model.cycles.continuation import FIRST_STEP, MOST_POINTS, Branch, Ending, Stretch, enough, stretch, turned
from quickreturn.reference_model.cycles.cycle_family import CycleFamily
from quickreturn.reference_model.cycles.fixed_points import BranchPoint, Limits, NotConverged, first_point, towards
from quickreturn.reference_model.cycles.periodic import NoPeriodicOrbit
from quickreturn.reference_model.cycles.poincare import CycleBroken
from quickreturn.reference_model.mechanism import Mechanism

T = TypeVar("T")


class _Kept(Protocol):
    """The next piece of a curve: from the store, or computed."""

    def __call__(self, kind: type[T], compute: Callable[[], T]) -> T: ...


#: Measure by default.
USUAL: Final = "peak.tip_acceleration"
#: Stresses, which depend on columns that a scene may lack.
STRESSES: Final = ("peak.stress", "amplitude.stress")
#: Sizes that follow from the columns of a turn, by name.
OF_CURVE: Final[Mapping[str, Measure]] = {
    name: each
    for name, each in MEASURES.items()
    if name in STRESSES or (each.size and each.columns and {*each.columns} <= {"time", *OBSERVED})
}
#: Relative tolerance of the integration: derivatives come from small differences of cycles, and this bounds their error to 1e-3.
INTEGRATION: Final = 1e-10
#: Number of values of the range at which a first periodic motion is searched, in order.
SEARCHES: Final = 9
#: Number of curves that are begun, each where the one before was lost; the one that reaches farthest counts.
BEGINNINGS: Final = 3
#: Number of steps along the curve, and of points to measure, after which the results so far are stored: about ten seconds of work.
PIECE: Final = 10
#: Least ratio of a peak to the valleys beside it.
PROMINENT: Final = 1.1
#: Error of the place of a fold, as a part of the range: a new search from other points moves it by at most 2e-7.
FOLD_TOLERANCE: Final = 1e-6


def checked_scenes(case: Case, varied: Range, speed: float | None, measures: Sequence[str]) -> Callable[[float], Mechanism]:
    """The scene for each value of the varied quantity; arguments and errors as for `resonance_curve`, as far as known beforehand."""
    for name in measures:
        if name in OF_CURVE:
            continue
        if name in MEASURES:
            raise CaseError(
                ARGUMENT, name, None, "has no resonance curve", f"curves are of sizes such as {USUAL}; `sweep` has this measure"
            )
        raise CaseError(ARGUMENT, name, None, "is unknown", nearest_or_all(name, tuple(OF_CURVE)))
    held = {} if speed is None else {SPEED: speed}

    def scene_at(value: float) -> Mechanism:
        progress.tell(phase=f"following the motion at {value / varied.size:.4g} {varied.unit}")
        return case.mechanism_with(held | {varied.key: value})

    for value in (varied.low, varied.high):
        _check(scene_at(value))
    return scene_at


def job(
    case: Case,
    varied: Range,
    speed: float | None = None,
    measures: Sequence[str] = (USUAL,),
    accuracy: float | None = None,
    claims: bool = True,
) -> Job[ResonanceCurve]:
    """`resonance_curve` as a job. Raises errors that are known beforehand: CaseError, Refusal."""
    scene_at = checked_scenes(case, varied, speed, measures)
    arguments = (case, varied, speed, tuple(measures), accuracy, claims)
    # files of equal scenes may answer a change differently, such as that of a thickness with a material: the ends of the range show it
    # and a curve says whether the speed is prescribed in place of the case's own drive
    inputs = (scene_at(varied.low), scene_at(varied.high), case.mechanism.crank_is_free, *arguments[1:])
    return Job(f"{case.name} reference", resonance_curve, arguments, "resonance curve", ("reference",), inputs, pieces=True)


@dataclass(frozen=True)
class _Measured:
    """Successive points of a curve: their measures and claims, nan where unknown."""

    values: Array  # shape (points, measures)
    errors: Array  # likewise
    value_errors: Array  # of the varied quantity, shape (points,)


def resonance_curve(
    case: Case,
    varied: Range,
    speed: float | None,
    measures: Sequence[str],
    accuracy: float | None,
    claims: bool,
    pieces: Pieces | None = None,
) -> ResonanceCurve:
    """The curve of a case's periodic motion.

    The crank turns at `speed` (prescribed, rad/s; None: as its own drive says) unless that varies. Modes are chosen for the `accuracy`
    (relative; None: that of `reference`). `measures` are names of `OF_CURVE`; with `claims` the error of every point is estimated. What was
    computed before comes from `pieces`.

    Raises:
        CaseError, Refusal: an invalid argument, or a machine without such a curve.
        EngineFailure: no periodic motion was found anywhere in the range.
    """
    scene_at, engine = checked_scenes(case, varied, speed, measures), ReferenceEngine()
    settings = engine.settings_for(accuracy or engine.default_accuracy, scene_at(varied.high))
    comparison = comparison_by(engine.comparisons(settings, scene_at(varied.high), case.output_step), "modes")
    other = comparison.other
    assert isinstance(other, ReferenceSettings)
    family = CycleFamily(scene_at, settings.modes, INTEGRATION)
    numbers = itertools.count()

    def kept(kind: type[T], compute: Callable[[], T]) -> T:
        return compute() if pieces is None else pieces.piece(next(numbers), kind, compute)

    followed = _followed(family, varied, kept)
    finer = CycleFamily(scene_at, other.modes, other.tolerance) if claims else None
    points, part = followed.points, counted(comparison.factor)

    def measured(begin: int) -> _Measured:
        some = points[begin : begin + PIECE]
        values, errors = (np.full((len(some), len(measures)), math.nan) for _ in range(2))
        value_errors, displacement = np.full(len(some), math.nan), None
        for at, point in enumerate(some):
            progress.tell(phase=f"measuring point {begin + at + 1} of {len(points)}")
            found = numbers_of(family, point.point, point.parameter, measures)
            values[at] = [each.value for each in found]
            if finer is not None:
                errors[at], value_errors[at], displacement = claims_on(point, found, finer, measures, part, displacement)
        return _Measured(values, errors, value_errors)

    parts = [kept(_Measured, partial(measured, begin)) for begin in range(0, len(points), PIECE)]
    values, errors, value_errors = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("values", "errors", "value_errors")
    )
    peaks = [
        kept(ResonancePeak, partial(topped, family, points[each.at - 1 : each.at + 2], each, measures[0]))
        for each in _maxima(points, values[:, 0], scene_at)
    ]
    special = [
        SpecialPoint(each.special, each.parameter, _tolerance(points, at), None if math.isnan(error) else float(error), at)
        for at, (each, error) in enumerate(zip(points, value_errors, strict=True))
        if each.special
    ]
    for at, ending in zip((0, len(points) - 1), followed.endings, strict=True):
        if ending is not None:
            kind = "slider left" if ending.left else "lost"
            special.append(SpecialPoint(kind, ending.parameter, ending.tolerance, None, at, ending.reason))
    return ResonanceCurve(
        range=varied,
        prescribed=case.mechanism.crank_is_free and not scene_at(varied.low).crank_is_free,
        values=np.array([each.parameter for each in points]),
        arclength=np.array([each.arclength for each in points]) - points[0].arclength,
        measures=dict(zip(measures, values.T, strict=True)),
        errors=dict(zip(measures, errors.T, strict=True)),
        value_errors=value_errors,
        multipliers=np.array([[each.multipliers[0].real, each.multipliers[0].imag] for each in points]),
        kinds=tuple(each.instability for each in points),
        special=tuple(sorted(special, key=lambda each: each.at)),
        peaks=tuple(peaks),
        settings={"modes": settings.modes, "finer_modes": other.modes, "tolerance": INTEGRATION},
    )


def _check(scene: Mechanism) -> None:
    """Raises Refusal for a scene whose cycle is not a differentiable map."""
    engine = ReferenceEngine()
    engine.check(scene)
    if scene.follower.is_rigid:
        raise Refusal("a resonance curve needs a follower that bends; give a finite follower.bending_stiffness")
    if engine.opens_loop(scene):
        raise Refusal(
            "a resonance curve needs a slider joint that is rigid and frictionless; leave its stiffness, clearance and friction out"
        )


def _followed(family: CycleFamily, varied: Range, kept: "_Kept") -> Branch:
    """The branch through the first periodic motion found within the range; where it is lost, a later one that reaches farther.

    Raises:
        EngineFailure: no periodic motion is found.
    """
    values = np.linspace(varied.low, varied.high, SEARCHES)
    branches = list[Branch]()
    while len(values) and len(branches) < BEGINNINGS:
        try:
            begin = kept(BranchPoint, partial(_begin, family, varied, values))
        except EngineFailure:
            if not branches:
                raise
            break
        branches.append(_both_ways(family, varied, begin, kept))
        if not any(ending is not None and not ending.left and ending.tolerance > 0.0 for ending in branches[-1].endings):
            break
        low, high = _reach(branches[-1])
        values = values[(values < low) | (values > high)]
    return max(branches, key=lambda each: np.ptp(_reach(each)))


def _limits(family: CycleFamily, varied: Range) -> Limits:
    """The range; with each multiple of the crank's speed that meets the first mode in it the vibration's phase turns once."""
    ends = [resonance(family.scene_at(value)) for value in (varied.low, varied.high)]
    ratios = [0.0 if end is None else end.ratio for end in ends]
    return Limits.of(varied.low, varied.high, abs(ratios[1] - ratios[0]))


def _reach(branch: Branch) -> tuple[float, float]:
    """Least and greatest value of the varied quantity along a branch."""
    values = [point.parameter for point in branch.points]
    return min(values), max(values)


def _both_ways(family: CycleFamily, varied: Range, begin: BranchPoint, kept: "_Kept") -> Branch:
    """The branch through a periodic motion, piece by piece."""
    limits = _limits(family, varied)
    ways = list[tuple[list[BranchPoint], Ending | None]]()
    for sign in (1.0, -1.0):
        here, step, passed, first = towards(begin, sign), FIRST_STEP, list[BranchPoint](), None
        while True:
            part = kept(Stretch, partial(stretch, family, here, limits, step, PIECE, first))
            passed += part.points
            ending = part.ending
            if part.step is not None and len(passed) > MOST_POINTS:
                ending = enough(passed[-1])
            if part.step is None or ending is not None:
                break
            if part.points:
                here, first = part.points[-1], towards(begin, sign)
            step = part.step
        ways.append((passed, ending))
        if part.closed:
            ways.append(([], None))
            break
    (after, end), (before, other_end) = ways
    return Branch((*map(turned, reversed(before)), begin, *after), (other_end, end))


def _begin(family: CycleFamily, varied: Range, values: Array) -> BranchPoint:
    """The first periodic motion found at one of some values. EngineFailure: none is found."""
    reasons = []
    for value in values.tolist():
        try:
            return first_point(family, family.orbit(value), value, _limits(family, varied))
        except (NoPeriodicOrbit, CycleBroken, NotConverged) as reason:
            reasons.append(f"at {value / varied.size:.4g} {varied.unit}: {reason}")
    raise EngineFailure(0.0, f"no periodic motion was found within the range ({reasons[0]})", "try another range")


def _tolerance(points: Sequence[BranchPoint], at: int) -> float:
    """Error of the location of a special point: see `FOLD_TOLERANCE` and `MULTIPLIER_TOLERANCE`."""
    here, before, after = points[at], points[at - 1], points[at + 1]
    if here.special == "fold":
        return FOLD_TOLERANCE * here.width
    change = abs(abs(after.multipliers[0]) - abs(before.multipliers[0]))
    return MULTIPLIER_TOLERANCE / change * abs(after.parameter - before.parameter) if change > 0.0 else math.inf


def _maxima(points: Sequence[BranchPoint], heights: Array, scene_at: Callable[[float], Mechanism]) -> Iterator[ResonancePeak]:
    """Local maxima between the points, by the parabola of the logarithms of three."""
    from scipy.signal import find_peaks  # takes a second to import

    log = np.log(heights)
    for at in find_peaks(log, prominence=math.log(PROMINENT))[0].tolist():
        near = slice(at - 1, at + 2)
        along = np.array([each.arclength for each in points[near]])
        value, height = (np.polyfit(along - along[1], numbers, 2) for numbers in (np.array([p.parameter for p in points[near]]), log[near]))
        top = float(np.clip(-height[1] / (2.0 * height[0]), along[0] - along[1], along[2] - along[1]))
        parameter = float(np.polyval(value, top))
        yield ResonancePeak(parameter, math.exp(float(np.polyval(height, top))), at, *driven(scene_at(parameter)))
