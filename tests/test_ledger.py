"""The ledger of the long tests notices a change of what a test imports, and of nothing else."""

import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ledger
from tests.ledger import Entry, Ledger, code_of, long_files, read, stale, write
from tests.package_copy import ROOT

TEST = """
import pytest
from tests.helper import value
@pytest.mark.verify
def test_value(): assert value() == 1
@pytest.mark.verify
@pytest.mark.skip
def test_skipped(): pass
def test_quick(): pass
"""
FILES = {
    "tests/__init__.py": "",
    "tests/test_value.py": TEST,
    "tests/test_quick.py": "def test_quick(): pass\n",
    "tests/helper.py": "def value():\n    from tests.constants import ONE\n    return ONE\n",
    "tests/constants.py": "ONE = 1\n",
    "tests/other.py": "",
    "pytest.ini": "[pytest]\nmarkers = verify: long\naddopts = --import-mode=importlib -m 'not verify'\npythonpath = .\n",
}


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    entries = {
        name: Entry(name, "abc1234", "0" * 16, 7, passed=2, failed=1, slices="0 7/12") for name in ("tests/test_a.py", "tests/test_b.py")
    }
    write(reversed(entries.values()), tmp_path / "ledger.csv")
    assert list(read(tmp_path / "ledger.csv").items()) == list(entries.items())
    assert read(tmp_path / "none.csv") == {}


def test_a_change_of_what_a_test_imports_is_noticed_and_no_other(checkout: Path) -> None:
    def code() -> str:
        return code_of("tests/test_value.py", checkout)

    first = code()
    (checkout / "tests/other.py").write_text("TWO = 2\n")
    assert code() == first
    for name in ("tests/constants.py", "tests/helper.py", "tests/test_value.py"):
        before = code()
        (checkout / name).write_text((checkout / name).read_text() + "# changed\n")
        assert code() != before


def test_what_should_run_again_is_listed_with_the_reason() -> None:
    good = Entry("a", "abc", "1", 60, passed=3, skipped=1)
    entries = {
        "a": good,
        "b": dataclasses.replace(good, code="0"),
        "c": dataclasses.replace(good, passed=2, failed=1),
        "e": dataclasses.replace(good, slices="0 2/4"),
        "f": dataclasses.replace(good, slices="0 1/2"),
    }
    assert stale(entries, ["a", "b", "c", "d", "e", "f"], lambda group: "1") == {
        "b": "code has changed since abc; it took 60 s",
        "c": "2 passed, 1 failed, 1 skipped at abc",
        "d": "is not in the ledger",
        "e": "slices 1, 3 have not run",
    }


def test_slices_of_the_same_code_make_up_one_entry() -> None:
    first = Entry("a", "abc", "1", 60, passed=3, slices="2/3")
    second = dataclasses.replace(first, commit="def", seconds=5, passed=1, skipped=1, slices="0/3")
    both = Entry("a", "def", "1", 65, passed=4, skipped=1, slices="0 2/3")
    assert second.after(first) == both
    assert first.after(both) == both  # it ran already
    assert dataclasses.replace(first, passed=0, failed=3).after(both).failed == 3
    for other in (dataclasses.replace(first, code="2"), dataclasses.replace(first, slices="1/7")):
        assert second.after(other) == second
    whole = dataclasses.replace(both, slices="")
    assert first.after(whole) == whole
    assert whole.after(first) == whole


def test_long_tests_are_found(checkout: Path) -> None:
    assert long_files(checkout) == ["tests/test_value.py"]
    found = long_files()
    assert {"tests/properties/test_symmetry.py", "tests/verification/test_ladder.py", "tests/test_documents.py"} <= set(found)
    assert "tests/test_structure.py" not in found
    assert set(read()) <= set(found)


#: Loads the ledger by its place: the made-up checkout has a package `tests` of its own.
CONFTEST = """
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
spec = spec_from_file_location("real_ledger", {place!r})
ledger = sys.modules["real_ledger"] = module_from_spec(spec)
spec.loader.exec_module(ledger)

def pytest_addoption(parser):
    parser.addoption("--part", default="")
    parser.addoption("--begin-within")
    parser.addoption("--keep-ledger", action="store_true")

def pytest_configure(config):
    if ledger.keeps(config):
        config.pluginmanager.register(ledger.Ledger(Path("ledger.csv"), Path(__file__).parent, config.getoption("--part")))
"""


def run(checkout: Path, *options: str, code: int = 0) -> str:
    (checkout / "conftest.py").write_text(CONFTEST.format(place=str(ROOT / "tests/ledger.py")))
    command = [sys.executable, "-P", "-m", "pytest", "-p", "no:cacheprovider", *options]
    # no bytecode: that of a file which is changed within a second, and keeps its size, would count as current
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1", "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    found = subprocess.run(command, cwd=checkout, capture_output=True, text=True, check=False, env=environment)
    assert found.returncode == code, found.stdout + found.stderr
    return found.stdout + found.stderr


def test_a_run_of_whole_files_is_entered(checkout: Path) -> None:
    run(checkout, "-m", "verify", "--keep-ledger", "tests/test_value.py")
    (entry,) = read(checkout / "ledger.csv").values()
    assert (entry.group, entry.outcome) == ("tests/test_value.py", "1 passed, 1 skipped")
    assert entry.code == code_of(entry.group, checkout)
    (checkout / "tests/constants.py").write_text("ONE = 2\n")
    found = stale(read(checkout / "ledger.csv"), [entry.group], lambda group: code_of(group, checkout))
    assert "code has changed" in found[entry.group]
    run(checkout, "-m", "verify", "--keep-ledger", code=1)
    assert read(checkout / "ledger.csv")[entry.group].outcome == "1 failed, 1 skipped"


def test_a_file_that_ran_in_slices_is_entered_slice_by_slice(checkout: Path) -> None:
    (checkout / "tests/test_other.py").write_text("import pytest\npytestmark = pytest.mark.verify\ndef test_one(): pass\n")
    run(checkout, "-m", "verify", "--keep-ledger", "--part=0/2", "tests/test_value.py")
    value, other = read(checkout / "ledger.csv")["tests/test_value.py"], read(checkout / "ledger.csv")["tests/test_other.py"]
    assert (value.outcome, value.missing) == ("1 passed, 1 skipped", [1])
    assert (other.outcome, other.missing) == ("no case", [1])
    run(checkout, "-m", "verify", "--keep-ledger", "--part=1/2", "tests/test_other.py")
    found = read(checkout / "ledger.csv")
    assert stale(found, list(found), lambda group: code_of(group, checkout)) == {}
    assert found["tests/test_other.py"].outcome == "1 passed"


@pytest.mark.parametrize("options", ["--begin-within=1", "-kvalue", "tests/test_value.py::test_value", "-mnot verify"])
def test_a_run_of_parts_of_files_is_not_entered(checkout: Path, options: str) -> None:
    assert "--keep-ledger needs all long tests" in run(checkout, "-m", "verify", "--keep-ledger", options, code=4)
    assert not (checkout / "ledger.csv").exists()


def test_the_status_is_listed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(ledger, "read", dict)
    assert ledger.main() == 0
    told = capsys.readouterr().out.splitlines()
    assert "tests/verification/test_ladder.py: is not in the ledger" in told
    assert told[-1].startswith("0 of ")
    assert isinstance(Ledger(tmp_path / "ledger.csv"), Ledger)
