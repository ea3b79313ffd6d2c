"""How sharp the cross-check is: errors that it finds, and whether cycles depend on the start."""

import math
from collections.abc import Sequence
from typing import Any

from quickreturn.plugins.thesis.page_data import ThesisData
from quickreturn.plugins.thesis.sharpness import SIZES, Planted, found_words
from quickreturn.plugins.thesis.starts import Start
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.tables import Column, Table
from quickreturn.reports.words import counted


def crosscheck(content: ThesisData) -> Chapter | None:
    """The chapter; None if neither study was recorded."""
    errors, others = content.recorded("planted", Planted), content.recorded("starts", Start)
    if not errors and not others:
        return None
    facts: dict[str, Any] = {"planted": planted_table(errors), "starts": starts_table(others)}
    return Chapter("crosscheck", "How sharp the cross-check is", finding(errors, others), facts)


def finding(errors: Sequence[Planted], others: Sequence[Start]) -> str:
    """The smallest errors that are found in nine of ten runs, and whether cycles depend on the start."""
    within, count = sum(row.within for row in others), sum(len(row.runs) for row in others)
    starts = f"{within} of {counted(count, 'cycle')} from other starts are the same within the claims" if others else ""
    return "; ".join(filter(None, (found_words(errors), starts)))


def planted_table(rows: Sequence[Planted]) -> Table:
    """Per engine and error: the number of runs in which it is found, by its size."""
    table = Table(
        "planted",
        """Errors planted in an engine's settled cycle: in how many runs at least one comparison with the reference finds them, with either
        sign. Sizes are relative; those of a delay are in ms. A change of the machine moves the cycle as it moves the reference's.""",
        ("engine", "error", Column("runs", form="d"), *(Column(f"size_{size:g}", f"{size:g}", form="d", group="size") for size in SIZES)),
    )
    for row in rows:
        counts = {f"size_{size:g}": sum((found or math.inf) <= size for found in row.found) for size in SIZES}
        table.add(engine=row.engine, error=row.error, runs=len(row.runs), **counts)
    return table


def starts_table(rows: Sequence[Start]) -> Table:
    """Per engine and start: how far the settled cycles are from those from the orbit."""
    table = Table(
        "starts",
        """Settled cycles from other starts than the reference's orbit, in all runs: cycles until settled, RMS difference from the cycle
        from the orbit, and the part of both settling claims that it takes.""",
        (
            "engine",
            "start",
            Column("settled", form="d"),
            Column("cycles", "most cycles", form="d"),
            Column("difference", "largest difference", "%", ".2g"),
            Column("used", "most used of the claims", "1", ".2f"),
            Column("beyond", form="d"),
        ),
    )
    for row in rows:
        used = max((difference / claim for difference, claim in zip(row.difference, row.claimed, strict=True)), default=None)
        numbers = {"settled": len(row.runs), "cycles": max(row.cycles, default=None), "difference": max(row.difference, default=None)}
        table.add(engine=row.engine, start=row.start, **numbers, used=used, beyond=len(row.runs) - row.within)
    return table
