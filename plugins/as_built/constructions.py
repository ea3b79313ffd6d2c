"""Constructions of run 24 as users of other programs build it, and their errors: `examples/as_built/`."""

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from quickreturn.cases.running.workshop import Workshop
from quickreturn.reports.long_studies import table

#: The programs' scripts. They stand in the checkout alone, and so does the record that is made from them.
SCRIPTS: Final = Path(__file__).resolve().parents[2] / "examples" / "as_built"


@dataclass(frozen=True)
class Construction:
    """A construction beside the converged solution; no numbers where the program lost the motion."""

    name: str  # unique among all programs
    program: str  # with its version
    end: float = 2.0  # of the motion, s; less than the 2 s asked if the program lost it
    error: float | None = None  # of the tip deflection, RMS of the difference over RMS
    peak: float | None = None  # largest tip deflection over the true one, less 1
    frequency: float | None = None  # of the first mode, with the crank held, over the true one, less 1
    damping: float | None = None  # its damping ratio
    gap: float | None = None  # largest distance of the crank's pin and the centre line, m
    seconds: float | None = None  # processor time of the solve

    @property
    def lost(self) -> bool:
        """Whether the program lost the motion."""
        return self.error is None


def constructions(names: Sequence[str] = ()) -> list[Construction]:
    """Those named, or all of the programs that are installed, computed in a process of its own."""
    script = [sys.executable, str(SCRIPTS / "measure.py"), "--rows", *names]
    with TemporaryDirectory() as folder:  # MuJoCo writes a log file into it
        done = subprocess.run(script, cwd=folder, capture_output=True, text=True, check=True)
    return [Construction(**json.loads(line)) for line in done.stdout.splitlines() if line.startswith("{")]


def built() -> list[Construction]:
    """The recorded constructions."""
    return table("as_built", Construction)


def rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows that record them; those of programs that are not installed stay as they were, with the version of the program."""
    found = constructions() if workshop.computes else []
    programs = {row.program.split()[0] for row in found}
    return {"as_built": found and found + [row for row in built() if row.program.split()[0] not in programs]}
