"""Slices of the long tests: together they hold every group once, and the clock bounds them."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.slices import Slice, group_of

FILES = {
    "conftest.py": """
import pytest
from tests.slices import Slices, add_options, slice_of

def pytest_addoption(parser): add_options(parser)
def pytest_configure(config): config.pluginmanager.register(Slices(config))

@pytest.fixture
def number(request): return slice_of(request.config)
""",
    "test_apart.py": """
import pytest
@pytest.mark.parametrize("n", range(20))
def test_case(n): pass
""",
    "test_sharing.py": """
import pytest
@pytest.fixture(scope="module")
def costly():
    print("made")
@pytest.mark.parametrize("n", range(5))
def test_shared(n, costly): pass
""",
    "test_caching.py": """
from functools import cache
import pytest
@cache
def costly(): pass
@pytest.mark.parametrize("n", range(5))
def test_cached(n): pass
""",
    "pytest.ini": "[pytest]\nmarkers = every_slice: in all\n",
}

#: File, function and number of its cases.
CASES = (("apart", "case", 20), ("sharing", "shared", 5), ("caching", "cached", 5))


@pytest.fixture
def suite(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def ran(suite: Path, *options: str, code: int = 0) -> str:
    """What pytest prints, in a process of its own."""
    environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": ":".join(filter(None, sys.path)), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    command = [sys.executable, "-m", "pytest", "-p", "xdist", "-p", "no:cacheprovider", "-v", *options]
    found = subprocess.run(command, cwd=suite, env=environment, capture_output=True, text=True, check=False)
    assert found.returncode == code, found.stdout + found.stderr
    return found.stdout + found.stderr


def passed(told: str) -> list[str]:
    return [line.split(" ")[0] for line in told.splitlines() if " PASSED" in line]


def test_each_case_belongs_to_one_slice_what_is_shared_to_the_same_and_what_is_marked_to_all(suite: Path) -> None:
    (suite / "test_marked.py").write_text("import pytest\n@pytest.mark.every_slice\ndef test_each(): pass\n")
    cases = [f"test_{name}.py::test_{case}[{n}]" for name, case, count in CASES for n in range(count)]
    slices = [[case for case in cases if Slice(f"{number}/3").holds(group_of(case, suite))] for number in (3, 1, 2)]
    assert sorted(name for each in slices for name in each) == sorted(cases)
    assert all(0 < len(each) < len(cases) for each in slices)
    for file in ("test_sharing.py", "test_caching.py"):
        assert sorted(sum(name.startswith(file) for name in each) for each in slices) == [0, 0, 5]
    assert sorted(passed(ran(suite, "--slice", "4/3"))) == sorted([*slices[1], "test_marked.py::test_each"])


@pytest.mark.verify
def test_with_several_processes_a_group_stays_in_one(suite: Path) -> None:
    told = ran(suite, "-n", "2", "--dist", "loadgroup", "--slice", "7/1")
    lines = [line for line in told.splitlines() if "PASSED" in line]
    assert len(lines) == 30
    assert len({line.split("]")[0] for line in lines if "test_sharing" in line}) == 1
    assert "30 passed" in told.splitlines()[-1]


@pytest.mark.verify
def test_what_the_time_does_not_allow_is_named_and_the_end_is_good(suite: Path) -> None:
    told = ran(suite, "--slice", "0/1", "--begin-within", "0", "-n", "2", "--dist", "loadgroup")
    assert "30 not begun, for the time was over" in told
    assert "\ntest_sharing.py::test_shared[4]\n" in told
    assert "30 skipped in" in told.splitlines()[-1]
    assert "made" not in told
    (suite / "test_wrong.py").write_text("def test_wrong(): assert False\n")
    assert "1 failed" in ran(suite, "--begin-within", "1", "test_wrong.py", code=1)


def test_a_slice_without_tests_is_good_and_one_that_is_not_understood_is_refused(suite: Path) -> None:
    cases = [f"test_apart.py::test_case[{number}]" for number in range(20)]
    empty = next(number for number in range(1000) if not any(map(Slice(f"{number}/1000").holds, cases)))
    assert "deselected in" in ran(suite, "--slice", f"{empty}/1000", "test_apart.py").splitlines()[-1]
    for text in ("3", "a/2", "1/0", "-1/3"):
        with pytest.raises(pytest.UsageError, match=f"--slice {text}: expected two whole numbers k/n"):
            Slice(text)


def test_in_turn_slices_draw_everything() -> None:
    everything = list(range(10))
    drawn = [Slice(f"{5 + 12 * turn}/12").drawn(everything, 3) for turn in range(20)]
    assert all(each == sorted(each) and len(set(each)) == 3 for each in drawn)
    assert {number for each in drawn[:4] for number in each} == set(everything)
    assert drawn[:10] == drawn[10:]
    assert Slice("1/2").drawn(everything, 20) == everything
    assert Slice("1/2").drawn([], 3) == []
