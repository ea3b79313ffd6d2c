"""The ledger of the long tests: with which code each of them last ran, and what came of it.

A run of long tests (`pytest -m verify`, of all, a slice or a few) enters each that ran in `verify_ledger.csv` in the store's folder.
`make verify-status` lists the files with tests that have not run since their code changed: the file itself, or a module that it imports,
directly or through others.
"""

import csv
import hashlib
import io
import subprocess
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, fields
from functools import cache, partial
from pathlib import Path
from typing import Final

import pytest

from quickreturn.cases.running.key import imported_modules, source_of
from quickreturn.cases.running.store import Store, write_atomically

ROOT: Final = Path(__file__).resolve().parents[1]
FILE: Final = "verify_ledger.csv"


@dataclass(frozen=True)
class Entry:
    """The last run of a long test."""

    test: str  # its name, which begins with its file, relative to the checkout
    commit: str  # of the checkout, abbreviated
    code: str  # hash of the file and of all modules that it imports
    seconds: float  # wall time
    outcome: str  # "passed", "failed" or "skipped"


def read(ledger: Path) -> dict[str, Entry]:
    """The entries by their tests; none if there is no ledger."""
    if not ledger.is_file():
        return {}
    rows = csv.DictReader(io.StringIO(ledger.read_text("utf-8")))
    return {row["test"]: Entry(**row | {"seconds": float(row["seconds"])}) for row in rows}


def write(entries: Iterable[Entry], ledger: Path) -> None:
    """Write the ledger, sorted by tests."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [field.name for field in fields(Entry)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(asdict(entry) for entry in sorted(entries, key=lambda entry: entry.test))
    write_atomically(ledger, text.getvalue().encode())


def file_of(test: str) -> str:
    """The file of a test, relative to the checkout."""
    return test.partition("::")[0]


def source(root: Path, module: str) -> Path | None:
    """The file of a module of the package or of the tests."""
    if module.partition(".")[0] != "tests":
        return source_of(module)
    place = root.joinpath(*module.split("."))
    return next((file for file in (place / "__init__.py", place.with_suffix(".py")) if file.is_file()), None)


def code_of(file: str, root: Path = ROOT) -> str:
    """Hash of a file of tests and of all modules that it imports."""
    digest = hashlib.sha256()
    for module, found in imported_modules([file.removesuffix(".py").replace("/", ".")], find=partial(source, root)).items():
        digest.update(f"{module} {hashlib.sha256(found.read_bytes()).hexdigest()}\n".encode())
    return digest.hexdigest()[:16]


def commit(root: Path = ROOT) -> str:
    """The checkout's commit, abbreviated; "" without git."""
    try:
        found = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=root, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return ""
    return found.stdout.strip()


def status(entries: dict[str, Entry], tests: Iterable[str], code: Callable[[str], str] = code_of) -> list[str]:
    """A line for each file with tests that should run again, and why; the last one says how many need not."""
    code, files, good, count = cache(code), dict[str, Counter[str]](), 0, 0
    for count, test in enumerate(tests, 1):  # noqa: B007 - the last one is the number of all
        entry = entries.get(test)
        if entry is None:
            reason = "never ran"
        elif entry.code != code(file_of(test)):
            reason = f"ran at {entry.commit}, with other code"
        elif entry.outcome != "passed":
            reason = f"{entry.outcome} at {entry.commit}"
        else:
            good += 1
            continue
        files.setdefault(file_of(test), Counter())[reason] += 1
    lines = [f"{file}: {'; '.join(f'{number} {reason}' for reason, number in reasons.items())}" for file, reasons in files.items()]
    return [*lines, f"{good} of {count} long tests passed with the code as it is"]


class Ledger:
    """Plugin that enters each long test that ran, and none that was skipped for the reason `unreached`."""

    def __init__(self, unreached: str, root: Path = ROOT) -> None:
        self.unreached = unreached
        self.commit = commit(root)
        self.code = cache(partial(code_of, root=root))  # as the file's first test finds it: it may change during hours of tests
        self.entries: dict[str, Entry] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Remember the outcome of a test, which has passed if all its parts have, and its time."""
        if report.skipped and self.unreached in str(report.longrepr):
            return
        before = self.entries.get(report.nodeid)
        outcome = report.outcome if before is None or before.outcome == "passed" else before.outcome
        seconds = round(report.duration + (before.seconds if before else 0.0), 2)
        self.entries[report.nodeid] = Entry(report.nodeid, self.commit, self.code(file_of(report.nodeid)), seconds, outcome)

    def pytest_sessionfinish(self) -> None:
        """Write the ledger."""
        if self.entries:
            ledger = Store().folder / FILE
            write((read(ledger) | self.entries).values(), ledger)


class Status:
    """Plugin that tells which of the tests chosen should run again, and runs none."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Compare in place of running."""
        self.lines = status(read(Store().folder / FILE), [item.nodeid for item in session.items])
        return True

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Print the lines."""
        for line in self.lines:
            terminalreporter.write_line(line)
