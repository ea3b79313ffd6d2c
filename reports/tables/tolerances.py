"""What missed its tolerance, and what may explain it."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from cases.comparison import EXTREMES, REFERENCE, CaseResult, Check, values
from cases.engine_run import EngineRun
from reports.tables.table import Cell, Column, Table, TableBuilder
from reports.words import HALF, QUANTITY, case_label, channel_name

#: An error of a signal of some RMS may move its extreme by this many times as much.
EXTREME_OVER_ERROR: Final = 3.0
#: The slider is at a gauge within this part of the follower's length: half of one of sixteen elements.
KINK: Final = 1.0 / 32.0
#: What is in excess by less than this part of a tolerance's width is marginal.
MARGINAL: Final = 0.1


def missed(results: Sequence[CaseResult]) -> Table:
    """One row per missed tolerance, the engine's own error estimates beside it."""
    builder = TableBuilder(
        "missed_tolerances",
        "Every tolerance missed. Deviation: as the tolerance defines it; for an extreme, relative to the channel's largest magnitude in the"
        " reference's cycle. Share: the value's size over that magnitude. Estimates: the engine's and the reference's own error estimates"
        " of this channel (tip deflection for frequencies) over the case's duration.",
        (
            Column("case", "run"),
            Column("engine", "engine"),
            Column("quantity", "quantity"),
            Column("half", "half"),
            Column("channel", "channel"),
            Column("value", "value", "SI", ".4g"),
            Column("reference", "reference", "SI", ".4g"),
            Column("kind", "kind", in_page=False),
            Column("deviation", "deviation", "1", "+.2f", "%", 100.0),
            Column("low", "from", "1", "+.1f", "%", 100.0, group="accepted"),
            Column("high", "to", "1", "+.1f", "%", 100.0, group="accepted"),
            Column("share", "share", "1", ".2f"),
            Column("own_estimate", "engine", "1", ".2g", "%", 100.0, group="error estimate"),
            Column("reference_estimate", "reference", "1", ".2g", "%", 100.0, group="error estimate"),
            Column("cause", "what the numbers suggest"),
        ),
        grouped=True,
    )
    for result in results:
        for check in result.missed:
            builder.add(**_row(result, check))
    return builder.table()


def _row(result: CaseResult, check: Check) -> dict[str, Any]:
    run, reference = result.runs[check.engine], result.runs[REFERENCE]
    pair = values(run, reference, check.quantity, check.half, check.channel)
    assert pair is not None  # without both numbers there is no check
    peak = reference.peak(check.channel) if check.channel and check.quantity in EXTREMES else None
    offset = 1.0 if check.tolerance.kind == "ratio" else 0.0  # a ratio is shown as its excess over 1, like the other kind
    return {
        "case": Cell(result.case.name, case_label(result.case.name)),
        "engine": check.engine,
        "quantity": Cell(check.quantity, QUANTITY[check.quantity]),
        "half": Cell(check.half, HALF[check.half]),
        "channel": Cell(check.channel, channel_name(check.channel)),
        "value": pair[0],
        "reference": pair[1],
        "kind": check.tolerance.kind,
        "deviation": Cell(check.deviation - offset, mark="missed"),
        "low": check.tolerance.low - offset,
        "high": check.tolerance.high - offset,
        "share": None if peak is None else abs(pair[1]) / peak,
        "own_estimate": _estimate(run, check.channel),
        "reference_estimate": _estimate(reference, check.channel),
        "cause": cause(result, check),
    }


