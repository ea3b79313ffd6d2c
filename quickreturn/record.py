"""Records results of the long studies as the tables of `reports.long_studies`: `python -m quickreturn.record`.

Missing results are computed, which takes hours; `--stored` takes only stored results.
Names of studies, as in `STUDIES`, choose among them: `python -m quickreturn.record classes`.
"""

import dataclasses
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any, Final

from quickreturn.cases import conformance
from quickreturn.cases.benchmark import SCENES, Benchmark, compiling, measure, stored
from quickreturn.cases.benchmark.scenes import ENGINES
from quickreturn.cases.case_file import load_case
from quickreturn.cases.classes import study as classes
from quickreturn.cases.jobs.job import Outcome
from quickreturn.cases.jobs.key import LIBRARIES
from quickreturn.cases.jobs.store import Store
from quickreturn.cases.jobs.whole_file import write_atomically
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.judging.matrix import judge_scenes
from quickreturn.cases.library import catalogue
from quickreturn.cases.library.hard import TAG
from quickreturn.cases.studies import confirming
from quickreturn.cases.thesis.finding import study as finding
from quickreturn.cases.thesis.scatter import bands
from quickreturn.engines.registry import MAIN, engine
from quickreturn.reports.long_studies import FOLDER, STUDIES, About, ConditioningRow, ConformanceRow, about, text_of
from quickreturn.reports.machine import version
from quickreturn.reports.thesis import long_studies as _  # noqa: F401 - registers its studies

#: Statistics of a benchmark's trials that the page shows, and further ones of `reference`; the others are not recorded.
STATISTICS: Final = ("largest_gap", "spurious_share")
OF_REFERENCE: Final = ("right_hand_side_calls", "integration_seconds", "calls_per_period")


def main(arguments: Sequence[str]) -> int:
    """Write the tables of all studies, or of the named ones; exit code 2 for an unknown argument."""
    names = [each for each in arguments if each != "--stored"]
    if unknown := sorted(set(names) - set(STUDIES)):
        print(f"python -m quickreturn.record: {' '.join(unknown)}: accepted: --stored, {', '.join(STUDIES)}", file=sys.stderr)
        return 2
    workshop, lines = Workshop(Store()), list[str]()
    if "--stored" in arguments:
        workshop = workshop.as_it_is
    for study in names or STUDIES:
        if line := _RECORDERS[study](workshop):
            lines.append(line)
            _write("about", [_about_now(each) if each == study else old for each in STUDIES if (old := about(each)) or each == study])
            about.cache_clear()
    print(", ".join(lines) or "nothing is stored")
    return 0


def _benchmark(workshop: Workshop) -> str:
    cases = [load_case(name) for name in SCENES]
    measured = (stored(case, workshop) or (measure(case, workshop) if workshop.computes else None) for case in cases)
    if benchmarks := [benchmark for benchmark in measured if benchmark is not None]:
        _write_benchmarks(benchmarks)
        _write("compiling", compiling(workshop, ENGINES))
    return f"{len(benchmarks)} of {len(cases)} scenes of the benchmark" if benchmarks else ""


def _hard_scenes(workshop: Workshop) -> str:
    matrix = judge_scenes([load_case(entry.name) for entry in catalogue(TAG)], workshop)
    if not matrix.cells:
        return ""
    _write("hard_scenes", [matrix.cells[case.name, name] for case in matrix.cases for name in MAIN if (case.name, name) in matrix.cells])
    conditionings = [(case.name, matrix.conditionings[case.name]) for case in matrix.cases if case.name in matrix.conditionings]
    _write("hard_scenes_conditioning", [ConditioningRow(name, matrix.converged.get(name), each) for name, each in conditionings])
    return f"{len(matrix.cells)} cells of the hard scenes"


def _classes(workshop: Workshop) -> str:
    scenes, trials = classes.study(workshop)
    _write("classes_scenes", scenes)
    return _write("classes", trials, f"cells of {len(scenes)} classes")


#: Study -> the function that writes its tables and returns a line on them, "" if there is nothing.
_RECORDERS: Final[Mapping[str, Callable[[Workshop], str]]] = {
    "benchmark": _benchmark,
    "hard scenes": _hard_scenes,
    "confirmation": lambda workshop: _write("confirmation", confirming(workshop), "confirming solutions"),
    "conformance": lambda workshop: _write("conformance", _conforming(workshop), "engines' conformance"),
    "finding": lambda workshop: _write("finding", finding.study(workshop), "rows on the thesis' finding"),
    "unprinted": lambda workshop: _write("unprinted", bands(workshop), "bands of runs"),
    "classes": _classes,
}


def _conforming(workshop: Workshop) -> list[ConformanceRow]:
    """The outcomes of all engines from the store; missing ones are computed unless only stored results are asked for."""
    rows = []
    for name in ENGINES:
        job = conformance.job(name)
        outcome = workshop.stored(job)
        if outcome is None and workshop.computes:
            outcome = workshop.kept(Outcome(job, conformance.conform(name, workshop.executor)))
        if outcome is not None and outcome.value is not None:
            rows.append(ConformanceRow.of(outcome.value, engine(name).version()))
    return rows


def _about_now(study: str) -> About:
    versions = [f"{name} {version(name)}" for name in LIBRARIES] + [str(engine(name).version()) for name in ("exudyn", "mujoco")]
    return About(study, time.strftime("%Y-%m-%d", time.gmtime()), ", ".join(versions), commit())


def commit() -> str:
    """The commit of the checkout that holds the tables, abbreviated; "" without git."""
    with suppress(FileNotFoundError):
        found = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=FOLDER, capture_output=True, text=True, check=False)
        return found.stdout.strip()
    return ""


def confirm(study: str) -> None:
    """Note that cells of a recorded study came out alike at the checkout's commit."""
    _write("about", [dataclasses.replace(old, confirmed=commit()) if each == study else old for each in STUDIES if (old := about(each))])
    about.cache_clear()


def _write_benchmarks(benchmarks: Sequence[Benchmark]) -> None:
    trials = []
    for trial in (trial for benchmark in benchmarks for trial in benchmark.trials):
        shown = STATISTICS + (OF_REFERENCE if trial.engine == "reference" else ())
        statistics = {name: trial.statistics[name] for name in shown if name in trial.statistics}
        trials.append(dataclasses.replace(trial, statistics=statistics))
    _write("benchmark", trials)
    _write("benchmark_scenes", [dataclasses.replace(benchmark, trials=()) for benchmark in benchmarks])


def _write(name: str, rows: Sequence[Any], of: str = "rows") -> str:
    """Write a table, unless it would be empty; return its number of rows in words."""
    if not rows:
        return ""
    write_atomically(FOLDER / f"{name}.csv", text_of(rows).encode())
    return f"{len(rows)} {of}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
