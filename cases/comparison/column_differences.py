"""Differences of a table from an engine, column by column: their size, their place and their cause, where one explains them."""

import math
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from quickreturn.cases.comparison.tables import GROWING, VIBRATING
from quickreturn.cases.motion.marching import channels_of
from quickreturn.cases.motion.request import NOTHING, Run
from quickreturn.cases.motion.settling import GRID, on_common_grid
from quickreturn.engines.relative import rms, scale

Array = NDArray[np.float64]

#: Least relative RMS difference of a column that needs an explanation.
LEAST_DIFFERENCE: Final = 0.02
#: Largest part of a difference that lateness may leave: a turn that does not repeat is taken to do so.
LATE: Final = 0.15
#: Least relative difference in the duration of a turn that is told: an engine that is 10 % off in the deflection keeps it to 1e-4.
SLOW: Final = 3e-3
#: Key of the sentence on a quantity of the scene, and of the sentence that nothing explains the difference.
QUANTITIES: Final = "quantities"
UNEXPLAINED: Final = "unexplained"
MOST_NAMED: Final = 6  # columns in that sentence


class Causes(NamedTuple):
    """What explains the differences of a table's columns.

    Attributes:
        plain: column -> a sentence on one plain relation to the engine's column; "crank_angle" -> that all columns are late; "time" -> that
            a turn takes longer or shorter.
        differing: column -> its relative difference, where `plain` has none; none if all are late.
        open: whether a quantity of the scene may explain them: most of the columns that vibrate differ, and are not all late alike.
    """

    plain: Mapping[str, str]
    differing: Mapping[str, float]
    open: bool

    def told(self, case: str, lead: str = "") -> dict[str, str]:
        """The sentences by column; `lead`: on a quantity of the scene."""
        if lead or not self.differing:
            return {**self.plain, **({QUANTITIES: lead} if lead else {})}
        least, most = (f"{100.0 * share:.0f} %" for share in (min(self.differing.values()), max(self.differing.values())))
        names = [*self.differing]
        few = ", ".join(names[:MOST_NAMED]) + (f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else "")
        quantity = f", and no single quantity of {case}," if self.open else ""
        off = most if least == most else f"{least} to {most}"
        return {**self.plain, UNEXPLAINED: f"no factor and no lateness{quantity} explains the difference of {few} (off by {off})"}


def column_differences(run: Run, other: Run) -> dict[str, float]:
    """RMS difference of each column that both have, over its `scale` in the other, at equal crank angles of the turn that was measured."""
    grids = _on_grid(run, other)
    right = {name: expected for name, (_, expected) in grids.items()}
    return {name: rms(recorded - expected) / scale(name, right) for name, (recorded, expected) in grids.items()}


def places(run: Run, other: Run) -> dict[str, float]:
    """Column -> crank angle, deg from 0 to 360, at which a table differs most from an engine."""
    first, last = other.cycle["crank_angle"][[0, -1]]
    angles = np.degrees(np.linspace(first, last, GRID, endpoint=False)) % 360.0
    return {name: float(angles[np.argmax(np.abs(recorded - expected))]) for name, (recorded, expected) in _on_grid(run, other).items()}


def causes(run: Run, other: Run) -> Causes:
    """What explains the differences of a table, whose run is `run`, from an engine in the same turn or state."""
    grids, off_by, plain = _on_grid(run, other), column_differences(run, other), dict[str, str]()
    vibrating = [name for name in grids if name in VIBRATING]
    if abs(later := float(np.ptp(run.cycle["time"]) / np.ptp(other.cycle["time"])) - 1.0) > SLOW:
        pace = f"{100.0 * abs(later):.2g} % {'longer' if later > 0.0 else 'shorter'}"
        plain["time"] = f"a turn of the crank takes {pace} in it than in {other.engine}"
    if lag := _common_lag([grids[name] for name in vibrating]):
        return Causes(plain | {"crank_angle": _sentence_of_lag(lag, run)}, {}, open=False)
    differing = {name: off for name, off in off_by.items() if off > LEAST_DIFFERENCE}
    is_open = 2 * len(differing.keys() & {*vibrating}) > len(vibrating)
    for name in [*differing]:
        if relation := _relation(*grids[name], run, other.engine):
            plain[name] = f"{name} {relation}"
            del differing[name]
    return Causes(plain, differing, is_open)


