"""The data of all chapters, with the stored results of the long verification."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Final, TypeVar

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.cases.motion.cycle import ChannelMeasures
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.cases.running.key import code_fingerprint
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import MAIN
from quickreturn.reports.page.chapter import MakeChapter

FILE: Final = "verification.json"


@dataclass(frozen=True)
class Verification:
    """Results of the long verification: the file `verification.json` in the store's folder.

    It holds {"code": fingerprint of the code, "date": text, "chapters": [{"title", "text", "columns": [text], "rows": [[text or number or
    null]]}]}. The report shows it as long as the code is unchanged.
    """

    chapters: tuple[dict[str, Any], ...] = ()  # in the form above
    date: str = ""
    absent: str = ""  # why there is none (a sentence), or ""


def verification(folder: Path) -> Verification:
    """The verification in the store's folder."""
    try:
        document = json.loads((folder / FILE).read_text("utf-8"))
        stored = Verification(tuple(document["chapters"]), document["date"])
    except FileNotFoundError:
        return Verification(absent="It has not been run with this store.")
    except (OSError, ValueError, KeyError, TypeError):
        return Verification(absent=f"{FILE} in the store cannot be read.")
    if document.get("code") != code_fingerprint():
        return Verification(absent="Its stored results were made with other code than this page, so they are not shown.")
    return stored


T = TypeVar("T")


@dataclass(frozen=True)
class MeasuredHalf:
    """One half of a recorded table's measured turn, in one channel, beside the engines."""

    case: Case
    table: Run  # the recorded table
    measure: ChannelMeasures  # of the table
    engines: Mapping[str, ChannelMeasures]  # engine -> the same measure of its cycle


@dataclass(frozen=True)
class Subject:
    """What a report is about, as far as its first screen depends on it."""

    arm: str = "flexible"  # kind of the arm
    turning: float = 0.0  # share of the machines whose arm turns fully
    consequence: str = ""  # what the swing does to it (a clause); "" if nothing is to be said
    inference: str = ""  # a sentence on what the results suggest; "" if there is none
    sharpness: str = ""  # how small an error of an engine would show, a sentence; "" if that is not known
    on_the_model: bool = False  # whether the thesis' model is among the figures, in place of the largest difference of a peak


@dataclass(frozen=True, kw_only=True)
class Content:
    """The data of a page on the user's own machines. A subject with chapters of its own derives its content from this class.

    Attributes:
        results: the cases, at least one.
        engines: names of the engines that the report is about.
        workshop: store and processes, in which chapters find the results of studies; None: there are none.
        data: function of the content -> its value, computed or given before (see `of`).
        verification: results of the long verification, or why there are none.
        facts: name -> fact about the computer, its software and the date.
        code: fingerprint of the code that computed the results.
        notices: sentences of the store on damaged entries.
    """

    chapters: ClassVar[Mapping[MakeChapter, float]] = MappingProxyType({})  # of the subject, with their ranks (`CHAPTERS`)
    ranks: ClassVar[Mapping[str, float]] = MappingProxyType({})  # chapters by name that stand elsewhere than in other reports
    templates: ClassVar[tuple[str, ...]] = ()  # packages with templates of these chapters
    is_own: ClassVar[bool] = True  # whether the report is about the user's own machines

    results: Sequence[CaseResult]
    engines: Sequence[str] = MAIN
    workshop: Workshop | None = None
    data: dict[Callable[[Any], Any], Any] = field(default_factory=dict)
    verification: Verification = field(default_factory=Verification)
    facts: Mapping[str, str] = field(default_factory=dict)
    code: str = ""
    notices: Sequence[str] = ()

    def of(self, load: Callable[["Content"], T]) -> T:
        """What a function makes of the content, computed once: data that several chapters need, or that only one of them knows."""
        if load not in self.data:
            self.data[load] = load(self)
        found: T = self.data[load]
        return found

    def has(self, name: str) -> bool:
        """Whether a case of the library is among those of the report."""
        return of_library(self.results, name) is not None

    @classmethod
    def recordings(cls) -> list[RecordedTable]:
        """Recorded tables that belong to the subject. CaseError: one cannot be read."""
        return []

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

    @property
    def comparisons(self) -> list[MeasuredHalf]:
        """Comparisons of recorded tables with engines, per half and channel."""
        return measured_halves(self.results)

    @property
    def troubles(self) -> list[tuple[str, Run]]:
        """Runs that are not simply settled, each with the name of its case."""
        return [(result.case.name, run) for result in self.results for run in result.runs.values() if run.status != Ending.SETTLED]


def of_library(results: Sequence[CaseResult], name: str) -> CaseResult | None:
    """The result of a case of the library, if it is among the cases shown. A user's case file of the same name does not count."""
    return next((result for result in results if result.case.name == name and result.case.source == "library"), None)


def measured_halves(results: Sequence[CaseResult]) -> list[MeasuredHalf]:
    """All recorded tables that can be compared with the engines, both halves of each channel."""
    halves = []
    for result in results:
        for table in (run for run in result.recorded.values() if run.usable):
            for measure in (measure for measure in table.measured.measures if measure.channel in CHANNELS):
                same = {name: run.measure(measure.half, measure.channel) for name, run in result.runs.items() if run.usable}
                engines = {name: of_engine for name, of_engine in same.items() if of_engine is not None}
                halves.append(MeasuredHalf(result.case, table, measure, engines))
    return halves
