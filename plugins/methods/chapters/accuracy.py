"""Accuracy and cost: errors at default accuracy, convergence, and steady states that were found without waiting for them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.motion.endings import Ending
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.plugins.methods.accuracy import Prescribed
from quickreturn.plugins.methods.data import studies_of
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.plugins.methods.trials.truth import Truth, confirms
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.plot import Plot, Series
from quickreturn.reports.results.engine_differences import engines_of
from quickreturn.reports.tables.cells import CASE
from quickreturn.reports.tables.table import Cell, Column, ColumnList, Table
from quickreturn.reports.words import cost, number, settings_words, short_name, size

#: Columns of the errors, with their headings.
_ERRORS: Final = tuple(Column(name, short_name(name), "%", ".2g", group="error") for name in ESTIMATED)

#: Solution against which the converged solution at a prescribed speed is compared, and against which an engine at that speed is.
DRIVEN: Final = "driven crank"
SAME_SPEED: Final = "same speed"
#: Parts of a disturbance that are left when a marched run counts as settled, and when no measure sees it any more.
SETTLED_AT, GONE_AT = 1e-3, 1e-6


def accuracy(content: Content) -> Chapter | None:
    """The chapter; None without studies and without a steady state that was found directly."""
    studies, record = content.of(studies_of)
    marching = [name for name in engines_of(content.results) if name != REFERENCE]
    orbit_table = orbits(content.results, marching)
    if studies is None and not orbit_table.rows:
        return None
    facts: dict[str, Any] = {
        "studies": studies is not None,
        "orbits": orbit_table,
        "solve_times": solve_times(content.results),
    }
    errors: dict[str, float] = {}
    if studies is not None:
        converged, known = studies.converged, {run.engine: run.error for run in studies.accuracy}
        errors = {name: error for name, error in known.items() if error is not None}
        facts |= {
            "failures": studies.failures,
            "converged": converged is not None,
            "confirming": {run.engine: confirms(run) for run in studies.confirming} if converged else {},
            "plot": _convergence(studies.convergence),
            "accuracy": accuracy_table(studies.accuracy),
            "of_record": record,
            "confirmation": confirmation(converged, studies.confirming),
            "convergence": convergence(studies.convergence),
            "prescribed": studies.prescribed and converged and prescribed(studies.prescribed, converged),
        }
    work = [float(cycles) for row in orbit_table.rows if isinstance(cycles := row["cycles_of_work"].value, (int, float))]
    return Chapter("accuracy", "Accuracy and cost", finding(errors, float(np.median(work)) if work else None), facts)


def finding(errors: Mapping[str, float], work: float | None) -> str:
    """The error of each engine's tip deflection in run 24; without any the work of a search for the steady state, in cycles."""
    if errors:
        texts = [f"{size(error)} ({name})" for name, error in errors.items()]
        return f"At default accuracy run 24’s tip deflection is off by {', '.join(texts)}"
    return "" if work is None else f"The search for the steady state takes the work of {number(work, '.3g')} cycles"


def _convergence(trials: Sequence[Trial]) -> Plot | None:
    if not trials:
        return None
    tightest = min(trial.settings["tolerance"] for trial in trials)
    finest = [trial for trial in trials[:-1] if trial.settings["tolerance"] == tightest]
    series = []
    for name in ESTIMATED:
        errors = {trial.settings["modes"]: error for trial in finest if (error := trial.error_of(name)) is not None}
        texts = [f"{modes} modes: {size(error)}" for modes, error in errors.items()]
        series.append(Series(name.replace("_", " "), name, [*errors], [100.0 * error for error in errors.values()], texts))
    return Plot("convergence.csv", "modes", "error, RMS over RMS [%]", series, "y")


def accuracy_table(runs: Sequence[Trial]) -> Table:
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
    table = Table(
        "accuracy",
        """Run 24 from the standard start, 2 s: error of each engine at its default accuracy against the converged solution, RMS(y −
        y_ref)/RMS(y_ref) on the grid of 1 ms, beside the solve time of that run and the engine's own estimate for the tip deflection. The
        estimate of thesis covers only the integration of its own equations. The CSV file has the settings, too.""",
        columns,
    )
    for run in runs:
        table.add(run, settings=settings_words(run.settings), error_estimate=run.claim, **run.errors)
    return table


def confirmation(converged: Truth | None, confirming: Sequence[Trial]) -> Table:
    """Differences of the confirming solutions from the converged one."""
    errors = [replace(column, group="difference") for column in _ERRORS]
    table = Table(
        "confirmation",
        """The converged solution and the solution of another engine that confirms it: their difference over the RMS of the converged
        one.""",
        (Column("engine", "converged"), "settings", "confirmed_by", Column("with_settings", "settings"), *errors),
    )
    for run in confirming if converged else ():
        assert converged is not None
        words = {"settings": settings_words(converged.settings), "with_settings": settings_words(run.settings)}
        table.add(engine=converged.engine, confirmed_by=run.engine, **words, **run.errors)
    return table