def _relation(recorded: Array, expected: Array, run: Run, engine: str) -> str:
    """The factor or the lateness that makes the engine's column the table's, as a clause; "": neither does."""
    factor = float(recorded @ expected / (expected @ expected))
    if factor and rms(recorded - factor * expected) <= LEAST_DIFFERENCE * abs(factor) * rms(expected):
        return f"is {factor:.4g} times that of {engine}"
    lag = _lag([(recorded, expected)])
    left = rms(recorded - _late(expected, lag))
    return f"is {_ms(lag, run)}" if left <= max(LEAST_DIFFERENCE * rms(expected), LATE * rms(recorded - expected)) else ""


def _common_lag(pairs: Sequence[tuple[Array, Array]]) -> float:
    """Lateness (rad of the crank) of all columns alike that explains their differences; 0: none.

    Offsets and factors of single columns do not count. `pairs`: recorded and expected values of two columns at least.
    """
    if len(pairs) < 2:
        return 0.0
    lag = _lag(pairs)
    apart, left = (math.sqrt(max(1.0 - _alike(pairs, each), 0.0)) for each in (0.0, lag))
    return 0.0 if apart < LEAST_DIFFERENCE or left > LATE * apart else lag


def _lag(pairs: Sequence[tuple[Array, Array]]) -> float:
    """Lateness of columns, rad of the crank from -pi to pi, negative if early: that with which they are most alike."""
    step = 2.0 * math.pi / GRID
    nearest = max(range(-GRID // 2, GRID // 2), key=_correlations(pairs).__getitem__) * step
    return float(minimize_scalar(lambda lag: -_alike(pairs, lag), bounds=(nearest - step, nearest + step), method="bounded").x)


def _correlations(pairs: Sequence[tuple[Array, Array]]) -> Array:
    """Mean squared correlation of columns for each lateness in points of the grid; those at the end are negative."""
    total = np.zeros(GRID)
    for recorded, expected in pairs:
        product = np.fft.irfft(np.fft.rfft(_about_mean(recorded)) * np.conj(np.fft.rfft(_about_mean(expected))), GRID)
        total += product**2
    return total / len(pairs)


def _alike(pairs: Sequence[tuple[Array, Array]], lag: float) -> float:
    """Mean squared correlation of columns when the expected ones are late; 1: alike but for factors and offsets."""
    return float(np.mean([(_about_mean(recorded) @ _about_mean(_late(expected, lag))) ** 2 for recorded, expected in pairs]))


def _about_mean(values: Array) -> Array:
    """A column less its mean, of length 1; zeros if it is constant."""
    apart = values - np.mean(values)
    return np.asarray(apart / (float(np.linalg.norm(apart)) or 1.0))


def _late(values: Array, lag: float) -> Array:
    """A column that repeats, on the grid, late by an angle of the crank, rad."""
    turned = 2.0 * math.pi * np.arange(GRID + 1) / GRID
    return np.asarray(CubicSpline(turned, np.append(values, values[0]))(np.mod(turned[:-1] - lag, 2.0 * math.pi)))


def _sentence_of_lag(lag: float, run: Run) -> str:
    """That all columns are late by an angle, rad, and how to take it off."""
    first, last = run.cycle["crank_angle"][[0, -1]]
    off = math.copysign(1.0, last - first) * math.degrees(lag)
    zero = f"crank_angle is about {abs(off):.3g} deg too {'large' if off > 0.0 else 'small'}"
    mend = f'"HEADING = crank_angle [deg] {"+" if off > 0.0 else "-"} {abs(off):.3g}"'
    return f"{zero}, or all other columns are {_ms(lag, run)}: --column {mend} takes it off"


def _ms(lag: float, run: Run) -> str:
    """Lateness by an angle of the crank, rad, in time."""
    ms = 1e3 * float(np.ptp(run.cycle["time"])) * abs(lag) / (2.0 * math.pi)
    return f"{ms:.3g} ms {'late' if lag > 0 else 'early'}"


def _on_grid(run: Run, other: Run) -> dict[str, tuple[Array, Array]]:
    """Columns that both have and that are not zero in the other, at even crank angles of the turn."""
    names = [name for name in run.cycle if name in other.cycle and name not in GROWING and other.peak(name) > NOTHING]
    recorded, expected = (on_common_grid(channels_of(each.cycle, names)) for each in (run, other))
    return {name: (recorded[name], expected[name]) for name in names}
