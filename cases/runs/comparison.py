"""Engines held against each other, case by case, with tolerances made of what they claim.

The tolerance of a measure is what both engines say of it: their own error estimates in the settled cycle (`cases.runs.estimates`) and
the uncertainty of the measurement. So a coarse engine that says how coarse it is agrees, and one that claims too much departs. How good
an engine is says its accuracy class. An engine whose estimate is not one of its whole error is not judged: its difference is a result.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any, Final, Literal

from quickreturn.cases.case import Case
from quickreturn.cases.errors import CaseError
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.measures.cycle import consensus_of, extremes_by_half
from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.recorded import RecordedTable
from quickreturn.cases.runs.campaign import Work, carry_out
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.runs.estimates import EXTREMES, VIBRATION, mean_estimate
from quickreturn.cases.runs.recorded import recorded_run
from quickreturn.cases.runs.request import LONGER, NOTHING, Run, RunRequest
from quickreturn.engines.registry import MAIN
from quickreturn.reference_model.errors import ExitCode
from quickreturn.reference_model.rigid import crank_pace

REFERENCE: Final = "reference"
HALVES: Final = ("pre", "post")
#: What is judged of each channel; the consensus of the channels' frequencies is judged besides.
QUANTITIES: Final = (*VIBRATION, *EXTREMES)
CONSENSUS: Final = "consensus_frequency"
#: Kinds of differences; "frequency" is the consensus of a half over its channels.
Kind = Literal["frequency", "channel frequency", "amplitude", "extreme"]
KINDS: Final[Mapping[Kind, tuple[str, ...]]] = {
    "frequency": (CONSENSUS,),
    "channel frequency": VIBRATION[:1],
    "amplitude": VIBRATION[1:],
    "extreme": EXTREMES,
}

#: Accuracy classes: the least that covers an engine's estimates and its deviation.
CLASSES: Final = (0.001, 0.003, 0.01, 0.03, 0.1)
WORSE: Final = "worse"


@dataclass(frozen=True)
class Claim:
    """A number, and how far off it may be: all in its own unit, nan where not known."""

    value: float
    estimate: float  # the engine's estimate of its error
    # of the measurement: one standard deviation of a frequency or amplitude; of an extreme what the samples leave open, and what the
    # channel may be off by because it has not settled
    uncertainty: float

    @property
    def width(self) -> float:
        """How far off it may be in all."""
        return self.estimate + self.uncertainty


@dataclass(frozen=True)
class Difference:
    """A number computed by two engines, and whether they agree within their claims.

    Attributes:
        case: name of the scene.
        engine: the one.
        other: the one it is held against.
        quantity: one of `QUANTITIES`, or `CONSENSUS`.
        half: "pre" or "post".
        channel: trajectory column; None for the consensus.
        mine: what the engine claims.
        its: what the other claims.
        scale: what differences are shown relative to: the other's value, of an extreme the channel's largest magnitude in its cycle.
    """

    case: str
    engine: str
    other: str
    quantity: str
    half: str
    channel: str | None
    mine: Claim
    its: Claim
    scale: float

    @property
    def difference(self) -> float:
        """Engine less other."""
        return self.mine.value - self.its.value

    @property
    def relative(self) -> float:
        """The difference over the scale."""
        return self.difference / self.scale

    @property
    def ratio(self) -> float:
        """The engine's number over the other's."""
        return self.mine.value / self.its.value

    @property
    def tolerance(self) -> float:
        """How much they may differ by what both claim."""
        return self.mine.width + self.its.width

    @property
    def passed(self) -> bool:
        """Whether they differ by no more; not if a number is none."""
        return abs(self.difference) <= self.tolerance

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON and CSV."""
        own = ("engine", "other", "quantity", "half", "channel", "difference", "tolerance", "scale", "passed")
        claims = {"": self.mine, "other_": self.its}.items()
        numbers = {f"{whose}{name}": value for whose, claim in claims for name, value in vars(claim).items()}
        return {name: getattr(self, name) for name in own} | numbers


