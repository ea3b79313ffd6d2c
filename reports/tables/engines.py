"""Runs by engines: frequencies and amplitudes, every measure, settings and statuses."""

from collections.abc import Sequence
from typing import Any, Final

from quickreturn.cases.measures.cycle import HALVES
from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.comparison import CONSENSUS, REFERENCE, CaseResult, pair_of
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.runs.estimates import EXTREMES
from quickreturn.cases.runs.request import Run
from quickreturn.engines.accurate import TIP
from quickreturn.reports.findings.runs import mean_crank_speed
from quickreturn.reports.tables.table import CASE, Cell, Column, ColumnList, Mark, Table, Value
from quickreturn.reports.words import channel_name, cost, listed, settings_words, short_name

#: Channels whose peaks and amplitudes the page shows; the CSV file has the amplitudes of all.
SHOWN: Final = ("tip_acceleration", "strain_2")
DIFFERENCE: Final = "Δ"
_UNRESOLVABLE: Final = "n. r."
_UNITS: Final = {"tip_acceleration": ("m/s²", ".2f")} | dict.fromkeys(CHANNELS[1:], ("10⁻⁶", ".1f"))


def run_by_engine(results: Sequence[CaseResult]) -> Table:
    """One row per case and engine; cases in which every number shown can be measured come first."""
    settled = all(run.status == Ending.SETTLED for result in results for run in result.runs.values())
    columns: ColumnList = (
        *(CASE, "engine"),
        Column("status", in_page=not settled),
        Column("accuracy_class", "class", meaning="least that covers the engine's own estimates and its deviation from the reference"),
        *_number_columns(),
    )
    table = Table("run_by_engine", columns, others=listed([channel_name(name) for name in CHANNELS if name not in SHOWN]))
    for result in sorted(results, key=_has_gaps):
        missed = {(check.engine, check.half) for check in result.missed if check.quantity == CONSENSUS}
        for name, run in result.runs.items():
            reference = result.runs.get(REFERENCE)
            other = reference if reference is not None and reference.usable and name != REFERENCE else None
            cells: dict[str, Value | Cell] = {}
            for channel in SHOWN:
                cells |= _peak_cells(run, other, channel)
            for half in HALVES:
                cells |= _frequency_cells(run, other, half, "missed" if (name, half) in missed else "")
                for channel in CHANNELS:
                    cells |= _amplitude_cells(run, other, half, channel)
            table.add(case=result.case.name, engine=name, status=_status(run), accuracy_class=result.accuracy_class(name), **cells)
    return table


def _has_gaps(result: CaseResult) -> bool:
    """Whether a frequency or an amplitude that the page shows is missing."""
    halves = [(run, half) for run in result.runs.values() for half in HALVES]
    measures = [run.measure(half, channel) for run, half in halves for channel in SHOWN]
    frequencies = [run.consensus_frequency(half) if run.usable else None for run, half in halves]
    return None in frequencies or any(measure is None or measure.first_mode_amplitude is None for measure in measures)


def _number_columns() -> list[Column]:
    """Columns of numbers: those that every run has come first, the others may be empty."""
    columns = []
    for channel in SHOWN:
        unit, _ = _UNITS[channel]
        columns += [
            Column(f"peak_{channel}", short_name(channel), unit, ".1f", group="peak"),
            Column(f"peak_{channel}_difference", DIFFERENCE, "%", "+.1f", group="peak"),
        ]
    for half in HALVES:
        key, group = f"{half}_frequency", f"{half}-return frequency"
        columns += [
            Column(key, "f₁", "Hz", ".2f", uncertainty=f"{key}_uncertainty", group=group, meaning="consensus over resolvable channels"),
            Column(f"{key}_uncertainty", unit="Hz", in_page=False),
            Column(f"{key}_difference", DIFFERENCE, "%", "+.2f", group=group, meaning="(engine − reference) / reference"),
        ]
    for channel in CHANNELS:
        unit, form = _UNITS[channel]
        for half in HALVES:
            key, shown, group = f"{half}_{channel}_amplitude", channel in SHOWN, f"{channel_name(channel)}: amplitude"
            columns += [
                Column(key, half, unit, form, shown, group=group),
                Column(f"{key}_uncertainty", unit=unit, in_page=False),
                Column(f"{key}_difference", DIFFERENCE, "%", "+.1f", shown, group=group),
            ]
    return columns


def _status(run: Run) -> Cell:
    return Cell(run.status, note=run.remark, mark="open" if run.status == Ending.INACCURATE else "" if run.usable else "failed")


def _peak_cells(run: Run, other: Run | None, channel: str) -> dict[str, Value | Cell]:
    """The largest magnitude over the cycle, and its relative excess over the reference's."""
    if not run.usable:
        return {f"peak_{channel}": Cell(None, note=run.status)}
    peak, other_peak = run.peak(channel), other.peak(channel) if other else 0.0
    return {f"peak_{channel}": peak, f"peak_{channel}_difference": peak / other_peak - 1.0 if other_peak else None}


