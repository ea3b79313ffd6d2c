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
    return [max(abs(d.mine.value) for d in pair) / max(abs(d.its.value) for d in pair) for pair in peaks.values()]


def counted(excesses: Sequence[Excess]) -> Table:
    """Excess of frequencies that are counted off a plot."""
    visible = Column("visible", "counted from", "% of range", ".1f")
    table = Table("counted_off_plots", (visible, "channel", *_spread_columns("%", "+.1f")))
    for threshold in dict.fromkeys(excess.visible for excess in excesses):
        for channel in CHANNELS:
            cells: dict[str, float] = {}
            for excess in (excess for excess in excesses if (excess.visible, excess.channel) == (threshold, channel)):
                cells |= _spread_cells(excess.half, excess)
            if cells:
                table.add(visible=threshold, channel=channel_name(channel), **cells)
    return table


def statements(conclusions: Sequence[Conclusion]) -> Table:
    """The statements and their verdicts."""
    table = Table("statements", ("section", "statement", "verdict", "inference", "numbers"))
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
