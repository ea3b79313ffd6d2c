"""What explains the difference of a table's columns from an engine's: the measuring chain of a column, or one delay or clock of all.

Each explanation is a model of the recorded rows, made of the engine's column at the same crank angles and a few constants that are fitted.
It is named if what it leaves of the difference, without the noise of the rows, is within the errors of sound programs, and clearly less
than what the next one leaves. Of explanations that leave about as much, those with the fewest constants are named, each of them.

In what follows e(t) is the engine's column in its own time t, and r the recorded one:

    an offset  r = e + b        a delay    r = e(t - d)          a filter   r is e behind a Butterworth low-pass of order 1 or 2
    a factor   r = a e          a drift    r = e + b + c t       a limit    r = min(max(e, low), high)
    hum        r = e + p cos(w t) + q sin(w t), w that of the mains      steps    r is e rounded to whole steps, or cut to them
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar
from scipy.signal import butter, lfilter

from quickreturn.cases.comparison.tables import GROWING, VIBRATING
from quickreturn.cases.files.instants import DEVIATIONS, ROUNDING, scatter
from quickreturn.cases.motion.marching import channels_of
from quickreturn.cases.motion.request import NOTHING, Run
from quickreturn.cases.motion.settling import GRID, on_common_grid
from quickreturn.engines.trajectory import rms, scale
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS

#: Least RMS difference of a column, over its RMS, that needs an explanation, and largest that an explanation may leave. Main engines
#: claim up to 0.7 % at their default settings.
LEAST_DIFFERENCE: Final = 0.01
#: Rest, over the column's RMS, below which explanations are not distinguished: the error that `reference` claims by default.
ALIKE: Final = 1e-3
#: Largest ratio of the rest of an explanation to the least rest, for both to be named.
AS_GOOD: Final = 2.0
#: Least relative difference in the duration of a turn that is told: an engine that is 10 % off in the deflection keeps it to 1e-4.
SLOW: Final = 3e-3
#: Factor of the noise's mean square, which is taken off: over some 200 rows it scatters by 10 %, of which nearly twice counts.
SURELY: Final = 1.16
NOISY: Final = 0.3  # largest noise over the column's standard deviation for which explanations are tried: more hides what they leave
MAINS: Final = (50.0, 60.0, 100.0, 120.0)  # Hz, and the second harmonics, which rectifiers leave
LATEST: Final = 0.25  # of a turn, by which a column may be late in a turn that does not repeat
TRIES: Final = 120  # values of a constant that are tried in half a turn, which has 3 to 15 periods of the vibration
CUT: Final = 0.01  # least part of the rows beyond a limit that is named
#: Largest part of the rows that have a value of their own if the column comes in steps, and largest departure of a value from them.
FEW: Final = 0.5
UNEVEN: Final = 0.05
#: Points of a turn in which a column is filtered.
FINE: Final = 4096
#: Key of the sentence on a quantity of the scene, and of the sentence that nothing explains the difference.
QUANTITIES: Final = "quantities"
UNEXPLAINED: Final = "unexplained"
MOST_NAMED: Final = 6  # columns in that sentence


@dataclass(frozen=True)
class Explanation:
    """One that was tried.

    Attributes:
        kind: what it is, with its article.
        words: what it says of the columns, a clause.
        left: RMS of what it leaves of them without their noise, over their RMS.
        constants: number of those that are fitted.
    """

    kind: str
    words: str
    left: float
    constants: int = 1


class Explained:
    """What is said of a difference: the explanations that hold, best first, and the least rest of another one."""

    def __init__(self, off: float, tries: Sequence[Explanation]) -> None:
        """`off`: the RMS difference, over the columns' RMS, without noise."""
        ranked = sorted(tries, key=lambda each: each.left)
        enough = max(AS_GOOD * ranked[0].left, ALIKE) if ranked else 0.0
        alike = [each for each in ranked if each.left <= min(enough, LEAST_DIFFERENCE)]
        fewest = min((each.constants for each in alike), default=0)
        self.off, self.tries, self.holding = off, tries, [each for each in alike if each.constants == fewest]
        self._next = next((each for each in ranked if each not in alike), None)

    @property
    def sentence(self) -> str:
        """The explanations that hold, what the best leaves, and what the next one would leave."""
        other, rest = self._next, ""
        if other and math.isfinite(other.left):
            rest = f", and {other.kind} would leave {_percent(other.left)}"
        clauses = "; or ".join(each.words for each in self.holding)
        return f"{clauses} (that leaves {_percent(self.holding[0].left)} of a difference of {_percent(self.off)}{rest})"


