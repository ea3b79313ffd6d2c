"""A column of trajectories is added as `docs/developing.md` says. Done on a copy of the package."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.package_copy import ROOT, whole_package

COLUMN = """        "crank_acceleration": Observable(
            "rad/s^2",
            "rate of the crank's speed",
            of_slider=True,
            recorded=False,
        ),
"""
#: Simulates with the engine that has the column, and with one that does not.
SIMULATE = """
import json
import quickreturn as qr
from quickreturn.solution import as_csv
from tests.witnesses import unconfirmed

case = qr.case("thesis-24").with_({"simulation.duration": "50 ms", "simulation.output_step": "0.5 ms"})
with_it, without = (qr.simulate(case, name, estimate=False, store=False, quiet=True) for name in ("exudyn", "mujoco"))
print(json.dumps({
    "frame": {name: with_it[name].tolist() for name in ("time", "crank_speed", "crank_acceleration")},
    "unconfirmed": sorted(unconfirmed()),
    "unit": with_it.frame.attrs["units"]["crank_acceleration"], "csv": as_csv(with_it.trajectory).decode().splitlines()[0].split(","),
    "without": list(without.frame), "measures": {each.name: each.unit for each in qr.measures()},
}))
"""


def replace(file: Path, line: str, lines: str) -> None:
    """Write lines in place of a line that occurs once."""
    text = file.read_text(encoding="utf-8")
    assert text.count(line) == 1
    file.write_text(text.replace(line, lines), encoding="utf-8")


def told_by(package: Path, program: str, folder: Path) -> Any:
    """The JSON document that a program prints with the copy of the package."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join((str(package.parent), str(ROOT / "build/tests-alone")))}
    ended = subprocess.run([sys.executable, "-c", program], env=environment, cwd=folder, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    return json.loads(ended.stdout.splitlines()[-1])


@pytest.mark.verify  # the copy compiles its equations
def test_a_column_needs_a_declaration_and_a_line_in_an_engine_and_appears_wherever_columns_do(tmp_path: Path) -> None:
    package = whole_package(tmp_path / "copy")
    columns = package / "reference_model/columns.py"
    text = columns.read_text(encoding="utf-8")
    end = text.index("    }\n)", text.index("COLUMNS: Final"))
    columns.write_text(text[:end] + COLUMN + text[end:], encoding="utf-8")
    speed = '            "crank_speed": speed,\n'
    replace(package / "engines/exudyn/flexible.py", speed, f'{speed}            "crank_acceleration": acceleration,\n')

    found = told_by(package, SIMULATE, tmp_path)
    frame = {name: np.array(values) for name, values in found["frame"].items()}
    differences = np.gradient(frame["crank_speed"], frame["time"])
    inside = slice(5, -5)
    assert frame["crank_acceleration"][inside] == pytest.approx(differences[inside], abs=0.05 * float(np.max(np.abs(differences))))
    assert found["unit"] == "rad/s^2"
    assert "crank_acceleration" in found["csv"]
    assert "crank_acceleration" not in found["without"]
    assert found["measures"]["peak.crank_acceleration"] == "rad/s^2"
    assert found["unconfirmed"] == [["column", "crank_acceleration"]]  # until the table of witnesses has it
