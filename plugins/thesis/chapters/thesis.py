"""What the thesis saw: what could have made it, with the weight of each explanation, and its model beside the converged one."""

from collections.abc import Sequence
from typing import Any, Final

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.comparison.pair import Difference, Kind
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.engines.registry import MODEL
from quickreturn.plugins.thesis.axes import axis_comparisons, fits_worse
from quickreturn.plugins.thesis.experiment import below_aluminium
from quickreturn.plugins.thesis.inference import tables
from quickreturn.plugins.thesis.inference.study import Confirmation
from quickreturn.plugins.thesis.page_data import ThesisData
from quickreturn.reports.engine_differences import differences, summary_of
from quickreturn.reports.long_studies import about
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.tables import Column, Table
from quickreturn.reports.words import HALF, channel_name, percents

#: Columns of a spread -> unit and format.
_SPREAD: Final = {"median": ("1", ".3f"), "least": ("1", ".3f"), "greatest": ("1", ".3f"), "runs": ("", "d")}


def thesis(content: ThesisData) -> Chapter:
    """The chapter."""
    results, inference = content.thesis_results, content.inference
    facts: dict[str, Any] = {
        "worse": fits_worse(axis_comparisons(results)),
        "of_record": about("finding"),
        "inferred": inference is not None,
        "stiffness": percents(*below_aluminium(), ".0f"),
        "ratios": ratios(results),
    }
    if inference is not None:
        facts |= {
            "against": tables.against(inference),
            "weights": tables.weights(inference),
            "votes": tables.votes(inference),
            "deciding": tables.deciding(inference),
            "unknowns": tables.unknowns(inference),
            "confirmed": tables.confirmed(content.recorded("finding_confirmed", Confirmation)),
        }
    return Chapter(
        "thesis", "What the thesis saw", tables.headline(inference) if inference else "Its model beside the converged one", facts
    )


def ratios(results: Sequence[CaseResult]) -> Table:
    """Medians and ranges over the runs of thesis / reference."""
    columns = [Column(f"{half}_{key}", key, *shown, group=HALF[half]) for half in HALVES for key, shown in _SPREAD.items()]
    table = Table(
        "thesis_over_reference",
        """The single cubic (thesis) over the converged solution (reference): medians and ranges over the runs, of first-mode frequency and
        amplitude where both resolve them, and of the peak over the half cycle.""",
        ("quantity", "channel", *columns),
    )
    rows: list[tuple[str, Kind, str | None]] = [("first-mode frequency", "frequency", None)]
    rows += [("first-mode amplitude", "amplitude", channel) for channel in CHANNELS]
    rows += [("peak", "extreme", channel) for channel in CHANNELS]
    for label, kind, channel in rows:
        cells: dict[str, float] = {}
        for half in HALVES:
            compared = differences(results, MODEL, kind, half=half, channel=channel)
            values = _peak_ratios(compared) if kind == "extreme" else [difference.ratio for difference in compared]
            if short := summary_of(values):
                spread = (short.median, short.lowest, short.highest, short.count)
                cells |= {f"{half}_{key}": number for key, number in zip(_SPREAD, spread, strict=True)}
        if cells:
            table.add(quantity=label, channel=channel_name(channel), **cells)
    return table


def _peak_ratios(extremes: Sequence[Difference]) -> list[float]:
    """Ratio of the largest magnitude in a half to the other engine's, per case, from minimum and maximum."""
    peaks: dict[str, list[Difference]] = {}
    for difference in extremes:
        peaks.setdefault(difference.case, []).append(difference)
    return [max(abs(d.number.value) for d in pair) / max(abs(d.other_number.value) for d in pair) for pair in peaks.values()]
