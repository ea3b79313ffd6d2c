"""Tables of the remains of the experiment, compared with the engines, and of the thesis' inconsistencies."""

from collections.abc import Sequence
from typing import Any

from quickreturn.cases.runs.comparison import REFERENCE, CaseResult
from quickreturn.cases.thesis.experiment import channel_is_usable, measured_crank_speed
from quickreturn.cases.thesis.inconsistencies import Inconsistency
from quickreturn.cases.thesis.runs import RUNS
from quickreturn.reports.findings.runs import mean_crank_speed
from quickreturn.reports.tables.table import CASE, CHANNEL, Cell, Column, ColumnList, Table
from quickreturn.reports.thesis.axes import AxisComparison
from quickreturn.reports.thesis.runs import thesis_runs


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
    table = Table("experiment", columns)
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
        table.add(
            case=result.case.name,
            measured_speed=Cell(None, "none printed", "tables 3.1 and 5.2 say N/A") if measured is None else measured,
            acceleration_valid=channel_is_usable(number, "tip_acceleration"),
            strain_valid=channel_is_usable(number, "strain_1"),
            **cells,
        )
    return table


def measured_alone(axes: Sequence[AxisComparison], engines: Sequence[str]) -> Table:
    """Simulated peaks over the largest label of each figure that shows measured curves alone."""
    ratios = [Column(engine, engine, "1", ".2f", group="simulated peak over label") for engine in engines]
    columns: ColumnList = ("figure", Column("run", form="d"), CHANNEL, Column("largest_label", "largest label", "SI", ".3g"), *ratios)
    table = Table("measured_alone", columns)
    for axis in axes:
        table.add(axis, **{engine: axis.ratios.get(engine) for engine in engines})
    return table


def inconsistencies(rows: Sequence[Inconsistency]) -> Table:
    """Contradictions and gaps of the thesis."""
    table = Table("inconsistencies", ("runs", "what", "published", Column("used", "used here"), Column("reason", "because")))
    for row in rows:
        table.add(row, runs=_runs(row.runs))
    return table


def _runs(numbers: Sequence[int]) -> str:
    if tuple(numbers) == tuple(RUNS):
        return "all"
    if len(numbers) > 2 and list(numbers) == list(range(numbers[0], numbers[-1] + 1)):
        return f"{numbers[0]} to {numbers[-1]}"
    return ", ".join(map(str, numbers))
