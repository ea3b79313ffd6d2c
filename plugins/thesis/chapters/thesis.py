"""What the thesis saw: its model compared with the converged one, what makes the halves differ, and its statements one by one."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.comparison.pair import Difference, Kind
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.engines.registry import MODEL
from quickreturn.plugins.thesis.axes import axis_comparisons, fits_worse
from quickreturn.plugins.thesis.conclusions import HOLDS, IN_PART, NOT, OUTCOMES, SAME_EFFECT, Conclusion
from quickreturn.plugins.thesis.effects import effect_facts, symmetric_effects_differ, tightened_words
from quickreturn.plugins.thesis.experiment.stiffness import StiffnessReading, stiffness_reading
from quickreturn.plugins.thesis.page_data import ThesisData
from quickreturn.plugins.thesis.sufficiency import Split
from quickreturn.plugins.thesis.unprinted import scatter_facts
from quickreturn.reports.long_studies import about
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.results.engine_differences import Summary, differences, summary_of
from quickreturn.reports.tables.table import Cell, Column, Mark, Table
from quickreturn.reports.words import HALF, channel_name, counted, number, percent, percents

#: The verdicts on several statements, where they differ from those on one.
_ON_SEVERAL: Final = {HOLDS: "hold", IN_PART: "hold in part", NOT: "do not hold"}


def thesis(content: ThesisData) -> Chapter:
    """The chapter."""
    results = content.thesis_results
    conclusions = content.conclusions
    compared = differences(results, MODEL, "frequency")
    fitted = [difference.relative for difference in compared]
    of_halves = {half: [difference.ratio for difference in compared if difference.half == half] for half in HALF}
    facts = {
        "worse": fits_worse(axis_comparisons(results)),
        "of_record": about("finding"),
        **effect_facts(content.finding, results),
        "of_record_scatter": about("unprinted"),
        **scatter_facts(content.bands),
        "stiffness": stiffness_words(stiffness_reading(fitted)),
        "ratios": ratios(results),
        "statements": statements(conclusions),
    }
    splits = content.splits if facts["effects_plot"] else []
    against = tightened_words(content.finding)
    text = finding(splits, against, symmetric_effects_differ(content.finding), of_halves, [each.outcome for each in conclusions])
    return Chapter("thesis", "What the thesis saw", text, facts)


def finding(splits: Sequence[Split], against: str, symmetric: bool, ratios: Mapping[str, Sequence[float]], outcomes: Sequence[str]) -> str:
    """What makes the halves differ, or else how stiff the single cubic is; and the verdicts on the statements.

    Args:
        splits: effects that make the halves differ as the words require, those with the fewest choices first.
        against: what the thesis says against the first of these (a clause), "" for nothing.
        symmetric: whether an effect that acts alike on both sides moves the halves apart.
        ratios: half -> frequencies of the single cubic over the converged ones.
        outcomes: verdict on each statement.
    """
    if splits:
        text = _splitting(splits, against, symmetric)
    elif all(ratios.values()):
        text = _stiffness(ratios)
    else:
        text = "Its statements, checked one by one"
    counts = Counter(outcomes)
    verdicts = (f"{counts[each]} {_ON_SEVERAL.get(each, each) if counts[each] > 1 else each}" for each in OUTCOMES if counts[each])
    return f"{text}; {counted(len(outcomes), 'statement')}: {', '.join(verdicts)}"


def _splitting(splits: Sequence[Split], against: str, symmetric: bool) -> str:
    first, only = splits[0], all(split.one_sided for split in splits)
    which = "a roller that is softer on one side" if only else "one that is not symmetric"
    but = f"; but {against}" if against else ""
    none = "" if symmetric else "; no symmetric effect tried moves them apart by more than the measurement leaves open"
    return (
        f"What made the halves differ is open. Of the effects tried one at a time, {which} would: at {first.strength} by"
        f" {percent(first.pre, '+.1f')} before and {percent(first.post, '+.1f')} after the return (medians){but}{none}"
    )


def _stiffness(ratios: Mapping[str, Sequence[float]]) -> str:
    """How stiff the single cubic is in both halves."""
    pre, post = (float(np.median(ratios[half])) for half in HALVES)
    stiff = "stiff" if pre - 1.0 + post - 1.0 > 0.0 else "soft"
    alike = " alike" if abs(post - pre) < SAME_EFFECT * abs(pre - 1.0) else ""
    return (
        f"Its one cubic is too {stiff} before and after the return{alike} ({number(pre, '.2f')} and {number(post, '.2f')} times the"
        f" converged frequency, medians of {len(ratios['pre'])} and {len(ratios['post'])} runs that resolve it)"
    )


def stiffness_words(stiffness: StiffnessReading) -> str:
    """The published bending stiffness beside that of ordinary aluminium, and beside the one that would undo the single cubic's excess."""
    published, (low, high) = stiffness.published.replace("*", " ").replace("^2", "²"), stiffness.below
    text = (
        f"EI = {published} over the nominal section means E = {number(stiffness.modulus / 1e9, '.1f')} GPa, {percents(low, high, '.0f')}"
        " below ordinary aluminium."
    )
    if not stiffness.needed:
        return text
    return (
        f"{text} A frequency grows with the square root of EI: to undo the single cubic’s median excess EI would have to be"
        f" {percent(stiffness.needed, '.0f')} lower. Inference: the published value may have been tuned towards the measured frequencies"
        f"{', though not all the way' if high < stiffness.needed else ''}."
    )


