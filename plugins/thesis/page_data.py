"""The data of a report on runs of the thesis, with its statements evaluated from recordings of its experiment."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Final, TypeVar

import numpy as np

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.cases.files.units import in_si
from quickreturn.cases.library.hard import ORIGINAL
from quickreturn.cases.library.thesis import RUNS, run_name
from quickreturn.cases.library.thesis.inconsistencies import inconsistencies
from quickreturn.cases.motion.cycle import HALVES, consensus_of
from quickreturn.cases.running.job import Job
from quickreturn.engines.registry import MODEL
from quickreturn.plugins.thesis.axes import axis_comparisons, fits_worse, thesis_runs
from quickreturn.plugins.thesis.experiment import channel_is_usable, experiment_tables
from quickreturn.plugins.thesis.inference.study import Row
from quickreturn.plugins.thesis.inference.tables import headline
from quickreturn.plugins.thesis.inference.weights import Inference, infer
from quickreturn.plugins.thesis.sharpness import Planted, found_words
from quickreturn.reference_model.mechanism import TorqueDrive
from quickreturn.reports.long_studies import table
from quickreturn.reports.page.content import Content, MeasuredHalf, Subject

T = TypeVar("T")


def counts(item: MeasuredHalf) -> bool:
    """Whether an item is a genuine recording of the experiment, in a channel that section 3.5 calls valid."""
    recording, run = item.table.recording, next((number for number in RUNS if run_name(number) == item.case.name), None)
    if recording is None or run is None or item.case.source != "library":
        return False
    return recording.of_experiment and recording.declared.get("origin") != "synthetic" and channel_is_usable(run, item.measure.channel)


def statement_values(comparisons: Sequence[MeasuredHalf], engine: str) -> dict[str, dict[int, float]]:
    """Ratios simulation / experiment for the thesis' relations: quantity of a statement -> run -> ratio.

    Only recordings of the experiment count; made-up curves and channels that the thesis calls unusable do not.
    """
    values: dict[str, dict[int, float]] = {}
    valid = [item for item in comparisons if counts(item) and engine in item.engines]
    for run, name in ((number, run_name(number)) for number in RUNS):
        for half in HALVES:
            here = [item for item in valid if item.case.name == name and item.measure.half == half]
            frequency = _frequency_ratio(here, engine)
            amplitude = _amplitude_ratio(here, engine)
            if frequency is not None:
                values.setdefault(f"{half}_frequency", {})[run] = frequency
            if amplitude is not None:
                values.setdefault(f"{half}_amplitude", {})[run] = amplitude
    pre, post = values.get("pre_frequency", {}), values.get("post_frequency", {})
    both = {run: post[run] / pre[run] for run in pre if run in post}
    return values | ({"post_over_pre_frequency": both} if both else {})


def _frequency_ratio(items: Sequence[MeasuredHalf], engine: str) -> float | None:
    """Ratio of the consensus over the engine's channels to that over the same measured channels."""
    pairs = [(item.engines[engine], item.measure) for item in items]
    both = [pair for pair in pairs if all(measure.first_mode_frequency is not None for measure in pair)]
    simulated, measured = (consensus_of("", [pair[side] for pair in both]).first_mode_frequency for side in (0, 1))
    return None if simulated is None or measured is None else simulated / measured


def _amplitude_ratio(items: Sequence[MeasuredHalf], engine: str) -> float | None:
    """Ratio of amplitudes, as the geometric mean over the channels."""
    pairs = [(item.engines[engine].first_mode_amplitude, item.measure.first_mode_amplitude) for item in items]
    ratios = [value / other_value for value, other_value in pairs if value is not None and other_value]
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else None


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

    def recorded(self, study: str, kind: type[T]) -> list[T]:
        """The rows of a recorded study, for a report with the thesis' example run."""
        return table(study, kind) if self.workshop and self.has(ORIGINAL) else []

    @property
    def inference(self) -> Inference | None:
        """The weights of what could have made the thesis' finding, from the recorded study; None without it."""
        return self.of(inference_of)

    @property
    def thesis_results(self) -> list[CaseResult]:
        """Results of the runs of the thesis; its statements are about these only."""
        return list(thesis_runs(self.results).values())

    @property
    def subject(self) -> Subject:
        """The thesis, unless the report also has other cases."""
        if len(self.thesis_results) < len(self.results):
            return Subject()
        inferred = f"{headline(self.inference)}." if self.inference else ""
        fits = AXES_FIT if fits_worse(axis_comparisons(self.thesis_results)) else ""
        found = found_words(self.recorded("planted", Planted))
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


def inference_of(content: Content) -> Inference | None:
    """The inference from the recorded study and from recordings of the experiment, for a report with the thesis' example run."""
    rows = tuple(table("finding", Row)) if content.workshop and content.has(ORIGINAL) else ()
    if not rows or content.workshop is None:
        return None
    job = Job("weights of explanations", infer, (rows, statement_values(content.comparisons, MODEL)), kind="weights of explanations")
    (outcome,) = content.workshop.outcomes([job], "weights of explanations")
    return outcome.value
