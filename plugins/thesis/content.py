"""The content of a report on runs of the thesis: its data with its chapters, and their places."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from quickreturn.cases.files.case import Case
from quickreturn.cases.library import ENTRIES
from quickreturn.plugins.thesis.chapters.crosscheck import crosscheck
from quickreturn.plugins.thesis.chapters.experiment import experiment
from quickreturn.plugins.thesis.chapters.inconsistencies import published_inconsistencies
from quickreturn.plugins.thesis.chapters.thesis import thesis
from quickreturn.plugins.thesis.page_data import ThesisData
from quickreturn.reports.page.chapter import MakeChapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.part import Part


def content_of(cases: Sequence[Case]) -> type[Content] | None:
    """The class of a report's content if a run of the thesis is among its cases."""
    return ThesisContent if any(case.source == "library" and case.name in ENTRIES for case in cases) else None


@dataclass(frozen=True, kw_only=True)
class ThesisContent(ThesisData):
    """The data of a page on at least one run of the thesis, and the places of its chapters."""

    chapters: ClassVar[Mapping[MakeChapter, float]] = MappingProxyType(
        {crosscheck: 0.5, thesis: 51.5, experiment: 53.1, published_inconsistencies: 53.2}
    )
    ranks: ClassVar[Mapping[str, float]] = MappingProxyType({"agreement": 0, "run_by_run": 53.3})


PAGE = Part(content=content_of)
