"""As users build it: run 24 by the means of MuJoCo and Exudyn alone, with their own joints, contacts and integrators."""

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from quickreturn.cases.running.workshop import Workshop
from quickreturn.reports.long_studies import about, table
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.part import Part
from quickreturn.reports.tables import Cell, Column, Mark, Table
from quickreturn.reports.words import counted, duration, listed, percent

#: The programs' scripts. They stand in the checkout alone, and so does the record that is made from them.
SCRIPTS: Final = Path(__file__).resolve().parents[2] / "examples" / "as_built"


@dataclass(frozen=True)
class Construction:
    """A construction beside the converged solution; no numbers where the program lost the motion."""

    name: str  # unique
    program: str  # with its version
    end: float = 2.0  # of the motion, s; less than the 2 s asked if the program lost it
    error: float | None = None  # of the tip deflection, RMS of the difference over RMS
    peak: float | None = None  # largest tip deflection over the true one, less 1
    frequency: float | None = None  # of a chain's first mode, with the crank held, over the true one, less 1
    damping: float | None = None  # its damping ratio
    gap: float | None = None  # largest distance of the crank's pin and the centre line, m; None with Exudyn's joint
    seconds: float | None = None  # processor time of the solve


def constructions(names: Sequence[str] = ()) -> list[Construction]:
    """Those named, or all, computed in a process of its own."""
    script = [sys.executable, str(SCRIPTS / "measure.py"), *names]
    with TemporaryDirectory() as folder:  # MuJoCo writes a log file into it
        done = subprocess.run(script, cwd=folder, capture_output=True, text=True, check=True)
    return [Construction(**json.loads(line)) for line in done.stdout.splitlines() if line.startswith("{")]


def built() -> list[Construction]:
    """The recorded constructions."""
    return table("as_built", Construction)


def rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows that record them."""
    return {"as_built": constructions() if workshop.computes else []}


#: The run that they are of.
CASE: Final = "thesis-24"
#: Error of a tip deflection that counts as right, and one that counts as wrong.
RIGHT: Final = 0.05
WRONG: Final = 0.1
#: Error of a frequency, and a gap (m), that look right.
CLOSE: Final = 3e-3
NARROW: Final = 1e-4


def as_built(content: Content) -> Chapter | None:
    """The chapter; None if no constructions were recorded, or the report has not the run that they are of."""
    rows = content.of(recorded)
    if not rows:
        return None
    facts = {"of_record": about("as built"), "table": table_of(rows)}
    return Chapter("as_built", "As users build it", finding(rows), facts)


def recorded(content: Content) -> Sequence[Construction]:
    """The recorded constructions, for a report with the run that they are of."""
    return built() if content.workshop and content.has(CASE) else []


def finding(rows: Sequence[Construction]) -> str:
    """How many constructions are right, lost, or wrong with a good frequency or a small gap."""
    right = [row for row in rows if row.error is not None and row.error <= RIGHT]
    lost, seeming = [row for row in rows if row.error is None], [row for row in rows if _seems_right(row)]
    programs = listed(list(dict.fromkeys(row.program.split()[0] for row in rows)))
    of = f"{len(right)} of {counted(len(rows), 'construction')} with the means of {programs} {'is' if len(right) == 1 else 'are'}"
    others = [f"{len(lost)} lost the motion"] * bool(lost) + [f"{len(seeming)} only looked right"] * bool(seeming)
    return f"{of} within {percent(RIGHT, 'g')} in run 24{'; ' if others else ''}{' and '.join(others)}"


def _seems_right(row: Construction) -> bool:
    """Whether a wrong construction has a small gap or the right frequency."""
    if row.error is None or row.error <= WRONG:
        return False
    return (row.gap is not None and row.gap < NARROW) or (row.frequency is not None and abs(row.frequency) < CLOSE)


def table_of(rows: Sequence[Construction]) -> Table:
    """A row per construction."""
    made = Table(
        "as_built",
        """Run 24, damped by its material, for 2 s. Deflection: RMS of the difference from the true one over its RMS. Peak and first
        frequency (crank held at 180°): relative to the true ones. Damping ratio: of a pluck. Gap: of the crank’s pin from a chain’s links.
        Solve: processor time, on a machine that did other work besides, so that only ratios count.""",
        (
            *("program", "name"),
            Column("error", "deflection", "%", ".2g"),
            Column("peak", unit="%", form="+.1f"),
            Column("frequency", unit="%", form="+.2f"),
            Column("damping", "damping ratio", "1", ".4f"),
            Column("gap", unit="mm", form=".2g"),
            Column("seconds", "solve", "s", ".2g"),
            Column("end", unit="s", form="g", in_page=False),
        ),
    )
    for row in rows:
        error = row.error
        mark: Mark = "failed" if error is None else "good" if error <= RIGHT else "missed" if error > WRONG else ""
        made.add(row, error=Cell(None, f"lost after {duration(row.end)}", mark=mark) if error is None else Cell(error, mark=mark))
    return made


PAGE = Part(chapters={as_built: 54}, templates=("quickreturn.plugins.as_built",))
