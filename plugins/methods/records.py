"""Recorded results of the studies of methods, and the rows that record them (`reports.long_studies`)."""

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.library import catalogue
from quickreturn.cases.library.hard import TAG
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import MAIN
from quickreturn.plugins.methods import accuracy
from quickreturn.plugins.methods.benchmark import SCENES, Benchmark, Compiling, measure, stored
from quickreturn.plugins.methods.benchmark import compiling as compile_times
from quickreturn.plugins.methods.benchmark.scenes import ENGINES
from quickreturn.plugins.methods.classes.map import Map
from quickreturn.plugins.methods.classes.study import ClassScene, study
from quickreturn.plugins.methods.judging.conditioning import Conditioning
from quickreturn.plugins.methods.judging.matrix import Judged, Matrix, judge_scenes
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.reports.long_studies import table

#: Statistics of a benchmark's trials that the page shows, and further ones of `reference`; the others are not recorded.
STATISTICS: Final = ("largest_gap", "spurious_share")
#: Statistics up to this are rounding, such as the gap (m) of a rigid joint.
ROUNDING: Final = 1e-9
OF_REFERENCE: Final = ("right_hand_side_calls", "integration_seconds", "calls_per_period")


@cache
def benchmarks() -> Mapping[str, Benchmark]:
    """Scene -> its measured benchmark."""
    trials = table("benchmark", Trial)
    scenes = table("benchmark_scenes", Benchmark)
    return {each.case: dataclasses.replace(each, trials=tuple(trial for trial in trials if trial.scene == each.case)) for each in scenes}


@cache
def compiling() -> list[Compiling]:
    """Times to compile engines."""
    return table("compiling", Compiling)


def confirming() -> list[Trial]:
    """Solutions that confirm the converged solution of the studies."""
    return table("confirmation", Trial)


def class_map() -> Map:
    """Times of each method in each class; empty if they were not recorded."""
    return Map(tuple(table("classes_scenes", ClassScene)), tuple(table("classes", Trial)))


def matrix(cases: Iterable[Case]) -> Matrix | None:
    """The hard scenes; None if they were not recorded."""
    cells = {(cell.scene, cell.engine): cell for cell in table("hard_scenes", Judged)}
    if not cells:
        return None
    shown = tuple(case for case in cases if any(scene == case.name for scene, _ in cells))
    return Matrix(shown, MAIN, cells, {row.scene: row for row in table("hard_scenes_conditioning", Conditioning)})


def benchmark_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of the benchmark: its scenes, its trials, and times to compile."""
    cases = [load_case(name) for name in SCENES]
    measured = [stored(case, workshop) or (measure(case, workshop) if workshop.computes else None) for case in cases]
    scenes = [dataclasses.replace(each, trials=()) for each in measured if each]
    trials = [_recorded(trial) for each in measured if each for trial in each.trials]
    return {"benchmark": trials, "benchmark_scenes": scenes, "compiling": compile_times(workshop, ENGINES) if scenes else []}


def confirmation_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of the solutions that confirm the converged one."""
    return {"confirmation": [_recorded(each) for each in accuracy.confirming(workshop)]}


def hard_scene_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of the hard scenes: verdicts, and how they are conditioned."""
    found = judge_scenes([load_case(entry.name) for entry in catalogue(TAG)], workshop)
    return {"hard_scenes": [*found.cells.values()], "hard_scenes_conditioning": [*found.conditionings.values()]}


def class_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of the map of classes: scenes and trials."""
    scenes, trials = study(workshop)
    return {"classes": trials, "classes_scenes": scenes}


def _recorded(trial: Trial) -> Trial:
    """A trial with the statistics that the page shows, and without what a single repetition repeats."""
    shown = STATISTICS + (OF_REFERENCE if trial.engine == "reference" else ())
    statistics = {name: trial.statistics[name] for name in shown if abs(trial.statistics.get(name, 0.0)) > ROUNDING}
    once = trial.repetitions == 1
    median, largest = (None, None) if once else (trial.solve_seconds_median, trial.solve_seconds_largest)
    return dataclasses.replace(trial, statistics=statistics, solve_seconds_median=median, solve_seconds_largest=largest)
