"""The usual mistakes in a column of a trajectory, with the values that each of them gives.

A mistake without a number of its own (a unit, a sign, another column) is one kind, a mistake with a fitted factor or offset another: the
first is tried before the second. Every prediction here is made from right values, so that none of them knows what was found, except for the
fitted numbers.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from quickreturn.cases.mistakes.explanation import Hypothesis
from quickreturn.cases.units import in_si
from quickreturn.engines.relative import rms
from quickreturn.reference_model.columns import BEARINGS, COLUMNS, SHAPE
from quickreturn.reference_model.mechanism import Mechanism, Scene

Array = NDArray[np.float64]

#: Digits at the end of a name, which number columns of one kind.
DIGITS: Final = "0123456789"
#: Largest range of a column that is the same in every row, as a part of its value.
_CONSTANT: Final = 1e-3
#: Number of rows up to which no rate is taken.
_FEWEST: Final = 3
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


def usual_mistakes(name: str, expected: Array, right: Mapping[str, Array], mechanism: Scene) -> Iterator[Hypothesis]:
    """The mistakes in a column that need no fitted number; arguments as for `diagnosis.diagnose`."""
    for mistake in _mistakes(name, expected, right, mechanism):
        yield mistake if mistake.size is not None else replace(mistake, size=rms(mistake.prediction))


def fitted_mistakes(name: str, found: Array, expected: Array) -> Iterator[Hypothesis]:
    """The mistakes in a column with one fitted number; `found`: the column as it is, shape (n,), the rest as above."""
    unit = COLUMNS[name].unit
    constant, whole = float(np.mean(found - expected)), float(np.mean(found))
    told, advice = _too_large(constant, unit), "look from where it is counted"
    yield Hypothesis(f"is {told} throughout", advice, expected + constant, fitted=1, size=_swing(expected))
    if np.ptp(found) <= _CONSTANT * abs(whole):
        everywhere = np.full_like(found, whole)
        yield Hypothesis(f"is {_with_unit(whole, unit)} in every row", "fill it", everywhere, fitted=1, gross=False, size=abs(whole))
    advice = "look for a factor or a quantity that is off by as much"
    factor = _factor(found, expected)
    predicted = factor * expected
    yield Hypothesis(f"is off by a plain factor of {factor:.4g}", advice, predicted, fitted=1, size=rms(predicted))


def _swing(values: Array) -> float:
    """RMS of a column about its mean: a constant that is added must leave little of that, whatever the mean."""
    return rms(values - np.mean(values))


class _KnownFactor(NamedTuple):
    """A factor on a column that has a cause."""

    factor: float
    words: str  # the cause
    advice: str
    gross: bool = True  # as in `Hypothesis`


def _known_factors(name: str) -> Iterator[_KnownFactor]:
    """The factors that a wrong sign, a wrong unit or a forgotten half give to a column."""
    unit, meaning = COLUMNS[name].unit, COLUMNS[name].meaning
    yield _KnownFactor(-1.0, "has the wrong sign", f"turn it round: {meaning}")
    sizes = {other: 1.0 / in_si(read) for other, read in _UNITS.get(unit, {}).items()}
    for other, factor in sizes.items():
        words, divide = f"is in {other}, not in {unit if unit != '1' else 'parts of one'}", _divided_by(factor)
        yield _KnownFactor(factor, words, divide)
        yield _KnownFactor(-factor, f"{words}, and has the wrong sign", f"{divide} and turn it round")
    for other, factor in sizes.items():  # after all units, as 1 kN = 1e6 mN: a column in kN is not one converted from mN
        yield _KnownFactor(1.0 / factor, f"is converted from {other} though it comes in {unit}", _divided_by(1.0 / factor))
    for factor, word in ((2.0, "twice"), (0.5, "half")):
        yield _KnownFactor(factor, f"is {word} what it should be", f"look for a factor of 2: {meaning}", gross=False)


def _divided_by(factor: float) -> str:
    return f"divide it by {factor:.6g}" if factor > 1.0 else f"multiply it by {1.0 / factor:.6g}"


def _factor(found: Array, values: Array) -> float:
    """The factor by which values come nearest to what is found; 0 if they are zero."""
    return float(found @ values / (values @ values)) if np.any(values) else 0.0


def _with_unit(value: float, unit: str) -> str:
    return f"{value:.4g}{'' if unit == '1' else f' {unit}'}"


def _too_large(constant: float, unit: str) -> str:
    return f"{_with_unit(abs(constant), unit)} too {'large' if constant > 0.0 else 'small'}"


class _Other(NamedTuple):
    """Other values that may stand in a column."""

    words: str  # what they are
    values: Array  # shape (n,)
    gross: bool  # whether a coarse engine without a mistake cannot give them


def _other_columns(name: str, right: Mapping[str, Array]) -> Iterator[_Other]:
    """Right values of other columns that may stand in a column, those of its unit first, and rates of columns."""
    unit = COLUMNS[name].unit
    columns = [other for other in COLUMNS if other in right and other != "time"]
    family = BEARINGS if name in BEARINGS else [other for other in columns if other.rstrip(DIGITS) == name.rstrip(DIGITS)]
    alike = [other for other in columns if COLUMNS[other].required or other in family]
    for other in sorted(alike, key=lambda other: COLUMNS[other].unit != unit):
        if other != name:
            # numbered columns of neighbouring places resemble each other in a coarse engine
            yield _Other(f"holds {other}", right[other], COLUMNS[other].unit == unit and COLUMNS[other].required)
    if len(right.get("time", ())) <= _FEWEST:
        return
    rates = dict(
        zip(alike, CubicSpline(right["time"], np.column_stack([right[other] for other in alike]))(right["time"], 1).T, strict=True)
    )
    for other, values in rates.items():
        yield _Other(f"is the rate of {other}", values, False)
    if name == "tip_acceleration":
        normal = np.cos(right["follower_angle"]) * rates["tip_y"] - np.sin(right["follower_angle"]) * rates["tip_x"]
        yield _Other("is the velocity of the tip along the follower's normal", normal, False)


def _shares(name: str, right: Mapping[str, Array]) -> Iterator[tuple[str, Array]]:
    """Parts that a column may lack or contain besides, in words and values: columns of its unit, the slider's part of a bearing force."""
    if name in BEARINGS and "slider_force" in right:
        body, axis = name.split("_")[0], name[-1]
        part = {"x": -np.sin(right["follower_angle"]), "y": np.cos(right["follower_angle"])}[axis] * right["slider_force"]
        yield (
            f"the slider's part, {'minus ' if body == 'pivot' else ''}the slider force along n{1 if axis == 'x' else 2}",
            (-part if body == "pivot" else part),
        )
    line = ("tip_deflection", *SHAPE)  # nobody subtracts the deflection of one place from that of another
    for other, column in COLUMNS.items():
        family = other.rstrip(DIGITS) == name.rstrip(DIGITS) or (name in line and other in line)
        if other in right and column.unit == COLUMNS[name].unit and not family and other != "time":
            yield other, right[other]


