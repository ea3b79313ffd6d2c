"""The ledger of the long tests: when each file of tests last ran, with which code, and what came of it.

`make verify` writes `verify_ledger.csv`, which is committed with the work; `python -m tests.ledger` (`make verify-status`) lists the files
whose code has changed since: the file itself, or a module that it imports, directly or through others. A file may also run in slices
(`make verify SLICE=k/n LEDGER=1`), one after the other: those that ran with the same code make up one entry.
"""

import csv
import hashlib
import io
import re
import subprocess
import sys
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Final

import pytest

from quickreturn.reference_model.imported_modules import imported_modules, source_of

ROOT: Final = Path(__file__).resolve().parents[1]
LEDGER: Final = ROOT / "tests/verify_ledger.csv"
#: What shows that a file has long tests: the mark, or laws, each of which has a long form.
_LONG: Final = re.compile(r"^[ \t@]*[^#\n]*(?:mark\.verify|properties\.law import)", re.MULTILINE)


@dataclass(frozen=True)
class Entry:
    """The last run of a file's long tests.

    Attributes:
        group: the file, relative to the checkout.
        commit: of the checkout, abbreviated.
        code: hash of the file and of all modules that it imports.
        seconds: wall time of its tests, added up.
        passed: number of cases; likewise `failed` and `skipped`.
        slices: those that ran, such as "0 3 7/12"; "" where all cases ran at once.
    """

    group: str
    commit: str
    code: str
    seconds: int
    passed: int = 0
    failed: int = 0
    skipped: int = 0
    slices: str = ""

    @property
    def outcome(self) -> str:
        """Numbers of cases, such as "3 passed, 1 failed"."""
        counts = {"passed": self.passed, "failed": self.failed, "skipped": self.skipped}
        return ", ".join(f"{count} {name}" for name, count in counts.items() if count) or "no case"

    @property
    def missing(self) -> list[int]:
        """The slices that have not run."""
        ran, count = _slices(self.slices)
        return sorted(set(range(count)) - ran)

    def after(self, earlier: "Entry | None") -> "Entry":
        """The entry of this run and of the slices that ran before with the same code; of a slice that ran twice the first counts."""
        if earlier is None or earlier.code != self.code or not self.slices:
            return self
        (ran, count), (before, count_before) = _slices(self.slices), _slices(earlier.slices)
        if ran <= before or count_before == 0:  # all that ran now had run
            return earlier if self.failed == 0 else self
        if count != count_before:
            return self
        return replace(
            self,
            seconds=self.seconds + earlier.seconds,
            passed=self.passed + earlier.passed,
            failed=self.failed + earlier.failed,
            skipped=self.skipped + earlier.skipped,
            slices=" ".join(str(each) for each in sorted(ran | before)) + f"/{count}",
        )


def _slices(text: str) -> tuple[set[int], int]:
    """Numbers and count of "0 3 7/12"; of "" none of none."""
    numbers, _, count = text.partition("/")
    return {int(each) for each in numbers.split()}, int(count or 0)


def read(ledger: Path = LEDGER) -> dict[str, Entry]:
    """The entries by their groups; none if there is no ledger."""
    if not ledger.is_file():
        return {}
    rows = csv.DictReader(io.StringIO(ledger.read_text("utf-8")))
    whole = ("seconds", "passed", "failed", "skipped")
    return {row["group"]: Entry(**row | {name: int(row[name]) for name in whole}) for row in rows}


