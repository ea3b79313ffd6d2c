"""What a column looks like after the usual mistakes, and which of them a given column shows."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from cases.conformance.checks import Array, percent
from engines.relative import rms
from reference_model.columns import COLUMNS
from reference_model.mechanism import Mechanism

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
#: Rows by which a column may come late or early.
_LAGS: Final = (1, -1, 2, -2, 3)
#: A mistake explains a column if it leaves no more than this part of the difference.
EXPLAINED: Final = 0.15
#: Of a coarse engine, whose own error is in the way, it must leave less than this part, and no more than that of the column.
_EXPLAINED_COARSELY: Final = (0.4, 0.6)
#: How far a model that says nothing of its own error may be off in the mild scene, relative to the column: one cubic is 43 % off in a
#: strain there.
HOPELESS: Final = 1.2


@dataclass(frozen=True)
class Suspect:
    """A mistake: what it is, what to do, what the column would be with it, and whether a coarse engine cannot come out like that."""

    cause: str
    advice: str
    values: Array
    gross: bool = True


@dataclass(frozen=True)
class Finding:
    """What is wrong with a column; `explained`: whether a mistake was found that makes it."""

    cause: str
    advice: str
    explained: bool


def diagnose(
    name: str, found: Array, expected: Array, tolerance: float | None, beside: Mapping[str, Array], mechanism: Mechanism
) -> Finding | None:
    """What is wrong with a column, or None.

    Args:
        name: of the column.
        found: what the engine gives.
        expected: what it should be.
        tolerance: by how much it may be off, in its unit; None: the engine does not say.
        beside: the right columns, among which it may have been exchanged.
        mechanism: the scene.
    """
    off, size = rms(found - expected), rms(expected)
    if size == 0.0:
        return None
    within = tolerance is not None and off <= tolerance
    claims = tolerance is not None and not within
    candidates = [suspect for suspect in _suspects(name, expected, beside, mechanism) if suspect.gross or claims]
    best = min(candidates, key=lambda suspect: _left(found, suspect.values))
    left = rms(found - best.values)
    if not claims:
        share, most = _EXPLAINED_COARSELY
        if left <= share * off and _left(found, best.values) <= most and off > 0.2 * size:
            return Finding(best.cause, best.advice, True)
        if within or off < HOPELESS * size:
            return None
    allowed = 0.0 if tolerance is None else tolerance * rms(best.values) / size
    if left <= max(EXPLAINED * off, min(allowed, 0.5 * off)):
        return Finding(best.cause, best.advice, True)
    claimed = "" if tolerance is None else f", by its own estimate it may be {percent(tolerance / size)} off"
    whole = f"{name} is {percent(off / size)} off{claimed}"
    return _fitted(name, found, expected, off) or Finding(whole, "compare it with reference where it departs first", False)


def _left(found: Array, values: Array) -> float:
    size = rms(values)
    return rms(found - values) / size if size > 0.0 else math.inf


def _fitted(name: str, found: Array, expected: Array, off: float) -> Finding | None:
    """A lag, a constant, or a factor that is no unit's, as far as it explains the column."""
    for rows in _LAGS:
        early, late = (found, expected) if rows > 0 else (expected, found)
        lag = abs(rows)
        if rms(early[lag:] - late[:-lag]) <= EXPLAINED * off:
            when = "late" if rows > 0 else "early"
            return Finding(
                f"{name} comes {lag} row{'s' if lag > 1 else ''} {when}",
                "take it at the instant of the row, after the last step, with everything derived brought up to date",
                True,
            )
    unit = COLUMNS[name].unit if name in COLUMNS else ""
    constant = float(np.mean(found - expected))
    if rms(found - expected - constant) <= EXPLAINED * off:
        size = f"{constant:.4g}" if unit in ("", "1") else f"{constant:.4g} {unit}"
        return Finding(f"{name} is {size} too large throughout", "look from where it is counted", True)
    factor = float(found @ expected / (expected @ expected))
    if rms(found - factor * expected) <= EXPLAINED * off:
        return Finding(f"{name} is {factor:.4g} times what it should be", "look for a factor or a quantity that is off by as much", True)
    return None


def _suspects(name: str, expected: Array, beside: Mapping[str, Array], mechanism: Mechanism) -> Iterator[Suspect]:
    unit = COLUMNS[name].unit
    yield Suspect(f"{name} has the wrong sign", f"turn it round: {COLUMNS[name].meaning}", -expected)
    yield Suspect(f"{name} is a size without sign", f"give it its sign: {COLUMNS[name].meaning}", np.abs(expected))
    for other, factor in UNITS.get(unit, {}).items():
        words, divide = f"{name} is in {other}, not in {unit if unit != '1' else 'parts of one'}", f"divide it by {factor:.6g}"
        yield Suspect(words, divide, factor * expected)
        yield Suspect(f"{words}, and has the wrong sign", f"{divide} and turn it round", -factor * expected)
        yield Suspect(f"{name} is converted from {other} though it comes in {unit}", f"multiply it by {factor:.6g}", expected / factor)
    for factor, word in ((2.0, "twice"), (0.5, "half")):
        yield Suspect(f"{name} is {word} what it should be", f"look for a factor of 2: {COLUMNS[name].meaning}", factor * expected, False)
    for other, column in COLUMNS.items():
        if other != name and other in beside and column.unit == unit and column.required:
            for sign, minus in ((1.0, ""), (-1.0, "minus ")):
                yield Suspect(f"{name} holds {minus}{other}", f"exchange them: {name} is {COLUMNS[name].meaning}", sign * beside[other])
    yield from _of_column(name, expected, beside, mechanism)


