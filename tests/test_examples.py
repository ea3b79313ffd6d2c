"""The packages of `examples/`, each installed as its user would and put to its own tests."""

import importlib.util
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

import pytest

from quickreturn.plugins.conform.contract import conform

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.verify
def test_the_pinocchio_engine_passes_its_tests(tmp_path: Path) -> None:
    """In an environment of its own, which takes all else from this one: Pinocchio is large, and nothing else here needs it."""
    package, environment = tmp_path / "package", tmp_path / "environment"
    shutil.copytree(ROOT / "examples" / "pinocchio_engine", package)
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    python = environment / "bin" / "python"
    site = Path(sysconfig.get_path("purelib", vars={"base": str(environment)}))
    (site / "beside.pth").write_text(f"import site; site.addsitedir({sysconfig.get_path('purelib')!r})\n", encoding="utf-8")
    install = [python, "-m", "pip", "install", "--quiet", "--constraint", ROOT / "constraints.txt", package]
    done = subprocess.run(install, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"pip cannot install the example with its dependency pin:\n{done.stderr}"
    done = subprocess.run([python, "-m", "pytest", "-q", package], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


PAGE = (ROOT / "docs" / "engine.md").read_text("utf-8")
ROWS = re.findall(r"^\| ([^|]*) \| (\d+) \| ([^|]*) % \| ([^|]*) % \| ([^|]*) % \|$", PAGE, re.M)

WORDS = {
    "MuJoCo, hinges": "mujoco_hinges", "MuJoCo 3, `bend`": "mujoco_bend", "Exudyn, ANCF cable": "exudyn_cable",
    "PyElastica, first element fixed": "pyelastica_rod", "Newton, hinges": "newton_hinges",
}  # fmt: skip


@pytest.fixture
def errors(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "rods"))
    yield importlib.import_module("errors")
    for name in ("errors", "rod", "picture"):
        sys.modules.pop(name, None)


@pytest.mark.parametrize(("program", "words"), [("mujoco_hinges", "MuJoCo, hinges"), ("exudyn_cable", "Exudyn, ANCF cable")])
def test_the_errors_are_those_of_the_page(errors: Any, program: str, words: str) -> None:
    (row,) = (row for row in ROWS if row[0] == words)
    found = errors.errors(program, int(row[1]), sys.executable)
    assert [100.0 * each for each in found[:3]] == pytest.approx([float(each) for each in row[2:]], abs=0.06)


def test_page_and_picture_show_the_record(errors: Any) -> None:
    picture = importlib.import_module("picture")
    record = {(row["program"], row["pieces"]): row for row in picture.rows_of()}
    pages = re.findall(r"^\|([^|]*)\| (\d+) \|((?: [^|]* % \|)+)$", PAGE, re.M)
    program = ""
    for words, pieces, shown in pages:
        program = WORDS.get(words.strip(), program)
        found = [100.0 * float(record[program, pieces][column]) for column in ("sag", "f1", "f2")]
        assert [float(each.strip(" %")) for each in shown.split("|")[:3]] == pytest.approx(found, rel=0.05, abs=0.0051), (program, pieces)
    assert len(pages) == len(WORDS)
    both = picture.drawn(picture.rows_of()).axes
    lines = {line.get_label(): line.get_ydata() for line in both[0].get_lines()}
    assert {program for program, _ in record} == set(picture.PROGRAMS)
    for program, (name, *_) in picture.PROGRAMS.items():
        assert lines[name] == pytest.approx([100.0 * abs(float(row["sag"])) for key, row in record.items() if key[0] == program])
    assert [axes.get_xlabel() for axes in both] == ["number of pieces N"] * 2
    assert "%" in both[0].get_ylabel()
    shown_file = (ROOT / "docs" / "pictures" / "rods.svg").read_text("utf-8")
    assert all(name in shown_file for name, *_ in picture.PROGRAMS.values())
    assert len(shown_file) < 40_000


@pytest.mark.skipif(importlib.util.find_spec("elastica") is not None, reason="PyElastica is installed")
def test_a_program_that_is_not_installed_is_left_out_with_a_word(errors: Any) -> None:
    with pytest.raises(RuntimeError, match="ModuleNotFoundError: No module named 'elastica'"):
        errors.errors("pyelastica_rod", 5, sys.executable)


def test_an_adapter_takes_sixty_lines() -> None:
    """What an author writes, with its imports."""
    scripts = [(ROOT / "examples" / "rods" / f"{name}_engine.py").read_text("utf-8") for name in ("mujoco", "pyelastica")]
    assert [len(script.splitlines()) <= 60 for script in scripts] == [True, True]


@pytest.mark.verify
def test_mujoco_conforms(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "rods"))
    found = conform(importlib.import_module("mujoco_engine").MyRod(), quiet=True)
    assert found.conforms, found.failed


@pytest.mark.verify
@pytest.mark.skipif(importlib.util.find_spec("elastica") is None, reason="PyElastica is not installed")
def test_pyelastica_conforms(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "rods"))
    found = conform(importlib.import_module("pyelastica_engine").PyElasticaRod(), quiet=True)
    assert found.conforms, found.failed
