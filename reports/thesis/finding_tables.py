"""Tables of the changes by each effect in the thesis' runs, and of the statements for which it would suffice."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from quickreturn.cases.runs.comparison import REFERENCE
from quickreturn.cases.thesis.finding.effects import name_of
from quickreturn.cases.thesis.finding.study import SAMPLE, SECOND, Row
from quickreturn.reports.tables.table import Cell, Column, ColumnList, Table
from quickreturn.reports.thesis.sufficiency import Sufficiency, Tried
from quickreturn.reports.words import HALF, listed, percent

#: Beginning of the columns of each formulation -> its engine.
WAYS: Final = {"": REFERENCE, "second_": SECOND}
#: Statements that compare simulation and experiment in numbers -> heading of the share of runs that show them.
RELATIONS: Final = {
    "pre-frequency": "f₁ pre right",
    "post-frequency": "f₁ post too high",
    "post-excess": "more than pre",
    "pre-amplitude": "amplitude pre right, runs 9 to 24",
    "pre-amplitude-long-crank": "low, runs 1 to 8",
    "post-amplitude": "post high",
}


def effects(rows: Sequence[Row]) -> Table:
    """Every effect at every strength."""
    columns: list[Column | str] = ["effect", "strength"]
    for half in HALF:
        columns += [
            Column(f"{half}_frequency", "f₁", "%", "+.1f", group=HALF[half], meaning="first-mode frequency, median over the runs"),
            Column(f"{half}_low", unit="%", in_page=False),
            Column(f"{half}_high", unit="%", in_page=False),
            Column(f"{half}_amplitude", "amplitude", "%", "+.0f", group=HALF[half]),
            Column(f"{half}_runs", "runs", form="d", group=HALF[half]),
        ]
    columns += [
        Column("apart", "post over pre", "%", "+.1f", group="f₁"),
        Column("measured", "± measured", "%", ".2f", group="f₁", meaning="one standard deviation, median"),
        Column("claim_frequency", "claim", "%", ".2g", group="f₁", meaning="estimated error of the computation, greatest of the sample"),
        Column("acceleration", "peak", "%", ".0f", uncertainty="claim_acceleration", group="tip acceleration"),
        Column("claim_acceleration", unit="%", in_page=False),
        Column("band", "90 to 180 Hz", "m/s²", ".2g", uncertainty="claim_band", group="tip acceleration"),
        Column("claim_band", unit="m/s²", in_page=False),
        Column("strain", "peak strain", "%", ".0f", uncertainty="claim_strain"),
        Column("claim_strain", unit="%", in_page=False),
        Column("claim_amplitude", unit="%", in_page=False),
        Column("ring", "at the return", "Hz", ".0f", group="run 24"),
        Column("runs", form="d", in_page=False),
        Column("failed", form="d", in_page=False),
    ]
    table = Table("finding", columns, sample=listed([str(run) for run in SAMPLE]))
    for row in rows:
        claims = dict(zip(("frequency", "amplitude", "acceleration", "strain", "band"), row.claim, strict=False))
        units = {"band": 1.0}
        table.add(
            effect=name_of(row.effect),
            strength=row.strength,
            **_halves(row),
            apart=row.apart,
            measured=row.measured / 100.0,
            acceleration=None if row.acceleration is None else row.acceleration / 100.0,
            strain=None if row.strain is None else row.strain / 100.0,
            band=row.band,
            ring=row.example[3] if row.example else None,
            runs=row.runs,
            failed=row.failed,
            **{f"claim_{name}": value * units.get(name, 0.01) for name, value in claims.items()},
        )
    return table


def _halves(row: Row) -> dict[str, Any]:
    cells: dict[str, Any] = {}
    for half in HALF:
        frequency, amplitude = row.changes(f"{half}_frequency"), row.changes(f"{half}_amplitude")
        cells |= dict(zip((f"{half}_low", f"{half}_frequency", f"{half}_high"), spread(frequency), strict=False))
        cells |= {f"{half}_amplitude": spread(amplitude)[1] if amplitude else None, f"{half}_runs": len(frequency)}
    return cells


def spread(changes: Mapping[int, float]) -> tuple[float, ...]:
    """Lower quartile, median and upper quartile over the runs; empty without runs."""
    return tuple(float(each) for each in np.percentile(list(changes.values()), (25.0, 50.0, 75.0))) if changes else ()


def second(pairs: Sequence[tuple[Row, Row]]) -> Table:
    """Both formulations, run by run."""
    columns = [Column(f"{who}{half}", HALF[half], "%", "+.2f", group=name) for who, name in WAYS.items() for half in HALF]
    table = Table("finding_second", ("effect", "strength", Column("run", form="d"), *columns))
    for row, other in pairs:
        changes = {f"{who}{half}": each.changes(f"{half}_frequency") for who, each in zip(WAYS, (row, other), strict=True) for half in HALF}
        for run in sorted(other.changes("pre_frequency") | other.changes("post_frequency")):
            cells = {key: found.get(run) for key, found in changes.items()}
            table.add(effect=name_of(row.effect), strength=row.strength, run=run, **cells)
    return table


def sets(found: Sequence[Tried]) -> Table:
    """Every set, its number of choices, and the statements that it shows."""
    shares = [Column(name, head, "%", ".0f", group="share of the runs") for name, head in RELATIONS.items()]
    columns: ColumnList = ("effect", "strength", Column("choices", form="d"), Column("chosen", in_page=False), *shares)
    table = Table(
        "sufficiency_sets", (*columns, Column("ring", "at the return", "Hz", ".0f", group="run 24"), Column("statements", form="d"))
    )
    for each in found:
        cells = {name: Cell(each.shares[name], mark="good" if each.shown[name] else "") for name in RELATIONS}
        table.add(
            effect=name_of(each.row.effect),
            strength=each.row.strength,
            choices=len(each.choices),
            chosen=", ".join(each.choices),
            ring=each.row.example[3] if each.row.example else None,
            statements=sum(each.shown.values()),
            **cells,
        )
    return table


def statements(found: Sequence[Sufficiency], number: int, of_no_joint: Sequence[str]) -> Table:
    """The sets that suffice for each statement."""
    columns = (Column("section"), "statement", "suffices", Column("sets", form="d"), Column("choices", "fewest choices", form="d"))
    table = Table("sufficiency", columns, sets=number)
    for each in found:
        table.add(
            section=each.statement.section,
            statement=each.statement.words,
            suffices=_suffices(each, of_no_joint),
            sets=None if each.statement.id in of_no_joint else len(each.sets),
            choices=each.choices,
        )
    return table


def _suffices(found: Sufficiency, of_no_joint: Sequence[str]) -> Cell:
    if found.statement.id in of_no_joint:
        return Cell("any: no joint bears on it", mark="good")
    if found.sets:
        strengths: dict[str, list[str]] = {}
        for each in found.sets:
            strengths.setdefault(name_of(each.row.effect), []).append(each.row.strength)
        return Cell("; ".join(f"{effect} ({', '.join(names)})" for effect, names in strengths.items()), mark="good")
    if found.best is None:
        return Cell("none", mark="missed")
    share = found.best.shares[found.statement.id] or 0.0
    told = f"at most {percent(share, '.0f')} of the runs where {percent(found.statement.share, '.0f')} are meant"
    return Cell(f"none; {told} ({found.best.words})", mark="missed")
