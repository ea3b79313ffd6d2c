"""Recorded results of the long studies as small tables beside this file; the page shows them if the user's own are missing.

A row is a dataclass: fields of fields and numbers of mappings have names with a dot, other mappings are JSON, numbers have five digits.
`python -m quickreturn.record` writes them; `about.csv` gives the date, versions and code of each study.
"""

import csv
import dataclasses
import json
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import NoneType
from typing import Any, Final, TypeVar, get_args, get_type_hints

import pandas as pd

from quickreturn.cases import studies
from quickreturn.cases.benchmark import Benchmark, Compiling
from quickreturn.cases.benchmark.findings import Point
from quickreturn.cases.benchmark.truth import Confirmation
from quickreturn.cases.case import Case
from quickreturn.cases.classes import study as classes
from quickreturn.cases.classes.map import Map
from quickreturn.cases.classes.measurement import Reach
from quickreturn.cases.conformance import Conformance
from quickreturn.cases.jobs.key import SIMULATION, code_fingerprint
from quickreturn.cases.jobs.records import decoded, encoded
from quickreturn.cases.jobs.store import Record
from quickreturn.cases.judging.conditioning import Conditioning
from quickreturn.cases.judging.matrix import Judged, Matrix
from quickreturn.engines.registry import MAIN

T = TypeVar("T")

FOLDER: Final = Path(__file__).parent
#: Study -> the code that it depends on. Packages beside the core add theirs.
CODE: Final[dict[str, tuple[str, ...]]] = {
    "benchmark": (*SIMULATION, "quickreturn.cases.benchmark"),
    "hard scenes": (*SIMULATION, "quickreturn.cases.judging"),
    "confirmation": (*SIMULATION, *studies.CODE),
    "conformance": (*SIMULATION, "quickreturn.cases.conformance"),
    "classes": (*SIMULATION, *classes.CODE),
}
#: Significant digits of recorded numbers.
DIGITS: Final = 5
#: Mappings with a column for each key; a missing number is left out of the first, and is None in the second.
_NUMBERS: Final = (dict[str, float], dict[str, float | None])


@dataclass(frozen=True)
class About:
    """Date, versions and code of a recorded study."""

    study: str
    date: str
    versions: str
    code: str

    @property
    def current(self) -> bool:
        """Whether the code is unchanged since then."""
        return self.code == code_fingerprint(CODE[self.study])


@dataclass(frozen=True)
class PointRow:
    """A point of a benchmark, and its scene."""

    case: str
    point: Point


@dataclass(frozen=True)
class ConditioningRow:
    """The conditioning of a hard scene, and the claimed error of its converged solution."""

    scene: str
    converged: float | None
    conditioning: Conditioning


@dataclass(frozen=True)
class ConformanceRow:
    """Whether an engine does what it says, and the number of checks behind this."""

    engine: str
    version: str
    verdict: str
    passed: int
    failed: int
    not_judged: int

    @classmethod
    def of(cls, found: Conformance, version: str) -> "ConformanceRow":
        """The outcome for a version of an engine."""
        counts = Counter(check.status for check in found.checks)
        return cls(found.engine, version, found.verdict, counts["passed"], counts["failed"], counts["not judged"])

    @property
    def words(self) -> str:
        """The verdict and the number of checks behind it."""
        unjudged = f", {self.not_judged} could not be judged" if self.not_judged else ""
        return f"{self.verdict}; {self.passed} checks passed{unjudged}"


@cache
def about(study: str) -> About | None:
    """Date, versions and code of a recorded study; None if it was not recorded."""
    return next((found for found in table("about", About) if found.study == study), None)


@cache
def benchmarks() -> Mapping[str, Benchmark]:
    """Scene -> its measured benchmark."""
    points: dict[str, list[Point]] = {}
    for each in table("benchmark", PointRow):
        points.setdefault(each.case, []).append(each.point)
    return {scene.case: dataclasses.replace(scene, points=tuple(points[scene.case])) for scene in table("benchmark_scenes", Benchmark)}


