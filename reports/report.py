"""The report: engines on cases, studies and tables, put together into one page with its CSV files beside it."""

import contextlib
import csv
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from cases import conformance
from cases.benchmark import SCENES, Benchmark, stored
from cases.case import Case
from cases.case_file import load_case
from cases.errors import shortened
from cases.frozen_crank import FrozenCrank, frozen_crank
from cases.jobs.job import Job
from cases.jobs.key import SIMULATION, code_fingerprint
from cases.jobs.store import words_of
from cases.jobs.workshop import Workshop
from cases.judging.matrix import Matrix
from cases.library import catalogue
from cases.library.hard import TAG
from cases.recorded import RecordedTable, experiment_tables
from cases.runs.comparison import REFERENCE, CaseResult, cross_validate
from cases.runs.request import CODE, Run
from cases.studies import ACCURACY_CASE, OPEN_RUNS, Studies, run_studies, work
from engines.registry import MAIN
from reports import long_studies
from reports.findings.runs import of_run, run_number
from reports.machine import machine_facts
from reports.output import OutputError, write_file
from reports.page.chapters import chapters_of
from reports.page.content import Content
from reports.page.facts.methods import stored_matrix
from reports.page.render import report_page
from reports.tables.table import Table
from reports.verification import verification as stored_verification

PAGE: Final = "index.html"
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
    def unusable(self) -> list[tuple[str, Run]]:
        """Recorded tables that cannot be held against the steady state, with their cases."""
        return [(result.case.name, run) for result in self.content.results for run in result.recorded.values() if not run.usable]

    @property
    def failed(self) -> bool:
        """Whether an engine did not complete a case. Studies change a case on purpose: what they cannot make is told in the page."""
        return bool(self.unusable) or any(trouble.is_failure for trouble in self.content.troubles)


def check_folder(folder: Path) -> None:
    """Find out now whether the report can be written to a folder later, and create it.

    Raises:
        OutputError: it is a file, or cannot be created or written to.
    """
    try:
        if folder.exists() and not folder.is_dir():
            raise OutputError(f"{shortened(str(folder))}: this is a file; give a folder")
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        if (folder / PAGE).is_dir():
            raise OutputError(f"{shortened(str(folder))}: {PAGE} in it is a folder; give another folder")
    except (OSError, ValueError) as error:  # ValueError: a null byte
        reason = words_of(error) if isinstance(error, OSError) else "no file name can hold its characters"
        raise OutputError(f"{shortened(str(folder))}: it cannot be written ({reason})") from error


def write_report(
    cases: Sequence[Case],
    folder: Path,
    workshop: Workshop,
    engines: Sequence[str] = MAIN,
    tables: Mapping[str, Sequence[RecordedTable]] | None = None,
) -> Written:
    """Compute what is missing, and write the page and its tables.

    Args:
        cases: at least one.
        folder: where it goes; it is created, and found out about before anything runs (see `check_folder`).
        workshop: where results are computed and kept.
        engines: names.
        tables: case -> what was recorded of it, beside the recordings of the experiment.

    Raises:
        CaseError: a recorded table that cannot be read or is not of its case; nothing has been computed then.
        OutputError: page or tables cannot be written.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    check_folder(folder)
    recorded = {case: [*found] for case, found in (tables or {}).items()}
    for table in experiment_tables():
        recorded.setdefault(table.declared["case"], []).append(table)
    studied = _studied(cases)
    results = cross_validate(cases, workshop, engines, tables=recorded, beside=work() if studied else None)
    studies, confirmation_recorded = _studies(workshop) if studied else (None, False)
    benchmarks, benchmarks_recorded = _benchmarks(cases, workshop, studied)
    matrix, matrix_recorded = _hard_scenes(workshop) if studied else (None, False)
    of_record = {"benchmark": benchmarks_recorded, "hard scenes": matrix_recorded, "confirmation": confirmation_recorded}
    example = of_run(results, EXAMPLE) if EXAMPLE else None
    found, missing = _frozen_crank(example, workshop)
    content = Content(
        results=results,
        studies=studies,
        benchmarks=benchmarks,
        frozen_crank=found,
        hard_scenes=matrix,
        of_record={study: about for study, taken in of_record.items() if taken and (about := long_studies.about(study))},
        verification=stored_verification(workshop.store.folder),
        conformance=_conformance(engines, workshop),
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
    write_file(folder / PAGE, report_page(content, chapters).encode())
    for name in stale:
        with contextlib.suppress(OSError):  # what cannot be removed stays: it is not linked from the page
            (folder / name).unlink()
    return Written(folder / PAGE, content, tables)


def _conformance(engines: Sequence[str], workshop: Workshop) -> dict[str, str]:
    """The verdicts that are stored."""
    found = {name: workshop.stored(conformance.job(name)) for name in engines}
    return {name: outcome.value.verdict for name, outcome in found.items() if outcome is not None and outcome.value is not None}


def _frozen_crank(example: CaseResult | None, workshop: Workshop) -> tuple[FrozenCrank | None, list[str]]:
    """What is known of the example run with its crank held, and why nothing is, if it could not be computed."""
    if example is None:
        return None, []
    reference = example.runs.get(REFERENCE)
    cycle = {name: reference.cycle[name] for name in ("crank_angle", "time")} if reference is not None and reference.usable else {}
    job = Job("frozen crank", frozen_crank, (example.case.mechanism, cycle), kind="frozen crank", code=("cases.frozen_crank",))
    (outcome,) = workshop.outcomes([job], "frozen-crank frequencies")
    if outcome.value is not None:
        return outcome.value, []
    return None, [f"{example.case.name}: the frozen-crank frequencies could not be computed: {outcome.explanation}"]


def _studied(cases: Sequence[Case]) -> bool:
    """Whether the report is about all runs that the studies are about."""
    return {ACCURACY_CASE, *OPEN_RUNS} <= {case.name for case in cases if case.source == "library"}


def _studies(workshop: Workshop) -> tuple[Studies, bool]:
    """All studies; where no confirming solutions are stored, those of record are taken, and the second value is true."""
    found = run_studies(workshop)
    if found.confirming:
        return found, False
    return replace(found, confirming=(recorded := long_studies.confirming())), bool(recorded)


def _benchmarks(cases: Sequence[Case], workshop: Workshop, studied: bool) -> tuple[list[Benchmark], bool]:
    """What was measured last of the cases shown, or with `studied` of the scenes on which methods are compared.

    Of these the recorded results are taken where there are no others; the second value says whether any were.
    """
    known = long_studies.benchmarks() if studied else {}
    found, of_record = [], False
    for case in [load_case(name) for name in SCENES] if studied else cases:
        own = stored(case, workshop)
        table = own or known.get(case.name)
        if table is not None:
            found.append(table)
            of_record |= own is None
    return found, of_record


def _hard_scenes(workshop: Workshop) -> tuple[Matrix | None, bool]:
    """The stored matrix of the hard scenes, else the recorded one; the second value says whether it is that."""
    own = stored_matrix(workshop)
    return (own, False) if own is not None else (long_studies.matrix([load_case(entry.name) for entry in catalogue(TAG)]), True)


def _earlier_tables(folder: Path) -> set[str]:
    """CSV files of an earlier report in the folder, by its own list; plain names only."""
    try:
        rows = list(csv.DictReader((folder / CATALOGUE).read_text("utf-8").splitlines()))
    except (OSError, ValueError, csv.Error):
        return set()
    names = {str(row.get("file") or "") for row in rows} | {CATALOGUE}
    return {name for name in names if name.endswith(".csv") and Path(name).name == name}