def ratios(results: Sequence[CaseResult]) -> Table:
    """Medians and ranges over the runs of thesis / reference."""
    table = Table(
        "thesis_over_reference",
        """The single cubic (thesis) over the converged solution (reference): medians and ranges over the runs, of first-mode frequency and
        amplitude where both resolve them, and of the peak over the half cycle.""",
        ("quantity", "channel", *_spread_columns("1", ".3f")),
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
                cells |= _spread_cells(half, short)
        if cells:
            table.add(quantity=label, channel=channel_name(channel), **cells)
    return table


def _spread_columns(unit: str, form: str) -> list[Column]:
    """Median, range and number of runs in each half."""
    columns = (("median", "median", unit, form), ("low", "least", unit, form), ("high", "greatest", unit, form), ("runs", "runs", "", "d"))
    return [Column(f"{half}_{key}", head, of, how, group=HALF[half]) for half in HALVES for key, head, of, how in columns]


def _spread_cells(half: str, spread: Summary) -> dict[str, float]:
    return {f"{half}_median": spread.median, f"{half}_low": spread.lowest, f"{half}_high": spread.highest, f"{half}_runs": spread.count}


def _peak_ratios(extremes: Sequence[Difference]) -> list[float]:
    """Ratio of the largest magnitude in a half to the other engine's, per case, from minimum and maximum."""
    peaks: dict[str, list[Difference]] = {}
    for difference in extremes:
        peaks.setdefault(difference.case, []).append(difference)
    return [max(abs(d.number.value) for d in pair) / max(abs(d.other_number.value) for d in pair) for pair in peaks.values()]


def statements(conclusions: Sequence[Conclusion]) -> Table:
    """The statements and their verdicts."""
    table = Table(
        "statements",
        """The thesis' statements on frequencies and amplitudes, in our words, and the verdict on each. An inference is a reading that the
        numbers allow but do not prove.""",
        ("section", "statement", "verdict", "inference", "numbers"),
    )
    for conclusion in conclusions:
        mark: Mark = "good" if conclusion.outcome in (HOLDS, IN_PART) else "missed" if conclusion.outcome == NOT else "open"
        table.add(
            conclusion,
            section=conclusion.statement.section,
            statement=conclusion.statement.words,
            verdict=Cell(conclusion.outcome, mark=mark),
            inference=Cell(conclusion.inference, "inference" if conclusion.inference else "–"),
        )
    return table
