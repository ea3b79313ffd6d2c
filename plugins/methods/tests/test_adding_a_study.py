"""A study is added as `docs/developing.md` says: a function that gives rows, and its name in one file; on a copy of the package."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.package_copy import whole_package

#: Of an engine that compiles nothing, so that the copy begins at once.
MODULE = '''"""The coarsest settings of exudyn against its finest, in the first instants of run 24."""

from dataclasses import replace

from quickreturn.cases.library import load_case
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import engine
from quickreturn.plugins.methods.race import tried
from quickreturn.plugins.methods.row import Row
from quickreturn.plugins.methods.truth import Truth, run_of


def rows(workshop: Workshop) -> dict[str, list[Row]]:
    """The rows that the workshop has or computes."""
    jobs = [Job("coarse", made, ("exudyn",), kind="coarse", engines=("exudyn",))]
    return {"coarse": [row for outcome in workshop.outcomes(jobs, "coarse settings") for row in outcome.value or ()]}


def made(name: str) -> list[Row]:
    """Coarse and fine settings of an engine."""
    case, chosen = replace(load_case("thesis-24"), duration=0.02), engine(name)
    coarse, fine = (chosen.settings_for(level, case.mechanism) for level in (0.05, 1e-3))
    truth = Truth(run_of(chosen, case, fine).trajectory, Row(scene=case.name, engine=name))
    return [tried(chosen, case, settings, truth) for settings in (coarse, fine)]
'''
#: Records the study as `python -m quickreturn.record coarse` does, without processes beside.
RECORD = """
from quickreturn import record
from quickreturn.cases.running.job import ThisProcess
from quickreturn.cases.running.workshop import Workshop
record.Workshop = lambda store: Workshop(store, ThisProcess())
record.main(["coarse"])
"""
#: Reads the record, and queries it.
READ = """
from quickreturn.plugins.methods.fronts import front
from quickreturn.plugins.methods.row import Row
from quickreturn.reports.long_studies import about, table
rows = table("coarse", Row)
print([(row.scene, row.method, row.completed) for row in rows])
print(rows[0].error > rows[1].error == 0.0, len(front(rows)), about("coarse").study)
"""


def run(package: Path, *arguments: str) -> str:
    """What Python prints that imports this package."""
    environment = os.environ | {"PYTHONPATH": str(package.parent), "QUICKRETURN_STORE": str(package.parent / "store")}
    told = subprocess.run([sys.executable, *arguments], env=environment, cwd=package.parent, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stderr
    return told.stdout


@pytest.mark.verify
def test_a_study_needs_a_module_and_its_name_in_one_file(tmp_path: Path) -> None:
    package = whole_package(tmp_path / "copy")
    (package / "plugins/methods/coarse.py").write_text(MODULE)
    plugin = package / "plugins/methods/plugin.py"
    line = '        "classes": f"{_HERE}.studies:class_rows",\n'
    assert plugin.read_text().count(line) == 1
    plugin.write_text(plugin.read_text().replace(line, f'{line}        "coarse": f"{{_HERE}}.coarse:rows",\n'))
    others = (package / "reports/long_studies/classes.csv").read_bytes()

    assert run(package, "-c", RECORD) == "coarse (2 rows of coarse)\n"
    assert (package / "reports/long_studies/coarse.csv").read_text().startswith("scene,engine,settings,errors.")
    assert (package / "reports/long_studies/classes.csv").read_bytes() == others
    rows, queried = run(package, "-c", READ).splitlines()
    assert rows == str([("thesis-24", "exudyn", True)] * 2)
    assert queried == "True 2 coarse"
