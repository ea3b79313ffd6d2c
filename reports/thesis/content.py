"""The content of a report on runs of the thesis: its data with the places of its chapters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from quickreturn.cases.case import Case
from quickreturn.cases.thesis.library import ENTRIES
from quickreturn.reports.chapters.agreement import agreement
from quickreturn.reports.chapters.classes import classes
from quickreturn.reports.chapters.each import run_by_run
from quickreturn.reports.chapters.hard import hard_scenes
from quickreturn.reports.page.chapter import MakeChapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.thesis.chapters.experiment import experiment
from quickreturn.reports.thesis.chapters.inconsistencies import published_inconsistencies
from quickreturn.reports.thesis.chapters.thesis import thesis
from quickreturn.reports.thesis.data import ThesisData


def content_type(cases: Sequence[Case]) -> type[Content]:
    """The class of a report's content: `ThesisContent` if a run of the thesis is among the cases, otherwise `Content`."""
    return ThesisContent if any(case.source == "library" and case.name in ENTRIES for case in cases) else Content


@dataclass(frozen=True, kw_only=True)
class ThesisContent(ThesisData):
    """The data of a page on at least one run of the thesis, and the places of its chapters."""

    placed: ClassVar[Mapping[MakeChapter | None, Sequence[MakeChapter]]] = MappingProxyType(
        {None: (agreement,), classes: (thesis,), hard_scenes: (experiment, published_inconsistencies, run_by_run)}
    )
