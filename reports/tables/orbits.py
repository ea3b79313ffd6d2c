"""Tables of steady states that were found directly: work, stability, and the cycles of marching."""

import math
from collections.abc import Sequence

from quickreturn.cases.runs.comparison import REFERENCE, CaseResult
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.studies import BothStarts
from quickreturn.reports.tables.table import CASE, Cell, Column, ColumnList, Table
from quickreturn.reports.words import number

#: Parts of a disturbance that are left when a marched run counts as settled, and when no measure sees it any more.
SETTLED_AT, GONE_AT = 1e-3, 1e-6


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
    table = Table("periodic_orbits", columns)
    for result in results:
        run = result.runs.get(REFERENCE)
        orbit = None if run is None else run.periodic_orbit
        if run is None or orbit is None or not orbit.multipliers:
            continue
        modulus = math.hypot(*orbit.multipliers[0])
        shrinking = 0.0 < modulus < 1.0
        cycles = {f"{name}_cycles": result.runs[name].cycles for name in marching if name in result.runs}
        table.add(
            orbit,
            case=result.case.name,
            stable=Cell(orbit.stable, Ending.NEUTRAL if run.status == Ending.NEUTRAL else "", run.remark if not orbit.stable else ""),
            cycles_of_work=run.cycles if orbit.stable else None,
            multiplier=modulus,
            cycles_to_settled=math.log(SETTLED_AT) / math.log(modulus) if shrinking else None,
            cycles_to_gone=math.log(GONE_AT) / math.log(modulus) if shrinking else None,
            **cycles,
        )
    return table


def both_starts(studied: Sequence[BothStarts]) -> Table:
    """One row per engine that marched from both starts."""
    starts = {"orbit": "from the periodic state", "straight": "from the standard start"}
    columns = [Column("engine")]
    for key, group in starts.items():
        columns.append(Column(f"{key}_cycles", "cycles", form="d", group=group))
        columns.append(Column(f"{key}_settling_error", "left", "%", ".2g", group=group))
    table = Table("both_starts", (*columns, Column("difference", unit="%", form=".2g")))
    for study in studied:
        runs = {"orbit": study.orbit, "straight": study.straight}
        cycles = {f"{key}_cycles": run.cycles for key, run in runs.items()}
        table.add(study, **cycles, **{f"{key}_settling_error": run.settling_error for key, run in runs.items()})
    return table
