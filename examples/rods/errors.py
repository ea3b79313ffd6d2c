"""Errors of the rods over their pieces: runs each program and prints a table, as `errors.csv`.

    python errors.py [--python NAME=PROGRAM] [PIECES ...]

A program that is not installed is left out, with a word. `--python` names the Python that runs a
script, such as `mujoco_bend=/venvs/mujoco3/bin/python`; it may be repeated.
"""

import argparse
import csv
import subprocess
import sys
from pathlib import Path
from typing import Final

import numpy as np
from quickreturn.plugins.conform.rods import ROOTS, ring

import rod

FOLDER: Final = Path(__file__).parent
PROGRAMS: Final = (
    "mujoco_hinges",
    "mujoco_bend",
    "exudyn_cable",
    "pyelastica_rod",
    "newton_hinges",
)
PIECES: Final = (3, 5, 10, 20)
#: Sag, m, and frequencies, Hz, by the closed forms for small deflections.
SAG: Final = rod.MASS_PER_LENGTH * rod.GRAVITY * rod.LENGTH**4 / (8.0 * rod.STIFFNESS)
UNIT: Final = np.sqrt(rod.STIFFNESS / rod.MASS_PER_LENGTH) / (2.0 * np.pi * rod.LENGTH**2)
COLUMNS: Final = ("program", "pieces", "sag", "f1", "f2", "f3")


def errors(program: str, pieces: int, python: str) -> list[float]:
    """Relative errors of the sag and of three frequencies. RuntimeError: why there are none."""
    script = [python, str(FOLDER / f"{program}.py"), str(pieces)]
    done = subprocess.run(script, capture_output=True, text=True, timeout=900, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr.strip().splitlines()[-1])
    lines = [line for line in done.stdout.splitlines() if line[:1] in "-0123456789"]
    found = ring(np.array([float(line) for line in lines[-len(rod.TIMES) :]]), rod.STEP)
    frequencies = np.full(3, np.nan)
    frequencies[: len(found.frequencies)] = found.frequencies
    return [-found.rest / SAG - 1.0, *(frequencies / (ROOTS**2 * UNIT) - 1.0)]


def main() -> None:
    """The table, row by row."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pieces", nargs="*", type=int, default=PIECES)
    parser.add_argument("--python", action="append", default=[])
    given = parser.parse_args()
    pythons = dict(each.split("=", 1) for each in given.python)
    table = csv.writer(sys.stdout, lineterminator="\n")
    table.writerow(COLUMNS)
    for program in PROGRAMS:
        try:
            for pieces in given.pieces:
                found = errors(program, pieces, pythons.get(program, sys.executable))
                table.writerow([program, pieces, *(f"{each:.2e}" for each in found)])
                sys.stdout.flush()
        except (RuntimeError, subprocess.TimeoutExpired) as why:
            print(f"{program} is left out: {why}", file=sys.stderr)


if __name__ == "__main__":
    main()
