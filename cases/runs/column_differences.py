"""Differences of a table from an engine, column by column: their size, their place and their cause, where one explains them."""

import math
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from quickreturn.cases.case import Case
from quickreturn.cases.measures.steady_state import GRID, on_common_grid
from quickreturn.cases.mistakes.diagnosis import Finding, diagnose, share_of
from quickreturn.cases.mistakes.explanation import UNEXPLAINED, Hypothesis
from quickreturn.cases.runs.marching import channels_of
from quickreturn.cases.runs.noise import white_noise
from quickreturn.cases.runs.recorded import GROWING, VIBRATING
from quickreturn.cases.runs.request import NOTHING, Run
from quickreturn.engines.relative import rms, scale
from quickreturn.reference_model.columns import COLUMNS

Array = NDArray[np.float64]

#: Least relative RMS difference of a column that needs an explanation.
LEAST_DIFFERENCE: Final = 0.02
#: What to do about a column that is late.
_SHIFTED: Final = "look from where the crank angle is counted, and when the row is taken"
#: Least relative difference in the duration of a turn that is told: an engine that is 10 % off in the deflection keeps it to 1e-4.
SLOW: Final = 3e-3
#: Key of the sentence on a quantity of the scene, and of the sentence that nothing explains the difference.
QUANTITIES: Final = "quantities"
UNEXPLAINED_COLUMNS: Final = "unexplained"
MOST_NAMED: Final = 6  # columns in that sentence
#: Least RMS of a difference besides noise that is reported, as a part of the noise, whose RMS is known to 7 % from 200 rows.
LEAST_REST: Final = 0.5


class Causes(NamedTuple):
    """Causes of the differences of a table's columns.

    Attributes:
        sure: column -> a sentence on its noise, or on a mistake; "crank_angle" -> that all columns are late; "time" -> that a turn takes
            longer or shorter.
        fitted: column -> a sentence on a mistake that another motion may look like: one with a fitted number, or a small one.
        differing: column -> its relative difference, where it needs an explanation and `sure` has none.
        open: whether a quantity of the scene may be the cause: most of the columns that vibrate differ, and are not all late alike.
    """

    sure: Mapping[str, str]
    fitted: Mapping[str, str]
    differing: Mapping[str, float]
    open: bool

    def told(self, case: str, lead: str = "") -> dict[str, str]:
        """The sentences by column; `lead`: on a quantity of the scene, which takes the place of fitted numbers.

        Where the motion may be another one, fitted numbers are told only if they explain every column.
        """
        if lead:
            return {**self.sure, QUANTITIES: lead}
        left = {name: off for name, off in self.differing.items() if name not in self.fitted}
        if not left:
            return {**self.sure, **self.fitted}
        if self.open:
            return {**self.sure, UNEXPLAINED_COLUMNS: _unexplained(case, self.differing)}
        return {**self.sure, **self.fitted, UNEXPLAINED_COLUMNS: _unexplained(case, left)}


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


def causes(run: Run, other: Run, case: Case) -> Causes:
    """The causes of the differences of a table, whose run is `run`, from an engine on the case, in the same turn or state.

    If all columns that vibrate are late alike, the other mistakes are those that are left when the lateness is taken off.
    """
    grids, right = _on_grid(run, other), on_common_grid(channels_of(other.cycle, COLUMNS.keys() & other.cycle.keys()))
    noises = {name: noise for name in grids if (noise := _noise_of(name, run, other))}
    vibrating = [name for name in grids if name in VIBRATING and name not in noises]
    off_by = column_differences(run, other)
    lag, left = _common_lag([grids[name] for name in vibrating])
    sure = dict(noises)
    if abs(later := float(np.ptp(run.cycle["time"]) / np.ptp(other.cycle["time"])) - 1.0) > SLOW:
        pace = f"{100.0 * abs(later):.2g} % {'longer' if later > 0.0 else 'shorter'}"
        sure["time"] = f"a turn of the crank takes {pace} in it than in {other.engine}: its clock or its drive is another one"
    if lag:
        grids = {name: (_late(recorded, -lag), expected) for name, (recorded, expected) in grids.items()}
        sure["crank_angle"] = _told_lag(lag, left, run)

    def mistake(name: str, tolerance: float | None) -> Finding | None:
        recorded, expected = grids[name]
        alone = _lag([grids[name]])
        told = f"is about {math.degrees(abs(alone)):.3g} deg of the crank {_when(alone)}"
        late = Hypothesis(told, _SHIFTED, _late(expected, alone), fitted=1)
        finding = diagnose(name, recorded, expected, tolerance, right, case.mechanism, [late])
        return finding if finding is not None and finding.explained else None

    def differing() -> dict[str, float]:
        return {name: off for name, off in off_by.items() if off > LEAST_DIFFERENCE and name not in sure}

    def is_open() -> bool:
        return not lag and 2 * len(differing().keys() & {*vibrating}) > len(vibrating)

    of_columns = [name for name in grids if name not in sure]
    found = {name: mistake(name, LEAST_DIFFERENCE * max(map(rms, grids[name]))) for name in of_columns}
    told = {name: f"{each.cause}; {each.advice}" for name, each in found.items() if each is not None}
    sure |= {name: told[name] for name, each in found.items() if each is not None and not each.fitted}
    if is_open():  # a small mistake of a column may be one of the motion
        sure = {name: sentence for name, sentence in sure.items() if name in noises or name == "time" or mistake(name, None)}
    fitted = {name: sentence for name, sentence in told.items() if name not in sure}
    return Causes(sure, fitted, {} if lag else differing(), is_open())


