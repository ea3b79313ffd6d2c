"""Recorded results of the long studies, as small CSV tables beside this file; the page shows them if the user's own are missing.

Each row is a dataclass. The columns of a field that is a dataclass, or a mapping to numbers, are named `field.key`; a cell of any other
structure is JSON. Numbers have five digits, times (s) three.
`python -m quickreturn.record` writes them; `about.csv` says by which commit each study was made, and by which some of its cells were last
computed anew and confirmed (`tests/quickreturn/records/test_recorded_cells.py`).
"""

import csv
import dataclasses
import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import NoneType
from typing import Any, Final, TypeVar, get_args, get_type_hints

import pandas as pd

from quickreturn.cases import as_built, benchmark, studies
from quickreturn.cases import conformance as conform
from quickreturn.cases.benchmark import Benchmark, Compiling
from quickreturn.cases.benchmark.scenes import ENGINES
from quickreturn.cases.case import Case
from quickreturn.cases.case_file import load_case
from quickreturn.cases.classes import study as classes
from quickreturn.cases.classes.map import Map
from quickreturn.cases.jobs.job import Outcome
from quickreturn.cases.jobs.records import decoded, encoded
from quickreturn.cases.jobs.store import Record
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.judging.conditioning import Conditioning
from quickreturn.cases.judging.matrix import Judged, Matrix, judge_scenes
from quickreturn.cases.library import catalogue
from quickreturn.cases.library.hard import TAG
from quickreturn.cases.trials.trial import Trial
from quickreturn.engines.registry import MAIN, engine

T = TypeVar("T")

FOLDER: Final = Path(__file__).parent
#: Significant digits of recorded numbers, and of times: these scatter by more than their third digit.
DIGITS: Final = 5
DIGITS_OF_TIMES: Final = 3
#: Statistics of a benchmark's trials that the page shows, and further ones of `reference`; the others are not recorded.
STATISTICS: Final = ("largest_gap", "spurious_share")
#: Statistics up to this are rounding, such as the gap (m) of a rigid joint.
ROUNDING: Final = 1e-9
OF_REFERENCE: Final = ("right_hand_side_calls", "integration_seconds", "calls_per_period")
#: A zero that an exponent begins with: 1e-06 is written as 1e-6, which saves a kilobyte, as leaving out empty last cells does.
_LEADING_ZERO: Final = re.compile(r"(?<=\d)e-0")
#: Types of mappings with a column for each key; they have no keys whose cells are empty.
_NUMBERS: Final = (dict[str, float], dict[str, float | None], Mapping[str, float])


@dataclass(frozen=True)
class About:
    """How a study was recorded.

    Attributes:
        study: its name.
        date: of the record.
        versions: of the libraries.
        commit: of the code, abbreviated; "" if it is not known.
        confirmed: the last commit at which cells were computed anew and came out alike; "" if there was none since.
    """

    study: str
    date: str
    versions: str
    commit: str
    confirmed: str = ""

    @property
    def words(self) -> str:
        """The date and the commits, as a clause."""
        at = f" at commit {self.commit}" if self.commit else ""
        return f"{self.date}{at}{f'; cells of it were last confirmed at commit {self.confirmed}' if self.confirmed else ''}"


@dataclass(frozen=True)
class ConformanceRow:
    """The verdict of `quickreturn conform` on a version of an engine, and the number of checks behind it."""

    engine: str
    version: str
    verdict: str
    passed: int
    failed: int
    not_judged: int

    @classmethod
    def of(cls, conformance: conform.Conformance, version: str) -> "ConformanceRow":
        """The outcome for a version of an engine."""
        counts = Counter(check.status for check in conformance.checks)
        return cls(conformance.engine, version, conformance.verdict, counts["passed"], counts["failed"], counts["not judged"])

    @property
    def words(self) -> str:
        """The verdict and the number of checks behind it."""
        unjudged = f", {self.not_judged} could not be judged" if self.not_judged else ""
        return f"{self.verdict}; {self.passed} checks passed{unjudged}"


@cache
def about(study: str) -> About | None:
    """How a study was recorded; None if it was not."""
    return next((row for row in table("about", About) if row.study == study), None)


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


def conformance() -> dict[str, str]:
    """Engine -> recorded verdict on whether it does what it says, with the date and commit of the record."""
    record = about("conformance")
    if record is None:
        return {}
    return {row.engine: f"{row.words} (recorded on {record.words})" for row in table("conformance", ConformanceRow)}


def confirming() -> list[Trial]:
    """Solutions that confirm the converged solution of the studies."""
    return table("confirmation", Trial)


def class_map() -> Map:
    """Times of each method in each class; empty if they were not recorded."""
    return Map(tuple(table("classes_scenes", classes.ClassScene)), tuple(table("classes", Trial)))


def matrix(cases: Iterable[Case]) -> Matrix | None:
    """The hard scenes; None if they were not recorded."""
    cells = {(cell.scene, cell.engine): cell for cell in table("hard_scenes", Judged)}
    if not cells:
        return None
    shown = tuple(case for case in cases if any(scene == case.name for scene, _ in cells))
    return Matrix(shown, MAIN, cells, {row.scene: row for row in table("hard_scenes_conditioning", Conditioning)})


def built() -> list[as_built.Construction]:
    """Constructions of run 24 as users of other programs build it."""
    return table("as_built", as_built.Construction)


