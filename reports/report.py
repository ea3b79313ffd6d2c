"""The report: engines on cases, studies, pictures and tables, put together into one page with its CSV files beside it."""

import contextlib
import csv
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from cases.benchmark import SCENES, Benchmark, measure, stored
from cases.case import Case
from cases.case_file import load_case
from cases.errors import shortened
from cases.experiment import load_curves
from cases.jobs.job import Job
from cases.jobs.key import SIMULATION, code_fingerprint
from cases.jobs.store import words_of
from cases.jobs.workshop import Workshop
from cases.runs.comparison import CaseResult, cross_validate
from cases.runs.request import CODE
from cases.studies import ACCURACY_CASE, OPEN_RUNS, run_studies, work
from engines.base import EngineFailure, Refusal
from engines.registry import MAIN
from reports.findings.evidence import Evidence, NoEvidence, evidence
from reports.findings.measured import measured_comparisons
from reports.findings.runs import of_run, run_number
from reports.machine import machine_facts
from reports.output import OutputError, write_file
from reports.page import page
from reports.pages.answer import answer
from reports.pages.blocks import Chapter
from reports.pages.comparison import disagreement, runs_by_engines
from reports.pages.content import Content
from reports.pages.experiment import experiment, published
from reports.pages.hard_scenes import hard_scenes, stored_matrix
from reports.pages.methods import methods
from reports.pages.per_run import per_run
from reports.pages.provenance import files, provenance, verification
from reports.pages.studies import accuracy_and_cost, open_points
from reports.pages.thesis_view import thesis_view
from reports.pictures import draw_pictures, jobs_of_cases
from reports.tables.provenance import catalogue
from reports.tables.table import Table
from reports.verification import verification as stored_verification

PAGE: Final = "index.html"
#: Solve time (s) beyond which a report that must measure methods itself does not try finer settings.
QUICK: Final = 1.0
#: The list of all CSV files, by which the next report in the same folder knows which files are an earlier report's.
CATALOGUE: Final = "tables.csv"
#: The run that the thesis shows as its example.
EXAMPLE: Final = run_number(ACCURACY_CASE)


@dataclass(frozen=True)
class Written:
    """What a report left behind: the page, and what is in it."""

    page: Path
    content: Content
    tables: tuple[Table, ...]

    @property
    def failed(self) -> bool:
        """Whether an engine did not complete a case. Studies change a case on purpose: what they cannot make is told in the page."""
        return any(trouble.is_failure for trouble in self.content.troubles)


def check_folder(folder: Path) -> None:
    """Find out now whether the report can be written to a folder later, and create it.

    Raises:
        OutputError: it is a file, or cannot be created or written to.
    """
    try:
        if folder.exists() and not folder.is_dir():
            raise OutputError(f"--output {shortened(str(folder))}: this is a file; give a folder")
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        if (folder / PAGE).is_dir():
            raise OutputError(f"--output {shortened(str(folder))}: {PAGE} in it is a folder; give another folder")
    except (OSError, ValueError) as error:  # ValueError: a null byte
        reason = words_of(error) if isinstance(error, OSError) else "no file name can hold its characters"
        raise OutputError(f"--output {shortened(str(folder))}: it cannot be written ({reason})") from error


def write_report(cases: Sequence[Case], folder: Path, workshop: Workshop, engines: Sequence[str] = MAIN) -> Written:
    """Compute what is missing, and write the page and its tables.

    Args:
        cases: at least one.
        folder: where it goes; it is created, and found out about before anything runs (see `check_folder`).
        workshop: where results and pictures are computed and kept.
        engines: names.

    Raises:
        CaseError: a measured curve that breaks its documented form; nothing has been computed then.
        OutputError: page or tables cannot be written.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    check_folder(folder)
    curves = load_curves()
    studied = _studied(cases)
    results = cross_validate(cases, workshop, engines, beside=work() if studied else None)
    studies = run_studies(workshop) if studied else None
    drawings = [job for job in jobs_of_cases(results, curves) if workshop.stored(job) is None]
    benchmarks = _benchmarks(workshop, drawings) if studies is not None else []
    example = of_run(results, EXAMPLE) if EXAMPLE else None
    found, missing = _evidence(example, workshop)
    content = Content(
        results=results,
        studies=studies,
        benchmarks=benchmarks,
        evidence=found,
        curves=curves,
        comparisons=measured_comparisons(results, curves),
        pictures=draw_pictures(results, studies, benchmarks, curves, workshop),
        hard_scenes=stored_matrix(workshop),
        verification=stored_verification(workshop.store.folder),
        facts=machine_facts(),
        code=code_fingerprint((*SIMULATION, *CODE)),
        notices=(*missing, *workshop.store.notices),
    )
    return write(content, folder)


def write(content: Content, folder: Path) -> Written:
    """Write page and tables, and remove tables of an earlier report in the same folder that this one does not have.

    Raises:
        OutputError: something cannot be written.
    """
    chapters = chapters_of(content)
    tables = tuple(table for chapter in chapters for table in chapter.tables)
    stale = _earlier_tables(folder) - {table.file for table in tables}
    for table in tables:
        write_file(folder / table.file, table.csv().encode())
    write_file(folder / PAGE, page(chapters, content.facts.get("date", "")).encode())
    for name in stale:
        with contextlib.suppress(OSError):  # what cannot be removed stays: it is not linked from the page
            (folder / name).unlink()
    return Written(folder / PAGE, content, tables)


def chapters_of(content: Content) -> list[Chapter]:
    """All chapters in their order."""
    makers: tuple[Callable[[Content], Chapter], ...] = (
        answer, runs_by_engines, disagreement, thesis_view, methods, open_points,
        accuracy_and_cost, hard_scenes, experiment, published, per_run, provenance, verification,
    )  # fmt: skip
    chapters = [make(content) for make in makers]
    tables = [table for chapter in chapters for table in chapter.tables]
    about = {"date": content.facts.get("date", ""), "code": content.code}
    return [*chapters, files(content, catalogue(tables, about))]


def _evidence(example: CaseResult | None, workshop: Workshop) -> tuple[Evidence | None, list[str]]:
    """The evidence on the example run and why there is none, if it could not be computed."""
    try:
        return (None if example is None else evidence(example, workshop)), []
    except NoEvidence as reason:
        return None, [str(reason)]


def _studied(cases: Sequence[Case]) -> bool:
    """Whether the report is about all runs that the studies are about."""
    return {ACCURACY_CASE, *OPEN_RUNS} <= {case.name for case in cases if case.source == "library"}


def _benchmarks(workshop: Workshop, beside: Sequence[Job[Any]]) -> list[Benchmark]:
    """What was measured last of each scene; the first scene is measured now, once, if it never was, with other jobs beside it."""
    found = []
    for name in SCENES:
        case = load_case(name)
        table = stored(case, workshop)
        if table is None and name == SCENES[0]:
            with contextlib.suppress(EngineFailure, Refusal):  # the chapter says what is missing
                table = measure(case, workshop, repetitions=1, longest=QUICK, beside=beside)
        if table is not None:
            found.append(table)
    return found


def _earlier_tables(folder: Path) -> set[str]:
    """CSV files of an earlier report in the folder, by its own list; plain names only."""
    try:
        rows = list(csv.DictReader((folder / CATALOGUE).read_text("utf-8").splitlines()))
    except (OSError, ValueError, csv.Error):
        return set()
    names = {str(row.get("file") or "") for row in rows} | {CATALOGUE}
    return {name for name in names if name.endswith(".csv") and Path(name).name == name}
