"""Names the mistake in a column of a trajectory."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from quickreturn.cases.mistakes.explanation import Hypothesis, explain
from quickreturn.cases.mistakes.usual import DIGITS, fitted_mistakes, usual_mistakes
from quickreturn.engines.relative import rms, scale
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Scene

Array = NDArray[np.float64]

#: Lateness that is tried, in rows, negative if early; the last is the largest.
_LAGS: Final = (1, -1, 2, -2, 3)
#: Part of a row; a column that is less late is in time.
_NOT_LATE: Final = 0.05
#: Advice for a late column.
IN_TIME: Final = "take it at the instant of the row, after the last step, with everything derived brought up to date"

#: Least difference of a column, relative to its size, that is explained if the engine's own error is unknown.
_GROSS: Final = 0.2
#: Relative error allowed in the mild scene for a model without an error estimate: one cubic is 43 % off in a strain there.
HOPELESS: Final = 1.2
#: Size of a column, relative to the right one, that no model is too coarse for: a smaller one lacks a factor, or its numbers.
_LIFELESS: Final = 0.05


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
    off, size = rms(found - expected), scale(name, {**right, name: expected})
    if size == 0.0:
        return None
    within = tolerance is not None and off <= tolerance
    beyond = tolerance is not None and not within
    if within and off <= _GROSS * size:
        return None
    tried = [mistake for mistake in (*usual_mistakes(name, expected, right, mechanism), *more) if mistake.gross or beyond]
    if not beyond:
        coarsely = explain(found, expected, tried, coarse=True) if off > _GROSS * size else None
        if coarsely is not None:
            return Finding(f"{name} {coarsely.words}", coarsely.advice, coarsely.remainder)
        lifeless = rms(found) < _LIFELESS * size and off > (1.0 - _LIFELESS) * size
        if within or (off < HOPELESS * size and not lifeless) or not (COLUMNS[name].required or name == name.rstrip(DIGITS)):
            return None
    explained = explain(found, expected, [*tried, *fitted_mistakes(name, found, expected)], tolerance or 0.0)
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
        yield Hypothesis(_comes(part), IN_TIME, by(part), fitted=1)


def _comes(lag: float) -> str:
    """Lateness in rows as a clause; "early" if it is negative."""
    return f"comes {abs(lag):.2g} row{'' if abs(lag) == 1 else 's'} {'late' if lag > 0 else 'early'}"
