"""Every run on every engine: frequencies, amplitudes and peaks, and every measure as a file."""

from collections.abc import Mapping, Sequence
from typing import Final

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.comparison.pair import CONSENSUS, Pair
from quickreturn.cases.files.shown import Units
from quickreturn.cases.motion.catalogue import IN_TABLES, MEASURES
from quickreturn.cases.motion.cycle import EXTREMES, HALVES, VIBRATION
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.number import Number
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.engine_differences import engines_of
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import (
    CASE,
    UNRESOLVABLE,
    Cell,
    Column,
    ColumnList,
    Mark,
    Table,
    Value,
    measure_cells,
    measure_column,
    status_cell,
)
from quickreturn.reports.words import case_label, channel_name, cost, counted, listed, short_name

#: Channels whose peaks and amplitudes the page shows; the CSV file has the amplitudes of all.
PLOTTED: Final = ("tip_acceleration", "strain_2")
DIFFERENCE: Final = "Δ"
#: Format of an amplitude in its unit.
_FORMS: Final = {"tip_acceleration": ".2f"} | dict.fromkeys(CHANNELS[1:], ".1f")


def runs(content: Content) -> Chapter:
    """The chapter."""
    resolved = {name: resolvable(content.results, name) for name in engines_of(content.results)}
    facts = {
        "unsettled": [f"{run.engine} on {case_label(case)} ({run.status})" for case, run in content.troubles],
        "table": run_by_engine(content.results),
        "measures": measures(content.results),
    }
    return Chapter("runs", "Every run on every engine", finding(len(content.troubles), resolved), facts)


def finding(troubles: int, resolved: Mapping[str, tuple[int, int]]) -> str:
    """The number of simulations that are not simply settled; engine -> number of half cycles with a resolvable first mode, and of all."""
    settled = f"{troubles} of the simulations {'is' if troubles == 1 else 'are'} not simply settled" if troubles else "All settled"
    counts = ", ".join(f"{name} {halves} of {number}" for name, (halves, number) in resolved.items() if number)
    if not any(halves for halves, _ in resolved.values()):
        return f"{settled}; the first mode rings too little to be measured" if counts else settled
    return f"{settled}; half turns in which the first mode rings enough to be measured: {counts}"


def resolvable(results: Sequence[CaseResult], engine: str) -> tuple[int, int]:
    """Of an engine's usable runs: the number of half cycles with a resolvable consensus frequency, and of all half cycles."""
    usable = [result.runs[engine] for result in results if engine in result.runs and result.runs[engine].usable]
    resolved = [run.consensus_frequency(half) is not None for run in usable for half in HALVES]
    return sum(resolved), len(resolved)


def run_by_engine(results: Sequence[CaseResult]) -> Table:
    """One row per case and engine; cases in which every number shown can be measured come first."""
    settled = all(run.status == Ending.SETTLED for result in results for run in result.runs.values())
    columns: ColumnList = (
        *(CASE, "engine"),
        Column("status", in_page=not settled),
        Column("accuracy_class", "class", meaning="least that covers the engine's own estimates and its deviation from the reference"),
        *_number_columns(results[0].case.units),
    )
    others = listed([channel_name(name) for name in CHANNELS if name not in PLOTTED])
    table = Table(
        "run_by_engine",
        f"""Peaks over the cycle (largest magnitude), first-mode frequency (consensus of the channels, ± one standard deviation) and
        amplitude (RMS of the envelope) before and after the return, with the difference to the reference (Δ). n. r.: not resolvable; a
        click shows the reason. The CSV file also has the reasons, the uncertainties and {others}.""",
        columns,
    )
    for result in sorted(results, key=_has_gaps):
        missed = {(check.engine, check.half) for check in result.missed if check.quantity == CONSENSUS}
        for name, run in result.runs.items():
            reference = result.runs.get(REFERENCE)
            other = reference if reference is not None and reference.usable and name != REFERENCE else None
            cells: dict[str, Value | Cell] = {}
            for channel in PLOTTED:
                cells |= _peak_cells(run, other, channel)
            for half in HALVES:
                cells |= _frequency_cells(run, other, half, "missed" if (name, half) in missed else "")
                for channel in CHANNELS:
                    cells |= _amplitude_cells(run, other, half, channel)
            table.add(case=result.case.name, engine=name, status=status_cell(run), accuracy_class=result.accuracy_class(name), **cells)
    return table