@cache
def compiling() -> list[Compiling]:
    """Times to compile engines."""
    return table("compiling", Compiling)


def conformance() -> dict[str, str]:
    """Engine -> verdict on whether it does what it says, with its date and code."""
    made = about("conformance")
    if made is None:
        return {}
    older = "" if made.current else ", which is older than this page’s"
    told = f"recorded on {made.date} with code {made.code[:12]}{older}"
    return {found.engine: f"{found.words} ({told})" for found in table("conformance", ConformanceRow)}


def confirming() -> list[Confirmation]:
    """Solutions that confirm the converged solution of the studies."""
    return table("confirmation", Confirmation)


def class_map() -> Map:
    """Times of each method in each class; empty if they were not recorded."""
    return Map(tuple(table("classes_scenes", classes.ClassScene)), tuple(table("classes", Reach)))


def matrix(cases: Iterable[Case]) -> Matrix | None:
    """The hard scenes; None if they were not recorded."""
    cells = {(cell.scene, cell.engine): cell for cell in table("hard_scenes", Judged)}
    if not cells:
        return None
    known = table("hard_scenes_conditioning", ConditioningRow)
    shown = tuple(case for case in cases if any(scene == case.name for scene, _ in cells))
    return Matrix(shown, MAIN, cells, {each.scene: each.conditioning for each in known}, {each.scene: each.converged for each in known})


def table(name: str, kind: type[T]) -> list[T]:
    """The rows of a table; none if there is no such file."""
    path = FOLDER / f"{name}.csv"
    if not path.exists():
        return []
    return [_whole(kind, row) for row in csv.DictReader(path.read_text("utf-8").splitlines())]


def text_of(rows: Iterable[Any]) -> str:
    """Rows as the text of a table. ValueError: there are none."""
    flat = [_flat(row) for row in rows]
    if not flat:
        raise ValueError("a table without rows")
    return pd.DataFrame(flat).to_csv(index=False, lineterminator="\n")


def _flat(item: Any, prefix: str = "") -> dict[str, str]:
    hints, row = get_type_hints(type(item)), dict[str, str]()
    for field in dataclasses.fields(item):
        value, name = getattr(item, field.name), prefix + field.name
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            row |= _flat(value, f"{name}.")
        elif hints[field.name] in _NUMBERS:
            row |= {f"{name}.{key}": json.dumps(_short(number)) for key, number in value.items() if number is not None}
        elif value is not None:
            row[name] = value if isinstance(value, str) else json.dumps(_short(encoded(value).document), separators=(",", ":"))
    return row


def _short(value: Any) -> Any:
    """The value with numbers of `DIGITS` digits."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, dict):
        return {name: _short(each) for name, each in value.items()}
    return [_short(each) for each in value] if isinstance(value, list) else value


def _whole(kind: Any, row: Mapping[str, str], prefix: str = "") -> Any:
    hints, values = get_type_hints(kind), dict[str, Any]()
    for field in dataclasses.fields(kind):
        hint, name = hints[field.name], prefix + field.name
        inner = next((each for each in get_args(hint) if each is not NoneType), hint) if NoneType in get_args(hint) else hint
        if dataclasses.is_dataclass(inner):
            there = any(text and head.startswith(f"{name}.") for head, text in row.items())
            values[field.name] = _whole(inner, row, f"{name}.") if there else None
        elif hint in _NUMBERS:
            cells = {key.removeprefix(f"{name}."): text for key, text in row.items() if key.startswith(f"{name}.")}
            found = {key: float(text) if text else None for key, text in cells.items()}
            values[field.name] = {key: number for key, number in found.items() if number is not None or hint is _NUMBERS[1]}
        elif row.get(name):
            values[field.name] = row[name] if inner is str else decoded(hint, Record(json.loads(row[name])))
        elif name in row or (field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING):
            values[field.name] = "" if hint is str else None
    return kind(**values)