def cause(result: CaseResult, check: Check) -> str:
    """What the numbers at hand suggest as the cause of a missed tolerance; the thresholds are in the words."""
    run, reference = result.runs[check.engine], result.runs[REFERENCE]
    size = abs(check.deviation - (1.0 if check.tolerance.kind == "ratio" else 0.0))
    excess = max(check.deviation - check.tolerance.high, check.tolerance.low - check.deviation)
    found = []
    if check.quantity in EXTREMES:
        estimates = [_estimate(run, check.channel), _estimate(reference, check.channel)]
        if EXTREME_OVER_ERROR * sum(estimate or 0.0 for estimate in estimates) >= size:
            found.append(f"discretization: within {EXTREME_OVER_ERROR:g} times the engines' own estimates for this channel")
        if _slider_at_gauge(result, check):
            found.append("at this instant the slider passes the gauge, where the curvature has a kink that elements and links round off")
    else:
        uncertainty = _frequency_uncertainty(reference, check)
        if uncertainty is not None and uncertainty >= excess:
            found.append("the measure: its own uncertainty is larger than what is in excess")
    if not run.document.get("reached", True):
        found.append(f"{check.engine} does not reach the accuracy asked, by its own estimate")
    if excess < MARGINAL * (check.tolerance.high - check.tolerance.low):
        found.append(f"marginal: in excess by less than {MARGINAL:.0%} of the tolerance's width")
    return "; ".join(found) or "not explained by the numbers at hand"


def _slider_at_gauge(result: CaseResult, check: Check) -> bool:
    """Whether the reference's extreme of a strain happens while the slider is within `KINK` of the gauge."""
    follower = result.case.mechanism.follower
    if check.channel is None or not check.channel.startswith("strain_"):
        return False
    cycle = result.runs[REFERENCE].cycle
    turned = np.abs(cycle["crank_angle"] - cycle["crank_angle"][0])
    here = turned <= np.pi if check.half == "pre" else turned >= np.pi
    signal = cycle[check.channel] if check.quantity == "maximum" else -cycle[check.channel]
    instant = int(np.argmax(np.where(here, signal, -np.inf)))
    gauge = follower.strain_gauges[int(check.channel[-1]) - 1]
    return bool(abs(cycle["slider_position"][instant] - gauge) <= KINK * follower.length)


def _estimate(run: EngineRun, channel: str | None) -> float | None:
    estimates = run.document.get("error_estimates") or {}
    found = estimates.get(channel or "tip_deflection")
    return None if found is None else float(found)


def _frequency_uncertainty(reference: EngineRun, check: Check) -> float | None:
    """Of the reference's frequency, relative."""
    if check.channel is None:
        frequency = reference.consensus_frequency(check.half)
        widths = [found["uncertainty"] for found in reference.document["consensus"] if found["half"] == check.half]
        return widths[0] / frequency if frequency else None
    measure = reference.measure(check.half, check.channel)
    if measure is None or not measure["first_mode_frequency"]:
        return None
    return float(measure["first_mode_frequency_uncertainty"] / measure["first_mode_frequency"])


def summary(results: Sequence[CaseResult]) -> Table:
    """Per engine and quantity: how many tolerances there were and how many were missed, with their reason."""
    builder = TableBuilder(
        "tolerances",
        "Tolerances against the reference, with their reasons. A tolerance is checked wherever both engines have the number.",
        (
            Column("engine", "engine"),
            Column("quantity", "quantity"),
            Column("low", "from", "1", "+.1f", "%", 100.0, group="accepted"),
            Column("high", "to", "1", "+.1f", "%", 100.0, group="accepted"),
            Column("checked", "checked", form="d"),
            Column("missed", "missed", form="d"),
            Column("reason", "reason for the width"),
        ),
        grouped=True,
    )
    groups: dict[tuple[str, str, str, str], list[Check]] = {}
    for check in (check for result in results for check in result.checks):
        groups.setdefault((check.engine, check.quantity, check.tolerance.kind, check.tolerance.reason), []).append(check)
    for (engine, quantity, kind, reason), checks in groups.items():
        offset = 1.0 if kind == "ratio" else 0.0
        low, high = max(check.tolerance.low for check in checks) - offset, min(check.tolerance.high for check in checks) - offset
        widened = "; widened by the uncertainties of both measures, the narrowest is shown"
        failed = sum(not check.passed for check in checks)
        builder.add(
            engine=engine,
            quantity=Cell(quantity, QUANTITY[quantity]),
            low=low,
            high=high,
            checked=len(checks),
            missed=Cell(failed, mark="missed" if failed else ""),
            reason=reason + (widened if checks[0].tolerance.measure_uncertainty else ""),
        )
    return builder.table()
