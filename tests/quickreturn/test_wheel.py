"""The package as others get it: a wheel, in an environment of its own, far from the checkout."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from quickreturn.reference_model.native import objects

ROOT = Path(__file__).parents[2]

#: No guard, no path: what a person types into a file. Workers must not run it again.
SCRIPT = """
import quickreturn as qr
from importlib.util import find_spec
from pathlib import Path
print("begun")
from quickreturn import reference_model
assert "site-packages" in qr.__file__ and "site-packages" in reference_model.__file__
for inner in ("reference_model", "engines", "cases", "reports"):
    assert find_spec(inner) is None
case = qr.case("thesis-24", {"crank.length": "5 in"}, duration=0.2)
solution = qr.simulate(case, "thesis")
assert len(solution.frame) == 201 and solution.frame.attrs["units"]["time"] == "s"
solution.plot().savefig("plot.png")
runs = qr.run("thesis-24", "thesis")
assert runs["thesis-24", "thesis"].usable and len(runs.frame) > 0
print(solution, runs, qr.list_engines(), sep="\\n")
"""

#: Whether a first simulation imports the compiler, and whether it keeps compiled code.
FIRST = """
import os, sys
os.environ["NUMBA_CACHE_DIR"] = "cache"  # that of the user has what other tests compiled
import quickreturn as qr
from quickreturn.reference_model.native.cache_folder import folder
qr.simulate("thesis-24", "reference", store=False)
print("numba" in sys.modules, folder().exists())
"""

#: What a type checker must know of each package: without `py.typed` in it a type would be Any, and not the one asserted.
TYPED = """
from typing import assert_type
import numpy as np
from quickreturn.reference_model.arrays import Array
import quickreturn as qr
from quickreturn.cases.motion.request import Run
from quickreturn.engines.accurate import Result
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reports.words import percent

shown = percent(0.5)
case = qr.case("thesis-24").with_({"crank.length": "5 in"})
assert_type(case, qr.Case)
assert_type(case.mechanism, Mechanism)
assert_type(case.mechanism.crank.length, float)
solution = qr.simulate(case, "thesis", estimate=False)
assert_type(solution, qr.Solution)
assert_type(solution.result, Result)
assert_type(solution.trajectory["tip_x"], Array)
assert_type(qr.run(case, "thesis")["thesis-24", "thesis"], Run)
assert_type([each.name for each in qr.list_cases()], list[str])
assert_type(qr.conform("thesis").conforms, bool | None)
assert_type(shown, str)
"""

#: Puts a verification into the store, as `make verify` does.
VERIFICATION = """
import json
from quickreturn.cases.running.key import code_fingerprint
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.store import write_atomically
from quickreturn.reports.page.content import FILE
chapter = {"title": "Faults", "text": "All of it survived.", "columns": ["fault", "share"], "rows": [["disk full", 0.5]]}
document = {"code": code_fingerprint(), "date": "today", "chapters": [chapter]}
write_atomically(Store().folder / FILE, json.dumps(document).encode())
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built from what git knows, as `make wheel` builds it: nothing that lies about by accident."""
    folder = tmp_path_factory.mktemp("wheel")
    files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=False).stdout.split(b"\0")
    if len(files) < 2:
        pytest.skip("not a git checkout")
    for name in filter(None, map(os.fsdecode, files)):
        target = folder / "source" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).exists():
            shutil.copy(ROOT / name, target, follow_symlinks=False)
    ship = [sys.executable, "-P", "-m", "quickreturn.reference_model.entries"]
    subprocess.run(ship, check=True, capture_output=True, cwd=folder, env={**clean(), "PYTHONPATH": str(folder / "source")})
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(folder / "source")]
    subprocess.run(command, check=True, capture_output=True, cwd=folder)
    (found,) = folder.glob("quickreturn-*.whl")
    return found


@pytest.mark.every_slice
@pytest.mark.verify
def test_the_wheel_holds_every_package_with_its_data_and_no_tests(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.partition("/")[0] for name in names if "dist-info" not in name} == {"quickreturn"}
    assert "quickreturn/py.typed" in names
    for needed in ("cases/library/example.toml", "cases/library/thesis/data/runs.csv"):
        assert f"quickreturn/{needed}" in names
    assert len([name for name in names if name.endswith(".object")]) == 7
    tracked = subprocess.run(["git", "ls-files", "reports", "pack"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    assert tracked
    assert {f"quickreturn/{name}" for name in tracked} <= set(names)


def pythons() -> list[str]:
    """The Python of the tests, and the newest: the last of `PYTHONS`, or the newest python3.N on the path; itself where none is newer."""
    given = os.environ.get("PYTHONS", "").split()
    newer = given or [found for minor in range(sys.version_info.minor + 1, 30) if (found := shutil.which(f"python3.{minor}"))]
    good = [each for each in newer if subprocess.run([each, "--version"], capture_output=True, check=False).returncode == 0]
    return [sys.executable, (good or [sys.executable])[-1]]


@pytest.fixture(scope="module", params=[0, 1], ids=["this Python", "the newest Python"])
def installed(request: pytest.FixtureRequest, wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs of an environment that holds the wheel and what it needs, and nothing else."""
    if request.param == 1 and len(set(pythons())) == 1:
        pytest.skip("no newer Python is on the path; name one by the variable PYTHONS")
    folder = tmp_path_factory.mktemp("user")
    subprocess.run([pythons()[request.param], "-m", "venv", folder / "venv"], check=True, cwd=folder, env=clean())
    pip = [folder / "venv/bin/python", "-m", "pip", "install", "--quiet", "--constraint", ROOT / "constraints.txt", f"{wheel}[plot]"]
    found = subprocess.run(pip, cwd=folder, env=clean(), capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    return folder / "venv/bin"


def clean() -> dict[str, str]:
    """Variables of a user, who has set none of this project."""
    return {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "QUICKRETURN", "NUMBA"))}


