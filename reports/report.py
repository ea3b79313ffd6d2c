"""Computes a report: engines on cases, studies and tables, on one page with its CSV files beside it."""

import contextlib
import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from quickreturn.cases import conformance
from quickreturn.cases.benchmark import SCENES, compiling, stored
from quickreturn.cases.benchmark.scenes import ENGINES
from quickreturn.cases.case import Case
from quickreturn.cases.case_file import load_case
from quickreturn.cases.jobs.job import Job
from quickreturn.cases.jobs.key import code_of
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.judging.matrix import judge_scenes
from quickreturn.cases.library import catalogue
from quickreturn.cases.library.hard import TAG
from quickreturn.cases.measures.number import SAYS_NOTHING
from quickreturn.cases.recorded import RecordedTable
from quickreturn.cases.runs.campaign import Work, cross_validate
from quickreturn.cases.runs.comparison import CaseResult, agreement
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.runs.request import Run
from quickreturn.cases.runs.steady_state import steady_state
from quickreturn.cases.studies import ACCURACY_CASE, run_studies, work
from quickreturn.engines.registry import MAIN, engine
from quickreturn.reports import long_studies
from quickreturn.reports.machine import machine_facts
from quickreturn.reports.output import check_folder, write_file
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.render import report_page
from quickreturn.reports.results.around import curves_around, jobs_around
from quickreturn.reports.results.runs import settled_speed
from quickreturn.reports.tables.table import Table
from quickreturn.reports.verification import verification as stored_verification
from quickreturn.reports.words import TIED, counted

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
    def unusable(self) -> list[tuple[str, Run]]:
        """Recorded tables that cannot be compared in the steady state, with their cases."""
        return [(result.case.name, run) for result in self.content.results for run in result.recorded.values() if not run.usable]

    @property
    def incomplete(self) -> list[tuple[str, Run]]:
        """Runs that an engine did not complete. Studies change a case on purpose, so the page reports their failures instead."""
        return [(case, run) for case, run in self.content.troubles if run.ending.incomplete]

    @property
    def inaccurate(self) -> list[tuple[str, Run]]:
        """Runs whose own estimates miss the accuracy asked, with their cases."""
        return [(case, run) for case, run in self.content.troubles if run.status == Ending.INACCURATE]

    @property
    def failed(self) -> bool:
        """Whether an engine did not complete a case or missed its accuracy, or a table cannot be used: as in `run`."""
        return bool(self.unusable or self.incomplete or self.inaccurate)

    @property
    def summary(self) -> str:
        """Lines: the page, what was simulated and how it ended, where engines differ, and the number of tables."""
        content = self.content
        runs = sum(len(result.runs) for result in content.results)
        made = f"{counted(len(content.results), 'case')}, {counted(runs, 'simulation')}".replace(TIED, " ")
        neutral = sum(run.status == Ending.NEUTRAL for _, run in content.troubles)
        further = f", {neutral} neutral" if neutral else ""
        missed = f", {len(self.inaccurate)} missed their accuracy" if self.inaccurate else ""
        ended = f"{made}: {runs - len(content.troubles)} settled{further}{missed}, {len(self.incomplete)} did not complete"
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
    content_type: type[Content] = Content,
) -> Written:
    """Compute what is missing, and write the page and its tables.

    Args:
        cases: at least one.
        folder: folder of the page; it is created and checked before anything runs (see `reports.output.check_folder`).
        workshop: processes and store.
        engines: names of engines.
        tables: case -> its recorded tables, besides those of `content_type.recordings`.
        accuracy: error of the tip deflection asked of every engine; None: each engine's default.
        settings: engine -> setting -> value as text.
        content_type: `Content`, or its subclass for cases with chapters of their own.

    Raises:
        CaseError: a recorded table cannot be read or is not of its case; nothing has been computed.
        OutputError: page or tables cannot be written.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    check_folder(folder, PAGE)
    recorded = {case: [*given] for case, given in (tables or {}).items()}
    for table in content_type.recordings():
        recorded.setdefault(table.declared["case"], []).append(table)
    own_cases = cases if content_type.is_own else []
    other_jobs = work(engines) if _studied(cases) else Work(jobs=[job for job in jobs_around(own_cases).values() if isinstance(job, Job)])
    results = cross_validate(cases, workshop, engines, accuracy, settings, recorded, other_jobs)
    further, missing = content_type.further(results, workshop)
    content = content_type(
        results=results,
        **_studies(cases, workshop, engines),
        **further,
        verification=stored_verification(workshop.store.folder),
        conformance=_conformance(engines, workshop),
        facts=machine_facts(),
        code=code_of(steady_state),
        notices=(*missing, *workshop.store.notices),
        around=curves_around(own_cases, workshop, {result.case.name: settled_speed(result) for result in results}),
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


def _conformance(engines: Sequence[str], workshop: Workshop) -> dict[str, str]:
    """Engine -> verdict on whether it does what it says: the user's stored one, else the recorded one."""
    outcomes = {name: workshop.stored(conformance.job(name)) for name in engines}
    judged = {name: outcome.value for name, outcome in outcomes.items() if outcome is not None and outcome.value is not None}
    own_verdicts = {name: long_studies.ConformanceRow.of(value, engine(name).version()).words for name, value in judged.items()}
    return long_studies.conformance() | own_verdicts


def _studied(cases: Sequence[Case]) -> bool:
    """Whether the studies belong to the report: the library's case that they are about is among its cases."""
    return ACCURACY_CASE in {case.name for case in cases if case.source == "library"}


def _studies(cases: Sequence[Case], workshop: Workshop, engines: Sequence[str]) -> dict[str, Any]:
    """The studies as fields of `Content`: the user's own results, or the recorded ones where the user has none.

    A report without the case of the studies has only the stored benchmarks of its own cases.
    """
    if not _studied(cases):
        return {"benchmarks": [table for case in cases if (table := stored(case, workshop))]}
    scenes = [load_case(entry.name) for entry in catalogue(TAG)]
    studies, matrix = run_studies(workshop, engines), judge_scenes(scenes, workshop.as_it_is)
    own_benchmarks, recorded_benchmarks = {name: stored(load_case(name), workshop) for name in SCENES}, long_studies.benchmarks()
    of_record = {
        "confirmation": not studies.confirming,
        "benchmark": any(own_benchmarks[name] is None and name in recorded_benchmarks for name in SCENES),
        "hard scenes": not matrix.cells,
    }
    return {
        "studies": studies if studies.confirming else replace(studies, confirming=long_studies.confirming()),
        "benchmarks": [table for name in SCENES if (table := own_benchmarks[name] or recorded_benchmarks.get(name))],
        "compiling": compiling(workshop.as_it_is, ENGINES) or long_studies.compiling(),
        "hard_scenes": matrix if matrix.cells else long_studies.matrix(scenes),
        "classes": long_studies.class_map(),
        "as_built": long_studies.built(),
        "of_record": {
            study: about for study in long_studies.STUDIES if of_record.get(study, True) and (about := long_studies.about(study))
        },
    }


def _earlier_tables(folder: Path) -> set[str]:
    """CSV files of an earlier report in the folder, by its own list; plain names only."""
    try:
        rows = list(csv.DictReader((folder / CATALOGUE).read_text("utf-8").splitlines()))
    except (OSError, ValueError, csv.Error):
        return set()
    names = {str(row.get("file") or "") for row in rows} | {CATALOGUE}
    return {name for name in names if name.endswith(".csv") and Path(name).name == name}
