"""Facts of the chapter on the strength of the user's own machine."""

from typing import Any

from quickreturn.reports.page.content import Content
from quickreturn.reports.tables.strength import strength as table


def strength(content: Content) -> dict[str, Any] | None:
    """The facts for `chapters/strength.html`; None for a report on the thesis' runs, or if no engine gives the stress."""
    cases = [case for case in content.loads if case.lead]
    return {"cases": cases, "table": table(content.loads)} if cases else None
