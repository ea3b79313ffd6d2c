"""The periodic motion of a machine over one of its quantities: curve, stability, special points and peaks, each with its error claim."""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from cases.case import PATHS, Case, dimension_of
from cases.errors import CaseError, as_written, nearest_or_all
from cases.jobs.job import Job
from cases.loads.resonance import resonance
from cases.measures.extremes import extremes
from cases.units import QuantityError, parse_quantity
from engines import progress
from engines.base import EngineFailure, Refusal
from engines.own.reference import ReferenceEngine, ReferenceSettings
from reference_model.columns import OBSERVED
from reference_model.continuation import Branch, BranchPoint, NotConverged, branch
from reference_model.cycle_family import CycleFamily
from reference_model.mechanism import Mechanism
from reference_model.periodic import NoPeriodicOrbit
from reference_model.rigid import crank_pace
from reference_model.scene_values import ALTERNATIVES, scene_of, values_of
from reference_model.section_map import CycleBroken

Array = NDArray[np.float64]

SPEED: Final = "crank.prescribed_speed"
#: What is measured unless asked otherwise.
USUAL: Final = "peak.tip_acceleration"
#: Name of a measure -> the column whose largest magnitude in a turn it is.
PEAKS: Final[Mapping[str, str]] = {f"peak.{name}": name for name in OBSERVED}
#: Tolerance of the integration: derivatives are taken from small differences of cycles, whose round-off it bounds to 1e-3 of them.
INTEGRATION: Final = 1e-10
#: Rows of a cycle between which a spline finds the peak.
ROWS: Final = 256
#: Values within the range at which a first periodic motion is searched, one after the other.
SEARCHES: Final = 9
#: Ratio of a peak to the valleys beside it from which on it counts as one.
PROMINENT: Final = 1.1
#: By how much a fold is missed, in parts of the range: locating it anew from other points moves it by at most 2e-7.
FOLD_TOLERANCE: Final = 1e-6
#: By how much a multiplier is missed: differences of cycles leave about 1e-4 of the largest derivatives.
MULTIPLIER_TOLERANCE: Final = 1e-3
#: Part of its own speed within which the curve around a machine goes.
NEAR: Final = 0.15
#: What a curve depends on besides what the simulation does.
CODE: Final = ("cases.resonance_curve", "cases.loads", "cases.measures.extremes")
#: Keys that no periodic motion depends on.
_WITHOUT_EFFECT: Final = ("crank.initial_angle", "crank.initial_speed")


@dataclass(frozen=True)
class Range:
    """A quantity of a scene and the values between which it varies.

    Attributes:
        key: dotted key of a case file.
        low, high: SI.
        unit: in which they were given, for people.
        size: of that unit, SI.
    """

    key: str
    low: float
    high: float
    unit: str
    size: float


@dataclass(frozen=True)
class SpecialPoint:
    """Where the motion changes its kind.

    Attributes:
        kind: "fold", "period doubling", "torus", "slider left" or "lost".
        value: of the varied quantity, SI.
        tolerance: by how much the model's own value may be missed.
        error: claim: by how much more modes move it; None: unknown.
        at: number of the point on the curve.
        reason: why the curve ends there (a clause); "" where it goes on.
    """

    kind: str
    value: float
    tolerance: float
    error: float | None
    at: int
    reason: str = ""


@dataclass(frozen=True)
class ResonancePeak:
    """A local maximum of the first measure along the curve.

    Attributes:
        value: of the varied quantity, SI.
        height: of the measure.
        at: number of the point on the curve.
        order: multiple of the crank's speed that is nearest to the mean first bending frequency there.
    """

    value: float
    height: float
    at: int
    order: int