def _benchmark(workshop: Workshop) -> dict[str, Sequence[Any]]:
    cases = [load_case(name) for name in benchmark.SCENES]
    measured = [benchmark.stored(case, workshop) or (benchmark.measure(case, workshop) if workshop.computes else None) for case in cases]
    scenes = [dataclasses.replace(each, trials=()) for each in measured if each]
    trials = [_recorded(trial) for each in measured if each for trial in each.trials]
    return {"benchmark": trials, "benchmark_scenes": scenes, "compiling": benchmark.compiling(workshop, ENGINES) if scenes else []}


def _recorded(trial: Trial) -> Trial:
    """A trial with the statistics that the page shows, and without what a single repetition repeats."""
    shown = STATISTICS + (OF_REFERENCE if trial.engine == "reference" else ())
    statistics = {name: trial.statistics[name] for name in shown if abs(trial.statistics.get(name, 0.0)) > ROUNDING}
    once = trial.repetitions == 1
    median, largest = (None, None) if once else (trial.solve_seconds_median, trial.solve_seconds_largest)
    return dataclasses.replace(trial, statistics=statistics, solve_seconds_median=median, solve_seconds_largest=largest)


def _hard_scenes(workshop: Workshop) -> dict[str, Sequence[Any]]:
    found = judge_scenes([load_case(entry.name) for entry in catalogue(TAG)], workshop)
    return {"hard_scenes": [*found.cells.values()], "hard_scenes_conditioning": [*found.conditionings.values()]}


def _conformance(workshop: Workshop) -> dict[str, Sequence[Any]]:
    rows = []
    for name in ENGINES:
        job = conform.job(name)
        outcome = workshop.stored(job)
        if outcome is None and workshop.computes:
            outcome = workshop.kept(Outcome(job, conform.conform(name, workshop.executor)))
        if outcome is not None and outcome.value is not None:
            rows.append(ConformanceRow.of(outcome.value, engine(name).version()))
    return {"conformance": rows}


def _classes(workshop: Workshop) -> dict[str, Sequence[Any]]:
    scenes, trials = classes.study(workshop)
    return {"classes": trials, "classes_scenes": scenes}


def _as_built(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Rows of programs that are not installed stay as they were recorded, with the version of the program."""
    found = as_built.constructions() if workshop.computes else []
    programs = {row.program.split()[0] for row in found}
    return {"as_built": found and found + [row for row in built() if row.program.split()[0] not in programs]}


#: Study -> the function that gives the rows of its tables. What the workshop lacks is computed, or left out if it only has what is stored.
#: Packages beside the core add theirs.
STUDIES: Final[dict[str, Callable[[Workshop], Mapping[str, Sequence[Any]]]]] = {
    "benchmark": _benchmark,
    "hard scenes": _hard_scenes,
    "confirmation": lambda workshop: {"confirmation": [_recorded(each) for each in studies.confirming(workshop)]},
    "conformance": _conformance,
    "classes": _classes,
    "as built": _as_built,
}


def table(name: str, kind: type[T]) -> list[T]:
    """The rows of a table; none if there is no such file."""
    path = FOLDER / f"{name}.csv"
    if not path.exists():
        return []
    return [_unflat(kind, row) for row in csv.DictReader(path.read_text("utf-8").splitlines())]


def text_of(rows: Iterable[Any]) -> str:
    """Rows as the text of a table. ValueError: there are none."""
    flat = [_flat(row) for row in rows]
    if not flat:
        raise ValueError("a table without rows")
    return re.sub(r",+$", "", pd.DataFrame(flat).to_csv(index=False, lineterminator="\n"), flags=re.MULTILINE)


def _flat(item: Any, prefix: str = "") -> dict[str, str]:
    """Heading -> cell for the fields of a dataclass, each heading beginning with `prefix`; a field's default has an empty cell."""
    hints, row = get_type_hints(type(item)), dict[str, str]()
    for field in dataclasses.fields(item):
        value, name = getattr(item, field.name), prefix + field.name
        default = field.default if field.default_factory is dataclasses.MISSING else field.default_factory()
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            row |= _flat(value, f"{name}.")
        elif hints[field.name] in _NUMBERS:
            row |= {f"{name}.{key}": _cell(number, key) for key, number in value.items() if number is not None}
        elif value is not None and value != default:
            row[name] = _cell(value, name)
    return row


def _cell(value: Any, name: str) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, float):
        digits = DIGITS_OF_TIMES if "seconds" in name else DIGITS
        text = re.sub(r"^(-?)0\.", r"\1.", f"{value:.{digits}g}")  # without the zero before the point, which JSON asks for
    else:
        text = json.dumps(_short(encoded(value).document), separators=(",", ":"))
    return _LEADING_ZERO.sub("e-", text)


def _short(value: Any) -> Any:
    """The value with its numbers rounded to `DIGITS` digits."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, dict):
        return {name: _short(item) for name, item in value.items()}
    return [_short(item) for item in value] if isinstance(value, list) else value


def _unflat(kind: Any, row: Mapping[str, str]) -> Any:
    """The dataclass `kind` from a row's cells: the inverse of `_flat`."""
    hints, values = get_type_hints(kind), dict[str, Any]()
    for field in dataclasses.fields(kind):
        hint, name = hints[field.name], field.name
        inner = next((part for part in get_args(hint) if part is not NoneType), hint) if NoneType in get_args(hint) else hint
        within = {head.removeprefix(f"{name}."): text for head, text in row.items() if text and head.startswith(f"{name}.")}
        if dataclasses.is_dataclass(inner):
            values[field.name] = _unflat(inner, within) if within else None
        elif hint in _NUMBERS:
            values[field.name] = {key: float(text) for key, text in within.items()}
        elif row.get(name):
            values[field.name] = inner(row[name]) if inner in (str, float) else decoded(hint, Record(json.loads(row[name])))
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            values[field.name] = "" if hint is str else None
    return kind(**values)
