"""Tables of the engines' claims, of larger differences, and of accuracy classes."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from quickreturn.cases.runs.comparison import CLASSES, WORSE, CaseResult, Difference, agreement
from quickreturn.cases.runs.estimates import EXTREMES, VIBRATION
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.findings.agreement import engines_of, outward
from quickreturn.reports.findings.sharpness import Sharpness
from quickreturn.reports.tables.table import CASE, CHANNEL, HALF_COLUMN, QUANTITY_COLUMN, Cell, Column, Table

#: Distance over the follower's length within which the slider counts as at a gauge: half of one of sixteen elements.
KINK: Final = 1.0 / 32.0
#: A difference is marginal if it exceeds its tolerance by less than this part of it.
MARGINAL: Final = 0.1
#: Columns of every table of comparisons.
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
    table = Table("departures", columns)
    for result in results:
        for check in result.missed:
            table.add(
                check,
                **_compared(result, check) | {"difference": Cell(_shown_difference(check), mark="missed")},
                claim=check.mine.width / check.scale,
                other_claim=check.its.width / check.scale,
                share=abs(check.its.value) / check.scale if check.quantity in EXTREMES else None,
                cause=cause(result, check),
            )
    return table


def table_departures(results: Sequence[CaseResult]) -> Table:
    """One row per number of a recorded table that differs from an engine's by more than claim and uncertainty of the measures."""
    of_tables = {"engine": Column("table"), "channel": replace(CHANNEL, head="column")}
    of_tables["other_value"] = Column("other_value", "engine's value", "SI", ".4g")
    table = Table("table_departures", [of_tables.get(column.key, column) for column in _COMPARISON])
    for result in results:
        for check in (check for check in result.table_checks if not check.passed):
            table.add(check, table=check.engine, **_compared(result, check))
    return table


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
    """The likely causes of a departure, as far as the numbers at hand show them (clauses)."""
    causes = []
    if check.quantity in EXTREMES and _slider_at_gauge(result, check):
        causes.append("at this instant the slider passes the gauge, where the curvature has a kink that elements and links round off")
    missed = [name for name in (check.engine, check.other) if not result.runs[name].reached]
    causes += [f"{name} does not reach the accuracy asked, by its own estimate" for name in missed]
    if abs(check.difference) < (1.0 + MARGINAL) * check.tolerance:
        causes.append(f"marginal: beyond the tolerance by less than {MARGINAL:.0%} of it")
    return "; ".join(causes) or "not explained by the numbers at hand"


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
    """Per pair of engines and quantity: the number of comparisons, the tolerance, and the part of it that was used."""
    columns = (
        "engine",
        Column("other", "against"),
        QUANTITY_COLUMN,
        Column("compared", form="d"),
        Column("beyond", form="d"),
        Column("say_nothing", form="d"),
        Column("tolerance", unit="%", form=".2g"),
        Column("used_median", "median", "1", ".2f", group="used"),
        Column("used_most", "most", "1", ".2f", group="used"),
    )
    table = Table("compared", columns)
    groups: dict[tuple[str, str, str], list[Difference]] = {}
    for check in (check for result in results for check in result.checks):
        groups.setdefault((check.engine, check.other, check.quantity), []).append(check)
    for (engine, other, quantity), checks in groups.items():
        used = [abs(check.difference) / check.tolerance for check in checks if check.tolerance > 0.0]
        beyond = sum(not check.passed for check in checks)
        table.add(
            engine=engine,
            other=other,
            quantity=quantity,
            compared=len(checks),
            beyond=Cell(beyond, mark="missed" if beyond else ""),
            say_nothing=agreement(checks)["says_nothing"],
            tolerance=float(np.median([check.tolerance / check.scale for check in checks])),
            used_median=float(np.median(used)) if used else None,
            used_most=max(used, default=None),
        )
    return table


def every_comparison(results: Sequence[CaseResult]) -> Table:
    """A file: one row per comparison of two engines, agreeing or not, in SI units.

    The tolerance is the sum of estimates, measurements and settling, each the sum of both engines'; `why` names the runs that show the
    estimates.
    """
    names = ("case", "engine", "other", "quantity", "half", "channel", "value", "other_value", "estimate", "measurement", "settling")
    table = Table("comparisons", (*names, "tolerance", "verdict", "unit", "why"), in_page=False)
    for result in results:
        for check in result.checks:
            both = {name: getattr(check.mine, name) + getattr(check.its, name) for name in ("estimate", "measurement", "settling")}
            unit = "Hz" if check.channel is None or check.quantity == VIBRATION[0] else COLUMNS[check.channel].unit
            why = "; ".join(check.why)
            table.add(check, case=result.case.name, value=check.mine.value, other_value=check.its.value, unit=unit, why=why, **both)
    return table


def sharp(rows: Sequence[Sharpness]) -> Table:
    """Per pair of engines and kind of numbers: the smallest error that the comparison finds."""
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
    for row in rows:
        table.add(row)
    return table


def classes(results: Sequence[CaseResult]) -> Table:
    """Per engine: the number of runs in each accuracy class."""
    names = [*(f"{100.0 * width:g} %" for width in CLASSES), WORSE, "unknown"]
    table = Table("accuracy_classes", ("engine", *(Column(f"class {name}", name, form="d", group="class") for name in names)))
    for engine in engines_of(results):
        reached = [result.accuracy_class(engine) or "unknown" for result in results if engine in result.runs]
        table.add(engine=engine, **{f"class {name}": reached.count(name) for name in names})
    return table
