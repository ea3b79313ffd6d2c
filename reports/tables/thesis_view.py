"""The thesis' model against the converged one, its statements, and what a soft joint would do."""

from collections.abc import Sequence

import numpy as np

from cases.frozen_crank import LBF_PER_IN, JointEffect
from cases.measures import CHANNELS
from cases.runs.comparison import HALVES, CaseResult
from reports.findings.agreement import Difference, Kind, differences
from reports.findings.conclusions import HOLDS, IN_PART, MODEL, NOT, Conclusion
from reports.findings.raw_extremes import Excess
from reports.tables.table import Cell, Column, Table, TableBuilder
from reports.words import HALF, channel_name


def ratios(results: Sequence[CaseResult]) -> Table:
    """Medians and ranges over the runs of thesis / reference."""
    builder = TableBuilder(
        "thesis_over_reference",
        "The single cubic (thesis) over the converged solution (reference): medians and ranges over the runs, of first-mode frequency and"
        " amplitude where both resolve them, and of the peak over the half cycle.",
        (
            Column("quantity", "quantity"),
            Column("channel", "channel"),
            *(
                Column(f"{half}_{key}", head, "1" if form else "", form or "d", group=HALF[half])
                for half in HALVES
                for key, head, form in (
                    ("median", "median", ".3f"),
                    ("low", "least", ".3f"),
                    ("high", "greatest", ".3f"),
                    ("runs", "runs", ""),
                )
            ),
        ),
    )
    rows: list[tuple[str, Kind, str | None]] = [("first-mode frequency", "frequency", None)]
    rows += [("first-mode amplitude", "amplitude", channel) for channel in CHANNELS]
    rows += [("peak", "extreme", channel) for channel in CHANNELS]
    for label, kind, channel in rows:
        cells: dict[str, Cell | float | int] = {}
        for half in HALVES:
            found = differences(results, MODEL, kind, half=half, channel=channel)
            values = _peak_ratios(found) if kind == "extreme" else [difference.ratio for difference in found]
            if values:
                numbers = {"median": float(np.median(values)), "low": min(values), "high": max(values), "runs": len(values)}
                cells |= {f"{half}_{key}": value for key, value in numbers.items()}
        if cells:
            builder.add(quantity=label, channel=channel_name(channel), **cells)
    return builder.table()


def _peak_ratios(found: Sequence[Difference]) -> list[float]:
    """Largest magnitude in a half over the other engine's, per case, from minimum and maximum."""
    peaks: dict[str, list[Difference]] = {}
    for difference in found:
        peaks.setdefault(difference.case, []).append(difference)
    return [max(abs(d.value) for d in pair) / max(abs(d.other) for d in pair) for pair in peaks.values()]


def counted(excesses: Sequence[Excess]) -> Table:
    """Excess of frequencies counted off a plot."""
    kinds = (("median", "median", "1", "+.1f"), ("low", "least", "1", "+.1f"), ("high", "greatest", "1", "+.1f"), ("runs", "runs", "", "d"))
    builder = TableBuilder(
        "counted_off_plots",
        "Excess of the single cubic's frequency over the converged one if both are counted off plots: half oscillations between visible"
        " extremes of the raw signal over their time, in the halves where both resolve the first mode. An extreme is counted if it stands"
        " out by the part of the signal's range in the first column. Not a measure of this report; see the text.",
        (
            Column("visible", "counted from", "1", ".1f", "% of range", 100.0),
            Column("channel", "channel"),
            *(
                Column(f"{half}_{key}", head, unit, form, "%" if unit else None, 100.0 if unit else 1.0, group=HALF[half])
                for half in HALVES
                for key, head, unit, form in kinds
            ),
        ),
    )
    for visible in dict.fromkeys(found.visible for found in excesses):
        for channel in CHANNELS:
            cells: dict[str, float | int] = {}
            for excess in (found for found in excesses if (found.visible, found.channel) == (visible, channel)):
                numbers = {"median": excess.median, "low": excess.lowest, "high": excess.highest, "runs": excess.count}
                cells |= {f"{excess.half}_{key}": value for key, value in numbers.items()}
            if cells:
                builder.add(visible=visible, channel=channel_name(channel), **cells)
    return builder.table()


def statements(found: Sequence[Conclusion]) -> Table:
    """The statements, and what becomes of each."""
    builder = TableBuilder(
        "statements",
        "What the thesis says about frequencies and amplitudes, in our words, and what becomes of it. An inference is a reading that the"
        " numbers allow and do not prove.",
        (
            Column("section", "section"),
            Column("statement", "statement"),
            Column("verdict", "verdict"),
            Column("inference", "inference"),
            Column("numbers", "numbers"),
        ),
    )
    for each in found:
        mark = "good" if each.outcome in (HOLDS, IN_PART) else "missed" if each.outcome == NOT else "open"
        builder.add(
            each,
            section=each.statement.section,
            statement=each.statement.words,
            verdict=Cell(each.outcome, mark=mark),  # type: ignore[arg-type]  # one of the marks
            inference=Cell(each.inference, "inference" if each.inference else "–"),
        )
    return builder.table()


def joints(effects: Sequence[JointEffect], run: str) -> Table:
    """What a linearly soft slider joint does."""
    builder = TableBuilder(
        "joint_stiffness",
        f"A linearly soft slider joint in {run}, crank held: change of the first mode's mean frequency in each half of the reference's"
        " cycle, and where the third converged mode lies over the crank angle.",
        (
            Column("stiffness", "joint stiffness", "N/m", ".3g", "kN/m", 1e-3),
            Column("stiffness_in_lbf_per_in", "the same", "lbf/in", ".4g"),
            Column("change_pre", "pre-return", "1", "+.2f", "%", 100.0, group="change of f₁"),
            Column("change_post", "post-return", "1", "+.2f", "%", 100.0, group="change of f₁"),
            Column("third_mode_low", "from", "Hz", ".0f", group="f₃"),
            Column("third_mode_high", "to", "Hz", ".0f", group="f₃"),
        ),
    )
    for effect in effects:
        builder.add(
            effect,
            stiffness_in_lbf_per_in=effect.stiffness / LBF_PER_IN,
            third_mode_low=effect.third_mode.low,
            third_mode_high=effect.third_mode.high,
        )
    return builder.table()