def _mistakes(name: str, expected: Array, right: Mapping[str, Array], mechanism: Scene) -> Iterator[Hypothesis]:
    unit, meaning = COLUMNS[name].unit, COLUMNS[name].meaning
    yield Hypothesis("is a size without sign", f"give it its sign: {meaning}", np.abs(expected))
    for factor, words, advice, gross in _known_factors(name):
        yield Hypothesis(words, advice, factor * expected, gross=gross)
    yield Hypothesis("is zero in every row", f"fill it, or leave it out: {meaning}", np.zeros_like(expected), gross=False)
    for other in _other_columns(name, right):
        verb, _, what = other.words.partition(" ")
        for sign, minus in ((1.0, ""), (-1.0, "minus ")):
            advice = f"exchange them: {name} is {meaning}" if verb == "holds" else f"give {meaning}"
            yield Hypothesis(f"{verb} {minus}{what}", advice, sign * other.values, gross=other.gross)
    size = rms(expected)
    for share, values in _shares(name, right):
        for sign, words in ((-1.0, f"lacks {share}"), (1.0, f"contains {share} besides")):
            yield Hypothesis(words, f"{name} is {meaning}", expected + sign * values, gross=False, size=size)
    if name in ("crank_angle", "follower_angle"):
        yield from _of_angles(expected)
    if unit == "1":
        for sign, minus in ((1.0, ""), (-1.0, "minus ")):
            words = f"is {minus}the curvature, not the surface strain"
            yield Hypothesis(words, "multiply the curvature by half the thickness", sign * expected / mechanism.follower.extreme_fibre)
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
        yield Hypothesis("is counted from its place at the start", "add that", expected - expected[0], size=_swing(expected))
    if name == "slider_force":
        yield from _forces(expected, right, mechanism)
    if name == "tip_x":
        yield Hypothesis("is counted from P, not from O", "add the pivot distance", expected - d, size=_swing(expected))
    if name == "tip_deflection":
        along, aside = across / np.hypot(*across)
        chord = "is measured from the line through pivot and slider, not from the tangent at the base"
        yield Hypothesis(chord, "measure along b2, the normal of the base tangent", along * tip[1] - aside * tip[0])
        rigid = np.sin(q2) * mechanism.follower.length
        yield Hypothesis("is measured along n2, not along b2", "turn it into the base frame", tip[1] - rigid)
    if name == "tip_acceleration":
        yield from _accelerations(right["time"], tip, right["tip_deflection"])


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
    runs_on, start = "let it run on from row to row: numpy.unwrap", f"it is {y[0]:.4g} rad at the start"
    for interval, values in (("-180 to 180", (y + np.pi) % (2.0 * np.pi) - np.pi), ("0 to 360", y % (2.0 * np.pi))):
        if not np.allclose(values, y):
            yield Hypothesis(f"is wrapped to {interval} degrees", runs_on, values)
            yield Hypothesis(f"is in degrees and wrapped to {interval}", f"convert it and {runs_on}", np.degrees(values))
    for words, advice, added in (
        ("is counted from the start", f"add its value at the start, {y[0]:.4g} rad", -y[0]),
        ("is counted from -n1, half a turn off", "add pi", -np.pi),
        ("is a turn too small", start, -2.0 * np.pi),
        ("is a turn too large", start, 2.0 * np.pi),
    ):
        yield Hypothesis(words, advice, y + added, size=_swing(y))


def _accelerations(time: Array, tip: Array, deflection: Array) -> Iterator[Hypothesis]:
    """Hypotheses of other accelerations of the tip, from second differences of its place."""

    def twice(values: Array) -> Array:
        return np.asarray(np.gradient(np.gradient(values, time, axis=-1), time, axis=-1))

    a = twice(tip)
    for words, values in (
        ("relative to the base frame: the second derivative of the deflection", twice(deflection)),
        ("along n1", a[0]),
        ("along n2", a[1]),
        ("the size of the vector, without sign", np.hypot(*a)),
    ):
        yield Hypothesis(f"is {words}", "take the absolute acceleration along the beam's normal at the tip", values)


def _direction(place: Array) -> Array:
    return np.asarray(np.unwrap(np.arctan2(place[1], place[0]) % (2.0 * np.pi)))
