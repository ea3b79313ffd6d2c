"""Write the tables: `python -m reports.long_studies`; what is not stored is computed, which takes hours; `--stored` takes what is."""

import dataclasses
import sys
import time
from collections.abc import Sequence
from typing import Any, Final

from cases import conformance
from cases.benchmark import SCENES, Benchmark, compiling, measure, stored
from cases.benchmark.scenes import ENGINES
from cases.case_file import load_case
from cases.finding import study as finding
from cases.jobs.job import Outcome
from cases.jobs.key import LIBRARIES, code_fingerprint
from cases.jobs.store import Store, write_atomically
from cases.jobs.workshop import Workshop
from cases.judging.matrix import Matrix, judge_scenes
from cases.library import catalogue
from cases.library.hard import TAG
from cases.studies import confirming
from cases.uncertainty.thesis import bands
from engines.registry import MAIN, engine
from reports.long_studies import CODE, FOLDER, About, RecordedConditioning, RecordedConformance, RecordedPoint, about, text_of
from reports.machine import version

#: What the page shows of a solver's statistics.
STATISTICS: Final = ("right_hand_side_calls", "integration_seconds", "largest_gap", "spurious_share")


def main(arguments: Sequence[str]) -> int:
    """Write all tables; exit code 2 for an option that is none."""
    if set(arguments) - {"--stored"}:
        print(f"python -m reports.long_studies: {' '.join(arguments)}: accepted: --stored", file=sys.stderr)
        return 2
    workshop, compute = Workshop(Store()), not arguments
    cases = [load_case(name) for name in SCENES]
    found = [table for case in cases if (table := stored(case, workshop) or (measure(case, workshop) if compute else None)) is not None]
    matrix = judge_scenes([load_case(entry.name) for entry in catalogue(TAG)], workshop, compute=compute)
    confirmed = confirming(workshop, compute=compute)
    if found:
        _write_benchmarks(found)
        _write("compiling", compiling(workshop, ENGINES, compute=compute))
    if matrix.cells:
        _write_matrix(matrix)
    conforming = [row for name in ENGINES if (row := _conformance(name, workshop, compute=compute)) is not None]
    effects = finding.study(workshop, compute=compute)
    scattered = bands(workshop, compute=compute)
    _write("conformance", conforming)
    _write("finding", effects)
    _write("unprinted", scattered)
    _write("confirmation", confirmed)
    made = {"benchmark": found, "hard scenes": matrix.cells, "confirmation": confirmed, "conformance": conforming, "finding": effects}
    made["unprinted"] = scattered
    _write("about", [each for study in CODE if (each := _made(study) if made[study] else about(study))])
    benchmarks, cells = f"{len(found)} of {len(cases)} scenes of the benchmark", f"{len(matrix.cells)} cells of the hard scenes"
    others = f"conformance of {len(conforming)} engines, {len(effects)} rows on the thesis' finding, bands of {len(scattered)} runs"
    print(f"{benchmarks}, {cells}, {len(confirmed)} confirming solutions, {others}")
    return 0


def _conformance(name: str, workshop: Workshop, *, compute: bool) -> RecordedConformance | None:
    """The outcome for one engine, from the store where it is there; None: it is not, and must not be computed."""
    job = conformance.job(name)
    stored = workshop.stored(job)
    if stored is None and compute:
        stored = workshop.kept(Outcome(job, conformance.conform(name, workshop.executor)))
    if stored is None or stored.value is None:
        return None
    return RecordedConformance.of(stored.value, engine(name).version())


def _made(study: str) -> About:
    versions = [f"{name} {version(name)}" for name in LIBRARIES] + [str(engine(name).version()) for name in ("exudyn", "mujoco")]
    return About(study, time.strftime("%Y-%m-%d", time.gmtime()), ", ".join(versions), code_fingerprint(CODE[study]))


def _write_benchmarks(found: Sequence[Benchmark]) -> None:
    points = []
    for table in found:
        for point in table.points:
            measured = point.measured and dataclasses.replace(
                point.measured, statistics={name: value for name, value in point.measured.statistics.items() if name in STATISTICS}
            )
            points.append(RecordedPoint(table.case, dataclasses.replace(point, measured=measured)))
    _write("benchmark", points)
    _write("benchmark_scenes", [dataclasses.replace(table, points=()) for table in found])


def _write_matrix(matrix: Matrix) -> None:
    _write("hard_scenes", [matrix.cells[case.name, name] for case in matrix.cases for name in MAIN if (case.name, name) in matrix.cells])
    known = [(case.name, matrix.conditionings[case.name]) for case in matrix.cases if case.name in matrix.conditionings]
    _write("hard_scenes_conditioning", [RecordedConditioning(name, matrix.converged.get(name), found) for name, found in known])


def _write(name: str, rows: Sequence[Any]) -> None:
    if rows:
        write_atomically(FOLDER / f"{name}.csv", text_of(rows).encode())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