@dataclass(frozen=True)
class CaseResult:
    """All engines on one case, and what became of their claims; beside them recorded tables, of which `whole` alone speaks."""

    case: Case
    runs: Mapping[str, Run]
    checks: tuple[Difference, ...] = field(default=())
    recorded: Mapping[str, Run] = field(default_factory=dict)
    table_checks: tuple[Difference, ...] = field(default=())  # tables against engines

    def __repr__(self) -> str:
        runs = ", ".join(f"{name} {run.status}" for name, run in self.whole.runs.items())
        return f"{self.case.name}: {runs}; {len(self.missed)} of {len(self.checks)} checks missed"

    @property
    def turn(self) -> int | None:
        """The turn from the standard start that is compared; None: the steady state."""
        return next((run.turn for run in self.runs.values() if run.turn is not None), None)

    @property
    def whole(self) -> "CaseResult":
        """The same with recorded tables as engines behind the others."""
        return CaseResult(self.case, {**self.runs, **self.recorded}, (*self.checks, *self.table_checks))

    @property
    def passed(self) -> bool | None:
        """Whether every engine delivered and none departs from another by more than both claim; None if nothing could be judged."""
        return not self.failures and not self.missed if self.checks else None

    @property
    def reason(self) -> str:
        """Why `passed` is not true (a clause), "" if it is."""
        if not self.checks:
            if len(self.runs) == 1:
                return "nothing to compare with: one engine alone"
            return "; ".join(
                ["nothing to compare with", *(f"{name}: {not_judged(run) or 'alone with its claims'}" for name, run in self.runs.items())]
            )
        departing = [f"{pair[0]} and {pair[1]} disagree by more than they claim" for pair in self.departures]
        return "; ".join([*departing, *(f"{run.engine} did not deliver: {run.status}" for run in self.failures)])

    @property
    def failures(self) -> tuple[Run, ...]:
        """Runs that failed, did not settle or did not reach the accuracy asked. A refusal is none: the engine says what it is."""
        return tuple(run for run in self.runs.values() if run.ending.exit_code == ExitCode.ENGINE_TROUBLE)

    @property
    def missed(self) -> tuple[Difference, ...]:
        """Where engines differ by more than they claim."""
        return tuple(check for check in self.checks if not check.passed)

    @property
    def departures(self) -> dict[tuple[str, str], list[Difference]]:
        """The same by pair of engines."""
        found: dict[tuple[str, str], list[Difference]] = {}
        for check in self.missed:
            found.setdefault((check.engine, check.other), []).append(check)
        return found

    def accuracy_class(self, name: str) -> str | None:
        """Least class that covers an engine's own estimates and its deviation from the reference ("0.3 %"), or "worse".

        Over consensus frequencies and extremes, these relative to the channel's largest magnitude; of a table over every column.
        None where that is not known: there is no estimate, or the engine estimates its integration alone and
        there is no reference to tell the rest.
        """
        run, reference = self.runs[name], self.runs.get(REFERENCE)
        known = reference is not None and reference.usable and name != REFERENCE
        if not run.usable or (not known if run.estimate_of == "integration" else run.unestimated):
            return None
        sizes = [size for half in HALVES for size in _own_sizes(run, half)]
        if known and reference is not None:
            held = [check for check in self.checks if (check.engine, check.other) == (name, REFERENCE) and check.quantity in EXTREMES]
            extremes = held if run.recording else self.differences(name, "extreme")
            sizes += [abs(found.relative) for found in (*self.differences(name, "frequency"), *extremes)]
        return next((f"{100.0 * width:g} %" for width in CLASSES if max(sizes) <= width), WORSE) if sizes else None

    def differences(
        self, name: str, kind: Kind, other: str = REFERENCE, half: str | None = None, channel: str | None = None
    ) -> list[Difference]:
        """Those of a kind between two engines where both have the number, in both halves and all channels unless one is given."""
        run, opposite = self.runs.get(name), self.runs.get(other)
        if run is None or opposite is None or not (run.usable and opposite.usable):
            return []
        halves, channels = HALVES if half is None else (half,), CHANNELS if channel is None else (channel,)
        places = product(halves, (None,) if kind == "frequency" else channels, KINDS[kind])
        found = (_difference(self.case, run, opposite, quantity, where, column) for where, column, quantity in places)
        return [each for each in found if each is not None]


