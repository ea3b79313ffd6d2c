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
    """A construction beside the converged solution; no numbers where the program lost the motion.

    Attributes:
        name: unique among all programs.
        program: with its version.
        end: of the motion, s; less than the 2 s asked if the program lost it.
        error: of the tip deflection, RMS of the difference over RMS.
        peak: largest tip deflection over the true one, less 1.
        frequency: of the first mode, with the crank held, over the true one, less 1.
        damping: its damping ratio.
        gap: largest distance of the crank's pin and the centre line, m.
        seconds: processor time of the solve.
    """

    name: str
    program: str
    end: float = 2.0
    error: float | None = None
    peak: float | None = None
    frequency: float | None = None
    damping: float | None = None
    gap: float | None = None
    seconds: float | None = None

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
