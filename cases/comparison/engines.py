"""Compares engines with each other, case by case, with tolerances from their claims.

The tolerance of a measure is the sum of both engines' claims: their own error estimates in the settled cycle (`cases.motion.estimates`),
what is left to the steady state, and the uncertainty of the measurement. So a coarse engine with a right estimate agrees, and one that
claims too small an error departs. The accuracy class says how good an engine is. An engine whose estimate does not cover its whole error is
not judged: its difference is a result.

Most of a frequency's or an amplitude's uncertainty lies in what the first mode is taken to be, which is the same in two signals that are
alike. So it counts as far as the signals differ: with their RMS difference in the half over the RMS of the signal less its mean, at most 1.
Changes of the machine by up to a tenth of the stiffness change a number by as much as that in four of five halves, twice as much in nine of
ten: it is a standard deviation, as the uncertainty is.

Waveforms are compared at equal crank angles in every half and channel, whether or not a mode is resolvable: the RMS of the difference and
its largest magnitude, against 0.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.files.case import Case
from quickreturn.cases.motion.consensus import consensus
from quickreturn.cases.motion.cycle import EXTREMES, HALVES, VIBRATION, extremes_by_half, signals_by_half
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.estimates import mean_estimate
from quickreturn.cases.motion.marching import channels_of
from quickreturn.cases.motion.number import (
    SAYS_NOTHING,
    TELLING,
    TELLING_OF_AMPLITUDES,
    TELLING_OF_FREQUENCIES,
    VERDICTS,
    Number,
    Verdict,
    or_nan,
)
from quickreturn.cases.motion.request import NOTHING, Run
from quickreturn.cases.motion.settling import GRID, on_common_grid
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reference_model.columns import COLUMNS

Array = NDArray[np.float64]

REFERENCE: Final = "reference"
#: Differences of two signals in a half, at equal crank angles: their RMS, and their largest magnitude.
WAVEFORM: Final = ("waveform", "largest_difference")
#: Quantities of each channel that are judged, besides the consensus of the channels' frequencies.
QUANTITIES: Final = (*VIBRATION, *EXTREMES, *WAVEFORM)
CONSENSUS: Final = "consensus_frequency"
#: Kinds of differences; "frequency" is the consensus of a half over its channels.
Kind = Literal["frequency", "channel frequency", "amplitude", "extreme", "waveform"]
KINDS: Final[Mapping[Kind, tuple[str, ...]]] = {
    "frequency": (CONSENSUS,),
    "channel frequency": VIBRATION[:1],
    "amplitude": VIBRATION[1:],
    "extreme": EXTREMES,
    "waveform": WAVEFORM,
}
#: Largest tolerance, over the scale, of a comparison that says something, if it is not `TELLING`.
LIMITS: Final[Mapping[str, float]] = {
    CONSENSUS: TELLING_OF_FREQUENCIES,
    VIBRATION[0]: TELLING_OF_FREQUENCIES,
    VIBRATION[1]: TELLING_OF_AMPLITUDES,
}

#: Accuracy classes, relative errors: an engine is in the least one that covers its estimates and its deviation.
CLASSES: Final = (0.001, 0.003, 0.01, 0.03, 0.1)
WORSE: Final = "worse"


@dataclass(frozen=True)
class Difference:
    """A number computed by two engines, and whether they agree within their claims.

    Attributes:
        case: name of the scene.
        engine: name of the engine that is judged.
        other: name of the engine that it is compared with.
        quantity: one of `QUANTITIES`, or `CONSENSUS`.
        half: "pre" or "post".
        channel: trajectory column; None for the consensus.
        number: the engine's number; of a waveform the size of the difference.
        other_number: the other engine's; of a waveform 0.
        scale: divisor of relative differences: magnitude of the other's value; for an extreme and the largest difference of two waveforms
            the channel's largest in the other's cycle, for their RMS difference the channel's RMS in the half.
        unshared: the part of the tolerance for the measurements: their uncertainties as far as the signals differ.
    """

    case: str
    engine: str
    other: str
    quantity: str
    half: str
    channel: str | None
    number: Number
    other_number: Number
    scale: float
    unshared: float

    @property
    def difference(self) -> float:
        """Engine minus other."""
        return self.number.value - self.other_number.value

    @property
    def unit(self) -> str:
        """SI unit of both numbers."""
        return "Hz" if self.channel is None or self.quantity == VIBRATION[0] else COLUMNS[self.channel].unit

    @property
    def relative(self) -> float:
        """The difference over the scale."""
        return self.difference / self.scale

    @property
    def ratio(self) -> float:
        """The engine's number over the other's."""
        return self.number.value / self.other_number.value

    @property
    def tolerance(self) -> float:
        """Largest difference within both claims: estimates, what is left to the steady state, and `unshared`."""
        both = (self.number, self.other_number)
        return sum(or_nan(number.estimate) + number.settling for number in both) + self.unshared

    @property
    def passed(self) -> bool:
        """Whether the difference is within the tolerance; False for NaN."""
        return abs(self.difference) <= self.tolerance

    @property
    def verdict(self) -> Verdict:
        """Whether the two agree; a tolerance beyond the limit (`LIMITS`) would hide any mistake."""
        if not self.passed:
            return "disagrees"
        return "agrees" if self.tolerance <= LIMITS.get(self.quantity, TELLING) * self.scale else "says nothing"

    @property
    def why(self) -> tuple[str, ...]:
        """The parts of both estimates, with the runs that show them, in words."""
        return tuple(
            f"{name}: {part}" for name, number in ((self.engine, self.number), (self.other, self.other_number)) for part in number.parts
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON and CSV."""
        names = ("engine", "other", "quantity", "half", "channel", "difference", "tolerance", "unshared", "scale", "passed", "verdict")
        claims = {"": self.number, "other_": self.other_number}.items()
        parts = ("value", "estimate", "uncertainty", "measurement", "settling")
        numbers = {f"{whose}{part}": getattr(claim, part) for whose, claim in claims for part in parts}
        return {name: getattr(self, name) for name in names} | numbers


