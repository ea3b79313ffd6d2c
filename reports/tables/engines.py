"""Runs by engines: frequencies and amplitudes, every measure, settings and statuses."""

from collections.abc import Sequence
from typing import Any, Final

from cases.measures import CHANNELS
from cases.runs.comparison import CONSENSUS, HALVES, REFERENCE, CaseResult, values
from cases.runs.request import INACCURATE, Run
from reports.tables.table import CASE, Cell, Column, Mark, Table, TableBuilder
from reports.words import channel_name, cost, listed, settings_words

#: Channels whose amplitudes the page shows; the CSV file has all.
SHOWN: Final = ("tip_acceleration", "strain_2")
_UNRESOLVABLE: Final = "n. r."
_UNITS: Final = {"tip_acceleration": ("m/s²", None, ".2f", 1.0)} | dict.fromkeys(CHANNELS[1:], ("1", "10⁻⁶", ".1f", 1e6))


def run_by_engine(results: Sequence[CaseResult]) -> Table:
    """One row per case and engine."""
    builder = TableBuilder(
        "run_by_engine",
        "First-mode frequency (consensus of the channels, ± one standard deviation) and amplitude (RMS of the envelope) before and after"
        " the return, with the difference to the reference (Δ). n. r.: not resolvable; the reason shows where the pointer rests, and"
        f" stands in the CSV file, which also has the uncertainties and {listed([channel_name(c) for c in CHANNELS if c not in SHOWN])}.",
        (
            *(CASE, Column("engine", "engine"), Column("status", "status")),
            Column("accuracy_class", "class", meaning="least that covers the engine's own estimates and its deviation from the reference"),
            *_number_columns(),
        ),
    )
    for result in results:
        reference = result.runs.get(REFERENCE)
        missed = {(check.engine, check.half) for check in result.missed if check.quantity == CONSENSUS}
        for name, run in result.runs.items():
            numbers: dict[str, Any] = {}
            for half in HALVES:
                mark: Mark = "missed" if (name, half) in missed else ""
                numbers |= _frequency_cells(run, reference, half, mark, name == REFERENCE)
                for channel in CHANNELS:
                    numbers |= _amplitude_cells(run, reference, half, channel, name == REFERENCE)
            numbers |= {"status": _status(run), "accuracy_class": result.accuracy_class(name)}
            builder.add(case=result.case.name, engine=name, **numbers)
    return builder.table()


def _number_columns() -> list[Column]:
    columns = []
    for half in HALVES:
        group = f"{half}-return frequency"
        key = f"{half}_frequency"
        columns += [
            Column(key, "f₁", "Hz", ".2f", uncertainty=f"{key}_uncertainty", group=group, meaning="consensus over resolvable channels"),
            Column(f"{key}_uncertainty", "±", "Hz", ".2f", in_page=False),
            Column(
                f"{key}_difference",
                "Δ",
                "1",
                "+.2f",
                "%",
                100.0,
                group=group,
                meaning="(engine − reference) / reference",
            ),
        ]
    for channel in CHANNELS:
        unit, shown_unit, form, factor = _UNITS[channel]
        for half in HALVES:
            key, shown, group = f"{half}_{channel}", channel in SHOWN, f"{channel_name(channel)}: amplitude"
            columns += [
                Column(f"{key}_amplitude", half, unit, form, shown_unit, factor, shown, group=group),
                Column(f"{key}_amplitude_uncertainty", "±", unit, form, shown_unit, factor, in_page=False),
                Column(f"{key}_amplitude_difference", "Δ", "1", "+.1f", "%", 100.0, shown, group=group),
            ]
    return columns


def _status(run: Run) -> Cell:
    mark: Mark = "" if run.usable else "failed"
    return Cell(run.status, note=run.remark, mark="open" if run.status == INACCURATE else mark)


def _frequency_cells(run: Run, reference: Run | None, half: str, mark: Mark, is_reference: bool) -> dict[str, Cell]:
    key = f"{half}_frequency"
    if not run.usable:
        return {key: Cell(None, note=run.status)}
    found = run.consensus_of(half)
    if found is None:
        measures = [(channel, run.measure(half, channel)) for channel in CHANNELS]
        reasons = [f"{channel_name(channel)}: {measure.reason if measure else ''}" for channel, measure in measures]
        return {key: Cell(None, _UNRESOLVABLE, "; ".join(reasons), "open")}
    comparable = reference is not None and reference.usable and not is_reference
    pair = values(run, reference, CONSENSUS, half, None) if comparable and reference is not None else None
    difference = Cell(None) if pair is None else Cell(pair[0] / pair[1] - 1.0, mark=mark)
    return {key: Cell(found.first_mode_frequency), f"{key}_uncertainty": Cell(found.uncertainty), f"{key}_difference": difference}


def _amplitude_cells(run: Run, reference: Run | None, half: str, channel: str, is_reference: bool) -> dict[str, Cell]:
    key = f"{half}_{channel}_amplitude"
    measure = run.measure(half, channel) if run.usable else None
    if measure is None:
        return {key: Cell(None, note=run.status)}
    value = measure.first_mode_amplitude
    if value is None:
        return {key: Cell(None, _UNRESOLVABLE, measure.reason, "open")}
    its = reference.measure(half, channel) if reference is not None and reference.usable and not is_reference else None
    other = its.first_mode_amplitude if its else None
    return {
        key: Cell(value),
        f"{key}_uncertainty": Cell(measure.first_mode_amplitude_uncertainty),
        f"{key}_difference": Cell(value / other - 1.0 if other else None),
    }


