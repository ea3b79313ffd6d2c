"""Compares engines with each other, case by case, with tolerances from their claims.

The tolerance of a measure is the sum of both engines' claims: their own error estimates in the settled cycle (`cases.motion.estimates`),
what is left to the steady state, and the uncertainty of the measurement. So a coarse engine with a right estimate agrees, and one that
claims too small an error departs. The accuracy class says how good an engine is. An engine whose estimate does not cover its whole error is
not judged: its difference is a result.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Final

from quickreturn.cases.comparison.causes import Explanation
from quickreturn.cases.comparison.pair import CONSENSUS, KINDS, QUANTITIES, Difference, Kind, Pair
from quickreturn.cases.files.case import Case
from quickreturn.cases.motion.cycle import EXTREMES, HALVES, VIBRATION, extremes_by_half
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.estimates import mean_estimate
from quickreturn.cases.motion.number import SAYS_NOTHING, VERDICTS
from quickreturn.cases.motion.request import NOTHING, Run
from quickreturn.cases.motion.time_scale import CHANNELS

REFERENCE: Final = "reference"
#: Accuracy classes, relative errors: an engine is in the least one that covers its estimates and its deviation.
CLASSES: Final = (0.001, 0.003, 0.01, 0.03, 0.1)
WORSE: Final = "worse"


@dataclass(frozen=True)
class CaseResult:
    """All engines on one case, and the verdict on their claims; also recorded tables, which only `with_tables` includes."""

    case: Case
    runs: Mapping[str, Run]  # by name of the engine
    checks: tuple[Difference, ...] = field(default=())  # engines against each other
    recorded: Mapping[str, Run] = field(default_factory=dict)  # by name of the recorded table
    table_checks: tuple[Difference, ...] = field(default=())  # tables against engines
    leads: Mapping[str, tuple[Explanation, ...]] = field(default_factory=dict)  # by name of the table: quantities that were tried on it

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
                ["nothing to compare with", *(f"{name}: {not_judged(run) or 'alone with its claims'}" for name, run in self.runs.items())]
            )
        if self.passed is None:
            return f"all {len(self.checks)} comparisons say nothing: what is claimed is more than {SAYS_NOTHING}"
        departing = [f"{pair[0]} and {pair[1]} disagree by more than they claim" for pair in self.departures]
        return "; ".join([*departing, *(f"{run.engine} did not deliver: {run.status}" for run in self.failures)])

    @cached_property
    def _pairs(self) -> dict[tuple[str, str], Pair]:
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
        pair = self._pairs.setdefault((name, other), Pair(run, opposite, self.case.name))
        differences = (pair.difference(quantity, where, column) for where, column, quantity in places)
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
    places, pair = [(CONSENSUS, None), *product(QUANTITIES, CHANNELS)], Pair(run, other, case.name, claimed=True)
    checks = (pair.difference(quantity, half, channel) for half in HALVES for quantity, channel in places)
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


def _relative_estimates(run: Run, half: str) -> Iterator[float]:
    """A run's relative error estimates in a half: of extremes relative to the channel's peak, of the consensus relative to itself."""
    for measure in run.measured.measures:
        peak, estimates = run.peak(measure.channel), [getattr(measure, f"{name}_estimate") for name in EXTREMES]
        if measure.half == half and peak > 0.0:
            yield from (estimate / peak for estimate in estimates if estimate is not None)
    frequency, estimate = run.consensus_frequency(half), mean_estimate(run.measured.measures, half)
    if frequency and estimate is not None:
        yield estimate / frequency