def _has_gaps(result: CaseResult) -> bool:
    """Whether a frequency or an amplitude that the page shows is missing."""
    halves = [(run, half) for run in result.runs.values() for half in HALVES]
    measures = [run.measure(half, channel) for run, half in halves for channel in PLOTTED]
    frequencies = [run.consensus_frequency(half) if run.usable else None for run, half in halves]
    return None in frequencies or any(measure is None or measure.first_mode_amplitude is None for measure in measures)


def _number_columns(units: Units) -> list[Column]:
    """Columns of numbers: those that every run has come first, the others may be empty."""
    columns = []
    for channel in PLOTTED:
        columns += [
            Column(f"peak_{channel}", short_name(channel), COLUMNS[channel].unit, ".1f", group="peak").shown_in(units),
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
        unit, form = COLUMNS[channel].unit, _FORMS[channel]
        for half in HALVES:
            key, shown, group = f"{half}_{channel}_amplitude", channel in PLOTTED, f"{channel_name(channel)}: amplitude"
            columns += [
                Column(key, half, unit, form, shown, group=group).shown_in(units),
                Column(f"{key}_uncertainty", unit=unit, in_page=False).shown_in(units),
                Column(f"{key}_difference", DIFFERENCE, "%", "+.1f", shown, group=group),
            ]
    return columns


def _peak_cells(run: Run, other: Run | None, channel: str) -> dict[str, Value | Cell]:
    """The largest magnitude over the cycle, and its relative excess over the reference's."""
    if not run.usable:
        return {f"peak_{channel}": Cell(None, note=run.status)}
    peak, other_peak = run.peak(channel), other.peak(channel) if other else 0.0
    return {f"peak_{channel}": peak, f"peak_{channel}_difference": peak / other_peak - 1.0 if other_peak else None}


def _frequency_cells(run: Run, other: Run | None, half: str, mark: Mark) -> dict[str, Cell]:
    consensus, measures = run.consensus_of(half), [(channel, run.measure(half, channel)) for channel in CHANNELS]
    reason = "; ".join(f"{channel_name(channel)}: {measure.reason if measure else ''}" for channel, measure in measures)
    difference = _difference(run, other, CONSENSUS, half, None, mark)
    return _number_cells(f"{half}_frequency", run, consensus.number if consensus else None, reason, difference)


def _amplitude_cells(run: Run, other: Run | None, half: str, channel: str) -> dict[str, Cell]:
    measure, amplitude = run.measure(half, channel), VIBRATION[1]
    number, reason = (None, "") if measure is None else (measure.number(amplitude), measure.reason)
    return _number_cells(f"{half}_{channel}_amplitude", run, number, reason, _difference(run, other, amplitude, half, channel))


def _number_cells(key: str, run: Run, number: Number | None, reason: str, difference: Cell) -> dict[str, Cell]:
    """A number with its uncertainty and its difference from the reference; or why there is none."""
    if not run.usable:
        return {key: Cell(None, note=run.status)}
    if number is None:
        return {key: Cell(None, UNRESOLVABLE, reason, "open")}
    return {key: Cell(number.value), f"{key}_uncertainty": Cell(number.measurement), f"{key}_difference": difference}


def _difference(run: Run, other: Run | None, quantity: str, half: str, channel: str | None, mark: Mark = "") -> Cell:
    pair = None if other is None else Pair(run, other).numbers(quantity, half, channel)
    return Cell(pair[0].value / pair[1].value - 1.0, mark=mark) if pair and pair[1].value else Cell(None)


def measures(results: Sequence[CaseResult]) -> Table:
    """Every measure of every engine, one row per case, engine, half and channel. A file only."""
    in_hertz = ("first_mode_frequency", "first_mode_frequency_uncertainty", "first_mode_frequency_estimate", "second_mode_frequency")
    amplitudes = ("first_mode_amplitude", "first_mode_amplitude_uncertainty", "first_mode_amplitude_estimate")
    extremes = tuple(f"{name}{part}" for name in EXTREMES for part in ("", "_uncertainty", "_estimate"))
    numbers = [*(Column(key, unit="Hz") for key in in_hertz), *(Column(key, unit="SI") for key in (*amplitudes, *extremes))]
    table = Table(
        "measures",
        """Every measure of every engine, for each half and channel: first-mode frequency and amplitude with uncertainties, the second mode
        if it is found, the extremes with their uncertainty from the spacing of rows, the engine's own estimates of the errors, and the
        reason why a frequency or amplitude is not resolvable. Accelerations in m/s², strains as 1.""",
        ("case", "engine", "status", "half", "channel", *numbers, "reason"),
        in_page=False,
    )
    for result in results:
        for name, run in result.runs.items():
            for measure in run.measured.measures:
                table.add(measure, case=result.case.name, engine=name, status=run.status)
    return table


def run_by_run(content: Content) -> Chapter:
    """The chapter: one section per case, without the notes that another chapter gives."""
    sections = [
        {
            "case": result.case,
            "notes": [f"{note[:1].upper()}{note[1:]}." for note in result.case.notes if note not in content.general_notes],
            "failures": result.failures,
            "departures": {" and ".join(pair): counted(len(checks), "number") for pair, checks in result.departures.items()},
            "table": case_table(result),
        }
        for result in content.results
    ]
    return Chapter("each", "Run by run", signals_finding(len(sections)), {"sections": sections})


def signals_finding(cases: int) -> str:
    """What the chapter shows."""
    return f"All signals{' of the run chosen above' if cases > 1 else ''}, engines overlaid"


def _others() -> str:
    """The measures of `case_table` that are not of the vibration, as their columns are headed."""
    heads = dict[str, list[str]]()
    for name, column in IN_TABLES.items():
        if not MEASURES[name].vibration:
            heads.setdefault(column.group, []).append(column.head)
    return ", ".join(f"{group} ({', '.join(parts)})" if group else ", ".join(parts) for group, parts in heads.items())


def case_table(result: CaseResult) -> Table:
    """The small table of one case: extremes, frequencies, peaks and cost per engine."""
    units = result.case.units
    columns: ColumnList = (
        "engine",
        "status",
        *(measure_column(name, units) for name in IN_TABLES if MEASURES[name].vibration),
        Column("peak_tip_acceleration", "tip acc.", "m/s^2", ".1f", group="peak").shown_in(units),
        *(Column(f"peak_{name}", channel_name(name), "10⁻⁶", ".0f", group="peak") for name in CHANNELS[1:]),
        Column("peak_slider_force", "slider force", "N", ".2f", group="peak").shown_in(units),
        *(measure_column(name, units) for name in IN_TABLES if not MEASURES[name].vibration),
        Column("cycles", form="d"),
        Column("solve_seconds", "solve", "s", ".2f", words=cost),
    )
    table = Table(
        f"run_{result.case.name.replace('-', '_')}",
        f"""First-mode frequency before and after the return, peaks over the cycle (largest magnitude), {_others()}, cycles until
        settled and solve time.""",
        columns,
    )
    for run in result.runs.values():
        peaks = {f"peak_{column}": run.peak(column) for column in (*CHANNELS, "slider_force") if run.usable}
        table.add(run.flat, status=status_cell(run), **peaks, **measure_cells(result.case, run))
    return table
