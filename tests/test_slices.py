"""Slices of the long tests: together they hold every group once, and the clock bounds them."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.slices import Slice

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
    "pytest.ini": "[pytest]\n",
}


@pytest.fixture
def suite(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def ran(suite: Path, *options: str, code: int = 0) -> str:
    """What pytest prints, in a process of its own."""
    environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": ":".join(filter(None, sys.path))}
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-v", *options]
    found = subprocess.run(command, cwd=suite, env=environment, capture_output=True, text=True, check=False)
    assert found.returncode == code, found.stdout + found.stderr
    return found.stdout + found.stderr


def passed(told: str) -> list[str]:
    return [line.split(" ")[0] for line in told.splitlines() if " PASSED" in line]


def test_each_case_belongs_to_one_slice_and_what_is_shared_to_the_same(suite: Path) -> None:
    slices = [passed(ran(suite, "--slice", f"{number}/3")) for number in (3, 1, 2)]
    everything = [name for each in slices for name in each]
    assert len(everything) == len(set(everything)) == 30
    assert all(0 < len(each) < 30 for each in slices)
    for file in ("test_sharing.py", "test_caching.py"):
        assert sorted(sum(name.startswith(file) for name in each) for each in slices) == [0, 0, 5]
    assert "test_apart.py::test_case[3]" in everything


def test_with_several_processes_a_group_stays_in_one(suite: Path) -> None:
    told = ran(suite, "-n", "2", "--dist", "loadgroup", "--slice", "7/1")
    lines = [line for line in told.splitlines() if "PASSED" in line]
    assert len(lines) == 30
    assert len({line.split("]")[0] for line in lines if "test_sharing" in line}) == 1
    assert "30 passed" in told.splitlines()[-1]


def test_what_the_time_does_not_allow_is_named_and_the_end_is_good(suite: Path) -> None:
    for more in ([], ["-n", "2", "--dist", "loadgroup"]):
        told = ran(suite, "--slice", "0/1", "--begin-within", "0", *more)
        assert "30 not begun, for the time was over" in told
        assert "\ntest_sharing.py::test_shared[4]\n" in told
        assert "30 skipped in" in told.splitlines()[-1]
        assert "made" not in told
    (suite / "test_wrong.py").write_text("def test_wrong(): assert False\n")
    ran(suite, "--begin-within", "1", code=1)


def test_a_slice_without_tests_is_good_and_one_that_is_not_understood_is_refused(suite: Path) -> None:
    empty = next(
        number for number in range(1000) if not any(Slice(f"{number}/1000").holds(f"test_apart.py::test_case[{n}]") for n in range(20))
    )
    assert "deselected in" in ran(suite, "--slice", f"{empty}/1000", "test_apart.py").splitlines()[-1]
    for text in ("3", "a/2", "1/0", "-1/3"):
        assert f"--slice {text}: expected two whole numbers k/n" in ran(suite, f"--slice={text}", code=4)


def test_in_turn_slices_draw_everything() -> None:
    everything = list(range(10))
    drawn = [Slice(f"{5 + 12 * turn}/12").drawn(everything, 3) for turn in range(20)]
    assert all(each == sorted(each) and len(set(each)) == 3 for each in drawn)
    assert {number for each in drawn[:4] for number in each} == set(everything)
    assert drawn[:10] == drawn[10:]
    assert Slice("1/2").drawn(everything, 20) == everything
    assert Slice("1/2").drawn([], 3) == []
