"""Computes a report: engines on cases, studies and tables, on one page with its CSV files beside it."""

import contextlib
import csv
import datetime
import os
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Final

from quickreturn.cases.comparison.campaign import cross_validate
from quickreturn.cases.comparison.engines import CaseResult, agreement
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.number import SAYS_NOTHING
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.cases.running.isolation import available_cores
from quickreturn.cases.running.key import code_of
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import MAIN
from quickreturn.reports.output import check_folder, write_file
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.content import verification as stored_verification
from quickreturn.reports.page.part import parts
from quickreturn.reports.page.render import report_page
from quickreturn.reports.tables import Table
from quickreturn.reports.words import TIED, counted

#: Packages whose versions the report names besides those of the engines.
PACKAGES: Final = ("quickreturn", "numpy", "scipy", "numba", "pandas", "matplotlib", "pint")


def machine_facts() -> dict[str, str]:
    """Name of a fact -> the fact in words."""
    return {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "processor": _processor(),
        "cores": f"{available_cores()} usable of {os.cpu_count() or 'unknown'}",
        "memory": f"{os.sysconf('SC_PHYS_PAGES') * os.sysconf('SC_PAGE_SIZE') / 2**30:.1f} GiB",
        "system": _system(),
        "Python": f"{platform.python_implementation()} {platform.python_version()}",
        "packages": ", ".join(f"{name} {version(name)}" for name in PACKAGES),
    }


def version(package: str) -> str:
    """Version of a package, or "not installed"."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def _processor() -> str:
    with contextlib.suppress(OSError):
        cpu_info = Path("/proc/cpuinfo").read_text("utf-8", errors="replace")
        if model := re.search(r"^model name\s*:\s*(.+)$", cpu_info, re.MULTILINE):
            return model[1].strip()
    return platform.processor() or platform.machine() or "unknown"


def _system() -> str:
    try:
        name = platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        name = platform.system()
    return f"{name}, {platform.system()} {platform.release()}, {platform.machine()}"


PAGE: Final = "index.html"
#: The list of all CSV files. The next report in the same folder reads it, and removes the tables that it does not replace.
CATALOGUE: Final = "tables.csv"


@dataclass(frozen=True)
class Written:
    """A written report."""

    page: Path  # path of its page
    content: Content  # data behind the page
    tables: tuple[Table, ...]  # those written as CSV files beside the page

    @property
    def summary(self) -> str:
        """Lines: the page, what was simulated and how it ended, where engines differ, and the number of tables."""
        content = self.content
        runs = sum(len(result.runs) for result in content.results)
        made = f"{counted(len(content.results), 'case')}, {counted(runs, 'simulation')}".replace(TIED, " ")
        endings = [run.ending for _, run in content.troubles]
        told = {"neutral": endings.count(Ending.NEUTRAL), "missed their accuracy": endings.count(Ending.INACCURATE)}
        others = "".join(f", {count} {words}" for words, count in told.items() if count)
        incomplete = sum(ending.incomplete for ending in endings)
        ended = f"{made}: {runs - len(endings)} settled{others}, {incomplete} did not complete"
        return "\n".join((str(self.page), ended, _verdict(content.results), f"{len(self.tables)} tables as CSV beside the page"))


def _verdict(results: Sequence[CaseResult]) -> str:
    """The number of comparisons in which engines differ by more than they claim, or why there are no comparisons."""
    checks = [check for result in results for check in result.with_tables.checks]
    if not checks:
        return f"nothing could be judged: {'; '.join(dict.fromkeys(result.reason for result in results))}"
    counts = agreement(checks)
    silent = f"; {counts['says_nothing']} say nothing, for more is claimed than {SAYS_NOTHING}" if counts["says_nothing"] else ""
    return f"engines differ by more than they claim in {counts['disagree'] or 'none'} of {len(checks)} comparisons{silent}"


def write_report(
    cases: Sequence[Case],
    folder: Path,
    workshop: Workshop,
    engines: Sequence[str] = MAIN,
    tables: Mapping[str, Sequence[RecordedTable]] | None = None,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, str]] | None = None,
) -> Written:
    """Compute what is missing, and write the page and its tables.

    Args:
        cases: at least one.
        folder: folder of the page; it is created and checked before anything runs (see `reports.output.check_folder`).
        workshop: processes and store.
        engines: names of engines.
        tables: case -> its recorded tables, besides those of the report's subject.
        accuracy: error of the tip deflection asked of every engine; None: each engine's default.
        settings: engine -> setting -> value as text.

    Raises:
        CaseError: a recorded table cannot be read or is not of its case; nothing has been computed.
        OutputError: page or tables cannot be written.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    check_folder(folder, PAGE)
    content_type = next((kind for part in parts() if part.content and (kind := part.content(cases))), Content)
    recorded = {case: [*given] for case, given in (tables or {}).items()}
    for table in content_type.recordings():
        recorded.setdefault(table.declared["case"], []).append(table)
    results = cross_validate(cases, workshop, engines, accuracy, settings, recorded)
    content = content_type(
        results=results,
        engines=engines,
        workshop=workshop,
        verification=stored_verification(workshop.store.folder),
        facts=machine_facts(),
        code=code_of(steady_state),
        notices=workshop.store.notices,
    )
    return write(content, folder)


def write(content: Content, folder: Path) -> Written:
    """Write page and tables, and remove tables of an earlier report in the same folder that are not in this one.

    Raises:
        OutputError: something cannot be written.
    """
    chapters = list(chapters_of(content))
    tables = tuple(table for chapter in chapters for table in chapter.tables)
    stale = _earlier_tables(folder) - {table.file for table in tables}
    for table in tables:
        write_file(folder / table.file, table.csv().encode())
    write_file(folder / PAGE, report_page(content, chapters).encode())
    for name in stale:
        with contextlib.suppress(OSError):  # a file that cannot be removed stays: the page does not link it
            (folder / name).unlink()
    return Written(folder / PAGE, content, tables)


def _earlier_tables(folder: Path) -> set[str]:
    """CSV files of an earlier report in the folder, by its own list; plain names only."""
    try:
        rows = list(csv.DictReader((folder / CATALOGUE).read_text("utf-8").splitlines()))
    except (OSError, ValueError, csv.Error):
        return set()
    names = {str(row.get("file") or "") for row in rows} | {CATALOGUE}
    return {name for name in names if name.endswith(".csv") and Path(name).name == name}
