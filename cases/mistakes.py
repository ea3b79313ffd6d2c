"""What a column looks like after the usual mistakes, and which of them a given column shows."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engines.relative import rms
from reference_model.columns import COLUMNS
from reference_model.mechanism import Mechanism

Array = NDArray[np.float64]

_POUND: Final = 4.4482216152605  # N
_INCH: Final = 0.0254  # m
#: SI unit -> other unit -> its number for one SI unit.
UNITS: Final[dict[str, dict[str, float]]] = {
    "s": {"milliseconds": 1e3, "minutes": 1.0 / 60.0},
    "m": {"millimetres": 1e3, "centimetres": 1e2, "inches": 1.0 / _INCH, "feet": 1.0 / (12.0 * _INCH)},
    "rad": {"degrees": 180.0 / math.pi, "turns": 0.5 / math.pi},
    "rad/s": {"degrees per second": 180.0 / math.pi, "rpm": 30.0 / math.pi, "turns per second (Hz)": 0.5 / math.pi},
    "m/s^2": {"millimetres/s^2": 1e3, "inches/s^2": 1.0 / _INCH, "g": 1.0 / 9.80665},
    "1": {"percent": 1e2, "microstrain": 1e6},
    "N": {"millinewtons": 1e3, "kilonewtons": 1e-3, "pounds": 1.0 / _POUND},
    "N m": {"newton millimetres": 1e3, "inch pounds": 1.0 / (_POUND * _INCH)},
    "J": {"millijoules": 1e3, "inch pounds": 1.0 / (_POUND * _INCH)},
    "Hz": {"rad/s": 2.0 * math.pi, "rpm": 60.0, "kHz": 1e-3},
}
#: A mistake explains a column if it leaves no more than this part of the difference.
EXPLAINED: Final = 0.15
#: Of a coarse engine, whose own error is in the way, it must leave less than this part, and no more than that of the column.
_EXPLAINED_COARSELY: Final = (0.4, 0.6)
#: How far a model that says nothing of its own error may be off in the mild scene, relative to the column: one cubic is 43 % off in a
#: strain there.
HOPELESS: Final = 1.2


class Mistake(NamedTuple):
    """What it is, what to do, what the column would be with it, and whether a coarse engine cannot come out like that."""

    words: str
    advice: str
    values: Array
    gross: bool = True


@dataclass(frozen=True)
class Finding:
    """What is wrong with a column; `left`: what a mistake that makes it leaves of the difference, in its unit; None: none is known."""

    cause: str
    advice: str
    left: float | None = None

    @property
    def explained(self) -> bool:
        """Whether a mistake was found that makes it."""
        return self.left is not None


def diagnose(
    name: str, found: Array, expected: Array, tolerance: float | None, beside: Mapping[str, Array], mechanism: Mechanism
) -> Finding | None:
    """What is wrong with a column, or None.

    Args:
        name: of the column.
        found: what the engine gives, shape (n,).
        expected: what it should be.
        tolerance: by how much it may be off, in its unit; None: the engine does not say.
        beside: the right columns, among which it may have been exchanged; "time" and all that every engine delivers.
        mechanism: the scene.
    """
    off, size = rms(found - expected), rms(expected)
    if size == 0.0:
        return None
    within = tolerance is not None and off <= tolerance
    claims = tolerance is not None and not within
    candidates = [mistake for mistake in _mistakes(name, expected, beside, mechanism) if mistake.gross or claims]
    best = min(candidates, key=lambda mistake: _left(found, mistake.values))
    left = rms(found - best.values)
    finding = Finding(f"{name} {best.words}", best.advice, left)
    if not claims:
        share, most = _EXPLAINED_COARSELY
        if left <= share * off and _left(found, best.values) <= most and off > 0.2 * size:
            return finding
        if within or off < HOPELESS * size:
            return None
    allowed = 0.0 if tolerance is None else tolerance * rms(best.values) / size
    if left <= max(EXPLAINED * off, min(allowed, 0.5 * off)):
        return finding
    claimed = "" if tolerance is None else f", by its own estimate it may be {100.0 * tolerance / size:.2g} % off"
    whole = f"{name} is {100.0 * off / size:.2g} % off{claimed}"
    return _fitted(name, found, expected, off) or Finding(whole, "compare it with reference where it departs first")


def _left(found: Array, values: Array) -> float:
    size = rms(values)
    return rms(found - values) / size if size > 0.0 else math.inf


def _fitted(name: str, found: Array, expected: Array, off: float) -> Finding | None:
    """A constant, or a factor that is no unit's, if it explains the column."""
    unit, constant = COLUMNS[name].unit, float(np.mean(found - expected))
    size = f"{abs(constant):.4g}{'' if unit == '1' else f' {unit}'} too {'large' if constant > 0.0 else 'small'}"
    factor = float(found @ expected / (expected @ expected))
    for words, advice, values in (
        (f"is {size} throughout", "look from where it is counted", expected + constant),
        (f"is {factor:.4g} times what it should be", "look for a factor or a quantity that is off by as much", factor * expected),
    ):
        if (left := rms(found - values)) <= EXPLAINED * off:
            return Finding(f"{name} {words}", advice, left)
    return None


