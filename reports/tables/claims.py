"""What engines claim, where they differ by more, and how good each of them is."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from cases.runs.comparison import CLASSES, WORSE, CaseResult, Check
from cases.runs.estimates import EXTREMES
from reports.findings.agreement import engines_of
from reports.tables.table import Cell, Column, Table, TableBuilder
from reports.words import HALF, QUANTITY, case_label, channel_name

#: The slider is at a gauge within this part of the follower's length: half of one of sixteen elements.
KINK: Final = 1.0 / 32.0
#: What exceeds a tolerance by less than this part of it is marginal.
MARGINAL: Final = 0.1


def departures(results: Sequence[CaseResult]) -> Table:
    """One row per number in which two engines differ by more than they claim."""
    builder = TableBuilder(
        "departures",
        "Every number in which two engines differ by more than they claim. Difference, claims and tolerance are relative to the other"
        " engine's value, of an extreme to the channel's largest magnitude in its cycle. A claim is the engine's own estimate of this"
        " number's error and the uncertainty of its measurement; the tolerance is the sum of both engines' claims. Share: the value's size"
        " over that magnitude.",
        (
            Column("case", "run"),
            Column("engine", "engine"),
            Column("other", "against"),
            Column("quantity", "quantity"),
            Column("half", "half"),
            Column("channel", "channel"),
            Column("value", "value", "SI", ".4g"),
            Column("other_value", "other value", "SI", ".4g"),
            Column("difference", "difference", "1", "+.2f", "%", 100.0),
            Column("tolerance", "tolerance", "1", ".2f", "%", 100.0),
            Column("claim", "engine", "1", ".2g", "%", 100.0, group="claim"),
            Column("other_claim", "other", "1", ".2g", "%", 100.0, group="claim"),
            Column("share", "share", "1", ".2f"),
            Column("cause", "what the numbers suggest"),
        ),
    )
    for result in results:
        for check in result.missed:
            builder.add(**_departure(result, check))
    return builder.table()


def table_departures(results: Sequence[CaseResult]) -> Table:
    """One row per number in which a recorded table and an engine differ by more than the engine claims and the measures are uncertain."""
    builder = TableBuilder(
        "table_departures",
        "Every number in which a recorded table and an engine differ by more than the uncertainty of the measures and the engine's own"
        " estimate together, relative to the engine's value, of an extreme to the column's largest magnitude in the turn.",
        (
            Column("case", "run"),
            Column("table", "table"),
            Column("other", "against"),
            Column("quantity", "quantity"),
            Column("half", "half"),
            Column("channel", "column"),
            Column("value", "value", "SI", ".4g"),
            Column("other_value", "engine's value", "SI", ".4g"),
            Column("difference", "difference", "1", "+.2f", "%", 100.0),
            Column("tolerance", "tolerance", "1", ".2f", "%", 100.0),
        ),
    )
    for result in results:
        for check in (check for check in result.table_checks if not check.passed):
            builder.add(
                case=Cell(result.case.name, case_label(result.case.name)),
                table=check.engine,
                other=check.other,
                quantity=Cell(check.quantity, QUANTITY[check.quantity]),
                half=Cell(check.half, HALF[check.half]),
                channel=Cell(check.channel, channel_name(check.channel)),
                value=check.mine.value,
                other_value=check.its.value,
                difference=check.difference / check.scale,
                tolerance=check.tolerance / check.scale,
            )
    return builder.table()


def _departure(result: CaseResult, check: Check) -> dict[str, Any]:
    return {
        "case": Cell(result.case.name, case_label(result.case.name)),
        "engine": check.engine,
        "other": check.other,
        "quantity": Cell(check.quantity, QUANTITY[check.quantity]),
        "half": Cell(check.half, HALF[check.half]),
        "channel": Cell(check.channel, channel_name(check.channel)),
        "value": check.mine.value,
        "other_value": check.its.value,
        "difference": Cell(check.difference / check.scale, mark="missed"),
        "tolerance": check.tolerance / check.scale,
        "claim": check.mine.width / check.scale,
        "other_claim": check.its.width / check.scale,
        "share": abs(check.its.value) / check.scale if check.quantity in EXTREMES else None,
        "cause": cause(result, check),
    }


def cause(result: CaseResult, check: Check) -> str:
    """What the numbers at hand suggest as the cause of a departure; the thresholds are in the words."""
    found = []
    if check.quantity in EXTREMES and _slider_at_gauge(result, check):
        found.append("at this instant the slider passes the gauge, where the curvature has a kink that elements and links round off")
    missed = [name for name in (check.engine, check.other) if not result.runs[name].reached]
    found += [f"{name} does not reach the accuracy asked, by its own estimate" for name in missed]
    if abs(check.difference) < (1.0 + MARGINAL) * check.tolerance:
        found.append(f"marginal: beyond the tolerance by less than {MARGINAL:.0%} of it")
    return "; ".join(found) or "not explained by the numbers at hand"


def _slider_at_gauge(result: CaseResult, check: Check) -> bool:
    """Whether the other engine's extreme of a strain happens while the slider is within `KINK` of the gauge."""
    follower = result.case.mechanism.follower
    if check.channel is None or not check.channel.startswith("strain_"):
        return False
    cycle = result.runs[check.other].cycle
    turned = np.abs(cycle["crank_angle"] - cycle["crank_angle"][0])
    here = turned <= np.pi if check.half == "pre" else turned >= np.pi
    signal = cycle[check.channel] if check.quantity == "maximum" else -cycle[check.channel]
    instant = int(np.argmax(np.where(here, signal, -np.inf)))
    gauge = follower.strain_gauges[int(check.channel[-1]) - 1]
    return bool(abs(cycle["slider_position"][instant] - gauge) <= KINK * follower.length)