def write(entries: Iterable[Entry], ledger: Path = LEDGER) -> None:
    """Write the ledger, sorted by groups."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [field.name for field in fields(Entry)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(asdict(entry) for entry in sorted(entries, key=lambda entry: entry.group))
    ledger.write_text(text.getvalue(), "utf-8")


def source(root: Path, module: str) -> Path | None:
    """The file of a module of the package or of the tests."""
    if module.partition(".")[0] != "tests":
        return source_of(module)
    place = root.joinpath(*module.split("."))
    return next((file for file in (place / "__init__.py", place.with_suffix(".py")) if file.is_file()), None)


def code_of(group: str, root: Path = ROOT) -> str:
    """Hash of a file of tests and of all modules that it imports."""
    digest = hashlib.sha256()
    for module, file in imported_modules([group.removesuffix(".py").replace("/", ".")], find=partial(source, root)).items():
        digest.update(f"{module} {hashlib.sha256(file.read_bytes()).hexdigest()}\n".encode())
    return digest.hexdigest()[:16]


def commit(root: Path = ROOT) -> str:
    """The checkout's commit, abbreviated; "" without git."""
    try:
        found = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=root, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return ""
    return found.stdout.strip()


def long_files(root: Path = ROOT) -> list[str]:
    """Files that have long tests, relative to the checkout."""
    files = sorted((root / "tests").rglob("test_*.py"))
    return [file.relative_to(root).as_posix() for file in files if _LONG.search(file.read_text("utf-8"))]


def stale(entries: dict[str, Entry], groups: Iterable[str], code: Callable[[str], str] = code_of) -> dict[str, str]:
    """Groups that should run again, each with the reason."""
    found = {}
    for group in groups:
        entry = entries.get(group)
        if entry is None:
            found[group] = "is not in the ledger"
        elif entry.code != code(group):
            found[group] = f"code has changed since {entry.commit}; it took {entry.seconds} s"
        elif entry.failed:
            found[group] = f"{entry.outcome} at {entry.commit}"
        elif entry.missing:
            found[group] = f"slices {', '.join(map(str, entry.missing))} have not run"
    return found


class Ledger:
    """Plugin that enters each file of which every long test has run, or every one of a slice ("3/12"; "" without)."""

    def __init__(self, file: Path = LEDGER, root: Path = ROOT, part: str = "") -> None:
        self.file, self.root, self.part = file, root, part
        self.outcomes: dict[str, list[str]] = {}
        self.seconds: dict[str, float] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count a case, and its time."""
        group = report.nodeid.partition("::")[0]
        self.seconds[group] = self.seconds.get(group, 0.0) + report.duration
        if report.when == "call" or report.outcome != "passed":
            self.outcomes.setdefault(group, []).append(report.outcome)

    def pytest_sessionfinish(self, exitstatus: int) -> None:
        """Write the ledger, unless the run was interrupted."""
        if exitstatus not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
            return
        at = commit(self.root)
        entries = read(self.file)
        groups = long_files(self.root)
        for group in groups if self.part else self.outcomes:  # a file with no case in a slice has nothing left to run in it
            outcomes = self.outcomes.get(group, [])
            counts = (outcomes.count(name) for name in ("passed", "failed", "skipped"))
            ran = Entry(group, at, code_of(group, self.root), round(self.seconds.get(group, 0.0)), *counts, slices=self.part)
            entries[group] = ran.after(entries.get(group))
        write((entry for entry in entries.values() if entry.group in groups), self.file)


def keeps(config: pytest.Config) -> bool:
    """Whether a run enters its files: it was asked to, and leaves out none of their long tests. UsageError: it was asked to, and would."""
    if not config.getoption("--keep-ledger"):
        return False
    partial_run = [name for name in ("--begin-within", "-k") if config.getoption(name)]
    partial_run += [argument for argument in config.args if "::" in argument]
    if partial_run or config.getoption("-m") != "verify":
        without = ", ".join(partial_run) or "another -m"
        raise pytest.UsageError(f"--keep-ledger needs all long tests of a file: -m verify, without {without}")
    return True


def main() -> int:
    """List what should run again."""
    entries, groups = read(), long_files()
    found = stale(entries, groups)
    for group, reason in found.items():
        sys.stdout.write(f"{group}: {reason}\n")
    sys.stdout.write(f"{len(groups) - len(found)} of {len(groups)} files of long tests ran with the code as it is\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
