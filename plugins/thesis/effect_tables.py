"""Tables of the changes that each effect makes in the thesis' runs, and of the statements that it would make true."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from quickreturn.cases.comparison.engines import REFERENCE
from quickreturn.plugins.thesis.finding.effects import name_of
from quickreturn.plugins.thesis.finding.study import SAMPLE, SECOND, Row
from quickreturn.plugins.thesis.sufficiency import Sufficiency, Trial
from quickreturn.reports.tables.table import Cell, Column, ColumnList, Table
from quickreturn.reports.words import HALF, listed, percent

#: Beginning of the columns of each formulation -> its engine.
FORMULATIONS: Final = {"": REFERENCE, "second_": SECOND}
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
    table = Table(
        "finding",
        f"""Each effect by itself, computed by the reference: change from the run as published, median over the runs that resolve the number
        (the CSV file has the quartiles, and the number of runs that failed). The torque is adjusted to keep the mean crank speed. Peaks:
        largest magnitude in the cycle. 90 to 180 Hz: RMS in the tip acceleration at crank angles from 360° to 420°. ± and claim: the
        estimated error of the numbers at the middle strength, the greatest of runs {listed([str(run) for run in SAMPLE])}, from runs with
        finer settings. The measurement of a frequency has a further uncertainty, in the column ± measured; a part of it remains in a
        change. At the return: the strongest frequency from 60 to 200 Hz.""",
        columns,
    )
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
    columns = [Column(f"{who}{half}", HALF[half], "%", "+.2f", group=name) for who, name in FORMULATIONS.items() for half in HALF]
    table = Table(
        "finding_second",
        """The middle strengths by a second formulation: change of the first mode's frequency from the run as published; the same engine
        computes both runs.""",
        ("effect", "strength", Column("run", form="d"), *columns),
    )
    for row, other in pairs:
        rows = dict(zip(FORMULATIONS, (row, other), strict=True))
        changes = {f"{who}{half}": rows[who].changes(f"{half}_frequency") for who in FORMULATIONS for half in HALF}
        for run in sorted(other.changes("pre_frequency") | other.changes("post_frequency")):
            cells = {key: of_runs.get(run) for key, of_runs in changes.items()}
            table.add(effect=name_of(row.effect), strength=row.strength, run=run, **cells)
    return table


def sets(trials: Sequence[Trial]) -> Table:
    """Every set, its number of choices, and the statements that it shows."""
    shares = [Column(name, head, "%", ".0f", group="share of the runs") for name, head in RELATIONS.items()]
    columns: ColumnList = (
        *("effect", "strength", Column("choices", form="d"), Column("chosen", in_page=False)),
        *shares,
        *(Column("ring", "at the return", "Hz", ".0f", group="run 24"), Column("statements", form="d")),
    )
    table = Table(
        "sufficiency_sets",
        """Every set: its number of choices, the share of runs that agree with the words (green: as many as the words require), run 24's
        strongest frequency at the return, and the number of true statements among those that a joint can affect.""",
        columns,
    )
    for trial in trials:
        cells = {name: Cell(trial.shares[name], mark="good" if trial.shown[name] else "") for name in RELATIONS}
        table.add(
            effect=name_of(trial.row.effect),
            strength=trial.row.strength,
            choices=len(trial.choices),
            chosen=", ".join(trial.choices),
            ring=trial.row.example[3] if trial.row.example else None,
            statements=sum(trial.shown.values()),
            **cells,
        )
    return table


def statements(verdicts: Sequence[Sufficiency], number: int, of_no_joint: Sequence[str]) -> Table:
    """The sets that suffice for each statement."""
    columns = (Column("section"), "statement", "suffices", Column("sets", form="d"), Column("choices", "fewest choices", form="d"))
    table = Table(
        "sufficiency",
        f"""The sets, among {number}, that would make the statement true if the thesis' single cubic is the simulation and the set is the
        experiment; and the least number of choices in such a set. A set is an effect and a strength; the converged model as published is
        one. None of the choices is published. The words are read as in the file of statements; nothing is adjusted to them.""",
        columns,
    )
    for verdict in verdicts:
        table.add(
            section=verdict.statement.section,
            statement=verdict.statement.words,
            suffices=_suffices(verdict, of_no_joint),
            sets=None if verdict.statement.id in of_no_joint else len(verdict.sets),
            choices=verdict.choices,
        )
    return table


def _suffices(verdict: Sufficiency, of_no_joint: Sequence[str]) -> Cell:
    if verdict.statement.id in of_no_joint:
        return Cell("any: no joint bears on it", mark="good")
    if verdict.sets:
        strengths: dict[str, list[str]] = {}
        for trial in verdict.sets:
            strengths.setdefault(name_of(trial.row.effect), []).append(trial.row.strength)
        return Cell("; ".join(f"{effect} ({', '.join(names)})" for effect, names in strengths.items()), mark="good")
    if verdict.best is None:
        return Cell("none", mark="missed")
    share = verdict.best.shares[verdict.statement.id] or 0.0
    text = f"at most {percent(share, '.0f')} of the runs where {percent(verdict.statement.share, '.0f')} are meant"
    return Cell(f"none; {text} ({verdict.best.words})", mark="missed")