def cross_validate(
    cases: Sequence[Case],
    workshop: Workshop,
    engines: Sequence[str] = MAIN,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, str]] | None = None,
    tables: Mapping[str, Sequence[RecordedTable]] | None = None,
    beside: Work | None = None,
) -> list[CaseResult]:
    """Bring every engine to its steady state on every case and compare.

    Args:
        cases: what to run.
        workshop: where.
        engines: names.
        accuracy: error of the tip deflection asked of every engine; None: each engine's default.
        settings: of an engine, by its name: setting -> value as text.
        tables: case -> what was recorded of it.
        beside: what else is computed with them and stored.

    Raises:
        CaseError: a case without crank and slider: there is no cycle to measure; a table that is not of its case.
        ValueError: two of the cases or of the engines have one name.
        UnknownEngine: see there.
    """
    recorded = {case.name: {table.name: recorded_run(table, case) for table in (tables or {}).get(case.name, ())} for case in cases}
    requests = {(case.name, engine): _request(case, engine, accuracy, settings) for case in cases for engine in engines}
    if len(requests) < len(cases) * len(engines):
        raise ValueError("two cases or two engines have one name")
    also = beside or Work()
    runs = carry_out({**also.requests, **requests}, workshop, "engines on cases", also.jobs)
    return [compare(case, {engine: runs[case.name, engine] for engine in engines}, recorded[case.name]) for case in cases]


def hold_against_engines(
    case: Case,
    tables: Sequence[RecordedTable],
    workshop: Workshop,
    engines: Sequence[str] = MAIN,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, str]] | None = None,
) -> list[CaseResult]:
    """Hold recorded tables against engines in the state that they show (`cases.runs.recorded`), and the engines against nothing else.

    Arguments and errors are those of `cross_validate`.

    Returns:
        One result for the steady state and one for each turn on the way to it that a table shows.
    """
    groups: dict[int | None, dict[str, Run]] = {}
    for table in tables:
        run = recorded_run(table, case)
        groups.setdefault(run.turn, {})[table.name] = run
    requests = {}
    for turn, group in groups.items():
        end = LONGER * max(float(run.cycle["time"][-1]) for run in group.values())
        for engine in engines:
            request = _request(case, engine, accuracy, settings)
            state = "steady state" if turn is None else f"turn {turn}"
            requests[case.name, engine, state] = request if turn is None else replace(request, turn=turn, duration=end)
    runs = iter(carry_out(requests, workshop, "engines on the case").values())
    results = [compare(case, {engine: next(runs) for engine in engines}, group) for group in groups.values()]
    return [replace(result, checks=()) for result in results]


def _request(case: Case, engine: str, accuracy: float | None, settings: Mapping[str, Mapping[str, str]] | None) -> RunRequest:
    texts = dict((settings or {}).get(engine, {}))
    if not crank_pace(case.mechanism):
        raise CaseError(case.name, "[crank]", None, "the crank stands still: there is no cycle", "give it a torque or a speed")
    return RunRequest(mechanism=case.mechanism, duration=case.duration, engine=engine, accuracy=accuracy, settings=texts)


def compare(case: Case, runs: Mapping[str, Run], recorded: Mapping[str, Run] | None = None) -> CaseResult:
    """Hold every engine against the reference, or where that cannot be judged against the first one that can, and tables against each.

    The runs of engines are all in the steady state or all in the same turn. Where the engines are in the steady state and a recorded
    table is not, it has not settled.
    """
    judged = {name: run for name, run in runs.items() if not not_judged(run)}
    against = judged.get(REFERENCE) or next(iter(judged.values()), None)
    checks = [check for run in judged.values() if against is not None and run is not against for check in _checks(case, run, against)]
    turns = {run.turn for run in runs.values()}
    tables = {name: run if run.turn is None or run.turn in turns else _unsettled(run) for name, run in (recorded or {}).items()}
    of_tables = [check for run in tables.values() if run.usable for other in judged.values() for check in _table_checks(case, run, other)]
    return CaseResult(case, runs, tuple(checks), tables, tuple(of_tables))


def _unsettled(run: Run) -> Run:
    told = f"begins in the standard start and has not settled after {run.cycles} turns; `quickreturn compare` holds it against that turn"
    return replace(run, status=Ending.NOT_SETTLED, remark=f"{run.remark}; {told}" if run.remark else told)


def not_judged(run: Run) -> str:
    """Why a run cannot be held against others (a clause), "" if it can."""
    if not run.usable:
        return run.status
    if run.estimate_of == "integration":
        return "its estimate is of the integration alone, not of its model"
    if run.estimate_of == "unverified":
        return "its estimates are not verified"
    return f"no estimates: {run.unestimated}" if run.unestimated else ""


def _checks(case: Case, run: Run, other: Run) -> list[Difference]:
    places = [(CONSENSUS, None), *product(QUANTITIES, CHANNELS)]
    found = (_difference(case, run, other, quantity, half, channel, claimed=True) for half in HALVES for quantity, channel in places)
    return [check for check in found if check is not None]


