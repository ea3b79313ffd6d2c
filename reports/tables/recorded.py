"""Tables of the remains of the experiment, compared with the engines."""

from collections.abc import Sequence
from typing import Any

from quickreturn.cases.experiment import channel_is_usable, measured_crank_speed
from quickreturn.cases.library import Inconsistency
from quickreturn.cases.library.thesis import RUNS
from quickreturn.cases.runs.comparison import REFERENCE, CaseResult
from quickreturn.cases.runs.request import Run
from quickreturn.reports.findings.axes import AxisComparison
from quickreturn.reports.findings.measured import MeasuredHalf
from quickreturn.reports.findings.runs import mean_crank_speed, thesis_runs
from quickreturn.reports.tables.table import CASE, CHANNEL, HALF_COLUMN, Cell, Column, ColumnList, Table
from quickreturn.reports.words import channel_name


def speeds_and_axes(results: Sequence[CaseResult], axes: Sequence[AxisComparison], engines: Sequence[str]) -> Table:
    """Per run the crank speed, the valid measurements, and the simulated peaks of engines over the largest axis label."""
    columns = [
        CASE,
        Column("measured_speed", "measured", "rad/s", ".3f", group="crank speed"),
        Column("simulated_speed", "simulated", "rad/s", ".3f", group="crank speed", meaning="mean of the reference's steady cycle"),
        Column("acceleration_valid", "acceleration", group="valid"),
        Column("strain_valid", "strain", group="valid"),
    ]
    for name, unit, form, group in (
        ("acceleration", "m/s²", ".1f", "tip acceleration"),
        ("strain", "%", ".2g", "strain, largest of three"),
    ):
        columns.append(Column(f"{name}_label", "label", unit, form, group=group))
        columns += [Column(f"{name}_{engine}", engine, "1", ".2f", group=group, meaning="peak over label") for engine in engines]
    found = Table("experiment", columns)
    for number, result in thesis_runs(results).items():
        cells: dict[str, Any] = {}
        for axis in (axis for axis in axes if axis.run == number):
            prefix = "acceleration" if axis.channel == "tip_acceleration" else "strain"
            cells[f"{prefix}_label"] = axis.largest_label
            cells |= {f"{prefix}_{engine}": axis.ratios.get(engine) for engine in engines}
        measured = measured_crank_speed(number)
        reference = result.runs.get(REFERENCE)
        if reference is not None and reference.usable:
            cells["simulated_speed"] = mean_crank_speed(reference)
        found.add(
            case=result.case.name,
            measured_speed=Cell(None, "none printed", "tables 3.1 and 5.2 say N/A") if measured is None else measured,
            acceleration_valid=channel_is_usable(number, "tip_acceleration"),
            strain_valid=channel_is_usable(number, "strain_1"),
            **cells,
        )
    return found


def measured_alone(axes: Sequence[AxisComparison], engines: Sequence[str]) -> Table:
    """Simulated peaks over the largest label of each figure that shows measured curves alone."""
    ratios = [Column(engine, engine, "1", ".2f", group="simulated peak over label") for engine in engines]
    columns: ColumnList = ("figure", Column("run", form="d"), CHANNEL, Column("largest_label", "largest label", "SI", ".3g"), *ratios)
    found = Table("measured_alone", columns)
    for axis in axes:
        found.add(axis, **{engine: axis.ratios.get(engine) for engine in engines})
    return found


def recorded(results: Sequence[CaseResult]) -> Table:
    """The recorded tables with their declarations, and the numbers of their comparisons with engines and of departures."""
    counts = Column("compared", form="d"), Column("beyond", form="d")
    columns = (CASE, "table", "version", "origin", "status", Column("rows", form="d"), "columns", *counts, "source", "remark")
    found = Table("recorded", columns)
    for result in results:
        for run in result.recorded.values():
            checks = [check for check in result.table_checks if check.engine == run.engine]
            beyond = sum(not check.passed for check in checks)
            found.add(
                run,
                compared=len(checks),
                beyond=Cell(beyond, mark="missed" if beyond else ""),
                case=result.case.name,
                table=run.engine,
                origin=_origin(run),
                status=Cell(run.status, mark="" if run.usable else "failed"),
                rows=0 if run.recording is None else run.recording.rows,
                columns=", ".join(channel_name(name) for name in run.cycle if name not in ("time", "crank_angle")),
                source=run.method,
            )
    return found


def _origin(run: Run) -> Cell:
    origin = run.recording.declared.get("origin", "") if run.recording else ""
    return Cell(origin or None, mark="open" if origin == "synthetic" else "")


def curve_comparison(found: Sequence[MeasuredHalf], engines: Sequence[str]) -> Table:
    """Engines over recorded tables, per half."""

    def over_table(quantity: str) -> list[Column]:
        group, meaning = f"first-mode {quantity}", "engine / table"
        return [Column(f"{quantity}_{name}", name, "1", ".3f", group=group, meaning=meaning) for name in engines]

    columns: ColumnList = (
        *(CASE, "table", CHANNEL, "origin", HALF_COLUMN),
        Column("frequency", "table", "Hz", ".2f", uncertainty="frequency_uncertainty", group="first-mode frequency"),
        Column("frequency_uncertainty", unit="Hz", in_page=False),
        *over_table("frequency"),
        Column("amplitude", "table", "SI", ".3g", group="first-mode amplitude"),
        *over_table("amplitude"),
        Column("minimum", unit="SI", form=".3g", group="extremes of the table"),
        Column("maximum", unit="SI", form=".3g", group="extremes of the table"),
    )
    table = Table("curve_comparison", columns)
    for item in found:
        cells: dict[str, Any] = {"frequency_uncertainty": item.measure.first_mode_frequency_uncertainty}
        for short in ("frequency", "amplitude"):
            value = getattr(item.measure, f"first_mode_{short}")
            cells[short] = Cell(None, "n. r.", item.measure.reason, "open") if value is None else value
            for engine in engines:
                its = getattr(item.engines.get(engine), f"first_mode_{short}", None)
                cells[f"{short}_{engine}"] = its / value if its is not None and value else None
        table.add(item.measure, case=item.case, table=item.table.engine, origin=_origin(item.table), **cells)
    return table


def inconsistencies(found: Sequence[Inconsistency]) -> Table:
    """Contradictions and gaps of the thesis."""
    table = Table("inconsistencies", ("runs", "what", "published", Column("used", "used here"), Column("reason", "because")))
    for item in found:
        table.add(item, runs=_runs(item.runs))
    return table


def _runs(numbers: Sequence[int]) -> str:
    if tuple(numbers) == tuple(RUNS):
        return "all"
    if len(numbers) > 2 and list(numbers) == list(range(numbers[0], numbers[-1] + 1)):
        return f"{numbers[0]} to {numbers[-1]}"
    return ", ".join(map(str, numbers))
