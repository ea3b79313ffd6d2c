"""The checkers of all languages that are installed: right tables, wrong ones, and input that is none."""

import math
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from quickreturn.plugins.pack import by_hand, values
from quickreturn.plugins.pack.problems import PROBLEMS
from quickreturn.plugins.pack.tests.test_problems import PACK, bounds_of, table_of

Columns = dict[str, np.ndarray]
#: Problem, file, share -> exit code, and signal -> status.
Checker = Callable[..., tuple[int, dict[str, str]]]
STATUSES = ("within", "outside", "beyond the horizon", "missing")
PROGRAMS = {"python": "", "c++": "g++", "octave": "octave-cli", "julia": "julia"}
#: Their interpreters take most of a second to start.
SLOW = ("c++", "octave", "julia")


def text_of(columns: Columns) -> str:
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return "\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows)]) + "\n"


@pytest.fixture(
    scope="module",
    params=[pytest.param(name, marks=[pytest.mark.verify, pytest.mark.every_slice] if name in SLOW else []) for name in PROGRAMS],
)
def checker(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Checker:
    program = PROGRAMS[request.param] and shutil.which(PROGRAMS[request.param])
    if program is None:
        pytest.skip(f"{PROGRAMS[request.param]} is not installed")
    if request.param == "c++":
        built = tmp_path_factory.mktemp("c++") / "check"
        strict = ("-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror")
        subprocess.run([program, *strict, "-o", built, PACK / "check.cpp"], check=True)

    def check(problem: str, file: Path, share: float | str = 0.0) -> tuple[int, dict[str, str]]:
        command = {
            "python": [sys.executable, "-I", "-S", PACK / "check.py", problem, file, str(share)],
            "c++": [built if request.param == "c++" else "", problem, file, str(share)],
            "octave": [program, "--eval", f"exit(check('{problem}', '{file}', {share!r}))"],
            "julia": [program, PACK / "check.jl", problem, file, str(share)],
        }[request.param]
        found = subprocess.run(list(map(str, command)), cwd=PACK, capture_output=True, text=True, check=False, timeout=100)
        lines = [(line[:18].strip(), line[19:37].strip()) for line in found.stdout.splitlines()]
        assert all(status in STATUSES for _, status in lines), found.stdout
        if found.returncode == 2:
            assert found.stderr.strip()
            assert "Traceback" not in found.stderr
        return found.returncode, dict(lines)

    return check


def resampled(rows: int) -> Columns:
    return by_hand.decay(rows, modes=80)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_each_table_is_within_its_own_bounds(checker: Checker, problem: str) -> None:
    code, found = checker(problem, PACK / problem / "results.csv")
    assert (code, found) == (0, dict.fromkeys(bounds_of(problem)["signals"], "within"))


def uneven() -> Columns:
    table = resampled(3000)
    kept = np.unique(np.concatenate([[0, 3000], (3000 * (np.linspace(0, 1, 900) ** 1.5)).astype(int)]))
    return {name: column[kept] for name, column in table.items()}


def with_rows_after_the_end() -> Columns:
    table = table_of("decay")
    return {name: np.append(column, column[-1] + (0.1 if name == "time" else 0.0)) for name, column in table.items()}


RIGHT: dict[str, Callable[[], Columns]] = {
    "finer rows": lambda: resampled(4100),
    "uneven rows": uneven,
    "other columns, in another order": lambda: {"phase": resampled(500)["time"] + 7, **dict(reversed(resampled(500).items()))},
    "rows after the end": with_rows_after_the_end,
}


@pytest.mark.parametrize("kind", RIGHT)
def test_right_tables_are_within(checker: Checker, tmp_path: Path, kind: str) -> None:
    (tmp_path / "mine.csv").write_text(text_of(RIGHT[kind]()), "utf-8")
    assert checker("decay", tmp_path / "mine.csv") == (0, {"tip_deflection": "within", "middle_deflection": "within"})


def test_marks_and_line_ends_of_other_systems_are_read(checker: Checker, tmp_path: Path) -> None:
    lines = text_of(table_of("decay")).splitlines()
    quoted = ", ".join(f'"{name}"' for name in lines[0].split(","))
    (tmp_path / "mine.csv").write_bytes("\r\n".join(["\ufeff" + quoted, "", *lines[1:], ""]).encode())
    assert checker("decay", tmp_path / "mine.csv")[0] == 0


def changed(**factors: float) -> Columns:
    """Decay with another stiffness, damping or mass."""
    before = vars(values.DECAY).copy()
    try:
        vars(values.DECAY).update({name: before[name] * factor for name, factor in factors.items()})
        return resampled(1500)
    finally:
        vars(values.DECAY).update(before)


def with_tip(change: Callable[[np.ndarray], np.ndarray]) -> Columns:
    table = table_of("decay")
    return table | {"tip_deflection": change(table["tip_deflection"])}


def rows_of(kept: slice) -> Columns:
    return {name: column[kept] for name, column in table_of("decay").items()}


def spoiled(value: float) -> Columns:
    return with_tip(lambda w: np.where(np.arange(len(w)) == 700, value, w))


WRONG: dict[str, Callable[[], Columns]] = {
    "unit": lambda: with_tip(lambda w: 1e3 * w),
    "a lag of one row": lambda: with_tip(lambda w: np.concatenate([w[:1], w[:-1]])),
    "stiffness, 1 %": lambda: changed(bending=1.01),
    "no damping of the material": lambda: changed(material=1e-6),
    "an offset of three bounds": lambda: with_tip(lambda w: w + 3 * bounds_of("decay")["signals"]["tip_deflection"]["bound"]),
    "one row is wrong": lambda: spoiled(0.0),
    "nan": lambda: spoiled(math.nan),
    "ends early": lambda: rows_of(slice(0, 1400)),
    "begins late": lambda: rows_of(slice(100, None)),
    "time in milliseconds": lambda: {name: column * (1e3 if name == "time" else 1) for name, column in table_of("decay").items()},
}


@pytest.mark.parametrize("kind", WRONG)
def test_wrong_tables_are_outside(checker: Checker, tmp_path: Path, kind: str) -> None:
    (tmp_path / "mine.csv").write_text(text_of(WRONG[kind]()), "utf-8")
    code, found = checker("decay", tmp_path / "mine.csv")
    assert (code, found["tip_deflection"]) == (1, "outside")


def test_a_missing_signal_and_one_that_is_off_beyond_the_horizon_are_told(checker: Checker, tmp_path: Path) -> None:
    table, horizon = table_of("bending-pendulum"), bounds_of("bending-pendulum")["signals"]["tip_y"]["horizon"]
    del table["middle_x"]
    table["tip_y"] = table["tip_y"] + np.where(table["time"] > horizon + 0.1, 0.01, 0.0)
    (tmp_path / "mine.csv").write_text(text_of(table), "utf-8")
    expected = {"tip_y": "beyond the horizon", "tip_x": "within", "middle_x": "missing", "middle_y": "within"}
    assert checker("bending-pendulum", tmp_path / "mine.csv") == (0, expected)
    late = {name: column[table["time"] > 2.5] for name, column in table.items()}
    (tmp_path / "mine.csv").write_text(text_of(late), "utf-8")
    assert checker("bending-pendulum", tmp_path / "mine.csv") == (
        0,
        expected | {"tip_x": "beyond the horizon", "middle_y": "beyond the horizon"},
    )


def test_a_share_is_allowed_besides(checker: Checker, tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text(text_of(with_tip(lambda w: 1.005 * w)), "utf-8")
    assert [checker("decay", tmp_path / "mine.csv", share)[0] for share in (0.004, 0.006)] == [1, 0]


NO_TABLE = {
    "no time": "t,tip_deflection\n0,0\n1,0\n",
    "no signal": "time,crank_angle\n0,0\n1,0\n",
    "decimal commas": "time,tip_deflection\n0,0\n0,001,0,002\n",
    "a name twice": "time,tip_deflection,tip_deflection\n0,0,1\n1,0,1\n",
    "semicolons": "time;tip_deflection\n0;0\n1;0\n",
    "times that go back": "time,tip_deflection\n0,0\n2,0\n1,0\n",
    "no text": "",
}


@pytest.mark.parametrize("kind", NO_TABLE)
def test_what_is_no_table_is_bad_input(checker: Checker, tmp_path: Path, kind: str) -> None:
    (tmp_path / "mine.csv").write_text(NO_TABLE[kind], "utf-8")
    assert checker("decay", tmp_path / "mine.csv") == (2, {})


def test_no_file_and_no_problem_are_bad_input(checker: Checker, tmp_path: Path) -> None:
    assert checker("decay", tmp_path / "none.csv") == (2, {})
    assert checker("dekay", PACK / "decay" / "results.csv") == (2, {})


@pytest.mark.parametrize("share", [-1.0, 1.0, "1%"])
def test_a_share_that_is_no_part_is_bad_input(checker: Checker, share: float | str) -> None:
    """A share of 1, or what a language makes of a text, would allow any table."""
    assert checker("decay", PACK / "decay" / "results.csv", share) == (2, {})


#: A host program whose locale writes decimal commas.
HOST = """
#include <cstdio>
#include "check.hpp"
struct Commas : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
};
int main(int, char** arguments) {
    std::locale::global(std::locale(std::locale(), new Commas));
    const auto verdicts = pack::judged(arguments[1], "decay", arguments[2]);
    for (const auto& each : verdicts) std::printf("%s %s\\n", each.status.c_str(), each.told.c_str());
}
"""


@pytest.mark.verify
def test_the_locale_of_a_program_in_cpp_does_not_matter(tmp_path: Path) -> None:
    if not (program := shutil.which("g++")):
        pytest.skip("g++ is not installed")
    (tmp_path / "host.cpp").write_text(HOST)
    subprocess.run([program, "-std=c++17", f"-I{PACK}", "-o", tmp_path / "host", tmp_path / "host.cpp"], check=True)
    told = subprocess.run([tmp_path / "host", PACK, PACK / "decay/results.csv"], check=True, capture_output=True, text=True).stdout
    assert set(re.findall(r"^\w+", told, re.MULTILINE)) == {"within"}
    assert "," not in re.sub(r", ", "", told)
