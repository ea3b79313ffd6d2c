"""The data of a report on runs of the thesis."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Final

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.cases.files.units import in_si
from quickreturn.cases.library.hard import ORIGINAL
from quickreturn.cases.library.thesis.inconsistencies import inconsistencies
from quickreturn.cases.library.thesis.runs import RUNS
from quickreturn.cases.running.job import Job
from quickreturn.engines.registry import MODEL
from quickreturn.plugins.thesis import records
from quickreturn.plugins.thesis.axes import axis_comparisons, fits_worse
from quickreturn.plugins.thesis.conclusions import Basis, Conclusion, conclusions
from quickreturn.plugins.thesis.effects import tightened_words
from quickreturn.plugins.thesis.experiment.recordings import experiment_tables
from quickreturn.plugins.thesis.experiment.stiffness import stiffness_reading
from quickreturn.plugins.thesis.finding.study import Row
from quickreturn.plugins.thesis.measured import statement_values
from quickreturn.plugins.thesis.modes import ThesisModes, thesis_modes
from quickreturn.plugins.thesis.runs import thesis_runs
from quickreturn.plugins.thesis.scatter import Band
from quickreturn.plugins.thesis.sharpness import Planted, found_words
from quickreturn.plugins.thesis.starts import Start
from quickreturn.plugins.thesis.sufficiency import Split, splits
from quickreturn.reference_model.mechanism import TorqueDrive
from quickreturn.reports.page.content import Content, Subject, of_library
from quickreturn.reports.words import percent, percents

#: What speaks for the model that departs from the others.
AXES_FIT: Final = (
    "The axes of the thesis’ figures, the only contact with its measurement that is left, fit the 1999 model better than the others."
)


@dataclass(frozen=True, kw_only=True)
class ThesisData(Content):
    """The data of a page on at least one run of the thesis."""

    templates: ClassVar[tuple[str, ...]] = ("quickreturn.plugins.thesis",)
    is_own: ClassVar[bool] = False

    @classmethod
    def recordings(cls) -> list[RecordedTable]:
        """Recordings of the experiment."""
        return experiment_tables()

    @property
    def thesis_modes(self) -> ThesisModes | None:
        """Frequencies of the thesis' example run with its crank held; None if that run is not among the results."""
        return self.of(modes_of)

    @property
    def finding(self) -> Sequence[Row]:
        """The recorded study of the causes of the thesis' finding."""
        return self.of(finding_of)

    @property
    def bands(self) -> Sequence[Band]:
        """Recorded bands of the thesis' runs over the scatter of unprinted quantities."""
        return self.of(bands_of)

    @property
    def planted(self) -> Sequence[Planted]:
        """In how many runs errors of each size are found, as recorded."""
        return self.of(planted_of)

    @property
    def starts(self) -> Sequence[Start]:
        """Recorded settled cycles from other starts."""
        return self.of(starts_of)

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
        found = found_words(self.planted)
        return Subject(
            arm="thin aluminium",
            consequence=", and the arm whips",
            inference=" ".join(filter(None, (fits, inferred))),
            sharpness=f"{found}." if found else "",
            on_the_model=True,
        )

    @property
    def assumed(self) -> Mapping[str, Any]:
        """Driving torque of the first run that a torque drives, N m, and the largest moment of in-plane gravity on its crank, N m."""
        assumptions: dict[str, Any] = {"template": "templates/assumptions.html", "torque": None, "weight": None}
        for crank in (result.case.mechanism.crank for result in reversed(self.thesis_results)):
            if isinstance(crank.drive, TorqueDrive):
                assumptions |= {"torque": crank.drive.torque, "weight": crank.mass * in_si("g0") * crank.center_of_mass}
        return assumptions

    @property
    def general_notes(self) -> frozenset[str]:
        """Published inconsistencies that concern all runs."""
        return frozenset(inconsistency.sentence for inconsistency in inconsistencies() if set(inconsistency.runs) == set(RUNS))


def modes_of(content: Content) -> ThesisModes | None:
    """Frequencies of the thesis' example run with its crank held, if it is among the results and can be computed."""
    example = of_library(content.results, ORIGINAL)
    if example is None or content.workshop is None:
        return None
    job = Job("frozen crank", thesis_modes, (example.case.mechanism,), kind="frozen crank")
    (outcome,) = content.workshop.outcomes([job], "frozen-crank frequencies")
    return outcome.value


def finding_of(content: Content) -> Sequence[Row]:
    """The recorded study of the causes of the thesis' finding, for a report with its example run."""
    return records.finding() if content.workshop and content.has(ORIGINAL) else []


def bands_of(content: Content) -> Sequence[Band]:
    """The recorded bands over the scatter of unprinted quantities, for a report with the thesis' example run."""
    return records.bands() if content.workshop and content.has(ORIGINAL) else []


def planted_of(content: Content) -> Sequence[Planted]:
    """The recorded study of planted errors, for a report with the thesis' example run."""
    return records.planted() if content.workshop and content.has(ORIGINAL) else []


def starts_of(content: Content) -> Sequence[Start]:
    """The recorded study of other starts, for a report with the thesis' example run."""
    return records.starts() if content.workshop and content.has(ORIGINAL) else []


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