def _of_column(name: str, y: Array, beside: Mapping[str, Array], mechanism: Mechanism) -> Iterator[Suspect]:
    """Mistakes that only one column can have."""
    d, thickness = mechanism.pivot_distance, mechanism.follower.thickness
    if name in ("crank_angle", "follower_angle"):
        runs_on = "let it run on from row to row: numpy.unwrap"
        wrapped = (y + np.pi) % (2.0 * np.pi) - np.pi
        for interval, values in (("-180 to 180", wrapped), ("0 to 360", y % (2.0 * np.pi))):
            if not np.allclose(values, y):
                yield Suspect(f"{name} is wrapped to {interval} degrees", runs_on, values)
                yield Suspect(f"{name} is in degrees and wrapped to {interval}", f"convert it and {runs_on}", np.degrees(values))
        yield Suspect(f"{name} is counted from the start", f"add its value at the start, {y[0]:.4g} rad", y - y[0])
        yield Suspect(f"{name} is counted from -n1, half a turn off", "add pi", y - np.pi)
        yield Suspect(f"{name} is a turn too small", "it lies within 90 deg of 180 deg at the start", y - 2.0 * np.pi)
        yield Suspect(f"{name} is a turn too large", "it lies within 90 deg of 180 deg at the start", y + 2.0 * np.pi)
    crank = mechanism.crank.length
    if "crank_angle" not in beside:
        return
    across = np.array([crank * np.cos(beside["crank_angle"]) - d, crank * np.sin(beside["crank_angle"])])
    if name == "follower_angle":
        yield Suspect(
            "follower_angle is the direction from the pivot to the slider, not of the tangent at the base",
            "take the angle of the base body",
            np.arctan2(across[1], across[0]) % (2.0 * np.pi),
        )
        tip = np.arctan2(beside["tip_y"], beside["tip_x"] - d) % (2.0 * np.pi)
        yield Suspect("follower_angle is the direction from the pivot to the tip", "take the angle of the base body", tip)
    if name == "slider_position":
        chord = "slider_position is the straight distance from the pivot, not the arc length"
        yield Suspect(chord, "integrate along the bent centre line", np.hypot(*across))
        yield Suspect("slider_position is counted from the tip", "subtract it from the length", mechanism.follower.length - y)
        yield Suspect("slider_position is counted from its place at the start", "add that", y - y[0])
    if name == "tip_x":
        yield Suspect("tip_x is counted from P, not from O", "add the pivot distance", y - d)
    if name == "tip_deflection":
        q2, place = beside["follower_angle"], (beside["tip_x"] - d, beside["tip_y"])
        along, aside = across / np.hypot(*across)
        yield Suspect(
            "tip_deflection is measured from the line through pivot and slider, not from the tangent at the base",
            "measure along b2, the normal of the base tangent",
            along * place[1] - aside * place[0],
        )
        rigid = np.sin(np.unwrap(q2)) * mechanism.follower.length
        yield Suspect("tip_deflection is measured along n2, not along b2", "turn it into the base frame", place[1] - rigid)
    if name.startswith("strain"):
        curvature = "multiply the curvature by half the thickness"
        yield Suspect(f"{name} is the curvature, not the surface strain", curvature, 2.0 * y / thickness)
        yield Suspect(f"{name} is minus the curvature, not the surface strain", curvature, -2.0 * y / thickness)
    if name == "tip_acceleration":
        yield from _accelerations(beside, d)


def _accelerations(beside: Mapping[str, Array], d: float) -> Iterator[Suspect]:
    """Other accelerations of the tip that an engine may have at hand; from second differences of its place."""
    step = float(beside["time"][1] - beside["time"][0])
    x, place_y, q2 = beside["tip_x"], beside["tip_y"], np.unwrap(beside["follower_angle"])
    a = np.gradient(np.gradient([x, place_y], step, axis=1), step, axis=1)
    along, across = np.cos(q2) * a[0] + np.sin(q2) * a[1], np.cos(q2) * a[1] - np.sin(q2) * a[0]
    relative = np.gradient(np.gradient(beside["tip_deflection"], step), step)
    absolute = "take the absolute acceleration along the beam's normal at the tip"
    for words, values in (
        ("relative to the base frame: the second derivative of the deflection", relative),
        ("without the tip's turning: what the base frame's rotation alone gives", across - relative),
        ("along n1", a[0]),
        ("along n2", a[1]),
        ("along the tangent, not along the normal", along),
        ("the size of the vector, without sign", np.hypot(*a)),
        ("without the centripetal part of a turning frame: twice differentiated in polar coordinates", _polar(x - d, place_y, step)),
    ):
        yield Suspect(f"tip_acceleration is {words}", absolute, values)


def _polar(x: Array, y: Array, step: float) -> Array:
    """Distance times angular acceleration of a place."""
    angle = np.unwrap(np.arctan2(y, x))
    return np.hypot(x, y) * np.gradient(np.gradient(angle, step), step)
