"""Everything that the chapters speak of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from quickreturn.cases.benchmark import Benchmark, Compiling
from quickreturn.cases.classes.map import Map
from quickreturn.cases.finding.study import Row
from quickreturn.cases.judging.matrix import Matrix
from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.runs.request import Run
from quickreturn.cases.studies import Studies
from quickreturn.cases.thesis_modes import ThesisModes
from quickreturn.cases.uncertainty.thesis import Band
from quickreturn.engines.registry import MODEL
from quickreturn.reports.findings.conclusions import Basis, Conclusion, conclusions
from quickreturn.reports.findings.failures import troubles
from quickreturn.reports.findings.loads import CaseLoads, loads_of_cases
from quickreturn.reports.findings.measured import MeasuredHalf, measured_halves, statement_values
from quickreturn.reports.findings.resonance import Around
from quickreturn.reports.findings.runs import thesis_runs
from quickreturn.reports.long_studies import About
from quickreturn.reports.verification import Verification


@dataclass(frozen=True, kw_only=True)
class Content:
    """What is known when the page is written.

    Attributes:
        results: the cases, at least one.
        studies: None where the cases that they are about are not all among the results.
        benchmarks: of the scenes on which methods are compared, those that there are.
        compiling: what it takes to compile engines, where that was measured.
        thesis_modes: on the thesis' example run; None where that is not among the results.
        hard_scenes: the matrix of verdicts on the hard scenes, if there are results.
        classes: the recorded map of classes.
        finding: the recorded study of what the thesis' finding comes from.
        bands: recorded: what the scatter of quantities that the thesis does not print does to its runs.
        of_record: study of `long_studies.CODE` -> about its recorded results, where these stand for the user's own.
        verification: of the long verification, if there are results.
        conformance: engine -> verdict on whether it does what it says, where that was tried.
        facts: about the machine.
        code: fingerprint of the code that computed the results.
        notices: sentences of the store on damaged entries.
        around: the resonance curves of one's own machines, around their speeds.
    """

    results: Sequence[CaseResult]
    studies: Studies | None = None
    benchmarks: Sequence[Benchmark] = ()
    compiling: Sequence[Compiling] = ()
    thesis_modes: ThesisModes | None = None
    hard_scenes: Matrix | None = None
    classes: Map = field(default_factory=Map)
    finding: Sequence[Row] = ()
    bands: Sequence[Band] = ()
    of_record: Mapping[str, About] = field(default_factory=dict)
    verification: Verification = field(default_factory=Verification)
    conformance: Mapping[str, str] = field(default_factory=dict)
    facts: Mapping[str, str] = field(default_factory=dict)
    code: str = ""
    notices: Sequence[str] = ()
    around: Sequence[Around] = ()

    @property
    def thesis_results(self) -> list[CaseResult]:
        """Those of the runs of the thesis, which is all that its statements are about."""
        return list(thesis_runs(self.results).values())

    @property
    def is_own(self) -> bool:
        """Whether it is about somebody's own machines, and no run of the thesis."""
        return not self.thesis_results

    @cached_property
    def loads(self) -> list[CaseLoads]:
        """What the parts of one's own machines bear."""
        return loads_of_cases(self.results) if self.is_own else []

    @property
    def comparisons(self) -> list[MeasuredHalf]:
        """Recorded tables against engines, per half and channel."""
        return measured_halves(self.results)

    @property
    def conclusions(self) -> list[Conclusion]:
        """On the thesis' statements."""
        return conclusions(Basis(self.thesis_results, self.thesis_modes, statement_values(self.comparisons, MODEL), self.finding))

    @property
    def troubles(self) -> list[tuple[str, Run]]:
        """Runs that are not simply settled, each with the name of its case."""
        return troubles(self.results)
