"""Which heading of another program's table is which column: `"phi = -1 * crank_angle [deg] + 90"`, given one by one or in a file."""

import difflib
import json
import os
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from quickreturn.cases.errors import Argument, CaseError, as_written, path_shown, similar_name, texts_given
from quickreturn.cases.text.number_rows import unit_factor
from quickreturn.cases.text.text_file import read_text
from quickreturn.reference_model.columns import COLUMNS, SHAPE

COLUMN: Final = Argument("columns")
_NEAR: Final = 0.45  # share of letters in the same order: "crank.phi" is near to crank_angle, "value0" to none
#: Words of other programs -> those of columns.
_WORDS: Final = {"phi": "angle", "theta": "angle", "w": "speed", "omega": "speed", "acc": "acceleration", "f": "force", "tau": "torque"}
IGNORED: Final = "-"  # in place of a column
_NUMBER: Final = r"\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?"
_TARGET: Final = re.compile(
    rf"([+-])?\s*(?:({_NUMBER})\s*\*\s*)?(\w+)\s*(?:\[([^\]]*)\])?\s*(?:([+-])\s*({_NUMBER})(?!\s*\*|[\d.]))?"
    rf"\s*(?:([+-])\s*({_NUMBER})\s*\*\s*time)?"
)
_EXAMPLE: Final = '"crank.phi = crank_angle [deg]", "phi = -1 * crank_angle [deg] + 90", or "phi = -" to ignore it'


@dataclass(frozen=True)
class Target:
    """What a heading's numbers are: factor * column + offset + drift * time, with the column in the unit and the time in s."""

    column: str  # as in `reference_model.columns`, or `IGNORED`
    unit: str | None = None  # None: that of the heading, or SI
    factor: float = 1.0
    offset: float = 0.0
    drift: float = 0.0


@dataclass(frozen=True)
class ColumnMapping:
    """Headings with their columns, and the decimal sign if it is known."""

    targets: Mapping[str, Target] = field(default_factory=dict)  # by heading; "1", "2", ... stand for the position
    decimal: str | None = None
    file: str = ""  # of the mapping, if there is one


def mapping_of(path: str, columns: Sequence[str] | Mapping[str, str], decimal: str | None) -> ColumnMapping:
    """The mapping of the file beside a table, if there is one, changed by texts such as "crank.phi = crank_angle [deg]".

    CaseError: a text or the file cannot be read.
    """
    if decimal not in (None, ".", ","):
        raise CaseError(Argument("decimal"), None, as_written(decimal), "is no decimal sign", 'give "." or ","')
    beside = mapping_file(path)
    targets, file = dict[str, Target](), ""
    if path != beside and os.path.isfile(beside):
        shown = path_shown(beside)
        try:
            document = tomllib.loads(read_text(beside, "a mapping"))
        except tomllib.TOMLDecodeError as wrong:
            raise CaseError(shown, None, None, f"is no TOML ({wrong})", "mend it, or give the file another name") from None
        if "columns" in document and "mechanism" not in document:
            file = shown
            decimal = decimal or _decimal_in(shown, document)
            for heading, text in document["columns"].items():
                targets[heading] = _target(shown, heading, text)
    if isinstance(columns, Mapping):
        columns = [f"{heading} = {target}" for heading, target in columns.items()]
    for text in texts_given(columns, COLUMN, "crank.phi = crank_angle [deg]"):
        heading, sign, target = (part.strip() for part in text.rpartition("="))
        if not (heading and sign):
            raise CaseError(COLUMN, None, as_written(text), "names no column", f"write {_EXAMPLE}")
        targets[heading] = _target(COLUMN, heading, target)
    return ColumnMapping(targets, decimal, file)


def mapping_file(path: str) -> str:
    """The path of the mapping beside a table: the same name with the ending .toml."""
    return str(Path(path).with_suffix(".toml"))


def suggested(headings: Sequence[str], known: Mapping[str, str], decimal: str | None) -> str:
    """The text of a mapping file for headings; `known`: heading -> the column and unit that it gives. Others are ignored until edited."""
    lines = ["# What each heading is: a column of a trajectory with its unit; - is ignored. See docs/your-tool.md."]
    lines += [f'decimal = "{decimal}"'] if decimal else []
    lines.append("[columns]")
    for heading in headings:
        text = known.get(heading, IGNORED)
        column = "" if heading in known else near_column(heading)
        near = f"  # perhaps {column} [{unit_in(heading, column) or _unit_of(column)}]" if column else ""
        lines.append(f"{json.dumps(heading, ensure_ascii=False)} = {json.dumps(text, ensure_ascii=False)}{near}")
    return "\n".join(lines) + "\n"


def near_column(heading: str) -> str:
    """The column whose name resembles a heading most; "" if none does."""
    words = re.split(r"[\W_]+", heading.partition("[")[0].partition("(")[0].strip().lower())
    name = "_".join(_WORDS.get(word, word) for word in words)
    return next(iter(difflib.get_close_matches(name, [each for each in COLUMNS if each not in SHAPE], 1, _NEAR)), "")


def unit_in(heading: str, column: str) -> str:
    """The unit of a column that a heading names in brackets or as its last word, such as "mm" in "tip_deflection_mm"; "" if none."""
    bracketed = re.search(r"[\[(]([^\])]*)[\])]\s*$", heading)
    unit = bracketed[1].strip() if bracketed else re.split(r"[\s_.]+", heading.strip())[-1]
    try:
        unit_factor("", "", COLUMNS[column].unit.replace(" ", "*"), unit)
    except CaseError:
        return ""
    return unit


def _unit_of(column: str) -> str:
    unit = COLUMNS[column].unit.replace(" ", "*")
    return "-" if unit == "1" else unit


def _decimal_in(shown: str, document: Mapping[str, object]) -> str | None:
    if unknown := [key for key in document if key not in ("columns", "decimal")]:
        raise CaseError(shown, unknown[0], None, "is no key of a mapping", 'write decimal = "," or a table [columns]')
    if not isinstance(document["columns"], dict):
        raise CaseError(shown, "columns", None, "is no table", f'write lines below [columns], such as "phi" = "{next(iter(COLUMNS))}"')
    given = document.get("decimal")
    if given not in (None, ".", ","):
        raise CaseError(shown, "decimal", as_written(given), "is no decimal sign", 'give "." or ","')
    return None if given is None else str(given)


def _target(source: str, heading: str, text: object) -> Target:
    """The target of a heading. CaseError: the text is none, or names no column or no unit of it."""
    if text == IGNORED:
        return Target(IGNORED)
    match = _TARGET.fullmatch(text.strip()) if isinstance(text, str) else None
    if match is None:
        raise CaseError(source, heading, as_written(text), "cannot be read", f"write {_EXAMPLE}")
    sign, number, column, unit, *line = match.groups()
    if column not in COLUMNS:
        near = similar_name(column, tuple(COLUMNS))
        accepted = f"did you mean {near}?" if near else f"columns are {', '.join(COLUMNS)}"
        raise CaseError(source, heading, as_written(column), "is no column of a trajectory", accepted)
    factor = (-1.0 if sign == "-" else 1.0) * float(number or 1)
    if factor == 0.0:
        raise CaseError(source, heading, as_written(text), "has the factor 0", f"write {_EXAMPLE}")
    if unit is not None:
        unit_factor(source, heading, COLUMNS[column].unit.replace(" ", "*"), unit.strip())
    offset, drift = (float(f"{line[at] or ''}{line[at + 1] or 0}") for at in (0, 2))
    return Target(column, unit if unit is None else unit.strip(), factor, offset, drift)