def _mistakes(name: str, expected: Array, beside: Mapping[str, Array], mechanism: Mechanism) -> Iterator[Mistake]:
    unit, meaning = COLUMNS[name].unit, COLUMNS[name].meaning
    yield Mistake("has the wrong sign", f"turn it round: {meaning}", -expected)
    yield Mistake("is a size without sign", f"give it its sign: {meaning}", np.abs(expected))
    for other, factor in UNITS.get(unit, {}).items():
        words, divide = f"is in {other}, not in {unit if unit != '1' else 'parts of one'}", f"divide it by {factor:.6g}"
        yield Mistake(words, divide, factor * expected)
        yield Mistake(f"{words}, and has the wrong sign", f"{divide} and turn it round", -factor * expected)
        yield Mistake(f"is converted from {other} though it comes in {unit}", f"multiply it by {factor:.6g}", expected / factor)
    for factor, word in ((2.0, "twice"), (0.5, "half")):
        yield Mistake(f"is {word} what it should be", f"look for a factor of 2: {meaning}", factor * expected, False)
    for other, column in COLUMNS.items():
        if other != name and other in beside and column.unit == unit and column.required:
            for sign, minus in ((1.0, ""), (-1.0, "minus ")):
                yield Mistake(f"holds {minus}{other}", f"exchange them: {name} is {meaning}", sign * beside[other])
    if name in ("crank_angle", "follower_angle"):
        yield from _of_angles(expected)
    crank, d, thickness = mechanism.crank.length, mechanism.pivot_distance, mechanism.follower.thickness
    across = np.array([crank * np.cos(beside["crank_angle"]) - d, crank * np.sin(beside["crank_angle"])])
    tip, q2 = np.array([beside["tip_x"] - d, beside["tip_y"]]), np.unwrap(beside["follower_angle"])
    if name == "follower_angle":
        base = "take the angle of the base body"
        yield Mistake("is the direction from the pivot to the slider, not of the tangent at the base", base, _direction(across))
        yield Mistake("is the direction from the pivot to the tip", base, _direction(tip))
    if name == "slider_position":
        chord = "is the straight distance from the pivot, not the arc length"
        yield Mistake(chord, "integrate along the bent centre line", np.hypot(*across))
        yield Mistake("is counted from the tip", "subtract it from the length", mechanism.follower.length - expected)
        yield Mistake("is counted from its place at the start", "add that", expected - expected[0])
    if name == "tip_x":
        yield Mistake("is counted from P, not from O", "add the pivot distance", expected - d)
    if name == "tip_deflection":
        along, aside = across / np.hypot(*across)
        chord = "is measured from the line through pivot and slider, not from the tangent at the base"
        yield Mistake(chord, "measure along b2, the normal of the base tangent", along * tip[1] - aside * tip[0])
        rigid = np.sin(q2) * mechanism.follower.length
        yield Mistake("is measured along n2, not along b2", "turn it into the base frame", tip[1] - rigid)
    if name.startswith("strain"):
        for sign, minus in ((2.0, ""), (-2.0, "minus ")):
            words = f"is {minus}the curvature, not the surface strain"
            yield Mistake(words, "multiply the curvature by half the thickness", sign * expected / thickness)
    if name == "tip_acceleration":
        yield from _accelerations(beside["time"], tip, q2, beside["tip_deflection"])


def _of_angles(y: Array) -> Iterator[Mistake]:
    runs_on, start = "let it run on from row to row: numpy.unwrap", "it lies within 90 deg of 180 deg at the start"
    for interval, values in (("-180 to 180", (y + np.pi) % (2.0 * np.pi) - np.pi), ("0 to 360", y % (2.0 * np.pi))):
        if not np.allclose(values, y):
            yield Mistake(f"is wrapped to {interval} degrees", runs_on, values)
            yield Mistake(f"is in degrees and wrapped to {interval}", f"convert it and {runs_on}", np.degrees(values))
    yield Mistake("is counted from the start", f"add its value at the start, {y[0]:.4g} rad", y - y[0])
    yield Mistake("is counted from -n1, half a turn off", "add pi", y - np.pi)
    yield Mistake("is a turn too small", start, y - 2.0 * np.pi)
    yield Mistake("is a turn too large", start, y + 2.0 * np.pi)


def _accelerations(time: Array, tip: Array, q2: Array, deflection: Array) -> Iterator[Mistake]:
    """Other accelerations of the tip that an engine may have at hand; from second differences of its place."""

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
        yield Mistake(f"is {words}", "take the absolute acceleration along the beam's normal at the tip", values)


def _direction(place: Array) -> Array:
    return np.asarray(np.arctan2(place[1], place[0]) % (2.0 * np.pi))
