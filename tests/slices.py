"""Runs the long tests in slices: `pytest -m verify --slice k/n --begin-within MINUTES`.

A slice keeps the groups whose checksum, by the remainder of a division by n, belongs to k. A group is one case, or all cases of a file
where these share what is costly: a fixture of the whole file, or a cache. Cases marked `every_slice` belong to all slices. Each group
goes to one process with `--dist loadgroup`. The number k also draws what a test computes in a slice where everything would take too long
(`portion`). After the minutes no further test begins: those that are left are skipped, and named at the end.
"""

import itertools
import random
import re
import time
import zlib
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import pytest

from quickreturn.cases.running.key import names_imported

T = TypeVar("T")

#: Chooses so many of a sequence, or all (the fixture `portion`).
Portion = Callable[[Iterable[Any], int], list[Any]]
#: What shows that cases of a file share something: a cached function in it, a fixture that lives as long as the file's tests.
_CACHE = re.compile(r"^@(?:functools\.)?cache\b", re.MULTILINE)
_FIXTURE = re.compile(r"^@pytest\.fixture\(.*scope=\"module\"", re.MULTILINE)
#: End of the names of files whose tests share a browser.
IN_A_BROWSER = "_in_a_browser.py"
UNREACHED = "not begun: the slice's time is over"

#: The files of quick tests that take longest come first, so that no process is left alone with one at the end.
LONGEST = (
    "test_documents",
    "test_faults",  # waits for time limits
    "test_conformance",
    "test_page_in_a_browser",
    "test_bad_input",
    "test_package",
    "test_derived_engine",
    "test_engine",
    "test_stability",
    "test_compare",
    "test_several",
    "test_thesis_equations",
    "test_beam_equations",
    "test_race",
    "test_tables",
    "test_rods",
    "test_causes",
    "test_page",
    "test_slices",  # starts pytest
    "test_fork_server",  # waits, too
    "test_limits",
    "test_symmetry",
    "test_fmu",
    "test_uncertainty",
    "test_report",
)


class Slice:
    """A slice of all groups: those that belong to the remainder of `number` (k, of any size) by `count` (n)."""

    def __init__(self, text: str) -> None:
        number, _, count = text.partition("/")
        if not (number.isdecimal() and count.isdecimal() and int(count) > 0):
            raise pytest.UsageError(f"--slice {text}: expected two whole numbers k/n, such as 3/12; n is at least 1")
        self.number, self.count = int(number), int(count)

    def __str__(self) -> str:
        return f"{self.number % self.count}/{self.count}"

    def holds(self, group: str) -> bool:
        """Whether a group belongs to it."""
        return zlib.crc32(group.encode()) % self.count == self.number % self.count

    def drawn(self, everything: Iterable[T], count: int) -> list[T]:
        """So many of a sequence, in its order; the next slices with the same groups draw others."""
        listed = list(everything)
        places = list(range(len(listed)))
        random.Random(0).shuffle(places)
        first = self.number // self.count * count
        chosen = itertools.islice(itertools.cycle(places), first % len(places), None) if places else iter(())
        return [listed[place] for place in sorted(itertools.islice(chosen, min(count, len(listed))))]


def add_options(parser: pytest.Parser) -> None:
    """The options of the command line."""
    parser.addoption("--slice", metavar="K/N", help="only the groups of tests whose checksum, modulo N, is K modulo N")
    parser.addoption("--begin-within", type=float, metavar="MINUTES", help="begin no test later; those left are named, and skipped")


def slice_of(config: pytest.Config) -> Slice | None:
    """The slice that was asked for, if any. UsageError: it is not understood."""
    text = config.getoption("--slice")
    return None if text is None else Slice(text)


def group_of(case: str, root: Path) -> str:
    """The group of a case, which is given by its name: its file, where that shares what is costly, or itself."""
    file = case.partition("::")[0]
    return file if shares(root / file, root) else case


@cache
def shares(file: Path, root: Path) -> bool:
    """Whether the cases of a file share something: a cache, or a fixture of its own or of a module of the tests that it imports."""
    text = file.read_text("utf-8")
    helpers = (root / f"{name.replace('.', '/')}.py" for name in names_imported(text) if name.startswith("tests."))
    return bool(_CACHE.search(text)) or any(
        _FIXTURE.search(each) for each in (text, *(helper.read_text("utf-8") for helper in helpers if helper.is_file()))
    )


class Slices:
    """The plugin."""

    def __init__(self, config: pytest.Config) -> None:
        self.slice = slice_of(config)
        minutes = config.getoption("--begin-within")
        self.end = float("inf") if minutes is None else time.monotonic() + 60.0 * minutes
        self.unreached: list[str] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """Keep the slice's groups."""
        if self.slice is not None:
            chosen = [
                item for item in items if item.get_closest_marker("every_slice") or self.slice.holds(group_of(item.nodeid, config.rootpath))
            ]
            config.hook.pytest_deselected(items=[item for item in items if item not in chosen])
            items[:] = chosen

    @pytest.hookimpl(optionalhook=True, tryfirst=True)
    def pytest_xdist_make_scheduler(self, config: pytest.Config, log: Any) -> Any:
        """With `--dist loadgroup`, deal out groups: xdist's own way marks names of cases, which pytest no longer allows.

        Of the quick tests only the longest files are dealt out by cases; the others stay whole, for helpers keep what they compute, and
        one process has all tests in a browser.
        """
        if config.getoption("dist") != "loadgroup":
            return None
        from xdist.scheduler import LoadScopeScheduling

        long = config.getoption("-m") == "verify"

        class Groups(LoadScopeScheduling):  # type: ignore[misc]
            def _split_scope(self, nodeid: str) -> str:
                file = nodeid.partition("::")[0]
                if not long and file.endswith(IN_A_BROWSER):
                    return IN_A_BROWSER
                return group_of(nodeid, config.rootpath) if long or Path(file).stem in LONGEST else file

        return Groups(config, log)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Begin no test after the time."""
        if time.monotonic() > self.end:
            pytest.skip(UNREACHED)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Remember what was not reached."""
        if report.skipped and isinstance(report.longrepr, tuple) and UNREACHED in report.longrepr[2]:
            self.unreached.append(report.nodeid)

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Name what was not reached."""
        if self.unreached:
            terminalreporter.section(f"{len(self.unreached)} not begun, for the time was over")
            for name in sorted(self.unreached):
                terminalreporter.write_line(name)

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """A slice to which no test belongs ends well."""
        if self.slice is not None and session.exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
            session.exitstatus = pytest.ExitCode.OK
