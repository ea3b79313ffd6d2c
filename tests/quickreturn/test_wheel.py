"""The package as others get it: a wheel, in an environment of its own, far from the checkout."""

import os
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

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


#: What a type checker must know of each package: without `py.typed` in it a type would be Any, and not the one asserted.
TYPED = """
from typing import assert_type
import numpy as np
from numpy.typing import NDArray
import quickreturn as qr
from quickreturn.cases.runs.request import Run
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
assert_type(solution.trajectory["tip_x"], NDArray[np.float64])
assert_type(qr.run(case, "thesis")["thesis-24", "thesis"], Run)
assert_type([each.name for each in qr.list_cases()], list[str])
assert_type(qr.conform("thesis").conforms, bool | None)
assert_type(shown, str)
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built from what git knows: nothing that lies about by accident."""
    folder = tmp_path_factory.mktemp("wheel")
    files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=False).stdout.split(b"\0")
    if len(files) < 2:
        pytest.skip("not a git checkout")
    for name in filter(None, map(os.fsdecode, files)):
        target = folder / "source" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).is_file():
            target.write_bytes((ROOT / name).read_bytes())
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(folder / "source")]
    subprocess.run(command, check=True, capture_output=True, cwd=folder)
    (found,) = folder.glob("quickreturn-*.whl")
    return found


def test_the_wheel_holds_every_package_with_its_data_and_no_tests(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.partition("/")[0] for name in names if "dist-info" not in name} == {"quickreturn"}
    assert "quickreturn/py.typed" in names
    for needed in ("cases/library/example.toml", "cases/thesis/data/runs.csv"):
        assert f"quickreturn/{needed}" in names
    here = {
        f"quickreturn/{path.relative_to(ROOT).as_posix()}"
        for path in (ROOT / "reports/templates").rglob("*")
        if path.is_file() and path.suffix != ".pyc"
    }
    assert here <= set(names)


@pytest.mark.verify
def test_three_lines_of_python_and_the_program_run_far_from_the_checkout(wheel: Path, tmp_path: Path) -> None:
    venv.create(tmp_path / "venv", with_pip=True)
    python = tmp_path / "venv/bin/python"
    install = [python, "-m", "pip", "install", "--quiet", "--constraint", ROOT / "constraints.txt", wheel]
    subprocess.run(install, check=True, cwd=tmp_path, capture_output=True)
    work = tmp_path / "work"
    work.mkdir()
    (work / "script.py").write_text(SCRIPT)
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "QUICKRETURN", "NUMBA"))}

    def run(*command: str | Path) -> str:
        found = subprocess.run(command, cwd=work, env=clean, capture_output=True, text=True, check=False)
        assert found.returncode == 0, found.stderr
        return found.stdout

    (work / "typed.py").write_text(TYPED)
    subprocess.run([sys.executable, "-m", "mypy", "--strict", "--python-executable", python, "typed.py"], cwd=work, check=True)
    assert run(python, "script.py").count("begun") == 1
    assert (work / "plot.png").read_bytes().startswith(b"\x89PNG")
    program = tmp_path / "venv/bin/quickreturn"
    assert run(program, "--version").startswith("quickreturn ")
    run(program, "simulate", "thesis-24", "--engine", "mujoco", "--duration", "0.1", "--output", "out.csv")
    assert len((work / "out.csv").read_text().splitlines()) == 102
