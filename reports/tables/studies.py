"""Accuracy, convergence, sensitivity and cost."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from cases.measures import CHANNELS
from cases.runs.comparison import CaseResult
from cases.studies import Moved, StudiedRun
from engines.accurate import ESTIMATED
from reports.findings.agreement import engines_of
from reports.tables.table import CASE, Cell, Column, Table, TableBuilder
from reports.words import HALF, QUANTITY, case_label, cost, settings_words, short_name

#: Columns of the errors, with their headings.
_ERRORS: Final = tuple(Column(name, short_name(name), "1", ".2g", "%", 100.0, group="error") for name in ESTIMATED)


def accuracy(runs: Sequence[StudiedRun]) -> Table:
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
    for run in runs:
        builder.add(run, settings=settings_words(run.settings), **run.errors)
    return builder.table()


def confirmation(converged: StudiedRun | None, confirming: Sequence[StudiedRun]) -> Table:
    """Difference of the solutions that stand for the truth."""
    builder = TableBuilder(
        "confirmation",
        "The converged solution and the one of another engine that confirms it: difference over the RMS of the former.",
        (
            Column("engine", "converged"),
            Column("settings", "settings"),
            Column("confirmed_by", "confirmed by"),
            Column("with_settings", "settings"),
            *(replace(column, group="difference") for column in _ERRORS),
        ),
    )
    for run in confirming if converged else ():
        assert converged is not None
        words = {"settings": settings_words(converged.settings), "with_settings": settings_words(run.settings)}
        builder.add(engine=converged.engine, confirmed_by=run.engine, **words, **run.errors)
    return builder.table()


def convergence(runs: Sequence[StudiedRun]) -> Table:
    """Modes by tolerance."""
    builder = TableBuilder(
        "convergence",
        "Convergence of the reference in run 24, 2 s from the standard start: error against the finest row, for each number of modes and"
        " tolerance of the integration.",
        (
            Column("modes", "modes", form="d"),
            Column("tolerance", "tolerance", "1", ".2g"),
            Column("degrees_of_freedom", "degrees of freedom", form="d"),
            *_ERRORS,
            Column("solve_seconds", "solve", "s", ".2g"),
            Column("right_hand_side_calls", "right hand side calls", form="g"),
            Column("is_reference", "is reference", in_page=False),
        ),
    )
    for run in runs:
        builder.add(run, **run.settings, **run.errors)
    return builder.table()


def sensitivity(found: Sequence[Moved]) -> Table:
    """How first-mode frequency and amplitudes move with what the thesis leaves open."""
    quantities = {"first_mode_frequency_consensus": "f₁"} | {f"first_mode_amplitude_{name}": short_name(name) for name in CHANNELS}
    builder = TableBuilder(
        "sensitivity",
        "Change of the steady state with what the thesis leaves open, reference: first-mode frequency (consensus) and first-mode amplitude"
        " of each channel, relative to the run as published. n. r.: not resolvable in one of the two.",
        (
            Column("run", "run", words=case_label),
            Column("change", "change"),
            *(
                Column(f"{half}_{key}", head, "1", "+.1f", "%", 100.0, group=HALF[half])
                for half in HALF
                for key, head in quantities.items()
            ),
        ),
    )
    for run, change in dict.fromkeys((each.run, each.change) for each in found):
        cells = {
            f"{each.half}_{each.quantity}_{each.channel}": Cell(None, "n. r.", f"{QUANTITY[each.quantity]} not resolvable", "open")
            if each.relative_change is None
            else Cell(each.relative_change)
            for each in found
            if (each.run, each.change) == (run, change)
        }
        builder.add(run=run, change=change, **cells)
    return builder.table()


def solve_times(results: Sequence[CaseResult]) -> Table:
    """Solve time of each engine on each case to its steady state."""
    engines = engines_of(results)
    builder = TableBuilder(
        "solve_times",
        "Solve time to the steady state (all its cycles), and per simulated second, of each engine on each case. Single-threaded, as"
        " measured when the run was computed; runs computed side by side share the machine.",
        (
            CASE,
            *(Column(f"{name}_solve_seconds", name, "s", ".2f", group="solve time") for name in engines),
            *(Column(f"{name}_per_second", name, "1", ".2f", group="solve time / simulated time") for name in engines),
        ),
    )
    for result in results:
        cells: dict[str, Any] = {}
        for name, run in result.runs.items():
            took, simulated = run.solve_seconds, run.simulated_seconds
            shown = "–" if took is None else cost(took)
            whole = took is not None and run.usable
            cells[f"{name}_solve_seconds"] = Cell(took, shown) if whole else Cell(took, shown, run.status, "open")
            if took is not None and simulated:
                cells[f"{name}_per_second"] = Cell(took / simulated, cost(took / simulated))
        builder.add(case=result.case.name, **cells)
    return builder.table()
