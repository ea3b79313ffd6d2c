"""Accuracy and cost: steady states that were found without waiting for them, and solve times to the steady state."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.motion.endings import Ending
from quickreturn.reports.engine_differences import engines_of
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import CASE, Cell, Column, ColumnList, Table
from quickreturn.reports.words import cost, number

#: Parts of a disturbance that are left when a marched run counts as settled, and when no measure sees it any more.
SETTLED_AT, GONE_AT = 1e-3, 1e-6


def accuracy(content: Content) -> Chapter | None:
    """The chapter; None without a steady state that was found directly."""
    found = orbits(content.results, [name for name in engines_of(content.results) if name != REFERENCE])
    if not found.rows:
        return None
    work = [float(cycles) for row in found.rows if isinstance(cycles := row["cycles_of_work"].value, (int, float))]
    facts = {"orbits": found, "solve_times": solve_times(content.results)}
    return Chapter("accuracy", "Cost of a steady state", finding(float(np.median(work)) if work else None), facts)


def finding(work: float | None) -> str:
    """The work of a search for the steady state, in cycles."""
    return "" if work is None else f"The search for the steady state takes the work of {number(work, '.3g')} cycles"


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
