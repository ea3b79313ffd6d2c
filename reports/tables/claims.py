"""What engines claim, where they differ by more, and how good each of them is."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from quickreturn.cases.runs.comparison import CLASSES, WORSE, CaseResult, Difference
from quickreturn.cases.runs.estimates import EXTREMES
from quickreturn.reports.findings.agreement import engines_of, outward
from quickreturn.reports.findings.sharpness import Sharpness
from quickreturn.reports.tables.table import CASE, CHANNEL, HALF_COLUMN, QUANTITY_COLUMN, Cell, Column, Table

#: The slider is at a gauge within this part of the follower's length: half of one of sixteen elements.
KINK: Final = 1.0 / 32.0
#: What exceeds a tolerance by less than this part of it is marginal.
MARGINAL: Final = 0.1
#: Of one comparison, in every table of them.
_COMPARISON: Final = (
    CASE,
    Column("engine"),
    Column("other", "against"),
    QUANTITY_COLUMN,
    HALF_COLUMN,
    CHANNEL,
    Column("value", unit="SI", form=".4g"),
    Column("other_value", unit="SI", form=".4g"),
    Column("difference", unit="%", form="+.2f"),
    Column("tolerance", unit="%", form=".2f"),
)


def departures(results: Sequence[CaseResult]) -> Table:
    """One row per number in which two engines differ by more than they claim."""
    columns = (
        *_COMPARISON,
        Column("claim", "engine", "%", ".2g", group="claim"),
        Column("other_claim", "other", "%", ".2g", group="claim"),
        Column("share", unit="1", form=".2f"),
        Column("cause", "what the numbers suggest"),
    )
    found = Table("departures", columns)
    for result in results:
        for check in result.missed:
            found.add(
                check,
                **_compared(result, check) | {"difference": Cell(_shown_difference(check), mark="missed")},
                claim=check.mine.width / check.scale,
                other_claim=check.its.width / check.scale,
                share=abs(check.its.value) / check.scale if check.quantity in EXTREMES else None,
                cause=cause(result, check),
            )
    return found


def table_departures(results: Sequence[CaseResult]) -> Table:
    """One row per number in which a recorded table and an engine differ by more than the engine claims and the measures are uncertain."""
    of_tables = {"engine": Column("table"), "channel": replace(CHANNEL, head="column")}
    of_tables["other_value"] = Column("other_value", "engine's value", "SI", ".4g")
    found = Table("table_departures", [of_tables.get(column.key, column) for column in _COMPARISON])
    for result in results:
        for check in (check for check in result.table_checks if not check.passed):
            found.add(check, table=check.engine, **_compared(result, check))
    return found


def _compared(result: CaseResult, check: Difference) -> dict[str, Any]:
    return {
        "case": result.case.name,
        "value": check.mine.value,
        "other_value": check.its.value,
        "difference": _shown_difference(check),
        "tolerance": check.tolerance / check.scale,
    }


def _shown_difference(check: Difference) -> float:
    return outward(check.quantity, check.difference) / check.scale


def cause(result: CaseResult, check: Difference) -> str:
    """What the numbers at hand suggest as the cause of a departure; the thresholds are in the words."""
    found = []
    if check.quantity in EXTREMES and _slider_at_gauge(result, check):
        found.append("at this instant the slider passes the gauge, where the curvature has a kink that elements and links round off")
    missed = [name for name in (check.engine, check.other) if not result.runs[name].reached]
    found += [f"{name} does not reach the accuracy asked, by its own estimate" for name in missed]
    if abs(check.difference) < (1.0 + MARGINAL) * check.tolerance:
        found.append(f"marginal: beyond the tolerance by less than {MARGINAL:.0%} of it")
    return "; ".join(found) or "not explained by the numbers at hand"


def _slider_at_gauge(result: CaseResult, check: Difference) -> bool:
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
    columns = (
        "engine",
        Column("other", "against"),
        QUANTITY_COLUMN,
        Column("compared", form="d"),
        Column("beyond", form="d"),
        Column("tolerance", unit="%", form=".2g"),
        Column("used_median", "median", "1", ".2f", group="used"),
        Column("used_most", "most", "1", ".2f", group="used"),
    )
    found = Table("compared", columns)
    groups: dict[tuple[str, str, str], list[Difference]] = {}
    for check in (check for result in results for check in result.checks):
        groups.setdefault((check.engine, check.other, check.quantity), []).append(check)
    for (engine, other, quantity), checks in groups.items():
        used = [abs(check.difference) / check.tolerance for check in checks if check.tolerance > 0.0]
        beyond = sum(not check.passed for check in checks)
        found.add(
            engine=engine,
            other=other,
            quantity=quantity,
            compared=len(checks),
            beyond=Cell(beyond, mark="missed" if beyond else ""),
            tolerance=float(np.median([check.tolerance / check.scale for check in checks])),
            used_median=float(np.median(used)) if used else None,
            used_most=max(used, default=None),
        )
    return found


def sharp(found: Sequence[Sharpness]) -> Table:
    """Per pair of engines and kind of numbers: how small an error the comparison finds."""
    columns = (
        "engine",
        Column("other", "against"),
        Column("kind", "numbers", words=lambda kind: "peak" if kind == "extreme" else str(kind)),
        Column("compared", form="d"),
        Column("tolerance", unit="%", form=".2g"),
        Column("used", "most used", "1", ".2f"),
        Column("found_somewhere", "in one at least", "%", ".2g", group="smallest error that is found"),
        Column("found_mostly", "in half of them", "%", ".2g", group="smallest error that is found"),
    )
    table = Table("sharpness", columns)
    for each in found:
        table.add(each)
    return table


def classes(results: Sequence[CaseResult]) -> Table:
    """Per engine: on how many runs it is how good."""
    names = [*(f"{100.0 * width:g} %" for width in CLASSES), WORSE, "unknown"]
    found = Table("accuracy_classes", ("engine", *(Column(f"class {name}", name, form="d", group="class") for name in names)))
    for engine in engines_of(results):
        reached = [result.accuracy_class(engine) or "unknown" for result in results if engine in result.runs]
        found.add(engine=engine, **{f"class {name}": reached.count(name) for name in names})
    return found
