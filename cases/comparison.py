"""Engines against the reference, case by case, with the tolerances of the cases' data."""

import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import Any, Final

from cases.case import Case
from cases.engine_run import EngineRun
from cases.measures import CHANNELS
from cases.measures.consensus import Consensus, consensus
from cases.steady_run import REFUSED, SETTLED
from cases.tolerances import Tolerance, tolerances_for

REFERENCE: Final = "reference"
HALVES: Final = ("pre", "post")
EXTREMES: Final = ("minimum", "maximum")


@dataclass(frozen=True)
class Check:
    """One deviation held against its tolerance; `channel` is None for the consensus."""

    engine: str
    quantity: str
    half: str
    channel: str | None
    deviation: float
    tolerance: Tolerance

    @property
    def passed(self) -> bool:
        """Whether the deviation is accepted."""
        return self.tolerance.accepts(self.deviation)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON and CSV."""
        return {
            "engine": self.engine,
            "quantity": self.quantity,
            "half": self.half,
            "channel": self.channel,
            "kind": self.tolerance.kind,
            "deviation": self.deviation,
            "low": self.tolerance.low,
            "high": self.tolerance.high,
            "passed": self.passed,
            "reason": self.tolerance.reason,
        }


@dataclass(frozen=True)
class CaseResult:
    """All engines on one case and what became of its tolerances."""

    case: Case
    runs: Mapping[str, EngineRun]
    checks: tuple[Check, ...] = field(default=())

    @property
    def passed(self) -> bool:
        """Whether every engine completed and every tolerance was met."""
        return not self.failures and all(check.passed for check in self.checks)

    @property
    def failures(self) -> tuple[EngineRun, ...]:
        """Runs that failed, did not settle or did not reach the accuracy asked. A refusal is none: the engine says what it is."""
        return tuple(run for run in self.runs.values() if run.status not in (SETTLED, REFUSED))

    @property
    def missed(self) -> tuple[Check, ...]:
        """Tolerances missed."""
        return tuple(check for check in self.checks if not check.passed)


def compare(case: Case, runs: Mapping[str, EngineRun]) -> CaseResult:
    """Hold every engine's measures against the reference's, where both have them."""
    reference = runs.get(REFERENCE)
    checks: list[Check] = []
    if reference is not None and reference.usable:
        for name, run in runs.items():
            if name != REFERENCE and run.usable:
                tolerances = tolerances_for(case.name, case.tags, name)
                for tolerance in tolerances:
                    own = {other.channel for other in tolerances if other.quantity == tolerance.quantity and other.channel}
                    checks += _checks(name, run, reference, tolerance, own)
    return CaseResult(case, runs, tuple(checks))


def _checks(name: str, run: EngineRun, reference: EngineRun, tolerance: Tolerance, own: Set[str]) -> list[Check]:
    """The checks of one tolerance; one for all channels leaves out those that have a tolerance of their `own`."""
    found = []
    for half in HALVES:
        if tolerance.half not in (None, half):
            continue
        channels = (None,) if tolerance.quantity == "consensus_frequency" else _channels(tolerance, own)
        for channel in channels:
            pair = values(run, reference, tolerance.quantity, half, channel)
            if pair is None:
                continue
            scale = reference.peak(channel) if channel and tolerance.quantity in EXTREMES else abs(pair[1])
            if scale > 0.0:
                deviation = tolerance.deviation(pair[0], pair[1], scale)
                uncertainty = (
                    0.0 if tolerance.quantity in EXTREMES else abs(deviation) * _relative_uncertainty(run, reference, half, channel)
                )
                found.append(Check(name, tolerance.quantity, half, channel, deviation, tolerance.widened(uncertainty)))
    return found


def _channels(tolerance: Tolerance, own: Set[str]) -> tuple[str, ...]:
    return (tolerance.channel,) if tolerance.channel else tuple(channel for channel in CHANNELS if channel not in own)


def values(run: EngineRun, other: EngineRun, quantity: str, half: str, channel: str | None) -> tuple[float, float] | None:
    """The same quantity of two runs, or None where one of them cannot resolve it.

    Args:
        run: one run.
        other: the other.
        quantity: "consensus_frequency" or a number of `cases.measures.Measure`.
        half: "pre" or "post".
        channel: a trajectory column; None for the consensus.
    """
    if quantity == "consensus_frequency" or channel is None:
        shared = _shared(run, other, half)
        pair = _consensus(run, half, shared).first_mode_frequency, _consensus(other, half, shared).first_mode_frequency
    else:
        mine, its = run.measure(half, channel), other.measure(half, channel)
        if mine is None or its is None:
            return None
        pair = mine[quantity], its[quantity]
    return None if pair[0] is None or pair[1] is None else (float(pair[0]), float(pair[1]))


def _consensus(run: EngineRun, half: str, channels: Sequence[str]) -> Consensus:
    """Consensus over the given channels: two runs can be compared over those only that both resolve."""
    measures = [measure for channel in channels if (measure := run.measure(half, channel))]
    frequencies = [measure["first_mode_frequency"] for measure in measures]
    return consensus(half, frequencies, [measure["first_mode_frequency_uncertainty"] for measure in measures])


def _shared(run: EngineRun, other: EngineRun, half: str) -> list[str]:
    return [name for name in CHANNELS if values(run, other, "first_mode_frequency", half, name)]


def _relative_uncertainty(run: EngineRun, other: EngineRun, half: str, channel: str | None) -> float:
    """Claimed uncertainties of both first-mode frequencies relative to their values, in quadrature; zero where not resolvable."""
    channels = [name for name in _shared(run, other, half) if channel in (None, name)]
    both = [_consensus(one, half, channels) for one in (run, other)]
    return math.hypot(*(c.uncertainty / c.first_mode_frequency for c in both if c.first_mode_frequency and c.uncertainty))


def largest_differences(run: EngineRun, other: EngineRun) -> dict[str, float | None]:
    """Largest relative difference over halves and channels, per kind of quantity; None where nothing can be compared.

    "frequency" and "amplitude" are relative to the other's value, "extremes" to the channel's largest magnitude in the other's cycle.
    """
    groups = {"frequency": ("first_mode_frequency",), "amplitude": ("first_mode_amplitude",), "extremes": EXTREMES}
    found: dict[str, float | None] = {}
    for group, quantities in groups.items():
        differences = []
        for half in HALVES:
            for channel in CHANNELS:
                for quantity in quantities:
                    pair = values(run, other, quantity, half, channel)
                    if pair is None:
                        continue
                    scale = other.peak(channel) if group == "extremes" else abs(pair[1])
                    if scale > 0.0:
                        differences.append(abs(pair[0] - pair[1]) / scale)
        found[group] = max(differences) if differences else None
    return found