def measures(results: Sequence[CaseResult]) -> Table:
    """Every measure of every engine, one row per case, engine, half and channel. A file only."""
    columns = [Column(key, key) for key in ("case", "engine", "status", "half", "channel")]
    in_hertz = ("first_mode_frequency", "first_mode_frequency_uncertainty", "first_mode_frequency_estimate", "second_mode_frequency")
    amplitudes = ("first_mode_amplitude", "first_mode_amplitude_uncertainty", "first_mode_amplitude_estimate")
    extremes = ("minimum", "minimum_estimate", "maximum", "maximum_estimate")
    columns += [Column(key, key, "Hz", "g") for key in in_hertz]
    columns += [Column(key, key, "SI", "g") for key in (*amplitudes, *extremes)]
    columns += [Column("reason", "reason")]
    builder = TableBuilder(
        "measures",
        "Every measure of every engine: per half and channel the first-mode frequency and amplitude with uncertainties, the second mode"
        " where it is found, the extremes, the engine's own estimates of the errors, and why frequency or amplitude is not resolvable."
        " Accelerations in m/s², strains as 1.",
        columns,
        in_page=False,
    )
    for result in results:
        for name, run in result.runs.items():
            for measure in run.measures:
                builder.add(case=result.case.name, engine=name, status=run.status, **vars(measure))
    return builder.table()


def settings(results: Sequence[CaseResult]) -> Table:
    """How each engine was run on each case."""
    builder = TableBuilder(
        "settings",
        "Settings per run and engine. They follow from the accuracy asked; the estimate is the engine's own, of the tip deflection: over"
        " two cycles where it marched from the periodic state, else over the case's duration from the standard start; that of thesis is of"
        " the integration of its own equations alone. Marched from: where the cycles began; the reference finds its steady state without.",
        (
            CASE,
            Column("engine", "engine"),
            Column("accuracy", "asked", "1", ".2g", "%", 100.0),
            Column("error_estimate", "estimate", "1", ".2g", "%", 100.0),
            Column("degrees_of_freedom", "degrees of freedom", form="d"),
            Column("start", "marched from"),
            Column("cycles", "cycles", form="d", meaning="until settled"),
            Column("settling_error", "distance from steady", "1", ".2g", "%", 100.0, meaning="estimated, of the last cycle"),
            Column("settings", "settings"),
        ),
    )
    for result in results:
        for run in result.runs.values():
            builder.add(
                run,
                case=result.case.name,
                start=run.start or Cell(None, note=run.status),
                settings=settings_words(run.settings or {}) or "none: it did not come so far",
            )
    return builder.table()


def case_table(result: CaseResult) -> Table:
    """The small table of one case: extremes, frequencies, peaks and cost per engine."""
    builder = TableBuilder(
        f"run_{result.case.name.replace('-', '_')}",
        "First-mode frequency before and after the return, peaks over the cycle (largest magnitude), mean and variation of the crank"
        " speed, cycles until settled and solve time.",
        (
            Column("engine", "engine"),
            Column("status", "status"),
            Column("pre_frequency", "f₁ pre", "Hz", ".2f"),
            Column("post_frequency", "f₁ post", "Hz", ".2f"),
            Column("peak_tip_acceleration", "tip acc.", "m/s²", ".1f", group="peak"),
            *(Column(f"peak_{name}", name.replace("_", " "), "1", ".0f", "10⁻⁶", 1e6, group="peak") for name in CHANNELS[1:]),
            Column("peak_slider_force", "slider force", "N", ".2f", group="peak"),
            Column("crank_speed", "mean", "rad/s", ".3f", group="crank speed"),
            Column("crank_speed_variation", "max − min", "1", ".1f", "%", 100.0, group="crank speed"),
            Column("cycles", "cycles", form="d"),
            Column("solve_seconds", "solve", "s", ".2f"),
        ),
    )
    for name, run in result.runs.items():
        numbers: dict[str, Any] = {}
        if run.usable:
            numbers = {f"peak_{column}": run.peak(column) for column in (*CHANNELS, "slider_force")}
            for half in HALVES:
                value = run.consensus_frequency(half)
                open_cell = Cell(None, _UNRESOLVABLE, "no channel resolves the first mode", "open")
                numbers[f"{half}_frequency"] = open_cell if value is None else value
            speed, time = run.cycle["crank_speed"], run.cycle["time"]
            mean = abs(float(run.cycle["crank_angle"][-1] - run.cycle["crank_angle"][0])) / float(time[-1] - time[0])
            numbers |= {"crank_speed": mean, "crank_speed_variation": float(speed.max() - speed.min()) / mean}
        took = run.solve_seconds
        numbers |= {"cycles": run.cycles, "solve_seconds": Cell(took, "–" if took is None else cost(took))}
        builder.add(engine=name, status=_status(run), **numbers)
    return builder.table()
