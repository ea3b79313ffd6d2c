"""Facts of the chapters on the thesis: its model compared with the converged one, its statements, the experiment, its inconsistencies."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.comparison import REFERENCE
from quickreturn.cases.thesis.experiment import statements
from quickreturn.cases.thesis.experiment.stiffness import stiffness_reading
from quickreturn.cases.thesis.inconsistencies import inconsistencies
from quickreturn.cases.thesis.scatter import Band
from quickreturn.engines.registry import MODEL, OWN
from quickreturn.reports.findings.agreement import differences, engines_of
from quickreturn.reports.thesis import experiment_tables
from quickreturn.reports.thesis import model_tables as tables
from quickreturn.reports.thesis import scatter as scatter_tables
from quickreturn.reports.thesis.axes import COLUMNS, axis_comparisons, fits_worse, measured_alone, misfit, ratios_of
from quickreturn.reports.thesis.conclusions import ACCURATE, ALIKE, CANNOT_FOLLOW, NOT, OUTCOMES
from quickreturn.reports.thesis.finding import EXCESS, finding
from quickreturn.reports.thesis.measured import counts
from quickreturn.reports.thesis.raw_extremes import Excess, counted_excess
from quickreturn.reports.words import HALF, span

if TYPE_CHECKING:
    from quickreturn.reports.thesis.content import ThesisContent

#: Hz, the frequency that section 3.4 reads off run 24.
SECOND_MODE: Final = next(statement.low for statement in statements() if statement.id == "second-mode")
#: The run that the thesis describes most.
EXAMPLE: Final = 24
#: Channels of strain, in which the slow bending is large.
STRAINS: Final = CHANNELS[1:]
#: Least difference between the halves, in an excess of frequency, that a reader of plots would notice.
MARKED: Final = 0.02


def thesis(content: "ThesisContent") -> dict[str, Any]:
    """The facts for `chapters/thesis.html`."""
    results = content.thesis_results
    conclusions, excesses = content.conclusions, counted_excess(results)
    ratios = {half: [each.ratio for each in differences(results, MODEL, "frequency", half=half)] for half in HALF}
    fitted = [difference.relative for difference in differences(results, MODEL, "frequency")]
    return {
        "conclusions": conclusions,
        "outcomes": {outcome: count for outcome in OUTCOMES if (count := sum(each.outcome == outcome for each in conclusions))},
        "contradicted": [each.statement.words for each in conclusions if each.outcome == NOT],
        "not_following": [each.statement.words for each in conclusions if each.outcome == CANNOT_FOLLOW],
        "medians": {half: float(np.median(of_half)) for half, of_half in ratios.items() if of_half},
        "resolved": {half: len(of_half) for half, of_half in ratios.items()},
        "alike": ALIKE,
        "accurate": ACCURATE,
        "fits_worse": fits_worse(axis_comparisons(results)),
        "fitted": fitted,
        "strains": {half: [each.median for each in excesses if each.half == half and each.channel in STRAINS] for half in HALF},
        "larger_after": _larger_after(excesses),
        "marked": MARKED,
        "second_mode": SECOND_MODE,
        "of_record": content.of_record.get("finding"),
        **finding(content.finding, results),
        **_scattered(content.bands),
        "of_record_scatter": content.of_record.get("unprinted"),
        "stiffness": stiffness_reading(fitted),
        "ratios": tables.ratios(results),
        "statements": tables.statements(conclusions),
        "counted": tables.counted(excesses),
    }


def _scattered(bands: Sequence[Band]) -> dict[str, Any]:
    """Effect of the scatter of unprinted quantities on the frequencies of the halves."""
    resolved = [band for band in bands if band.ratio]
    if not resolved:
        return {"scatter": None}
    return {
        "scatter": {
            "compared": sum(band.compared for band in resolved),
            "runs": len(resolved),
            "medians": sorted(band.ratio[1] for band in resolved),
            "least": min(resolved, key=lambda band: band.ratio[0]),
            "most": max(resolved, key=lambda band: band.ratio[2]),
            "apart": sum(band.apart for band in resolved),
            "example": next((band for band in resolved if band.run == EXAMPLE), None),
            "needed": 1.0 / EXCESS,
        },
        "unprinted": scatter_tables.unprinted(),
        "bands": scatter_tables.bands(bands),
    }


def _larger_after(excesses: Sequence[Excess]) -> list[bool]:
    """For each threshold, whether the counted excess is larger after the return in every strain by more than `MARKED`."""
    larger = []
    for visible in dict.fromkeys(excess.visible for excess in excesses):
        gaps = []
        for channel in STRAINS:
            medians = {excess.half: excess.median for excess in excesses if (excess.visible, excess.channel) == (visible, channel)}
            gaps += [medians["post"] - medians["pre"]] if len(medians) == len(HALF) else []
        larger.append(bool(gaps) and min(gaps) > MARKED)
    return larger


def experiment(content: "ThesisContent") -> dict[str, Any]:
    """The facts for `chapters/experiment.html`: what is left of the experiment."""
    axes, alone = axis_comparisons(content.results), measured_alone(content.results)
    engines = [name for name in engines_of(content.results) if name in OWN]
    ratios: dict[str, dict[str, list[float]]] = {}
    for channel in COLUMNS:
        for engine in engines:
            of_engine = ratios_of(axes, channel, engine)
            if of_engine:
                ratios.setdefault(channel, {})[engine] = of_engine
    misfits = {channel: {name: misfit(of_engine) for name, of_engine in of_engines.items()} for channel, of_engines in ratios.items()}
    return {
        "model": MODEL,
        "reference": REFERENCE,
        "ratios": ratios,
        "ranges": {channel: _ranges(of_engines) for channel, of_engines in ratios.items()},
        "misfits": misfits,
        "fits_worse": fits_worse(axes),
        "alone": max((axis for axis in alone if axis.channel == "strain"), key=lambda axis: axis.largest_label, default=None),
        "stiffness": stiffness_reading([]),
        "strain_band": max((each.strain[2] / each.strain[0] for each in content.bands if each.strain), default=None),
        "recorded": any(counts(item) for item in content.comparisons),
        "speeds": experiment_tables.speeds_and_axes(content.results, axes, engines),
        "alone_table": experiment_tables.measured_alone(alone, engines),
    }


def _ranges(ratios: Mapping[str, Sequence[float]]) -> dict[str, list[str]]:
    """Range of the ratios as text -> the engines with this range."""
    ranges: dict[str, list[str]] = {}
    for name, values in ratios.items():
        ranges.setdefault(span(min(values), max(values), ".2f"), []).append(name)
    return ranges


def inconsistencies_found(content: "ThesisContent") -> dict[str, Any]:
    """The facts for `chapters/inconsistencies.html`."""
    rows = inconsistencies()
    return {"inconsistencies": rows, "table": experiment_tables.inconsistencies(rows)}