@dataclass(frozen=True)
class CaseResult:
    """All engines on one case, and the verdict on their claims; also recorded tables, which only `with_tables` includes."""

    case: Case
    runs: Mapping[str, Run]  # by name of the engine
    checks: tuple[Difference, ...] = field(default=())  # engines against each other
    recorded: Mapping[str, Run] = field(default_factory=dict)  # by name of the recorded table
    table_checks: tuple[Difference, ...] = field(default=())  # tables against engines
    leads: Mapping[str, str] = field(default_factory=dict)  # by name of the table: a sentence on the quantities that would explain it

    def __repr__(self) -> str:
        runs = ", ".join(f"{name} {run.status}" for name, run in self.with_tables.runs.items())
        return f"{self.case.name}: {runs}; {len(self.missed)} of {len(self.checks)} checks missed"

    @property
    def turn(self) -> int | None:
        """The turn from the standard start that is compared; None: the steady state."""
        return next((run.approach.turn for run in self.runs.values() if run.approach.turn is not None), None)

    @property
    def with_tables(self) -> "CaseResult":
        """The result with recorded tables as engines after the others."""
        return CaseResult(self.case, {**self.runs, **self.recorded}, (*self.checks, *self.table_checks))

    @property
    def settled_speed(self) -> float | None:
        """Mean crank speed (rad/s) of the settled motion by `reference`, or else by the first engine that has one; None without one."""
        usable = {name: run for name, run in self.runs.items() if run.usable}
        return usable.get(REFERENCE, next(iter(usable.values()))).mean_crank_speed if usable else None

    @property
    def passed(self) -> bool | None:
        """Whether every engine delivered and none departs from another by more than both claim; None if nothing could be judged."""
        return not self.failures and not self.missed if self.agreement["agree"] or self.missed else None

    @property
    def agreement(self) -> dict[str, int]:
        """Number of comparisons that agree, that disagree, and that say nothing (`Difference.verdict`)."""
        return agreement(self.checks)

    @property
    def reason(self) -> str:
        """Why `passed` is not true (a clause), "" if it is."""
        if not self.checks:
            if len(self.runs) == 1:
                return "nothing to compare with: one engine alone"
            return "; ".join(
                [
                    "nothing to compare with",
                    *(f"{name}: {not_judged(run) or 'alone with its claims'}" for name, run in self.runs.items()),
                ]
            )
        if self.passed is None:
            return f"all {len(self.checks)} comparisons say nothing: what is claimed is more than {SAYS_NOTHING}"
        departing = [f"{pair[0]} and {pair[1]} disagree by more than they claim" for pair in self.departures]
        return "; ".join([*departing, *(f"{run.engine} did not deliver: {run.status}" for run in self.failures)])

    @cached_property
    def _pairs(self) -> dict[tuple[str, str], "Pair"]:
        return {}

    @property
    def failures(self) -> tuple[Run, ...]:
        """Runs that failed, did not settle or did not reach the accuracy asked. A refusal does not count."""
        return tuple(run for run in self.runs.values() if not run.ending.delivered)

    @property
    def missed(self) -> tuple[Difference, ...]:
        """Checks in which engines differ by more than they claim."""
        return tuple(check for check in self.checks if not check.passed)

    @property
    def departures(self) -> dict[tuple[str, str], list[Difference]]:
        """Missed checks by pair of engines."""
        departures: dict[tuple[str, str], list[Difference]] = {}
        for check in self.missed:
            departures.setdefault((check.engine, check.other), []).append(check)
        return departures

    def accuracy_class(self, name: str) -> str | None:
        """Least class ("0.3 %") that covers an engine's own estimates and its deviation from the reference, or "worse".

        It covers consensus frequencies and extremes, these relative to the channel's largest magnitude; those of a table in every column.
        None if it is not known: there is no estimate, or the estimate covers the integration alone and there is no reference for the rest.
        """
        run, reference = self.runs[name], self.runs.get(REFERENCE)
        comparable = reference is not None and reference.usable and name != REFERENCE
        if not run.usable or (not comparable if run.estimate_of == "integration" else run.measured.unestimated):
            return None
        sizes = [size for half in HALVES for size in _relative_estimates(run, half)]
        if comparable:
            of_table = [check for check in self.checks if (check.engine, check.other) == (name, REFERENCE) and check.quantity in EXTREMES]
            extremes = of_table if run.recording else self.differences(name, "extreme")
            sizes += [abs(difference.relative) for difference in (*self.differences(name, "frequency"), *extremes)]
        return next((f"{100.0 * width:g} %" for width in CLASSES if max(sizes) <= width), WORSE) if sizes else None

    def differences(
        self, name: str, kind: Kind, other: str = REFERENCE, half: str | None = None, channel: str | None = None
    ) -> list[Difference]:
        """Differences of a kind between two engines in numbers that both have, in both halves and all channels unless one is given."""
        run, opposite = self.runs.get(name), self.runs.get(other)
        if run is None or opposite is None or not (run.usable and opposite.usable):
            return []
        halves, channels = HALVES if half is None else (half,), CHANNELS if channel is None else (channel,)
        places = product(halves, (None,) if kind == "frequency" else channels, KINDS[kind])
        pair = self._pairs.setdefault((name, other), Pair(run, opposite))
        differences = (pair.difference(self.case.name, quantity, where, column) for where, column, quantity in places)
        return [difference for difference in differences if difference is not None]