def prescribed(study: Prescribed, converged: Truth) -> Table:
    """The change by a prescribed crank speed, and the errors of the models that need one, with their own estimates for the integration."""
    errors = (*_ERRORS, Column("error_estimate", "own estimate", "%", ".2g"))
    table = Table(
        "prescribed_speed",
        """Run 24 with its mean crank speed prescribed, by the method that requires a prescribed speed: error against the converged solution
        named, RMS(y − y_ref)/RMS(y_ref). This is the error of the model. Beside it stands the engine's own estimate, which covers the
        integration alone.""",
        ("engine", "settings", Column("against", "held against"), *errors),
    )
    table.add(engine=converged.engine, settings=settings_words(converged.settings), against=DRIVEN, **study.changed)
    for run in study.runs:
        table.add(run, settings=settings_words(run.settings), against=SAME_SPEED, error_estimate=run.claim, **run.errors)
    return table


def convergence(trials: Sequence[Trial]) -> Table:
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
    table = Table(
        "convergence",
        """Convergence of the reference in run 24, 2 s from the standard start: error against the finest row, for each number of modes and
        tolerance of the integration.""",
        columns,
    )
    for trial in trials:
        calls = trial.statistics.get("right_hand_side_calls")
        settings = {name: trial.settings[name] for name in ("modes", "tolerance")}  # the others are the same throughout
        table.add(trial, **settings, **trial.errors, right_hand_side_calls=calls, is_reference=trial is trials[-1])
    return table


def solve_times(results: Sequence[CaseResult]) -> Table:
    """Solve time of each engine on each case to its steady state."""
    engines = engines_of(results)
    seconds = (Column(f"{name}_solve_seconds", name, "s", ".2f", group="solve time", words=cost) for name in engines)
    relative = (Column(f"{name}_per_second", name, "1", ".2f", group="solve time / simulated time", words=cost) for name in engines)
    table = Table(
        "solve_times",
        """Solve time to the steady state (all its cycles), and per simulated second, of each engine on each case. Times are single-threaded
        and were measured when the run was computed. Runs that were computed at the same time shared the machine.""",
        (CASE, *seconds, *relative),
    )
    for result in results:
        cells: dict[str, Any] = {}
        for name, run in result.runs.items():
            took, simulated = run.computation.solve_seconds, run.computation.simulated_seconds
            cells[f"{name}_solve_seconds"] = took if took is not None and run.usable else Cell(took, note=run.status, mark="open")
            cells[f"{name}_per_second"] = took / simulated if took is not None and simulated else None
        table.add(case=result.case.name, **cells)
    return table


def orbits(results: Sequence[CaseResult], marching: Sequence[str]) -> Table:
    """One row per case whose steady state the reference found directly.

    Args:
        results: of all cases.
        marching: engines that march to their steady state; each has a column with its cycles.
    """
    columns: ColumnList = (
        CASE,
        Column("period", unit="s", form=".4f"),
        Column("iterations", "Newton steps", form="d"),
        Column("cycles_of_work", "cycles' work", form=".3g"),
        Column("multiplier", "largest multiplier", "1", ".3f"),
        "stable",
        Column("cycles_to_settled", f"to {number(SETTLED_AT, 'g')}", form=".1f", group="cycles of marching"),
        Column("cycles_to_gone", f"to {number(GONE_AT, 'g')}", form=".1f", group="cycles of marching"),
        *(Column(f"{name}_cycles", name, form="d", group="cycles marched") for name in marching),
    )
    table = Table(
        "periodic_orbits",
        """Steady states that the reference finds directly, by Newton's method on the map from one passage of the slider's farthest place to
        the next. Work is counted in simulated cycles. The largest Floquet multiplier is the part of a disturbance that is left after a
        cycle. It gives the number of cycles in which marching reduces a disturbance to a given part. Beside it stand the cycles that
        engines marched from this state. thesis marched from the standard start, because its steady state is a different one.""",
        columns,
    )
    for result in results:
        run = result.runs.get(REFERENCE)
        orbit = None if run is None else run.approach.periodic_orbit
        if run is None or orbit is None or not orbit.multipliers:
            continue
        modulus = math.hypot(*orbit.multipliers[0])
        shrinking = 0.0 < modulus < 1.0
        cycles = {f"{name}_cycles": result.runs[name].approach.cycles for name in marching if name in result.runs}
        table.add(
            orbit,
            case=result.case.name,
            stable=Cell(orbit.stable, Ending.NEUTRAL if run.status == Ending.NEUTRAL else "", run.remark if not orbit.stable else ""),
            cycles_of_work=run.approach.cycles if orbit.stable else None,
            multiplier=modulus,
            cycles_to_settled=math.log(SETTLED_AT) / math.log(modulus) if shrinking else None,
            cycles_to_gone=math.log(GONE_AT) / math.log(modulus) if shrinking else None,
            **cycles,
        )
    return table