def summary(results: Sequence[CaseResult]) -> Table:
    """Per pair of engines and quantity: how much was compared, with what tolerance, and how much of it was used."""
    builder = TableBuilder(
        "compared",
        "What was compared. Tolerance: what both engines claim together, relative as above, median. Used: the difference over the"
        " tolerance; beyond 1 the engines differ by more than they claim.",
        (
            Column("engine", "engine"),
            Column("other", "against"),
            Column("quantity", "quantity"),
            Column("compared", "compared", form="d"),
            Column("beyond", "beyond", form="d"),
            Column("tolerance", "tolerance", "1", ".2g", "%", 100.0),
            Column("used_median", "median", "1", ".2f", group="used"),
            Column("used_most", "most", "1", ".2f", group="used"),
        ),
    )
    groups: dict[tuple[str, str, str], list[Check]] = {}
    for check in (check for result in results for check in result.checks):
        groups.setdefault((check.engine, check.other, check.quantity), []).append(check)
    for (engine, other, quantity), checks in groups.items():
        used = [abs(check.difference) / check.tolerance for check in checks if check.tolerance > 0.0]
        beyond = sum(not check.passed for check in checks)
        builder.add(
            engine=engine,
            other=other,
            quantity=Cell(quantity, QUANTITY[quantity]),
            compared=len(checks),
            beyond=Cell(beyond, mark="missed" if beyond else ""),
            tolerance=float(np.median([check.tolerance / check.scale for check in checks])),
            used_median=float(np.median(used)) if used else None,
            used_most=max(used, default=None),
        )
    return builder.table()


def classes(results: Sequence[CaseResult]) -> Table:
    """Per engine: on how many runs it is how good."""
    names = [*(f"{100.0 * width:g} %" for width in CLASSES), WORSE, "unknown"]
    builder = TableBuilder(
        "accuracy_classes",
        "How good each engine is: on how many runs the accuracy class is the least that covers the engine's own estimates and its deviation"
        " from the reference, in the consensus frequencies and in all extremes (relative to the channel's largest magnitude).",
        (Column("engine", "engine"), *(Column(f"class {name}", name, form="d", group="class") for name in names)),
    )
    for engine in engines_of(results):
        found = [result.accuracy_class(engine) or "unknown" for result in results if engine in result.runs]
        builder.add(engine=engine, **{f"class {name}": found.count(name) for name in names})
    return builder.table()