@dataclass(frozen=True)
class Causes:
    """What explains the differences of a table's columns.

    Attributes:
        duration: a sentence on a turn that takes longer or shorter; "" if it does not.
        common: what all columns have in common; None: nothing is looked for.
        columns: each column that differs, with what explains it, if anything does.
        open: whether a quantity of the scene may explain them: most of the columns that vibrate differ.
    """

    duration: str
    common: Explained | None
    columns: Mapping[str, Explained]
    open: bool

    def told(self, case: str, quantities: Sequence[Explanation] = ()) -> dict[str, str]:
        """The sentences by column; `quantities`: explanations by quantities of the scene, of the table as a whole."""
        plain = {"time": self.duration} if self.duration else {}
        tries = [*(self.common.tries if self.common else ()), *quantities]
        if tries:
            whole = Explained(self.common.off if self.common else max(each.off for each in self.columns.values()), tries)
            if whole.holding:
                key = QUANTITIES if whole.holding[0] in quantities else "crank_angle"
                return {**plain, key: whole.sentence}
        found = {name: f"{name} {each.sentence}" for name, each in self.columns.items() if each.holding}
        differing = {name: each.off for name, each in self.columns.items() if not each.holding}
        if not differing:
            return {**plain, **found}
        least, most = _percent(min(differing.values())), _percent(max(differing.values()))
        names = [*differing]
        few = ", ".join(names[:MOST_NAMED]) + (f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else "")
        tried = f"nothing that was tried, nor one or two quantities of {case}," if self.open else "nothing that was tried"
        off = most if least == most else f"{least} to {most}"
        return {**plain, **found, UNEXPLAINED: f"{tried} explains the difference of {few} (off by {off})"}


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
    columns, duration = [_Column(run, other, name) for name in _on_grid(run, other)], ""
    if abs(later := float(np.ptp(run.cycle["time"]) / np.ptp(other.cycle["time"])) - 1.0) > SLOW:
        pace = f"{100.0 * abs(later):.2g} % {'longer' if later > 0.0 else 'shorter'}"
        duration = f"a turn of the crank takes {pace} in it than in {other.engine}"
    vibrating = [column for column in columns if column.name in VIBRATING]
    differing = [column for column in columns if column.off > LEAST_DIFFERENCE]
    most = 2 * sum(column in differing for column in vibrating) > len(vibrating)
    common = _common(vibrating, run) if most and len(vibrating) > 1 else None
    if common and common.holding:
        return Causes(duration, common, {}, open=common.holding[0].left > AS_GOOD * ALIKE)
    return Causes(duration, common, {column.name: column.explained(other.engine) for column in differing}, most)


