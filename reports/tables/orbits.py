"""Steady states that were found directly: how, how stable, and what waiting for them would take."""

import math
from collections.abc import Sequence

from cases.runs.comparison import REFERENCE, CaseResult
from cases.studies import BothStarts
from reports.tables.table import CASE, Column, Table, TableBuilder

#: What is left of the way to the steady state when a marched run counts as settled, and a distance at which no measure sees it any more.
SETTLED_AT, GONE_AT = 1e-3, 1e-6


def orbits(results: Sequence[CaseResult], marching: Sequence[str]) -> Table:
    """One row per case whose steady state the reference found directly.

    Args:
        results: of all cases.
        marching: engines that wait for their steady state, whose cycles stand beside.
    """
    builder = TableBuilder(
        "periodic_orbits",
        "Steady states that the reference finds directly, by Newton's method on the map from one passage of the slider's farthest place to"
        " the next. Work is counted in cycles simulated. The largest Floquet multiplier is what a cycle leaves of a disturbance; from it"
        " follow the cycles that marching takes to shrink one to a part of itself. Beside it the cycles that engines marched: from this"
        " state, or from the standard start (thesis, whose steady state is another one).",
        (
            CASE,
            Column("period", "period", "s", ".4f"),
            Column("iterations", "Newton steps", form="d"),
            Column("cycles_of_work", "cycles' work", form=".3g"),
            Column("multiplier", "largest multiplier", "1", ".3f"),
            Column("stable", "stable"),
            Column("cycles_to_settled", f"to {SETTLED_AT:g}", form=".1f", group="cycles of marching"),
            Column("cycles_to_gone", f"to {GONE_AT:g}", form=".1f", group="cycles of marching"),
            *(Column(f"{name}_cycles", name, form="d", group="cycles marched") for name in marching),
        ),
    )
    for result in results:
        run = result.runs.get(REFERENCE)
        orbit = None if run is None else run.periodic_orbit
        if run is None or orbit is None or not orbit.multipliers:
            continue
        modulus = math.hypot(*orbit.multipliers[0])
        shrinking = 0.0 < modulus < 1.0
        cycles = {f"{name}_cycles": result.runs[name].cycles for name in marching if name in result.runs}
        builder.add(
            orbit,
            case=result.case.name,
            cycles_of_work=run.cycles if orbit.stable else None,
            multiplier=modulus,
            cycles_to_settled=math.log(SETTLED_AT) / math.log(modulus) if shrinking else None,
            cycles_to_gone=math.log(GONE_AT) / math.log(modulus) if shrinking else None,
            **cycles,
        )
    return builder.table()


def both_starts(found: Sequence[BothStarts]) -> Table:
    """One row per engine that marched from both starts."""
    builder = TableBuilder(
        "both_starts",
        "Run 24 marched from the periodic state of the reference and, with the same settings, from the standard start: cycles until"
        " settled, the distance that is left to steady by the run's own estimate, and the difference of the two last cycles (RMS over the"
        " channels, relative to theirs).",
        (
            Column("engine", "engine"),
            Column("orbit_cycles", "cycles", form="d", group="from the periodic state"),
            Column("orbit_settling_error", "left", "1", ".2g", "%", 100.0, group="from the periodic state"),
            Column("straight_cycles", "cycles", form="d", group="from the standard start"),
            Column("straight_settling_error", "left", "1", ".2g", "%", 100.0, group="from the standard start"),
            Column("difference", "difference", "1", ".2g", "%", 100.0),
        ),
    )
    for each in found:
        builder.add(
            each,
            orbit_cycles=each.orbit.cycles,
            orbit_settling_error=each.orbit.settling_error,
            straight_cycles=each.straight.cycles,
            straight_settling_error=each.straight.settling_error,
        )
    return builder.table()