def _frequency_cells(run: Run, other: Run | None, half: str, mark: Mark) -> dict[str, Cell]:
    key = f"{half}_frequency"
    if not run.usable:
        return {key: Cell(None, note=run.status)}
    consensus = run.consensus_of(half)
    if consensus is None:
        measures = [(channel, run.measure(half, channel)) for channel in CHANNELS]
        reasons = [f"{channel_name(channel)}: {measure.reason if measure else ''}" for channel, measure in measures]
        return {key: Cell(None, _UNRESOLVABLE, "; ".join(reasons), "open")}
    difference = _difference(run, other, CONSENSUS, half, None, mark)
    return {key: Cell(consensus.first_mode_frequency), f"{key}_uncertainty": Cell(consensus.uncertainty), f"{key}_difference": difference}


def _amplitude_cells(run: Run, other: Run | None, half: str, channel: str) -> dict[str, Cell]:
    key = f"{half}_{channel}_amplitude"
    measure = run.measure(half, channel) if run.usable else None
    if measure is None:
        return {key: Cell(None, note=run.status)}
    if measure.first_mode_amplitude is None:
        return {key: Cell(None, _UNRESOLVABLE, measure.reason, "open")}
    return {
        key: Cell(measure.first_mode_amplitude),
        f"{key}_uncertainty": Cell(measure.first_mode_amplitude_uncertainty),
        f"{key}_difference": _difference(run, other, "first_mode_amplitude", half, channel),
    }


def _difference(run: Run, other: Run | None, quantity: str, half: str, channel: str | None, mark: Mark = "") -> Cell:
    pair = None if other is None else pair_of(run, other, quantity, half, channel)
    return Cell(pair[0].value / pair[1].value - 1.0, mark=mark) if pair and pair[1].value else Cell(None)


def measures(results: Sequence[CaseResult]) -> Table:
    """Every measure of every engine, one row per case, engine, half and channel. A file only."""
    in_hertz = ("first_mode_frequency", "first_mode_frequency_uncertainty", "first_mode_frequency_estimate", "second_mode_frequency")
    amplitudes = ("first_mode_amplitude", "first_mode_amplitude_uncertainty", "first_mode_amplitude_estimate")
    extremes = tuple(f"{name}{part}" for name in EXTREMES for part in ("", "_uncertainty", "_estimate"))
    numbers = [*(Column(key, unit="Hz") for key in in_hertz), *(Column(key, unit="SI") for key in (*amplitudes, *extremes))]
    table = Table("measures", ("case", "engine", "status", "half", "channel", *numbers, "reason"), in_page=False)
    for result in results:
        for name, run in result.runs.items():
            for measure in run.measures:
                table.add(measure, case=result.case.name, engine=name, status=run.status)
    return table


def settings(results: Sequence[CaseResult]) -> Table:
    """Settings of each engine on each case."""
    columns: ColumnList = (
        *(CASE, "engine"),
        Column("accuracy", "asked", "%", ".2g"),
        Column("error_estimate", "estimate", "%", ".2g"),
        Column("degrees_of_freedom", form="d"),
        Column("start", "marched from"),
        Column("cycles", form="d", meaning="until settled"),
        Column("settling_error", "distance from steady", "%", ".2g", meaning="estimated, of the last cycle"),
        "settings",
    )
    table = Table("settings", columns)
    for result in results:
        for run in result.runs.values():
            text = settings_words(run.settings or {}) or "none: the run ended before"
            estimate = Cell(run.error_estimate, note="; ".join(map(str, run.error_parts.get(TIP, ()))))
            start = run.start or Cell(None, note=run.status)
            table.add(run, case=result.case.name, error_estimate=estimate, start=start, settings=text)
    return table


def case_table(result: CaseResult) -> Table:
    """The small table of one case: extremes, frequencies, peaks and cost per engine."""
    columns: ColumnList = (
        "engine",
        "status",
        Column("pre_frequency", "f₁ pre", "Hz", ".2f"),
        Column("post_frequency", "f₁ post", "Hz", ".2f"),
        Column("peak_tip_acceleration", "tip acc.", "m/s²", ".1f", group="peak"),
        *(Column(f"peak_{name}", channel_name(name), "10⁻⁶", ".0f", group="peak") for name in CHANNELS[1:]),
        Column("peak_slider_force", "slider force", "N", ".2f", group="peak"),
        Column("crank_speed", "mean", "rad/s", ".3f", group="crank speed"),
        Column("crank_speed_variation", "max − min", "%", ".1f", group="crank speed"),
        Column("cycles", form="d"),
        Column("solve_seconds", "solve", "s", ".2f", words=cost),
    )
    table = Table("run_", columns, of=result.case.name.replace("-", "_"))
    for run in result.runs.values():
        cells: dict[str, Any] = {}
        if run.usable:
            cells = {f"peak_{column}": run.peak(column) for column in (*CHANNELS, "slider_force")}
            for half in HALVES:
                value = run.consensus_frequency(half)
                open_cell = Cell(None, _UNRESOLVABLE, "no channel resolves the first mode", "open")
                cells[f"{half}_frequency"] = open_cell if value is None else value
            speed, mean = run.cycle["crank_speed"], abs(mean_crank_speed(run))
            cells |= {"crank_speed": mean, "crank_speed_variation": float(speed.max() - speed.min()) / mean}
        table.add(run, status=_status(run), **cells)
    return table
