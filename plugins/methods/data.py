"""What the studies of methods add to the page: the user's own results, or the recorded ones where there are none."""

from collections.abc import Sequence
from dataclasses import replace

from quickreturn.cases.comparison.campaign import Work
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.library import catalogue
from quickreturn.cases.library.hard import TAG
from quickreturn.plugins.methods import accuracy as studies
from quickreturn.plugins.methods import records
from quickreturn.plugins.methods.accuracy import ACCURACY_CASE, Studies
from quickreturn.plugins.methods.benchmark import SCENES, Benchmark, Compiling, stored
from quickreturn.plugins.methods.benchmark import compiling as compile_times
from quickreturn.plugins.methods.benchmark.scenes import ENGINES
from quickreturn.plugins.methods.classes.map import Map
from quickreturn.plugins.methods.judging.matrix import Matrix, judge_scenes
from quickreturn.reports.long_studies import About, about
from quickreturn.reports.page.content import Content


def work(cases: Sequence[Case], engines: Sequence[str], own: bool) -> Work:
    """What the studies of accuracy compute, for a report with the case that they are about."""
    return studies.work(engines) if any(case.name == ACCURACY_CASE and case.source == "library" for case in cases) else Work()


def studies_of(content: Content) -> tuple[Studies | None, About | None]:
    """Results of the studies of accuracy, and about the record of the solutions that confirm them, if these are recorded ones."""
    if content.workshop is None or not content.has(ACCURACY_CASE):
        return None, None
    found = studies.run_studies(content.workshop, content.engines)
    if found.confirming:
        return found, None
    return replace(found, confirming=records.confirming()), about("confirmation")


def benchmarks_of(content: Content) -> tuple[Sequence[Benchmark], About | None]:
    """Measurements of the scenes on which methods are compared, or of the report's own cases; about their record, if they are recorded."""
    if content.workshop is None:
        return [], None
    if not content.has(ACCURACY_CASE):
        return [table for result in content.results if (table := stored(result.case, content.workshop))], None
    own, recorded = {name: stored(load_case(name), content.workshop) for name in SCENES}, records.benchmarks()
    found = [table for name in SCENES if (table := own[name] or recorded.get(name))]
    return found, about("benchmark") if any(own[name] is None and name in recorded for name in SCENES) else None


def compiling_of(content: Content) -> Sequence[Compiling]:
    """Times to compile engines, if they were measured."""
    if content.workshop is None or not content.has(ACCURACY_CASE):
        return []
    return compile_times(content.workshop.as_it_is, ENGINES) or records.compiling()


def matrix_of(content: Content) -> tuple[Matrix | None, About | None]:
    """The matrix of verdicts on the hard scenes, and about its record, if it is the recorded one."""
    if content.workshop is None or not content.has(ACCURACY_CASE):
        return None, None
    scenes = [load_case(entry.name) for entry in catalogue(TAG)]
    matrix = judge_scenes(scenes, content.workshop.as_it_is)
    return (matrix, None) if matrix.cells else (records.matrix(scenes), about("hard scenes"))


def map_of(content: Content) -> Map:
    """The recorded map of classes."""
    return records.class_map() if content.workshop and content.has(ACCURACY_CASE) else Map()