@dataclass(frozen=True)
class ResonanceCurve:
    """Points in order of arclength, which pass through folds; arrays of shape (k,).

    A point's claim is a rectangle: the curve of a converged model passes through `values` +- `value_errors` and each measure +- its error.
    The converged point is looked for in the plane across the curve, so that the claim holds at folds as it does elsewhere.

    Attributes:
        case: its name.
        range: what varies, and between which values.
        prescribed: whether the crank's speed was prescribed in place of the case's own drive.
        values: of the varied quantity, SI.
        arclength: along the curve, in parts of the range and of the motion's size.
        measures: by name.
        errors: of these, by name; nan where unknown.
        value_errors: nan where unknown.
        multipliers: largest Floquet multiplier, real and imaginary part, shape (k, 2).
        kinds: "" of a stable point, else "fold", "period doubling" or "torus".
        special, peaks: in order of arclength.
        settings: modes and tolerance of the model, and of the finer one.
    """

    case: str
    range: Range
    prescribed: bool
    values: Array
    arclength: Array
    measures: dict[str, Array]
    errors: dict[str, Array]
    value_errors: Array
    multipliers: Array
    kinds: tuple[str, ...]
    special: tuple[SpecialPoint, ...]
    peaks: tuple[ResonancePeak, ...]
    settings: dict[str, float]

    def kind_after(self, at: int) -> str:
        """How the motion is unstable between a point and the next one, "" where it is stable."""
        return self.kinds[at + 1 if any(each.at == at for each in self.special) else at]

    def stretches(self) -> Iterator[tuple[slice, bool]]:
        """Stretches of the curve, and whether they are unstable; special points belong to both stretches that they part."""
        unstable, begin = [bool(self.kind_after(at)) for at in range(len(self.kinds) - 1)], 0
        for state, group in itertools.groupby(unstable):
            end = begin + len(list(group))
            yield slice(begin, end + 1), state
            begin = end


def range_of(key: str, text: str, option: str = "--vary") -> Range:
    """The range that "a .. b" describes. CaseError: it cannot be."""
    if key not in PATHS or key.startswith("simulation."):
        raise CaseError(option, key, None, "is no quantity of a scene", nearest_or_all(key, tuple(PATHS)))
    about = PATHS[key]
    if about.count is not None or not about.moves or key in _WITHOUT_EFFECT:
        raise CaseError(option, key, None, "changes no periodic motion continuously", "give a single number of the scene")
    ends = [part.strip() for part in text.split("..")]
    example = f'such as "{"60 rpm .. 300 rpm" if key == SPEED else f"1 {about.unit} .. 2 {about.unit}"}"'
    if len(ends) != 2 or not all(ends):
        raise CaseError(option, key, as_written(text), "is no range", f"write two values with .. between them, {example}")
    try:
        low, high = (parse_quantity(end, dimension_of(key)) for end in ends)
    except QuantityError as wrong:
        raise CaseError(option, key, as_written(text), wrong.problem, wrong.accepted) from None
    if not low < high or low * high < 0.0 or (key == SPEED and low * high == 0.0):
        raise CaseError(option, key, as_written(text), "is no range to follow", f"give a smaller and a larger value of one sign, {example}")
    unit = ends[1].partition(" ")[2]
    return Range(key, low, high, unit, parse_quantity(f"1 {unit}", dimension_of(key)) if unit else 1.0)


