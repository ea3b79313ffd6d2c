"""A report's page without running anything: made-up results, and what a chapter says."""

from collections.abc import Sequence
from typing import Any

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.part import parts
from quickreturn.reports.page.render import report_page
from tests.reports.reported_results import PageReader, reported_result


def read(content: Content) -> PageReader:
    """The finished page."""
    return PageReader(report_page(content, list(chapters_of(content))))


def plain(text: str) -> str:
    """The text with plain blanks."""
    return " ".join(text.replace("\N{NO-BREAK SPACE}", " ").split())


def text_of(content: Content) -> str:
    """Its words, with plain blanks."""
    return plain(read(content).text)


def chapter_of(content: Content, name: str) -> Chapter:
    """The chapter with this id; those behind it are not made."""
    return next(chapter for chapter in chapters_of(content) if chapter.id == name)


def finding_of(content: Content, name: str) -> str:
    """The finding in a chapter's heading, with plain blanks."""
    return plain(chapter_of(content, name).finding)


def content_of(*, results: Sequence[CaseResult], **more: Any) -> Content:
    """The data of a page on these results, of the kind that a report on their cases has."""
    cases = [result.case for result in results]
    kind = next((kind for part in parts() if part.content and (kind := part.content(cases))), Content)
    return kind(results=results, **more)


def one_run(*results: CaseResult, **more: Any) -> Content:
    """A report on made-up results; without any, on run 24."""
    return content_of(results=list(results) or [reported_result("thesis-24")], **more)
