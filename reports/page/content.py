"""The data of all chapters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar

from quickreturn.cases.as_built import Construction
from quickreturn.cases.benchmark import Benchmark, Compiling
from quickreturn.cases.classes.map import Map
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.judging.matrix import Matrix
from quickreturn.cases.recorded import RecordedTable
from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.runs.request import Run
from quickreturn.cases.studies import Studies
from quickreturn.reports.long_studies import About
from quickreturn.reports.page.chapter import MakeChapter
from quickreturn.reports.results.around import Around
from quickreturn.reports.results.loads import CaseLoads, loads_of_case
from quickreturn.reports.results.measured import MeasuredHalf, measured_halves
from quickreturn.reports.verification import Verification


@dataclass(frozen=True)
class Subject:
    """What a report is about, as far as its first screen depends on it.

    Attributes:
        arm: kind of the arm.
        turning: share of the machines whose arm turns fully.
        consequence: what the swing does to it (a clause); "" if nothing is to be said.
        inference: a sentence on what the results suggest; "" if there is none.
        on_the_model: whether the thesis' model is among the figures, in place of the largest difference of a peak.
    """

    arm: str = "flexible"
    turning: float = 0.0
    consequence: str = ""
    inference: str = ""
    on_the_model: bool = False


@dataclass(frozen=True, kw_only=True)
class Content:
    """The data of a page on the user's own machines. A subject with chapters of its own derives its content from this class.

    Attributes:
        results: the cases, at least one.
        studies: results of the studies; None if their cases are not all among the results.
        benchmarks: measurements of the scenes on which methods are compared, as far as they exist.
        compiling: times to compile engines, if they were measured.
        hard_scenes: the matrix of verdicts on the hard scenes, if there are results.
        classes: the recorded map of classes.
        as_built: recorded constructions of run 24 by users of other programs.
        of_record: study of `long_studies.STUDIES` -> about its recorded results, where these stand for the user's own.
        verification: results of the long verification, or why there are none.
        conformance: engine -> verdict on whether it does what it says, if that was tested.
        facts: name -> fact about the computer, its software and the date.
        code: fingerprint of the code that computed the results.
        notices: sentences of the store on damaged entries.
        around: the resonance curves of the user's own machines, around their speeds.
    """

    #: Chapters of the subject, and those that stand elsewhere than in `chapters.CHAPTERS`, by the chapter that they follow; None: first.
    placed: ClassVar[Mapping[MakeChapter | None, Sequence[MakeChapter]]] = MappingProxyType({})
    templates: ClassVar[tuple[str, ...]] = ()  # packages with templates of these chapters
    is_own: ClassVar[bool] = True  # whether the report is about the user's own machines

    results: Sequence[CaseResult]
    studies: Studies | None = None
    benchmarks: Sequence[Benchmark] = ()
    compiling: Sequence[Compiling] = ()
    hard_scenes: Matrix | None = None
    classes: Map = field(default_factory=Map)
    as_built: Sequence[Construction] = ()
    of_record: Mapping[str, About] = field(default_factory=dict)
    verification: Verification = field(default_factory=Verification)
    conformance: Mapping[str, str] = field(default_factory=dict)
    facts: Mapping[str, str] = field(default_factory=dict)
    code: str = ""
    notices: Sequence[str] = ()
    around: Sequence[Around] = ()

    @classmethod
    def recordings(cls) -> list[RecordedTable]:
        """Recorded tables that belong to the subject. CaseError: one cannot be read."""
        return []

    @classmethod
    def further(cls, results: Sequence[CaseResult], workshop: Workshop) -> tuple[dict[str, Any], list[str]]:
        """Values of a subclass's own fields, computed from the results, and sentences on what could not be computed."""
        return {}, []

    @property
    def subject(self) -> Subject:
        """What the report is about."""
        turning = [result.case.mechanism.turns_fully for result in self.results]
        return Subject(turning=sum(turning) / len(turning))

    @property
    def assumed(self) -> Mapping[str, Any] | None:
        """Facts on the assumptions of the subject, with their `template`; None: there are none."""
        return None

    @property
    def general_notes(self) -> frozenset[str]:
        """Notes on cases that the page leaves out of its sections on single cases, because another chapter gives them."""
        return frozenset()

    @cached_property
    def loads(self) -> list[CaseLoads]:
        """Loads on the parts of the user's own machines."""
        return [loads_of_case(result) for result in self.results] if self.is_own else []

    @property
    def comparisons(self) -> list[MeasuredHalf]:
        """Comparisons of recorded tables with engines, per half and channel."""
        return measured_halves(self.results)

    @property
    def troubles(self) -> list[tuple[str, Run]]:
        """Runs that are not simply settled, each with the name of its case."""
        return [(result.case.name, run) for result in self.results for run in result.runs.values() if run.status != Ending.SETTLED]