def scene_with(scene: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """The scene with other values (SI) by dotted key; keys that they replace are dropped.

    Raises:
        ImpossibleMechanism: the parts do not fit together.
    """
    changed = {section: dict(keys) for section, keys in values_of(scene).items()}
    for first, others in ALTERNATIVES:
        dropped = others if first in values else (first,) if any(path in values for path in others) else ()
        for section, _, key in (path.partition(".") for path in dropped):
            changed[section].pop(key, None)
    for path, value in values.items():
        section, _, key = path.partition(".")
        changed.setdefault(section, {})[key] = value
    found = scene_of(changed)
    assert isinstance(found, Mechanism)
    return found


def checked_scenes(case: Case, varied: Range, speed: float | None, measures: Sequence[str]) -> Callable[[float], Mechanism]:
    """The scene for each value of what varies; arguments and errors as of `resonance_curve`, as far as they are known beforehand."""
    for name in measures:
        if name not in PEAKS:
            raise CaseError("--measure", name, None, "is unknown", nearest_or_all(name, tuple(PEAKS)))
    scene = case.mechanism
    base = scene if speed is None or varied.key == SPEED else scene_with(scene, {SPEED: speed})

    def scene_at(value: float) -> Mechanism:
        progress.tell(phase=f"following the motion at {value / varied.size:.4g} {varied.unit}")
        return scene_with(base, {varied.key: value})

    for value in (varied.low, varied.high):
        _check(scene_at(value))
    return scene_at


def job_around(case: Case) -> Job[ResonanceCurve]:
    """The curve over speeds within `NEAR` of the machine's own, without claims; of a machine that a torque drives, of its mean speed.

    Raises:
        CaseError, Refusal: as `resonance_curve` does; Refusal also of a crank that stands still.
    """
    pace = crank_pace(case.mechanism)
    if pace == 0.0:
        raise Refusal("a resonance curve needs a crank that turns; give a speed, or a torque and damping")
    low, high = sorted(((1.0 - NEAR) * pace, (1.0 + NEAR) * pace))
    return job(case, Range(SPEED, low, high, "rpm", math.pi / 30.0), claims=False)


def job(
    case: Case,
    varied: Range,
    speed: float | None = None,
    measures: Sequence[str] = (USUAL,),
    accuracy: float | None = None,
    claims: bool = True,
) -> Job[ResonanceCurve]:
    """`resonance_curve` as a job. Raises what is known beforehand: CaseError, Refusal, ImpossibleMechanism."""
    checked_scenes(case, varied, speed, measures)
    arguments = (case, varied, speed, tuple(measures), accuracy, claims)
    inputs = (case.scene, *arguments[1:])
    return Job(f"{case.name} reference", resonance_curve, arguments, "resonance curve", ("reference",), CODE, inputs)


def resonance_curve(
    case: Case,
    varied: Range,
    speed: float | None = None,
    measures: Sequence[str] = (USUAL,),
    accuracy: float | None = None,
    claims: bool = True,
) -> ResonanceCurve:
    """The curve of a case's periodic motion.

    Args:
        case: the machine.
        varied: what varies.
        speed: of the crank, prescribed, rad/s; None: that of the case's own drive, unless the speed itself varies.
        measures: what to measure, names of `PEAKS`; peaks are those of the first.
        accuracy: relative, for which the model's modes are chosen; None: that of `reference`.
        claims: whether the error of every point is estimated, which takes a fifth of the time.

    Raises:
        CaseError, Refusal, ImpossibleMechanism: something cannot be.
        EngineFailure: no periodic motion was found anywhere in the range.
    """
    scene_at, engine = checked_scenes(case, varied, speed, measures), ReferenceEngine()
    settings = engine.settings_for(accuracy or engine.default_accuracy, scene_at(varied.high))
    comparison = engine.comparisons(settings, scene_at(varied.high), case.output_step)[0]
    other = comparison.other
    assert isinstance(other, ReferenceSettings)
    family = CycleFamily(scene_at, settings.modes, INTEGRATION)
    found = _followed(family, varied)
    finer = CycleFamily(scene_at, other.modes, other.tolerance) if claims else None
    rows = [_measured(each, family, finer, measures, abs(comparison.factor - 1.0)) for each in _told(found.points, "measuring")]
    taken = {name: np.array([row.measures[name] for row in rows]) for name in measures}
    value_errors = np.array([row.value_error for row in rows])
    special = [
        SpecialPoint(
            each.special,
            each.parameter,
            _tolerance(found.points, at),
            None if math.isnan(rows[at].value_error) else rows[at].value_error,
            at,
        )
        for at, each in enumerate(found.points)
        if each.special
    ]
    for at, ending in zip((0, len(rows) - 1), found.endings, strict=True):
        if ending is not None:
            kind = "slider left" if ending.left else "lost"
            special.append(SpecialPoint(kind, ending.parameter, ending.tolerance, None, at, ending.reason))
    return ResonanceCurve(
        case=case.name,
        range=varied,
        prescribed=case.mechanism.crank_is_free and not scene_at(varied.low).crank_is_free,
        values=np.array([each.parameter for each in found.points]),
        arclength=np.array([each.arclength for each in found.points]) - found.points[0].arclength,
        measures=taken,
        errors={name: np.array([row.errors[name] for row in rows]) for name in measures},
        value_errors=value_errors,
        multipliers=np.array([[each.multipliers[0].real, each.multipliers[0].imag] for each in found.points]),
        kinds=tuple(each.instability for each in found.points),
        special=tuple(sorted(special, key=lambda each: each.at)),
        peaks=tuple(_peaks(found.points, taken[measures[0]], scene_at)),
        settings={"modes": settings.modes, "finer_modes": other.modes, "tolerance": INTEGRATION},
    )


@dataclass(frozen=True)
class _Row:
    """What is measured at a point, with claims."""

    measures: dict[str, float]
    errors: dict[str, float]
    value_error: float


def _check(scene: Mechanism) -> None:
    """Refusal: a scene whose cycle is no map that can be differentiated."""
    engine = ReferenceEngine()
    engine.check(scene)
    if scene.follower.is_rigid:
        raise Refusal("a resonance curve needs a follower that bends; give a finite follower.bending_stiffness")
    if engine.opens_loop(scene):
        raise Refusal(
            "a resonance curve needs a slider joint that is rigid and frictionless; leave its stiffness, clearance and friction out"
        )


def _followed(family: CycleFamily, varied: Range) -> Branch:
    """The branch through the first periodic motion that is found within the range. EngineFailure: none is found."""
    reasons = []
    for value in np.linspace(varied.low, varied.high, SEARCHES).tolist():
        try:
            return branch(family, family.orbit(value), value, varied.low, varied.high)
        except (NoPeriodicOrbit, CycleBroken, NotConverged) as reason:
            reasons.append(f"at {value / varied.size:.4g} {varied.unit}: {reason}")
    raise EngineFailure(0.0, f"no periodic motion was found within the range ({reasons[0]})", "try another range")


def _measured(point: BranchPoint, family: CycleFamily, finer: CycleFamily | None, measures: Sequence[str], factor: float) -> _Row:
    """The measures of a point, and claims: the difference to the finer family's point (equation 10.13) over `factor`."""
    here = _taken(family, point.point, point.parameter, measures)
    row = _Row({name: value for name, (value, _) in here.items()}, dict.fromkeys(measures, math.nan), math.nan)
    if finer is None:
        return row
    try:
        there, parameter = finer.nearest(point)
        other = _taken(finer, there, parameter, measures)
    except (CycleBroken, NotConverged):
        return row
    errors = {name: abs(other[name][0] - value) / factor + rest for name, (value, rest) in here.items()}
    return replace(row, errors=errors, value_error=abs(parameter - point.parameter) / factor)


def _taken(family: CycleFamily, point: Array, value: float, measures: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Each measure, and how far off the rows of the cycle leave it."""
    columns = family.columns(point, value, ROWS)
    time = columns["time"]
    found = {}
    for name in measures:
        least, greatest = extremes(time, columns[PEAKS[name]], time[0], time[-1])
        largest = max(least, greatest, key=lambda each: abs(each.value))
        found[name] = abs(largest.value), largest.uncertainty
    return found


def _tolerance(points: Sequence[BranchPoint], at: int) -> float:
    """By how much the parameter of a special point may be missed: see `FOLD_TOLERANCE` and `MULTIPLIER_TOLERANCE`."""
    here, before, after = points[at], points[at - 1], points[at + 1]
    if here.special == "fold":
        return FOLD_TOLERANCE * here.width
    change = abs(abs(after.multipliers[0]) - abs(before.multipliers[0]))
    return MULTIPLIER_TOLERANCE / change * abs(after.parameter - before.parameter) if change > 0.0 else math.inf


def _peaks(points: Sequence[BranchPoint], heights: Array, scene_at: Callable[[float], Mechanism]) -> Iterator[ResonancePeak]:
    """Local maxima between the points, by the parabola of the logarithms of three."""
    log = np.log(heights)
    for at in find_peaks(log, prominence=math.log(PROMINENT))[0].tolist():
        near = slice(at - 1, at + 2)
        along = np.array([each.arclength for each in points[near]])
        value, height = (np.polyfit(along - along[1], numbers, 2) for numbers in (np.array([p.parameter for p in points[near]]), log[near]))
        top = float(np.clip(-height[1] / (2.0 * height[0]), along[0] - along[1], along[2] - along[1]))
        parameter = float(np.polyval(value, top))
        known = resonance(scene_at(parameter))
        yield ResonancePeak(parameter, math.exp(float(np.polyval(height, top))), at, known.harmonic if known else 0)


def _told(points: Sequence[BranchPoint], phase: str) -> Iterator[BranchPoint]:
    """The points, one after the other, as whoever listens is told."""
    for number, point in enumerate(points, 1):
        progress.tell(phase=f"{phase} point {number} of {len(points)}")
        yield point
