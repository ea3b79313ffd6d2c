"""The content of a report on runs of the thesis: its data with the chapters in their order."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from quickreturn.cases.case import Case
from quickreturn.cases.thesis.library import ENTRIES
from quickreturn.reports.chapters.accuracy import accuracy
from quickreturn.reports.chapters.agreement import agreement
from quickreturn.reports.chapters.classes import classes
from quickreturn.reports.chapters.each import run_by_run
from quickreturn.reports.chapters.hard import hard_scenes
from quickreturn.reports.chapters.methods import methods
from quickreturn.reports.chapters.provenance import provenance
from quickreturn.reports.chapters.recorded import recorded
from quickreturn.reports.chapters.runs import runs
from quickreturn.reports.page.chapter import Chapters
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
    """The data of a page on at least one run of the thesis, with its chapters."""

    chapters: ClassVar[Chapters] = (
        agreement,
        runs,
        recorded,
        methods,
        classes,
        thesis,
        accuracy,
        hard_scenes,
        experiment,
        published_inconsistencies,
        run_by_run,
        provenance,
    )