class _Column:
    """A column of a table beside that of an engine."""

    def __init__(self, run: Run, other: Run, name: str) -> None:
        self.name, self.unit = name, f" {unit}" if (unit := COLUMNS[name].unit) != "1" else ""
        self.time, self.recorded = run.cycle["time"], run.cycle[name]
        self.begin, self.end = (float(other.cycle["time"][place]) for place in (0, -1))
        angle, turned = run.cycle["crank_angle"], np.abs(other.cycle["crank_angle"] - other.cycle["crank_angle"][0])
        self.turned, self._instant = np.abs(angle - angle[0]), CubicSpline(turned, other.cycle["time"])
        #: The engine's time at each row: that of the same crank angle or, where none was recorded, at the same part of the turn.
        self.phase = np.asarray(self._instant(self.turned))
        self.even = np.allclose(np.interp(self.time, self.time[[0, -1]], angle[[0, -1]]), angle, rtol=0.0, atol=1e-9)
        if self.even:
            self.phase = self.begin + (self.time - self.time[0]) * (self.end - self.begin) / np.ptp(self.time)
        self.repeats = other.approach.turn is None
        self._expected = CubicSpline(other.cycle["time"], other.cycle[name])
        self.size = scale(name, other.cycle)
        self.step = self._step()
        self.noise = 0.0 if self.step else scatter(self.time, self.recorded) / DEVIATIONS
        self.off = self.left(self.expected(), self.size)

    def expected(self, shift: Array | float = 0.0, turn: float = 0.0) -> Array:
        """The engine's column at the rows, later by `shift`, s, or at crank angles less by `turn`, rad; nan where it is unknown."""
        at = self.phase - shift
        if turn:
            at = np.asarray(self._instant(np.mod(self.turned - turn, 2.0 * math.pi) if self.repeats else self.turned - turn))
        if self.repeats:
            return np.asarray(self._expected(self.begin + np.mod(at - self.begin, self.end - self.begin)))
        return np.asarray(np.where((at >= self.begin) & (at <= self.end), self._expected(at), np.nan))

    def left(self, model: Array, size: float) -> float:
        """RMS of what a model leaves, without noise, over a size."""
        square = float(np.nanmean((self.recorded - model) ** 2)) - SURELY * self.noise**2
        return math.sqrt(max(square, 0.0)) / size if size > 0.0 else math.inf

    def explained(self, engine: str) -> Explained:
        """All explanations of this column alone."""
        tries = [*self._linear(engine), self._delay(), *(self._filter(order) for order in (1, 2)), self._limits(), self._steps()]
        return Explained(self.off, tries if self.noise < NOISY * float(np.std(self.recorded)) else ())

    def fit(self, base: Array, regressors: Sequence[Array]) -> tuple[Array, float]:
        """The coefficients of regressors that are added to a base, and what that leaves."""
        known = np.isfinite(base)
        matrix = np.column_stack(regressors)
        coefficients, *_ = np.linalg.lstsq(matrix[known], (self.recorded - base)[known])
        return np.asarray(coefficients), self.left(base + matrix @ coefficients, self.size)

    def _linear(self, engine: str) -> list[Explanation]:
        expected, one, since = self.expected(), np.ones_like(self.time), self.time - self.time[0]
        known = np.isfinite(expected)  # rounding may put the first or the last row outside the engine's turn
        factor = float(self.recorded[known] @ expected[known] / (expected[known] @ expected[known]))
        (offset,), left = self.fit(expected, [one])
        (_, slope), left_of_drift = self.fit(expected, [one, since])
        tries = [
            Explanation("a factor", f"is {factor:.4g} times that of {engine}", self.left(factor * expected, abs(factor) * self.size)),
            Explanation("an offset", f"is {abs(offset):.3g}{self.unit} {'above' if offset > 0 else 'below'} that of {engine}", left),
            Explanation("a drift", f"drifts by {slope:.3g}{self.unit} a second", left_of_drift, 2),
        ]
        for frequency in MAINS:
            if frequency * float(np.median(np.diff(self.time))) < 0.5:
                turning = 2.0 * math.pi * frequency * self.time
                (one_part, other_part), left = self.fit(expected, [np.cos(turning), np.sin(turning)])
                amplitude = math.hypot(one_part, other_part)
                tries.append(Explanation(f"{frequency:g} Hz", f"has {amplitude:.3g}{self.unit} of {frequency:g} Hz in it", left, 2))
        return tries

    def _delay(self) -> Explanation:
        turn = self.end - self.begin
        farthest = 0.5 * turn if self.repeats else LATEST * turn
        delay, left = _searched(lambda late: self.left(self.expected(late), self.size), np.linspace(-farthest, farthest, 2 * TRIES))
        return Explanation("a delay", f"is {_ms(delay)}", left)

    def _filter(self, order: int) -> Explanation:
        """A low-pass filter; the state in which it begins the turn is fitted, too."""
        instants = np.linspace(self.begin, self.end, FINE)
        rate = (FINE - 1) / (self.end - self.begin)
        values, still = self._expected(instants), np.zeros(FINE)

        def fitted(logarithm: float) -> float:
            numerator, denominator = butter(order, math.exp(logarithm), fs=rate)
            first = values[0] * np.ones(FINE)
            forced = first + lfilter(numerator, denominator, values - values[0])
            free = [lfilter(numerator, denominator, still, zi=state)[0] for state in np.eye(order)]
            rows = [np.interp(self.phase, instants, each) for each in (forced, *free)]
            return self.fit(rows[0], rows[1:])[1]

        lowest, highest = 2.0 / (self.end - self.begin), 0.25 * len(self.time) / (self.end - self.begin)
        logarithm, left = _searched(fitted, np.linspace(math.log(lowest), math.log(highest), TRIES // 4))
        told = f"has passed a low-pass of {'first' if order == 1 else 'second'} order at {math.exp(logarithm):.3g} Hz"
        return Explanation(f"a low-pass of order {order}", told, left)

    def _limits(self) -> Explanation:
        expected, (low, high) = self.expected(), np.quantile(self.recorded, (0.0, 1.0))
        inside = np.mean((low < expected) & (expected < high))
        cut = [f"{end:.3g}" for end, beyond in ((low, expected < low), (high, expected > high)) if np.mean(beyond) > CUT]
        words = f"is cut off at {' and '.join(cut)}{self.unit}"
        return Explanation("a limit", words, self.left(np.clip(expected, low, high), self.size) if inside > 0.5 else math.inf)

    def _steps(self) -> Explanation:
        expected, rests = self.expected(), [math.inf]
        for below, above in ((0.5, 0.5), (0.0, 1.0), (1.0, 0.0)) if self.step else ():  # rounded, or cut to the step below or above
            nearest = np.clip(expected, self.recorded - below * self.step, self.recorded + above * self.step)
            rests.append(rms((expected - nearest)[1:-1]) / self.size)
        return Explanation("steps", f"comes in steps of {self.step:.3g}{self.unit}", min(rests))

    def _step(self) -> float:
        """Distance of the values, if they are few and evenly spaced; 0 otherwise. The ends of a turn are interpolated."""
        digits = self.recorded[1:-1] / (ROUNDING * (float(np.ptp(self.recorded)) or 1.0))
        levels = np.unique(np.round(digits))
        if not 2 < len(levels) < FEW * len(digits):
            return 0.0
        apart = np.diff(levels)
        step = float(np.median(apart[apart < 1.5 * np.min(apart)]))
        uneven = apart / step - np.round(apart / step)
        return step * ROUNDING * float(np.ptp(self.recorded)) if np.max(np.abs(uneven)) < UNEVEN else 0.0


def _common(columns: Sequence[_Column], run: Run) -> Explained | None:
    """One delay of all columns, one clock, or another zero of the crank's encoder; offset and factor of each column do not count."""

    def left(shift: Array | float = 0.0, turn: float = 0.0) -> float:
        return math.sqrt(np.mean([_apart(column, column.expected(shift, turn)) ** 2 for column in columns]))

    one, off = columns[0], left()
    if off <= LEAST_DIFFERENCE:  # each has its own factor or offset
        return None
    farthest, period = 0.5 if one.repeats else LATEST, one.end - one.begin
    around = np.linspace(-farthest, farthest, 2 * TRIES)
    delay, of_delay = _searched(left, around * period)
    tries = [Explanation("a delay of all columns", f"all columns but crank_angle are {_ms(delay)}", of_delay)]
    if one.even:  # the time of a row says where the crank is
        pace, of_clock = _searched(lambda fast: left(fast * one.time), around * period / float(one.time[-1]))
        clock = f"time runs {100.0 * abs(pace):.3g} % too {'slow' if pace < 0.0 else 'fast'}"
        tries.append(Explanation("a clock", clock, of_clock))
    else:
        turn, of_zero = _searched(lambda turn: left(turn=turn), around * 2.0 * math.pi)
        zero = math.copysign(math.degrees(turn), turn * float(np.diff(run.cycle["crank_angle"][[0, -1]])[0]))
        mend = f'--column "HEADING = crank_angle [deg] {"+" if zero > 0.0 else "-"} {abs(zero):.3g}" takes it off'
        words = f"crank_angle is {abs(zero):.3g} deg too {'large' if zero > 0.0 else 'small'}: {mend}"
        tries.append(Explanation("another zero of crank_angle", words, of_zero))
    return Explained(off, tries)


def _apart(column: _Column, expected: Array) -> float:
    """What a column leaves of another, without noise, if offset and factor do not count; at most 1."""
    known = np.isfinite(expected)
    recorded, values = (each[known] - np.mean(each[known]) for each in (column.recorded, expected))
    sizes = float(values @ values), float(recorded @ recorded)
    if not min(sizes) > 0.0:
        return 0.0
    rest = 1.0 - float(recorded @ values) ** 2 / (sizes[0] * sizes[1])
    return math.sqrt(max(rest - SURELY * column.noise**2 * recorded.size / sizes[1], 0.0))


def _searched(rest: Callable[[float], float], tries: Array) -> tuple[float, float]:
    """The constant that leaves least, and what it leaves: the best of some evenly spaced tries, then the least between its neighbours."""
    near, step = float(min(tries, key=rest)), float(tries[1] - tries[0])
    found = minimize_scalar(rest, bounds=(near - step, near + step), method="bounded", options={"xatol": 1e-4 * step})
    return float(found.x), float(found.fun)


def _ms(late: float) -> str:
    """A delay, s, in words."""
    return f"{1e3 * abs(late):.3g} ms {'late' if late > 0 else 'early'}"


def _percent(part: float) -> str:
    return f"{100.0 * part:.2g} %"


def _on_grid(run: Run, other: Run) -> dict[str, tuple[Array, Array]]:
    """Columns that both have and that are not zero in the other, at even crank angles of the turn."""
    names = [name for name in run.cycle if name in other.cycle and name not in GROWING and other.peak(name) > NOTHING]
    recorded, expected = (on_common_grid(channels_of(each.cycle, names)) for each in (run, other))
    return {name: (recorded[name], expected[name]) for name in names}
