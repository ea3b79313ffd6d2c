"""Tables of accuracy, convergence and cost."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from quickreturn.cases.benchmark.findings import Point, completed
from quickreturn.cases.benchmark.truth import Confirmation, Converged
from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.studies import Prescribed, StudiedRun
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.reports.findings.agreement import engines_of
from quickreturn.reports.tables.table import CASE, Cell, Column, ColumnList, Table
from quickreturn.reports.words import cost, settings_words, short_name

#: Columns of the errors, with their headings.
_ERRORS: Final = tuple(Column(name, short_name(name), "%", ".2g", group="error") for name in ESTIMATED)

#: Solution against which the converged solution at a prescribed speed is compared, and against which an engine at that speed is.
DRIVEN: Final = "driven crank"
SAME_SPEED: Final = "same speed"


def accuracy(runs: Sequence[StudiedRun]) -> Table:
    """Error and cost of each engine at its default accuracy."""
    columns: ColumnList = (
        "engine",
        Column("solve_seconds", "solve", "s", ".2f"),
        Column("setup_seconds", unit="s", in_page=False),
        *_ERRORS,
        Column("error_estimate", "own estimate", "%", ".2g"),
        Column("degrees_of_freedom", form="d"),
        Column("settings", in_page=False),
        Column("remark", in_page=False),
    )
    table = Table("accuracy", columns)
    for run in runs:
        table.add(run, settings=settings_words(run.settings), **run.errors)
    return table


def confirmation(converged: Converged | None, confirming: Sequence[Confirmation]) -> Table:
    """Differences of the confirming solutions from the converged one."""
    errors = [replace(column, group="difference") for column in _ERRORS]
    table = Table("confirmation", (Column("engine", "converged"), "settings", "confirmed_by", Column("with_settings", "settings"), *errors))
    for run in confirming if converged else ():
        assert converged is not None
        words = {"settings": settings_words(converged.settings), "with_settings": settings_words(run.settings)}
        table.add(engine=converged.engine, confirmed_by=run.engine, **words, **run.differences)
    return table


def prescribed(study: Prescribed, converged: Converged) -> Table:
    """The change by a prescribed crank speed, and the errors of the models that need one, with their own estimates for the integration."""
    errors = (*_ERRORS, Column("error_estimate", "own estimate", "%", ".2g"))
    table = Table("prescribed_speed", ("engine", "settings", Column("against", "held against"), *errors))
    table.add(engine=converged.engine, settings=settings_words(converged.settings), against=DRIVEN, **study.changed)
    for run in study.runs:
        table.add(run, settings=settings_words(run.settings), against=SAME_SPEED, **run.errors)
    return table


def convergence(points: Sequence[Point]) -> Table:
    """Error of the reference against its finest settings, the last row, for each number of modes and tolerance."""
    columns = (
        Column("modes", form="d"),
        Column("tolerance", unit="1", form=".2g"),
        Column("degrees_of_freedom", form="d"),
        *_ERRORS,
        Column("solve_seconds", "solve", "s", ".2g"),
        Column("right_hand_side_calls", form="g"),
        Column("is_reference", in_page=False),
    )
    table = Table("convergence", columns)
    for point, measured in completed(points):
        calls = measured.statistics.get("right_hand_side_calls")
        settings = {name: point.settings[name] for name in ("modes", "tolerance")}  # the others are the same throughout
        table.add(measured, **settings, **measured.errors, right_hand_side_calls=calls, is_reference=point is points[-1])
    return table


def solve_times(results: Sequence[CaseResult]) -> Table:
    """Solve time of each engine on each case to its steady state."""
    engines = engines_of(results)
    seconds = (Column(f"{name}_solve_seconds", name, "s", ".2f", group="solve time", words=cost) for name in engines)
    relative = (Column(f"{name}_per_second", name, "1", ".2f", group="solve time / simulated time", words=cost) for name in engines)
    table = Table("solve_times", (CASE, *seconds, *relative))
    for result in results:
        cells: dict[str, Any] = {}
        for name, run in result.runs.items():
            took, simulated = run.solve_seconds, run.simulated_seconds
            cells[f"{name}_solve_seconds"] = took if took is not None and run.usable else Cell(took, note=run.status, mark="open")
            cells[f"{name}_per_second"] = took / simulated if took is not None and simulated else None
        table.add(case=result.case.name, **cells)
    return table