def agreement(checks: Iterable[Difference]) -> dict[str, int]:
    """See `CaseResult.agreement`."""
    found = Counter(check.verdict for check in checks)
    return {name: found[verdict] for name, verdict in zip(("agree", "disagree", "says_nothing"), VERDICTS, strict=True)}


def compare(case: Case, runs: Mapping[str, Run], recorded: Mapping[str, Run] | None = None) -> CaseResult:
    """Compare every engine with the reference, or if that cannot be judged with the first one that can, and tables with each engine.

    The runs of engines are all in the steady state or all in the same turn. Where the engines are in the steady state and a recorded
    table is not, it has not settled.
    """
    judged = {name: run for name, run in runs.items() if not not_judged(run)}
    against = judged.get(REFERENCE) or next(iter(judged.values()), None)
    checks = [check for run in judged.values() if against is not None and run is not against for check in _checks(case, run, against)]
    turns = {run.approach.turn for run in runs.values()}
    tables = {name: run if run.approach.turn in {None, *turns} else _unsettled(run) for name, run in (recorded or {}).items()}
    of_tables = [check for run in tables.values() if run.usable for other in judged.values() for check in _table_checks(case, run, other)]
    return CaseResult(case, runs, tuple(checks), tables, tuple(of_tables))


def _unsettled(run: Run) -> Run:
    turns = f"{run.approach.cycles} turns; `quickreturn compare` compares it in that turn"
    told = f"begins in the standard start and has not settled after {turns}"
    return replace(run, status=Ending.NOT_SETTLED, remark=f"{run.remark}; {told}" if run.remark else told)


