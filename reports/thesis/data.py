"""The data of a report on runs of the thesis."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Final

from quickreturn.cases.jobs.job import Job
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.recorded import RecordedTable
from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.studies import ACCURACY_CASE
from quickreturn.cases.thesis.experiment.recordings import experiment_tables
from quickreturn.cases.thesis.experiment.stiffness import stiffness_reading
from quickreturn.cases.thesis.finding.study import Row
from quickreturn.cases.thesis.inconsistencies import inconsistencies
from quickreturn.cases.thesis.modes import ThesisModes, thesis_modes
from quickreturn.cases.thesis.runs import RUNS
from quickreturn.cases.thesis.scatter import Band
from quickreturn.cases.units import in_si
from quickreturn.engines.registry import MODEL
from quickreturn.reference_model.mechanism import TorqueDrive
from quickreturn.reports.page.content import Content, Subject
from quickreturn.reports.results.runs import of_library
from quickreturn.reports.thesis import long_studies
from quickreturn.reports.thesis.axes import axis_comparisons, fits_worse
from quickreturn.reports.thesis.conclusions import Basis, Conclusion, conclusions
from quickreturn.reports.thesis.effects import tightened_words
from quickreturn.reports.thesis.measured import statement_values
from quickreturn.reports.thesis.runs import thesis_runs
from quickreturn.reports.thesis.sufficiency import Split, splits
from quickreturn.reports.words import percent, percents

#: What speaks for the model that departs from the others.
AXES_FIT: Final = (
    "The axes of the thesis’ figures, the only contact with its measurement that is left, fit the 1999 model better than the others."
)


@dataclass(frozen=True, kw_only=True)
class ThesisData(Content):
    """The data of a page on at least one run of the thesis.

    Attributes:
        thesis_modes: frequencies of the thesis' example run; None if that run is not among the results.
        finding: the recorded study of the causes of the thesis' finding.
        bands: recorded bands of the thesis' runs over the scatter of unprinted quantities.
    """

    templates: ClassVar[tuple[str, ...]] = ("quickreturn.reports.thesis",)
    is_own: ClassVar[bool] = False

    thesis_modes: ThesisModes | None = None
    finding: Sequence[Row] = ()
    bands: Sequence[Band] = ()

    @classmethod
    def recordings(cls) -> list[RecordedTable]:
        """Recordings of the experiment."""
        return experiment_tables()

    @classmethod
    def further(cls, results: Sequence[CaseResult], workshop: Workshop) -> tuple[dict[str, Any], list[str]]:
        """The recorded studies, and frequencies of the example run with its crank held, if it is among the results."""
        example = of_library(results, ACCURACY_CASE)
        if example is None:
            return {}, []
        job = Job("frozen crank", thesis_modes, (example.case.mechanism,), kind="frozen crank")
        (outcome,) = workshop.outcomes([job], "frozen-crank frequencies")
        fields = {"finding": long_studies.finding(), "bands": long_studies.bands(), "thesis_modes": outcome.value}
        reason = f"{example.case.name}: the frozen-crank frequencies could not be computed: {outcome.explanation}"
        return fields, [] if outcome.value is not None else [reason]

    @property
    def thesis_results(self) -> list[CaseResult]:
        """Results of the runs of the thesis; its statements are about these only."""
        return list(thesis_runs(self.results).values())

    @property
    def conclusions(self) -> list[Conclusion]:
        """Conclusions on the thesis' statements."""
        return conclusions(Basis(self.thesis_results, self.thesis_modes, statement_values(self.comparisons, MODEL), self.finding))

    @property
    def splits(self) -> list[Split]:
        """Effects that make the halves differ as the thesis says, if these were recorded."""
        return splits(self.finding)

    @property
    def subject(self) -> Subject:
        """The thesis, unless the report also has other cases."""
        if len(self.thesis_results) < len(self.results):
            return Subject()
        inferred = inference(self.splits, tightened_words(self.finding))
        fits = AXES_FIT if fits_worse(axis_comparisons(self.thesis_results)) else ""
        return Subject("thin aluminium", 0.0, ", and the arm whips", " ".join(filter(None, (fits, inferred))), on_the_model=True)

    @property
    def assumed(self) -> Mapping[str, Any]:
        """Driving torque of the first run that a torque drives, N m, and the largest moment of in-plane gravity on its crank, N m."""
        assumptions: dict[str, Any] = {"template": "assumptions.html", "torque": None, "weight": None}
        for crank in (result.case.mechanism.crank for result in reversed(self.thesis_results)):
            if isinstance(crank.drive, TorqueDrive):
                assumptions |= {"torque": crank.drive.torque, "weight": crank.mass * in_si("g0") * crank.center_of_mass}
        return assumptions

    @property
    def general_notes(self) -> frozenset[str]:
        """Published inconsistencies that concern all runs."""
        return frozenset(inconsistency.sentence for inconsistency in inconsistencies() if set(inconsistency.runs) == set(RUNS))


def inference(splits: Sequence[Split], against: str) -> str:
    """What could make the frequency too high after the return alone, and what speaks against it; "" if that was not recorded.

    Args:
        splits: effects that make the halves differ as the words require.
        against: what the thesis says against the first of these, a clause.
    """
    if not splits:
        return ""
    first, below = splits[0], stiffness_reading([]).below
    slowest, fastest = (1.0 / math.sqrt(1.0 - part) - 1.0 for part in below)
    return (
        "Compared with measurements its frequency was right before the return and too high after it. Why is open, for no measured curve"
        f" survives. A roller that is softer on one side would do that ({percent(first.pre, '+.1f')} before,"
        f" {percent(first.post, '+.1f')} after, at {first.strength}){f', but {against}' if against else ''}. The printed bending"
        f" stiffness is {percents(*below, '.0f')} below that of aluminium: with the usual one the arm rings"
        f" {percents(slowest, fastest, '.0f')} faster in both halves."
    )
