"""A study is added as `docs/developing.md` says: a function that carries out trials, and its name in one file; on a copy of the package."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.package_copy import whole_package

#: Of an engine that compiles nothing, so that the copy begins at once.
MODULE = '''"""The coarsest settings of exudyn against its finest, in the first instants of run 24."""

from dataclasses import replace

from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.methods.trials.methods import methods
from quickreturn.plugins.methods.trials.trial import Trial, run_of, trial_of


def rows(workshop: Workshop) -> dict[str, list[Trial]]:
    """The trials that the workshop has or computes."""
    jobs = [Job("coarse", trials, ("exudyn",), kind="coarse", engines=("exudyn",))]
    return {"coarse": [trial for outcome in workshop.outcomes(jobs, "coarse settings") for trial in outcome.value or ()]}


def trials(name: str) -> list[Trial]:
    """The coarsest and the finest settings of an engine."""
    case = replace(load_case("thesis-24"), duration=0.02)
    (method,) = methods([name], case)
    plans = list(method.plans(case))
    truth = run_of(method.engine, case, plans[-1].settings).trajectory
    return [trial_of(plan, truth) for plan in (plans[0], plans[-1])]
'''
#: Records the study as `python -m quickreturn.record coarse` does, without processes beside.
RECORD = """
from quickreturn import record
from quickreturn.cases.running.in_process import ThisProcess
from quickreturn.cases.running.workshop import Workshop
record.Workshop = lambda store: Workshop(store, ThisProcess())
record.main(["coarse"])
"""
#: Reads the record, and queries it.
READ = """
from quickreturn.plugins.methods.trials.queries import changing, fastest_at
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.reports.long_studies import about, table
trials = table("coarse", Trial)
print([(trial.scene, trial.method, trial.completed) for trial in trials])
print([{"elements", "step"} <= set(changing(trial, trials)) for trial in trials], trials[0].error > trials[1].error == 0.0)
print(fastest_at(trials, 0.1) == {"exudyn": min(trials, key=lambda trial: trial.seconds)}, about("coarse").study)
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
    line = '        "classes": f"{_HERE}.records:class_rows",\n'
    assert plugin.read_text().count(line) == 1
    plugin.write_text(plugin.read_text().replace(line, f'{line}        "coarse": f"{{_HERE}}.coarse:rows",\n'))
    others = (package / "reports/long_studies/classes.csv").read_bytes()

    assert run(package, "-c", RECORD) == "coarse (2 rows of coarse)\n"
    assert (package / "reports/long_studies/coarse.csv").read_text().startswith("scene,engine,settings,degrees_of_freedom,errors.")
    assert (package / "reports/long_studies/classes.csv").read_bytes() == others
    trials, changed, fastest = run(package, "-c", READ).splitlines()
    assert trials == str([("thesis-24", "exudyn", True)] * 2)
    assert changed == "[True, True] True"
    assert fastest == "True coarse"
