"""What is left of the experiment, held against the engines."""

from collections.abc import Sequence
from typing import Any

from cases.experiment import channel_is_usable, measured_crank_speed
from cases.library import Inconsistency
from cases.library.thesis import RUNS
from cases.measures import Measure
from cases.runs.comparison import REFERENCE, CaseResult
from cases.runs.request import Run
from reports.findings.axes import AxisComparison
from reports.findings.conclusions import MODEL
from reports.findings.measured import MeasuredHalf
from reports.findings.runs import thesis_runs
from reports.tables.table import CASE, CHANNEL, HALF_COLUMN, Cell, Column, Table, TableBuilder
from reports.words import channel_name


def speeds_and_axes(results: Sequence[CaseResult], axes: Sequence[AxisComparison]) -> Table:
    """Per run the crank speed, which measurements are valid, and the simulated peaks over the largest axis label."""
    builder = TableBuilder(
        "experiment",
        "Per run: measured crank speed (table 3.1) and the speed simulated; which measurements section 3.5 calls valid; largest"
        " legible axis label of the appendix' figure and the simulated peak over it (printed strain read as percent). A label bounds"
        " the plotted curves roughly and from below: labels are missing, and measured curves share the axes.",
        (
            CASE,
            Column("measured_speed", "measured", "rad/s", ".3f", group="crank speed"),
            Column("simulated_speed", "simulated", "rad/s", ".3f", group="crank speed", meaning="mean of the reference's steady cycle"),
            Column("acceleration_valid", "acceleration", group="valid"),
            Column("strain_valid", "strain", group="valid"),
            Column("acceleration_label", "label", "m/s²", ".1f", group="tip acceleration"),
            Column(f"acceleration_{MODEL}", MODEL, "1", ".2f", group="tip acceleration", meaning="peak over label"),
            Column(f"acceleration_{REFERENCE}", REFERENCE, "1", ".2f", group="tip acceleration", meaning="peak over label"),
            Column("strain_label", "label", "1", ".2g", "%", 100.0, group="strain, largest of three"),
            Column(f"strain_{MODEL}", MODEL, "1", ".2f", group="strain, largest of three", meaning="peak over label"),
            Column(f"strain_{REFERENCE}", REFERENCE, "1", ".2f", group="strain, largest of three", meaning="peak over label"),
        ),
    )
    for number_of_run, result in thesis_runs(results).items():
        cells: dict[str, Any] = {}
        for axis in (found for found in axes if found.run == number_of_run):
            prefix = "acceleration" if axis.channel == "tip_acceleration" else "strain"
            cells[f"{prefix}_label"] = axis.largest_label
            for engine in (MODEL, REFERENCE):
                cells[f"{prefix}_{engine}"] = axis.ratio(engine)
        measured = measured_crank_speed(number_of_run)
        reference = result.runs.get(REFERENCE)
        if reference is not None and reference.usable:
            angle, time = reference.cycle["crank_angle"], reference.cycle["time"]
            cells["simulated_speed"] = float(angle[-1] - angle[0]) / float(time[-1] - time[0])
        builder.add(
            case=result.case.name,
            measured_speed=Cell(None, "none printed", "tables 3.1 and 5.2 say N/A") if measured is None else measured,
            acceleration_valid=channel_is_usable(number_of_run, "tip_acceleration"),
            strain_valid=channel_is_usable(number_of_run, "strain_1"),
            **cells,
        )
    return builder.table()


def recorded(results: Sequence[CaseResult]) -> Table:
    """The recorded tables with what they declare."""
    builder = TableBuilder(
        "recorded",
        "Recorded tables: results of other tools, earlier versions and measurements, with what their files declare.",
        (
            CASE,
            Column("table", "table"),
            Column("version", "version"),
            Column("origin", "origin"),
            Column("status", "status"),
            Column("rows", "rows", form="d"),
            Column("columns", "columns"),
            Column("source", "source"),
            Column("remark", "remark"),
        ),
    )
    for result in results:
        for run in result.recorded.values():
            builder.add(
                run,
                case=result.case.name,
                table=run.engine,
                origin=_origin(run),
                status=Cell(run.status, mark="" if run.usable else "failed"),
                rows=0 if run.recording is None else run.recording.rows,
                columns=", ".join(channel_name(name) for name in run.cycle if name not in ("time", "crank_angle")),
                source=run.method,
            )
    return builder.table()


def _origin(run: Run) -> Cell:
    origin = run.recording.declared.get("origin", "") if run.recording else ""
    return Cell(origin or None, mark="open" if origin == "synthetic" else "")


def curve_comparison(found: Sequence[MeasuredHalf], engines: Sequence[str]) -> Table:
    """Engines over recorded tables, per half."""
    builder = TableBuilder(
        "curve_comparison",
        "Engines over recorded tables: first-mode frequency and amplitude of the table (measured like an engine's cycle) and each engine's"
        " number over it. Extremes of what was measured or digitised are taken after a zero-phase low-pass at 200 Hz.",
        (
            CASE,
            Column("table", "table"),
            CHANNEL,
            Column("origin", "origin"),
            HALF_COLUMN,
            Column("frequency", "table", "Hz", ".2f", uncertainty="frequency_uncertainty", group="first-mode frequency"),
            Column("frequency_uncertainty", "±", "Hz", ".2f", in_page=False),
            *(Column(f"frequency_{name}", name, "1", ".3f", group="first-mode frequency", meaning="engine / table") for name in engines),
            Column("amplitude", "table", "SI", ".3g", group="first-mode amplitude"),
            *(Column(f"amplitude_{name}", name, "1", ".3f", group="first-mode amplitude", meaning="engine / table") for name in engines),
            Column("minimum", "minimum", "SI", ".3g", group="extremes of the table"),
            Column("maximum", "maximum", "SI", ".3g", group="extremes of the table"),
        ),
    )
    for item in found:
        cells: dict[str, Any] = {}
        for short in ("frequency", "amplitude"):
            value = _first_mode(item.measure, short)
            cells[short] = Cell(None, "n. r.", item.measure.reason, "open") if value is None else value
            for engine in engines:
                its = _first_mode(item.engines.get(engine), short)
                cells[f"{short}_{engine}"] = its / value if its is not None and value else None
        builder.add(
            item.measure,
            case=item.case,
            table=item.table.engine,
            origin=_origin(item.table),
            frequency_uncertainty=item.measure.first_mode_frequency_uncertainty,
            **cells,
        )
    return builder.table()


def _first_mode(measure: Measure | None, quantity: str) -> float | None:
    if measure is None:
        return None
    return measure.first_mode_frequency if quantity == "frequency" else measure.first_mode_amplitude


def inconsistencies(found: Sequence[Inconsistency]) -> Table:
    """Where the thesis contradicts itself or leaves a gap."""
    builder = TableBuilder(
        "inconsistencies",
        "Published inconsistencies and gaps, and what is used here instead. Nothing is mended silently.",
        (
            Column("runs", "runs"),
            Column("what", "what"),
            Column("published", "published"),
            Column("used", "used here"),
            Column("reason", "because"),
        ),
    )
    for item in found:
        builder.add(item, runs=_runs(item.runs))
    return builder.table()


def _runs(numbers: Sequence[int]) -> str:
    if tuple(numbers) == tuple(RUNS):
        return "all"
    if len(numbers) > 2 and list(numbers) == list(range(numbers[0], numbers[-1] + 1)):
        return f"{numbers[0]} to {numbers[-1]}"
    return ", ".join(map(str, numbers))
