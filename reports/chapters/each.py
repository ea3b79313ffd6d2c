"""Run by run: the numbers of each case, and its notes, failures and departures; the script draws the curves."""

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.motion.catalogue import IN_TABLES, MEASURES
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables.cells import measure_cells, measure_column, status_cell
from quickreturn.reports.tables.table import Column, ColumnList, Table
from quickreturn.reports.words import channel_name, cost, counted


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
    facts = {"sections": sections, "tables": [section["table"] for section in sections]}
    return Chapter("each", "Run by run", finding(len(sections)), facts)


def finding(cases: int) -> str:
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