def answer(folder: Path, *command: str | Path) -> str:
    """What a program prints that runs in a folder and ends well."""
    found = subprocess.run(command, cwd=folder, env=clean(), capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    return found.stdout


@pytest.mark.verify
def test_three_lines_of_python_and_the_program_run_far_from_the_checkout(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT)
    (tmp_path / "typed.py").write_text(TYPED)
    python, program = installed / "python", installed / "quickreturn"
    typed = [sys.executable, "-m", "mypy", "--strict", "--python-executable", python, "typed.py"]
    subprocess.run(typed, cwd=tmp_path, check=True)
    assert answer(tmp_path, python, "script.py").count("begun") == 1
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG")
    assert answer(tmp_path, program, "--version").startswith("quickreturn ")
    answer(tmp_path, program, "simulate", "thesis-24", "--engine", "mujoco", "--duration", "0.1", "--output", "out.csv")
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 102


@pytest.mark.verify
def test_a_first_simulation_compiles_nothing(installed: Path, tmp_path: Path) -> None:
    if not objects._of_level():
        pytest.skip(f"this processor is not {objects.LEVEL}")
    assert answer(tmp_path, installed / "python", "-c", FIRST) == "False False\n"


@pytest.mark.verify
def test_a_report_shows_a_stored_verification_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    """Written by the names of the installed packages, and shown by the installed command, from a folder that holds nothing."""
    python, safe = installed / "python", [installed / "python", "-P", installed / "quickreturn"]
    answer(tmp_path, python, "-P", "-c", VERIFICATION)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".quickreturn"]
    answer(tmp_path, *safe, "--quiet", "report", "thesis-24", "--engine", "thesis", "--output", "page")
    assert "All of it survived." in (tmp_path / "page/index.html").read_text("utf-8")
    told = json.loads(answer(tmp_path, *safe, "modes", "thesis-24", "--engine", "reference", "--crank-angle", "180", "--json"))
    assert told["frequencies"][0] > 0.0
    answer(tmp_path, *safe, "run", "thesis-24", "--engine", "thesis", "--json")
