"""Hard scenes: what comes of asking every engine for an error in every hard scene."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final

from quickreturn.cases.library.hard import IMPOSSIBLE
from quickreturn.engines.registry import MODEL
from quickreturn.plugins.methods.race import Race
from quickreturn.plugins.methods.row import ENDED, FAILED, MEANINGS, NOT_REACHED, OWN_EQUATIONS, REACHED, REFUSED, TOO_SLOW, WRONG, Row
from quickreturn.plugins.methods.studies import REQUESTED, hard_scenes_of
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import Cell, Column, Mark, Table
from quickreturn.reports.words import TIED, counted, number, size

#: The look of a status. The cell also contains its words, so that colour alone carries no information.
_MARKS: Final[Mapping[str, Mark]] = {
    REACHED: "good",
    ENDED: "good",
    OWN_EQUATIONS: "model",
    NOT_REACHED: "missed",
    TOO_SLOW: "missed",
    FAILED: "missed",
    REFUSED: "open",
    WRONG: "failed",
}


def hard_scenes(content: Content) -> Chapter | None:
    """The chapter; None without rows."""
    found = content.of(hard_scenes_of)
    rows = [row for race in found.races for row in race.rows]
    if not rows:
        return None
    facts = {
        "of_record": found.record,
        "requested": REQUESTED,
        "wrong": [f"{row.engine} in {row.scene}" for row in rows if row.status == WRONG],
        "meanings": {status: meaning for status, meaning in MEANINGS.items() if any(row.status == status for row in rows)},
        "model": MODEL,
        "impossible": list(IMPOSSIBLE.values()),
        "statuses": statuses(found.races),
    }
    return Chapter("hard", "Hard scenes", finding(rows), facts)


def finding(rows: Sequence[Row]) -> str:
    """The number of answers with each status, and of claims that do not hold."""
    counts = Counter(row.status for row in rows)
    texts = [f"{counts[status]} {status}" for status in MEANINGS if counts[status] and status != WRONG]
    claimed = sum(row.claim is not None for row in rows)
    wrong = f"{counts[WRONG]} silently wrong" if counts[WRONG] else "none silently wrong"
    return f"Of {counted(len(rows), 'answer')} {', '.join(texts)}; {wrong} of {counted(claimed, 'claim')}"


def statuses(races: Sequence[Race]) -> Table:
    """A row per scene, a column per engine."""
    engines = list(dict.fromkeys(row.engine for race in races for row in race.rows))
    table = Table(
        "hard_scenes",
        """What came of asking every engine for the error in every hard scene, and the error against the solution that is known. That
        solution is known up to the time given, to the end of the scene or to where it parts from that with four modes less. A click on a
        cell shows the engine’s claim and the reason.""",
        (
            Column("scene", in_page=False),
            Column("title", "run 24 with"),
            Column("until", "known up to", "s", ".3g"),
            Column("difference", "known to", "%", ".1g"),
            *(Column(name, name) for name in engines),
        ),
    )
    for race in races:
        cells = {row.engine: cell(row) for row in race.rows}
        title = race.title.removeprefix("Run 24, ")
        table.add(scene=race.case, title=title, until=race.until, difference=race.confirmation.error, **cells)
    return table


def cell(row: Row) -> Cell:
    """The status of an answer in words, with its error and, if the run ended early, the time."""
    off = "" if row.error is None else f", {size(row.error)} off"
    at = f" at {number(row.time, '.4g')}{TIED}s" if row.time else ""
    claim = "" if row.claim is None else f"claims {size(row.claim)}; "
    return Cell(row.status, f"{row.status}{at}{off}", f"{claim}{row.remark}", _MARKS[row.status])
