"""Whether the machine of a report on one's own cases will hold."""

from typing import Any

from quickreturn.reports.page.content import Content
from quickreturn.reports.tables.strength import strength as table


def strength(content: Content) -> dict[str, Any] | None:
    """None for a report on the thesis' runs, and where no engine gives the stress."""
    found = [each for each in content.loads if each.lead]
    return {"cases": found, "table": table(content.loads)} if found else None
