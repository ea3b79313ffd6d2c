"""Accuracy, convergence, sensitivity and cost."""

from collections.abc import Sequence
from typing import Any, Final

import pandas as pd

from cases.runs.comparison import CaseResult
from engines.accurate import ESTIMATED
from reports.findings.agreement import engines_of
from reports.tables.table import Cell, Column, Table, TableBuilder
from reports.words import HALF, QUANTITY, case_label, short_name

#: Columns of the errors, with their headings.
_ERRORS: Final = tuple(Column(name, short_name(name), "1", ".2g", "%", 100.0, group="error") for name in ESTIMATED)


def accuracy(frame: pd.DataFrame) -> Table:
    """Error of each engine at its default accuracy, and what it costs."""
    builder = TableBuilder(
        "accuracy",
        "Run 24 from the standard start, 2 s: error of each engine at its default accuracy against the converged solution,"
        " RMS(y − y_ref)/RMS(y_ref) on the grid of 1 ms, beside the solve time of that run and the engine's own estimate for the tip"
        " deflection, which of thesis is that of the integration of its own equations alone. The CSV file has the settings, too.",
        (
            Column("engine", "engine"),
            Column("solve_seconds", "solve", "s", ".2f"),
            Column("setup_seconds", "setup", "s", ".2f", in_page=False),
            *_ERRORS,
            Column("error_estimate", "own estimate", "1", ".2g", "%", 100.0),
            Column("degrees_of_freedom", "degrees of freedom", form="d"),
            Column("settings", "settings", in_page=False),
            Column("remark", "remark", in_page=False),
        ),
    )
    return _filled(builder, frame)


def confirmation(frame: pd.DataFrame) -> Table:
    """Difference of the two solutions that stand for the truth."""
    builder = TableBuilder(
        "confirmation",
        "The converged solution and the one of another engine that confirms it: difference over the RMS of the former.",
        (
            Column("engine", "converged"),
            Column("settings", "settings"),
            Column("confirmed_by", "confirmed by"),
            Column("with_settings", "settings"),
            *(Column(column.key, column.head, "1", ".2g", "%", 100.0, group="difference") for column in _ERRORS),
        ),
    )
    return _filled(builder, frame)


def convergence(frame: pd.DataFrame) -> Table:
    """Shapes by tolerance; columns as the study has them."""
    columns = []
    for key in map(str, frame.columns):
        if key in ESTIMATED:
            columns.append(Column(key, short_name(key), "1", ".2g", "%", 100.0, group="error"))
        elif key in ("tolerance", "solve_seconds"):
            columns.append(Column(key, key.split("_")[0], "s" if key == "solve_seconds" else "1", ".2g"))
        elif pd.api.types.is_numeric_dtype(frame[key]):
            columns.append(Column(key, key.replace("_", " "), form="g"))
        else:
            columns.append(Column(key, key.replace("_", " ")))
    caption = (
        "Convergence of the reference in run 24, 2 s from the standard start: error against the finest row, for each number of modes and"
        " tolerance of the integration."
    )
    return _filled(TableBuilder("convergence", caption, columns), frame)


def _filled(builder: TableBuilder, frame: pd.DataFrame) -> Table:
    keys = {column.key for column in builder.columns}
    for record in frame.to_dict("records"):
        builder.add(**{str(key): _plain(value) for key, value in record.items() if str(key) in keys})
    return builder.table()


def _plain(value: Any) -> Any:
    value = value.item() if hasattr(value, "item") else value
    if isinstance(value, float):
        if value != value:
            return None
        return value
    return value


def sensitivity(frame: pd.DataFrame) -> Table:
    """How first-mode frequency and amplitudes move with what the thesis leaves open."""
    quantities = [("first_mode_frequency", "consensus", "f₁")]
    quantities += [
        ("first_mode_amplitude", channel, short_name(channel)) for channel in ("tip_acceleration", "strain_1", "strain_2", "strain_3")
    ]
    builder = TableBuilder(
        "sensitivity",
        "Change of the steady state with what the thesis leaves open, reference: first-mode frequency (consensus) and first-mode amplitude"
        " of each channel, relative to the run as published. n. r.: not resolvable in one of the two.",
        (
            Column("run", "run"),
            Column("change", "change"),
            *(
                Column(f"{half}_{quantity}_{channel}", head, "1", "+.1f", "%", 100.0, group=HALF[half])
                for half in HALF
                for quantity, channel, head in quantities
            ),
        ),
    )
    if frame.empty:
        return builder.table()
    known = {column.key for column in builder.columns}
    for (run, change), group in frame.groupby(["run", "change"], sort=False):
        cells: dict[str, Any] = {}
        for record in group.to_dict("records"):
            key = f"{record['half']}_{record['quantity']}_{record['channel']}"
            value = _plain(record["relative_change"])
            if key in known:
                cells[key] = Cell(None, "n. r.", f"{QUANTITY[record['quantity']]} not resolvable", "open") if value is None else value
        builder.add(run=Cell(str(run), case_label(str(run))), change=str(change), **cells)
    return builder.table()


def solve_times(results: Sequence[CaseResult]) -> Table:
    """Solve time of each engine on each case to its steady state."""
    engines = engines_of(results)
    builder = TableBuilder(
        "solve_times",
        "Solve time to the steady state (all its cycles), and per simulated second, of each engine on each case. Single-threaded, as"
        " measured when the run was computed; runs computed side by side share the machine.",
        (
            Column("case", "run"),
            *(Column(f"{name}_solve_seconds", name, "s", ".2f", group="solve time") for name in engines),
            *(Column(f"{name}_per_second", name, "1", ".2f", group="solve time / simulated time") for name in engines),
        ),
    )
    for result in results:
        cells: dict[str, Any] = {}
        for name, run in result.runs.items():
            seconds, simulated = run.solve_seconds, run.simulated_seconds
            if seconds is None or not run.usable:
                cells[f"{name}_solve_seconds"] = Cell(seconds, "" if seconds is not None else "–", run.status, "open")
            else:
                cells[f"{name}_solve_seconds"] = seconds
            if seconds is not None and simulated:
                cells[f"{name}_per_second"] = seconds / simulated
        builder.add(case=Cell(result.case.name, case_label(result.case.name)), **cells)
    return builder.table()