def not_judged(run: Run) -> str:
    """Why a run cannot be compared with others (a clause), "" if it can."""
    if not run.usable:
        return run.status
    if run.estimate_of == "integration":
        return "its estimate covers the integration alone, not its model"
    if run.estimate_of == "unverified":
        return "its estimates are not verified"
    return f"no estimates: {run.measured.unestimated}" if run.measured.unestimated else ""


def _checks(case: Case, run: Run, other: Run) -> list[Difference]:
    places, pair = [(CONSENSUS, None), *product(QUANTITIES, CHANNELS)], Pair(run, other, claimed=True)
    checks = (pair.difference(case.name, quantity, half, channel) for half in HALVES for quantity, channel in places)
    return [check for check in checks if check is not None]


def _table_checks(case: Case, table: Run, other: Run) -> list[Difference]:
    """Checks of a recorded table against an engine: first-mode numbers that both resolve, and extremes of columns that both have."""
    checks = [check for check in _checks(case, table, other) if check.quantity in (CONSENSUS, *VIBRATION)]
    filtered = table.recording is not None and table.recording.filtered
    time, angle = other.cycle["time"], other.cycle["crank_angle"]
    estimates = other.measured.extreme_estimates
    for channel in dict.fromkeys(measure.channel for measure in table.measured.measures if measure.channel in estimates):
        its_extremes, scale = extremes_by_half(time, angle, other.cycle[channel], filtered), other.peak(channel)
        for half in HALVES:
            for quantity, extreme in zip(EXTREMES, its_extremes[half], strict=True):
                number = table.number(quantity, half, channel)
                if number is not None and not math.isnan(number.error) and scale > NOTHING:
                    other_number = replace(extreme, estimate=estimates[channel][half], settling=other.approach.distance(channel, scale))
                    both, places = number.measurement + other_number.measurement, (quantity, half, channel)
                    checks.append(Difference(case.name, table.engine, other.engine, *places, number, other_number, scale, both))
    return checks


