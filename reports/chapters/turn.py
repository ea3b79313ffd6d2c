"""What happens in a turn of the user's own machine, in sentences."""

from collections.abc import Sequence

from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.results.turn import Statement, leading_statements


def turn(content: Content) -> Chapter | None:
    """The chapter; None for a report on the thesis' runs, or without a settled turn."""
    results = content.results if content.is_own else []
    cases = [(result.case.title, told) for result in results if (told := leading_statements(result))]
    return Chapter("turn", "What happens in a turn", finding(cases[0][1]), {"cases": cases}) if cases else None


def finding(told: Sequence[Statement]) -> str:
    """The first statement."""
    return told[0].sentence.removesuffix(".")
