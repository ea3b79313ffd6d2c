"""Recorded results of the long studies, as small CSV tables beside this file; the page shows them if the user's own are missing.

Each row is a dataclass. The columns of a field that is a dataclass, or a mapping to numbers, are named `field.key`; a cell of any other
structure is JSON. Numbers have four digits, times (s) three.
`python -m quickreturn.record` writes them; `about.csv` says by which commit each study was made, and by which some of its cells were last
computed anew and confirmed (`tests/quickreturn/records/test_recorded_cells.py`).
"""

import csv
import dataclasses
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import NoneType
from typing import Any, Final, TypeVar, get_args, get_type_hints

import pandas as pd

from quickreturn.cases.running.store import Record, decoded, encoded
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.plugins import entries, found

T = TypeVar("T")

FOLDER: Final = Path(__file__).parent
#: Significant digits of recorded numbers, and of times: these scatter by more than their third digit.
DIGITS: Final = 4
DIGITS_OF_TIMES: Final = 3
#: A zero that an exponent begins with: 1e-06 is written as 1e-6, which saves a kilobyte, as leaving out empty last cells does.
_LEADING_ZERO: Final = re.compile(r"(?<=\d)e-0")
#: Types of mappings with a column for each key; they have no keys whose cells are empty.
_NUMBERS: Final = (dict[str, float], dict[str, float | None], Mapping[str, float])


@dataclass(frozen=True)
class About:
    """How a study was recorded."""

    study: str  # its name
    date: str  # of the record
    versions: str  # of the libraries
    commit: str  # of the code, abbreviated; "" if it is not known
    confirmed: str = ""  # the last commit at which cells were computed anew and came out alike; "" if there was none since

    @property
    def words(self) -> str:
        """The date and the commits, as a clause."""
        at = f" at commit {self.commit}" if self.commit else ""
        return f"{self.date}{at}{f'; cells of it were last confirmed at commit {self.confirmed}' if self.confirmed else ''}"


@cache
def about(study: str) -> About | None:
    """How a study was recorded; None if it was not."""
    return next((row for row in table("about", About) if row.study == study), None)


def studies() -> dict[str, Callable[[Workshop], Mapping[str, Sequence[Any]]]]:
    """Study -> the function that gives the rows of its tables.

    What the workshop lacks is computed, or left out if it only has what is stored.
    """
    return {study: found(place) for study, place in entries("records").items()}


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