def _unexplained(case: str, columns: Mapping[str, float]) -> str:
    """The sentence on columns whose differences nothing explains; `columns`: their relative differences."""
    least, most = (share_of(share) for share in (min(columns.values()), max(columns.values())))
    off = most if least == most else f"{least} to {most}"
    names = [*columns]
    few = ", ".join(names[:MOST_NAMED]) + (f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else "")
    tried = f"lateness, another value of one quantity of {case} or two, mistakes in a column"
    return f"none of these explains the difference of {few} (off by {off}): {tried}"


def _noise_of(name: str, run: Run, other: Run) -> str:
    """A sentence on a column whose differences are mostly noise, if that is more than `LEAST_DIFFERENCE` of the column; otherwise ""."""
    turned, other_turned = (np.abs(each.cycle["crank_angle"] - each.cycle["crank_angle"][0]) for each in (run, other))
    expected = CubicSpline(other_turned, other.cycle[name])(turned)
    inside = slice(1, -1)  # the first and the last row of a turn are interpolated
    difference, size = (run.cycle[name] - expected)[inside], rms(expected)
    noise = white_noise(run.cycle["time"][inside], difference)
    if noise is None or noise.rms <= LEAST_DIFFERENCE * size:
        return ""
    white = f"{100.0 * noise.rms / size:.2g} % RMS, white" + (f" above {noise.above:.2g} Hz" if noise.above else "")
    besides = math.sqrt(max(rms(difference) ** 2 - noise.rms**2, 0.0))
    more = f"; besides that it is off by {100.0 * besides / size:.1g} %" if besides > LEAST_REST * noise.rms else ""
    return f"the differences of {name} look like noise of {white}{more}"


def _common_lag(pairs: Sequence[tuple[Array, Array]]) -> tuple[float, float]:
    """Lateness (rad of the crank) of all columns alike that explains their differences, and the part of these that it leaves; 0: none.

    Offsets and factors of single columns do not count. `pairs`: recorded and expected values of two columns at least.
    """
    if len(pairs) < 2:
        return 0.0, 1.0
    lag = _lag(pairs)
    apart, left = (math.sqrt(max(1.0 - _alike(pairs, each), 0.0)) for each in (0.0, lag))
    if apart < LEAST_DIFFERENCE or left > UNEXPLAINED * apart:
        return 0.0, 1.0
    return lag, left / apart


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


def _told_lag(lag: float, left: float, run: Run) -> str:
    time, (first, last) = run.cycle["time"], run.cycle["crank_angle"][[0, -1]]
    turning, ms = math.copysign(1.0, last - first), 1e3 * float(time[-1] - time[0]) * abs(lag) / (2.0 * math.pi)
    off = turning * math.degrees(lag)
    zero = f"crank_angle is about {abs(off):.3g} deg too {'large' if off > 0.0 else 'small'}"
    mend = f'"HEADING = crank_angle [deg] {"+" if off > 0.0 else "-"} {abs(off):.3g}"'
    explained = f"that explains all but {share_of(left)} of the difference"
    return f"{zero}, or all other columns are {ms:.3g} ms {_when(lag)}: {explained}; --column {mend} takes it off"


def _when(lag: float) -> str:
    return "late" if lag > 0 else "early"


def _on_grid(run: Run, other: Run) -> dict[str, tuple[Array, Array]]:
    """Columns that both have and that are not zero in the other, at even crank angles of the turn."""
    names = [name for name in run.cycle if name in other.cycle and name not in GROWING and other.peak(name) > NOTHING]
    recorded, expected = (on_common_grid(channels_of(each.cycle, names)) for each in (run, other))
    return {name: (recorded[name], expected[name]) for name in names}
