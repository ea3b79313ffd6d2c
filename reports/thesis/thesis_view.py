"""Tables that compare the thesis' model with the converged one, and of its statements."""

from collections.abc import Sequence

from quickreturn.cases.measures.cycle import HALVES
from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.comparison import CaseResult, Difference, Kind
from quickreturn.engines.registry import MODEL
from quickreturn.reports.findings.agreement import Summary, differences, summary_of
from quickreturn.reports.tables.table import Cell, Column, Mark, Table
from quickreturn.reports.thesis.conclusions import HOLDS, IN_PART, NOT, Conclusion
from quickreturn.reports.thesis.raw_extremes import Excess
from quickreturn.reports.words import HALF, channel_name


def ratios(results: Sequence[CaseResult]) -> Table:
    """Medians and ranges over the runs of thesis / reference."""
    table = Table("thesis_over_reference", ("quantity", "channel", *_spread_columns("1", ".3f")))
    rows: list[tuple[str, Kind, str | None]] = [("first-mode frequency", "frequency", None)]
    rows += [("first-mode amplitude", "amplitude", channel) for channel in CHANNELS]
    rows += [("peak", "extreme", channel) for channel in CHANNELS]
    for label, kind, channel in rows:
        cells: dict[str, float] = {}
        for half in HALVES:
            found = differences(results, MODEL, kind, half=half, channel=channel)
            values = _peak_ratios(found) if kind == "extreme" else [difference.ratio for difference in found]
            if short := summary_of(values):
                cells |= _spread_cells(half, short)
        if cells:
            table.add(quantity=label, channel=channel_name(channel), **cells)
    return table


def _spread_columns(unit: str, form: str) -> list[Column]:
    """Median, range and number of runs in each half."""
    columns = (("median", "median", unit, form), ("low", "least", unit, form), ("high", "greatest", unit, form), ("runs", "runs", "", "d"))
    return [Column(f"{half}_{key}", head, of, how, group=HALF[half]) for half in HALVES for key, head, of, how in columns]


def _spread_cells(half: str, found: Summary) -> dict[str, float]:
    return {f"{half}_median": found.median, f"{half}_low": found.lowest, f"{half}_high": found.highest, f"{half}_runs": found.count}


def _peak_ratios(found: Sequence[Difference]) -> list[float]:
    """Ratio of the largest magnitude in a half to the other engine's, per case, from minimum and maximum."""
    peaks: dict[str, list[Difference]] = {}
    for difference in found:
        peaks.setdefault(difference.case, []).append(difference)
    return [max(abs(d.mine.value) for d in pair) / max(abs(d.its.value) for d in pair) for pair in peaks.values()]


def counted(excesses: Sequence[Excess]) -> Table:
    """Excess of frequencies that are counted off a plot."""
    visible = Column("visible", "counted from", "% of range", ".1f")
    table = Table("counted_off_plots", (visible, "channel", *_spread_columns("%", "+.1f")))
    for threshold in dict.fromkeys(each.visible for each in excesses):
        for channel in CHANNELS:
            cells: dict[str, float] = {}
            for each in (each for each in excesses if (each.visible, each.channel) == (threshold, channel)):
                cells |= _spread_cells(each.half, each)
            if cells:
                table.add(visible=threshold, channel=channel_name(channel), **cells)
    return table


def statements(conclusions: Sequence[Conclusion]) -> Table:
    """The statements and their verdicts."""
    table = Table("statements", ("section", "statement", "verdict", "inference", "numbers"))
    for each in conclusions:
        mark: Mark = "good" if each.outcome in (HOLDS, IN_PART) else "missed" if each.outcome == NOT else "open"
        table.add(
            each,
            section=each.statement.section,
            statement=each.statement.words,
            verdict=Cell(each.outcome, mark=mark),
            inference=Cell(each.inference, "inference" if each.inference else "–"),
        )
    return table
