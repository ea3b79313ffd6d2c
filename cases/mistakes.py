"""Columns with the usual mistakes, and the mistake in a given column."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from quickreturn.cases.explanation import Hypothesis, explain
from quickreturn.cases.units import in_si
from quickreturn.engines.relative import rms
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Mechanism, Scene

Array = NDArray[np.float64]

#: Digits at the end of a name, which number columns of one kind.
_DIGITS: Final = "0123456789"
#: Lateness that is tried, in rows, negative if early; the last is the largest.
_LAGS: Final = (1, -1, 2, -2, 3)
#: Part of a row; a column that is less late is in time.
_NOT_LATE: Final = 0.05
#: Advice for a late column.
IN_TIME: Final = "take it at the instant of the row, after the last step, with everything derived brought up to date"
#: SI unit -> other unit in words -> the same as `in_si` reads it.
_UNITS: Final[dict[str, dict[str, str]]] = {
    "s": {"milliseconds": "ms", "minutes": "min"},
    "m": {"millimetres": "mm", "centimetres": "cm", "inches": "in", "feet": "ft"},
    "rad": {"degrees": "deg", "turns": "turn"},
    "rad/s": {"degrees per second": "deg/s", "rpm": "rpm", "turns per second (Hz)": "turn/s"},
    "m/s^2": {"millimetres/s^2": "mm/s^2", "inches/s^2": "in/s^2", "g": "g0"},
    "1": {"percent": "percent", "microstrain": "microstrain"},
    "N": {"millinewtons": "mN", "kilonewtons": "kN", "pounds": "lbf"},
    "N m": {"newton millimetres": "N*mm", "inch pounds": "lbf*in"},
    "J": {"millijoules": "mJ", "inch pounds": "lbf*in"},
}
#: Least difference of a column, relative to its size, that is explained if the engine's own error is unknown.
_GROSS: Final = 0.2
#: Largest part of its column that a mistake of a coarse engine may leave.
_LEFT_OF_COLUMN: Final = 0.6
#: Relative error allowed in the mild scene for a model without an error estimate: one cubic is 43 % off in a strain there.
HOPELESS: Final = 1.2


@dataclass(frozen=True)
class Finding:
    """A mistake in a column."""

    cause: str  # in words
    advice: str  # what to do
    remainder: float | None = None  # RMS of the difference that it leaves, in the column's unit; None: no known mistake explains it
    fitted: bool = False  # whether a number in it was fitted

    @property
    def explained(self) -> bool:
        """Whether a known mistake explains it."""
        return self.remainder is not None


def diagnose(
    name: str,
    found: Array,
    expected: Array,
    tolerance: float | None,
    right: Mapping[str, Array],
    mechanism: Scene,
    more: Iterable[Hypothesis] = (),
) -> Finding | None:
    """The mistake in a column, or None.

    Args:
        name: of the column.
        found: the engine's values, shape (n,).
        expected: the right values.
        tolerance: allowed RMS error, in the column's unit; None: the engine does not say.
        right: right values of columns with which it may be exchanged: "time" and all that every engine delivers.
        mechanism: the scene.
        more: mistakes that depend on how the rows were recorded.
    """
    off, size = rms(found - expected), rms(expected)
    if size == 0.0:
        return None
    within = tolerance is not None and off <= tolerance
    beyond = tolerance is not None and not within
    tried = [mistake for mistake in (*_mistakes(name, expected, right, mechanism), *more) if mistake.gross or beyond]
    if not beyond:
        seen = [mistake for mistake in tried if rms(found - mistake.prediction) <= _LEFT_OF_COLUMN * rms(mistake.prediction)]
        coarsely = explain(found, expected, seen, coarse=True) if off > _GROSS * size else None
        if coarsely is not None:
            return Finding(f"{name} {coarsely.words}", coarsely.advice, coarsely.remainder)
        if within or off < HOPELESS * size or not (COLUMNS[name].required or name == name.rstrip(_DIGITS)):
            return None
    explained = explain(found, expected, [*tried, *_fitted(name, found, expected)], tolerance or 0.0)
    if explained is not None:
        return Finding(f"{name} {explained.words}", explained.advice, explained.remainder, explained.fitted)
    claimed = "" if tolerance is None else f", by its own estimate it may be off by {share_of(tolerance / size)}"
    return Finding(f"{name} is off by {share_of(off / size)}{claimed}", "compare it with reference where it departs first")


def share_of(share: float, of: str = "its size") -> str:
    """A share with two digits: in per cent, or from 2 on as a multiple of `of`."""
    if share >= 2.0:
        return f"{_two_digits(share)} times {of}"
    return f"{_two_digits(100.0 * share)} %"


def _two_digits(number: float) -> str:
    """Two digits, without an exponent unless the number is tiny."""
    text = f"{number:.2g}"
    return f"{float(text):.0f}" if "e+" in text else text


def _fitted(name: str, found: Array, expected: Array) -> Iterator[Hypothesis]:
    """Hypotheses of a constant offset, and of a factor that is not that of a unit."""
    unit, constant = COLUMNS[name].unit, float(np.mean(found - expected))
    size = f"{abs(constant):.4g}{'' if unit == '1' else f' {unit}'} too {'large' if constant > 0.0 else 'small'}"
    yield Hypothesis(f"is {size} throughout", "look from where it is counted", expected + constant, fitted=True)
    factor = float(found @ expected / (expected @ expected))
    words, advice = f"is {factor:.4g} times what it should be", "look for a factor or a quantity that is off by as much"
    yield Hypothesis(words, advice, factor * expected, fitted=True)


def lateness(found: Array, expected: Array, at: Array | None = None, fine: Array | None = None) -> Iterator[Hypothesis]:
    """Hypotheses of a column that comes late or early by whole rows, or by a part of a row.

    Args:
        found: the column's values, shape (n,).
        expected: the right values, in evenly spaced rows.
        at: index of each row of `found` among the rows of `fine`, and its shift for a lateness of one row, shape (2, n); None: row for row.
        fine: right values in finer rows, from which late ones are interpolated; None: `expected`.
    """
    source = expected if fine is None else fine
    spline, last = CubicSpline(np.arange(len(source)), source), len(source) - 1
    place, moved = np.array([np.arange(len(found)), np.ones(len(found))]) if at is None else at

    def by(lag: float) -> Array:
        return np.asarray(spline(np.clip(place - lag * moved, 0, last)))

    def left(lag: float) -> float:
        return rms((found - by(lag))[_LAGS[-1] : -_LAGS[-1]])

    for lag in _LAGS:
        yield Hypothesis(_comes(lag), IN_TIME, by(lag))
    lags = np.linspace(-_LAGS[-1], _LAGS[-1], 8 * _LAGS[-1] + 1)
    nearest = float(min(lags, key=left))
    part = float(minimize_scalar(left, bounds=(nearest - 0.25, nearest + 0.25), method="bounded").x)
    if abs(part) > _NOT_LATE:
        yield Hypothesis(_comes(part), IN_TIME, by(part), fitted=True)


def _comes(lag: float) -> str:
    """Lateness in rows as a clause; "early" if it is negative."""
    return f"comes {abs(lag):.2g} row{'' if abs(lag) == 1 else 's'} {'late' if lag > 0 else 'early'}"


def _mistakes(name: str, expected: Array, right: Mapping[str, Array], mechanism: Scene) -> Iterator[Hypothesis]:
    """The usual mistakes in a column, with the values that each would give; arguments as for `diagnose`."""
    unit, meaning = COLUMNS[name].unit, COLUMNS[name].meaning
    yield Hypothesis("has the wrong sign", f"turn it round: {meaning}", -expected)
    yield Hypothesis("is a size without sign", f"give it its sign: {meaning}", np.abs(expected))
    for other, read in _UNITS.get(unit, {}).items():
        factor = 1.0 / in_si(read)
        words, divide = f"is in {other}, not in {unit if unit != '1' else 'parts of one'}", f"divide it by {factor:.6g}"
        yield Hypothesis(words, divide, factor * expected)
        yield Hypothesis(f"{words}, and has the wrong sign", f"{divide} and turn it round", -factor * expected)
        yield Hypothesis(f"is converted from {other} though it comes in {unit}", f"multiply it by {factor:.6g}", expected / factor)
    for factor, word in ((2.0, "twice"), (0.5, "half")):
        yield Hypothesis(f"is {word} what it should be", f"look for a factor of 2: {meaning}", factor * expected, gross=False)
    for other, column in COLUMNS.items():
        alike = column.required or other.rstrip(_DIGITS) == name.rstrip(_DIGITS)
        if other != name and other in right and column.unit == unit and alike:
            for sign, minus in ((1.0, ""), (-1.0, "minus ")):
                words, exchange = f"holds {minus}{other}", f"exchange them: {name} is {meaning}"
                # numbered columns of neighbouring places resemble each other in a coarse engine
                yield Hypothesis(words, exchange, sign * right[other], gross=column.required)
    if name in ("crank_angle", "follower_angle"):
        yield from _of_angles(expected)
    if unit == "1":
        for sign, minus in ((2.0, ""), (-2.0, "minus ")):
            words = f"is {minus}the curvature, not the surface strain"
            yield Hypothesis(words, "multiply the curvature by half the thickness", sign * expected / mechanism.follower.thickness)
    if mechanism.crank is None:
        return
    crank, d = mechanism.crank.length, mechanism.pivot_distance
    across = np.array([crank * np.cos(right["crank_angle"]) - d, crank * np.sin(right["crank_angle"])])
    tip, q2 = np.array([right["tip_x"] - d, right["tip_y"]]), np.unwrap(right["follower_angle"])
    if name == "follower_angle":
        base = "take the angle of the base body"
        yield Hypothesis("is the direction from the pivot to the slider, not of the tangent at the base", base, _direction(across))
        yield Hypothesis("is the direction from the pivot to the tip", base, _direction(tip))
    if name == "slider_position":
        chord = "is the straight distance from the pivot, not the arc length"
        yield Hypothesis(chord, "integrate along the bent centre line", np.hypot(*across))
        yield Hypothesis("is counted from the tip", "subtract it from the length", mechanism.follower.length - expected)
        yield Hypothesis("is counted from its place at the start", "add that", expected - expected[0])
    if name == "slider_force":
        yield from _forces(expected, right, mechanism)
    if name == "tip_x":
        yield Hypothesis("is counted from P, not from O", "add the pivot distance", expected - d)
    if name == "tip_deflection":
        along, aside = across / np.hypot(*across)
        chord = "is measured from the line through pivot and slider, not from the tangent at the base"
        yield Hypothesis(chord, "measure along b2, the normal of the base tangent", along * tip[1] - aside * tip[0])
        rigid = np.sin(q2) * mechanism.follower.length
        yield Hypothesis("is measured along n2, not along b2", "turn it into the base frame", tip[1] - rigid)
    if name == "tip_acceleration":
        yield from _accelerations(right["time"], tip, q2, right["tip_deflection"])


def _forces(normal: Array, right: Mapping[str, Array], mechanism: Mechanism) -> Iterator[Hypothesis]:
    """Hypotheses of other forces of a slider with rollers or friction."""
    slider = mechanism.slider
    if not slider.is_rigid:
        for roller, values in (("plus", np.maximum(normal, 0.0)), ("minus", np.minimum(normal, 0.0))):
            yield Hypothesis(f"is that of the {roller} roller alone", "add the force of the other one", values)
    if slider.has_friction:
        acts = np.tanh(np.gradient(right["slider_position"], right["time"]) / slider.friction_speed)
        friction = (slider.friction_force + slider.friction * np.abs(normal)) * acts
        advice = "take the part along the follower's normal"
        yield Hypothesis("is the friction along the follower", advice, friction)
        yield Hypothesis("is the size of normal force and friction together", advice, np.hypot(normal, friction))


def _of_angles(y: Array) -> Iterator[Hypothesis]:
    runs_on, start = "let it run on from row to row: numpy.unwrap", "it lies within 90 deg of 180 deg at the start"
    for interval, values in (("-180 to 180", (y + np.pi) % (2.0 * np.pi) - np.pi), ("0 to 360", y % (2.0 * np.pi))):
        if not np.allclose(values, y):
            yield Hypothesis(f"is wrapped to {interval} degrees", runs_on, values)
            yield Hypothesis(f"is in degrees and wrapped to {interval}", f"convert it and {runs_on}", np.degrees(values))
    yield Hypothesis("is counted from the start", f"add its value at the start, {y[0]:.4g} rad", y - y[0])
    yield Hypothesis("is counted from -n1, half a turn off", "add pi", y - np.pi)
    yield Hypothesis("is a turn too small", start, y - 2.0 * np.pi)
    yield Hypothesis("is a turn too large", start, y + 2.0 * np.pi)


def _accelerations(time: Array, tip: Array, q2: Array, deflection: Array) -> Iterator[Hypothesis]:
    """Hypotheses of other accelerations of the tip, from second differences of its place."""

    def twice(values: Array) -> Array:
        return np.asarray(np.gradient(np.gradient(values, time, axis=-1), time, axis=-1))

    a, relative = twice(tip), twice(deflection)
    along, across = np.cos(q2) * a[0] + np.sin(q2) * a[1], np.cos(q2) * a[1] - np.sin(q2) * a[0]
    polar = np.hypot(*tip) * twice(np.unwrap(np.arctan2(tip[1], tip[0])))
    for words, values in (
        ("relative to the base frame: the second derivative of the deflection", relative),
        ("without the tip's turning: what the base frame's rotation alone gives", across - relative),
        ("along n1", a[0]),
        ("along n2", a[1]),
        ("along the tangent, not along the normal", along),
        ("the size of the vector, without sign", np.hypot(*a)),
        ("without the centripetal part of a turning frame: twice differentiated in polar coordinates", polar),
    ):
        yield Hypothesis(f"is {words}", "take the absolute acceleration along the beam's normal at the tip", values)


def _direction(place: Array) -> Array:
    return np.asarray(np.arctan2(place[1], place[0]) % (2.0 * np.pi))