class Pair:
    """Two runs of a case, and the numbers that both have."""

    def __init__(self, run: Run, other: Run, *, claimed: bool = False) -> None:
        """`claimed`: whether numbers without an error estimate are left out, also from the consensus."""
        self._runs, self._claimed = (run, other), claimed

    def difference(self, case: str, quantity: str, half: str, channel: str | None) -> Difference | None:
        """The difference in a number of the case of this name; None if a run lacks it, or if there is no scale.

        Args:
            case: name.
            quantity: `CONSENSUS` or one of `QUANTITIES`.
            half: "pre" or "post".
            channel: a trajectory column; None for the consensus, which is over the channels that both resolve.
        """
        if quantity in WAVEFORM and channel is not None:
            found = self._waveform(quantity, half, channel)
        else:
            found = self._consensus(half) if channel is None else self._of_channel(quantity, half, channel)
        if found is None:
            return None
        number, other_number, measurement, scale = found
        if not scale > 0.0 or (self._claimed and math.isnan(number.error + other_number.error)):
            return None
        run, other = self._runs
        return Difference(case, run.engine, other.engine, quantity, half, channel, number, other_number, scale, measurement)

    def numbers(self, quantity: str, half: str, channel: str | None = None) -> tuple[Number, Number] | None:
        """Both runs' numbers; arguments as of `difference`."""
        found = self.difference("", quantity, half, channel)
        return None if found is None else (found.number, found.other_number)

    def _of_channel(self, quantity: str, half: str, channel: str) -> tuple[Number, Number, float, float] | None:
        number, other_number = (run.number(quantity, half, channel) for run in self._runs)
        if number is None or other_number is None:
            return None
        measurement = number.measurement + other_number.measurement
        if quantity in EXTREMES:
            return number, other_number, measurement, self._runs[1].peak(channel)
        return number, other_number, self._apart.get((half, channel), 1.0) * measurement, abs(other_number.value)

    def _consensus(self, half: str) -> tuple[Number, Number, float, float] | None:
        """The weighted means of the channels that both resolve; the weights, by the uncertainties, are the same for both runs."""
        found = [pair for channel in CHANNELS if (pair := self.difference("", VIBRATION[0], half, channel))]
        if not found:
            return None
        weights = np.array([1.0 / (pair.number.measurement**2 + pair.other_number.measurement**2) for pair in found])
        weights /= weights.sum()

        def mean(numbers: Sequence[Number]) -> Number:
            estimates, settling = ([or_nan(getattr(each, of)) for each in numbers] for of in ("estimate", "settling"))
            values, uncertainties = [each.value for each in numbers], [each.measurement for each in numbers]
            uncertainty = or_nan(consensus(half, values, uncertainties).uncertainty)
            return Number(float(weights @ values), float(weights @ estimates), uncertainty, float(weights @ settling))

        number, other_number = mean([pair.number for pair in found]), mean([pair.other_number for pair in found])
        return number, other_number, float(weights @ [pair.unshared for pair in found]), abs(other_number.value)

    def _waveform(self, quantity: str, half: str, channel: str) -> tuple[Number, Number, float, float] | None:
        if channel not in self._waveforms:
            return None
        of_run, of_other = (values[HALVES.index(half)] for values in self._waveforms[channel])
        sizes, apart = (np.sqrt(np.mean(of_other**2)), self._runs[1].peak(channel)), of_run - of_other
        size = (np.sqrt(np.mean(apart**2)), np.max(np.abs(apart)))[WAVEFORM.index(quantity)]
        numbers = []
        for run, value in zip(self._runs, (float(size), 0.0), strict=True):
            known = (run.measured.waveform_estimates, run.measured.extreme_estimates)[WAVEFORM.index(quantity)].get(channel, {}).get(half)
            rms = float(np.sqrt(np.mean(run.cycle[channel] ** 2)))
            left = ((run.approach.settling_error or 0.0) * rms, run.approach.distance(channel, rms))[WAVEFORM.index(quantity)]
            numbers.append(Number(value, known, settling=left))
        return numbers[0], numbers[1], 0.0, float(sizes[WAVEFORM.index(quantity)])

    @cached_property
    def _apart(self) -> dict[tuple[str, str], float]:
        """By half and channel: RMS difference of the signals less their means, over the RMS of the other's, at most 1."""
        if not self._repeats:
            return {}
        signals = [signals_by_half(run.cycle["time"], run.cycle["crank_angle"], self._channels(run)) for run in self._runs]
        found = {}
        for place, other in signals[1].items():
            if place in signals[0]:
                difference, size = signals[0][place] - other, float(np.std(other))
                found[place] = min(1.0, float(np.std(difference)) / size) if size > 0.0 else 1.0
        return found

    @cached_property
    def _waveforms(self) -> dict[str, tuple[tuple[Array, Array], tuple[Array, Array]]]:
        """Channel -> its values at even crank angles in both halves, of both runs."""
        if not self._repeats:
            return {}
        grids = [on_common_grid(channels_of(run.cycle, self._channels(run))) for run in self._runs]
        return {
            name: tuple((grid[name][: GRID // 2], grid[name][GRID // 2 :]) for grid in grids)  # type: ignore[misc]
            for name in grids[0]
            if name in grids[1]
        }

    @property
    def _repeats(self) -> bool:
        """Whether each run has one cycle that repeats, of its own turn: signals are compared, not means over cycles."""
        return all(run.approach.averaged_cycles == 1 and "time" in run.cycle and run.recording is None for run in self._runs)

    @staticmethod
    def _channels(run: Run) -> dict[str, Array]:
        return {name: run.cycle[name] for name in CHANNELS if name in run.cycle}


def _relative_estimates(run: Run, half: str) -> Iterator[float]:
    """A run's relative error estimates in a half: of extremes relative to the channel's peak, of the consensus relative to itself."""
    for measure in run.measured.measures:
        peak, estimates = run.peak(measure.channel), [getattr(measure, f"{name}_estimate") for name in EXTREMES]
        if measure.half == half and peak > 0.0:
            yield from (estimate / peak for estimate in estimates if estimate is not None)
    frequency, estimate = run.consensus_frequency(half), mean_estimate(run.measured.measures, half)
    if frequency and estimate is not None:
        yield estimate / frequency