def _table_checks(case: Case, table: Run, other: Run) -> list[Difference]:
    """A recorded table held against an engine: what both resolve of the first mode, and the extremes of every column that both have."""
    found = [check for check in _checks(case, table, other) if check.quantity not in EXTREMES]
    filtered = table.recording is not None and table.recording.filtered
    time, angle = other.cycle["time"], other.cycle["crank_angle"]
    for channel in dict.fromkeys(measure.channel for measure in table.measures if measure.channel in other.extreme_estimates):
        its_extremes, scale = extremes_by_half(time, angle, other.cycle[channel], filtered), other.peak(channel)
        known = (other.settling_errors or {}).get(channel)
        unsettled = known if known is not None else (other.settling_error or 0.0) * scale  # of the whole where no more is known
        for half in HALVES:
            for quantity, extreme in zip(EXTREMES, its_extremes[half], strict=True):
                mine = claim(table, quantity, half, channel)
                if mine is not None and not math.isnan(mine.width) and scale > NOTHING:
                    its = Claim(extreme.value, other.extreme_estimates[channel][half], extreme.uncertainty + unsettled)
                    found.append(Difference(case.name, table.engine, other.engine, quantity, half, channel, mine, its, scale))
    return found


def _difference(
    case: Case, run: Run, other: Run, quantity: str, half: str, channel: str | None, claimed: bool = False
) -> Difference | None:
    """A number of two runs; arguments as of `pair_of`. None also where there is no scale."""
    pair = pair_of(run, other, quantity, half, channel, claimed)
    if pair is None:
        return None
    scale = other.peak(channel) if channel and quantity in EXTREMES else abs(pair[1].value)
    return Difference(case.name, run.engine, other.engine, quantity, half, channel, *pair, scale) if scale > 0.0 else None


def pair_of(
    run: Run, other: Run, quantity: str, half: str, channel: str | None = None, claimed: bool = False
) -> tuple[Claim, Claim] | None:
    """The same number of two runs, or None where one of them cannot resolve it.

    Args:
        run: one run.
        other: the other.
        quantity: `CONSENSUS` or a number of `cases.measures.Measure`.
        half: "pre" or "post".
        channel: a trajectory column; None for the consensus, which is over the channels that both resolve.
        claimed: whether numbers without an estimate of their error are left out, and their channels out of the consensus.
    """
    if channel is None:
        shared = [name for name in CHANNELS if pair_of(run, other, VIBRATION[0], half, name, claimed)]
        mine, its = (_consensus(one, half, shared) for one in (run, other))
    else:
        mine, its = (claim(one, quantity, half, channel) for one in (run, other))
    if mine is None or its is None or (claimed and math.isnan(mine.width + its.width)):
        return None
    return mine, its


def claim(run: Run, quantity: str, half: str, channel: str) -> Claim | None:
    """What a run says of a number of a channel; None where it cannot resolve it."""
    measure = run.measure(half, channel)
    value = None if measure is None else measure.number(quantity)
    if measure is None or value is None:
        return None
    estimate, uncertainty = _known(measure.estimate(quantity)), _known(measure.number(f"{quantity}_uncertainty"))
    unsettled = _known((run.settling_errors or {}).get(channel)) if quantity in EXTREMES else 0.0
    return Claim(float(value), estimate, uncertainty + unsettled)


def _consensus(run: Run, half: str, channels: Sequence[str]) -> Claim | None:
    found = consensus_of(half, [measure for channel in channels if (measure := run.measure(half, channel))])
    if found.first_mode_frequency is None:
        return None
    return Claim(found.first_mode_frequency, _known(mean_estimate(run.measures, half, channels)), _known(found.uncertainty))


def _known(number: float | None) -> float:
    return math.nan if number is None else number


def _own_sizes(run: Run, half: str) -> Iterator[float]:
    """A run's own estimates in a half: of the consensus relative to it, of extremes to the peak."""
    for measure in run.measures:
        peak, estimates = run.peak(measure.channel), [measure.estimate(name) for name in EXTREMES]
        if measure.half == half and peak > 0.0:
            yield from (estimate / peak for estimate in estimates if estimate is not None)
    frequency, estimate = run.consensus_frequency(half), mean_estimate(run.measures, half)
    if frequency and estimate is not None:
        yield estimate / frequency
