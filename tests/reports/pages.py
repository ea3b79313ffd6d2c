"""A report's page without running anything: made-up results, and what a chapter says."""

from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.render import report_page
from tests.reports.reported_results import PageReader, reported_result


def read(content: Content) -> PageReader:
    """The finished page."""
    return PageReader(report_page(content, chapters_of(content)))


def text_of(content: Content) -> str:
    """Its words, with plain blanks."""
    return " ".join(read(content).text.replace("\N{NO-BREAK SPACE}", " ").split())


def one_run(*results: CaseResult, **more: object) -> Content:
    """A report on made-up results; without any, on run 24."""
    return Content(results=list(results) or [reported_result("thesis-24")], **more)  # type: ignore[arg-type]
