"""The columns of a trajectory that another program's table gives: by its headings, and by texts such as `"phi = -1 * crank_angle [deg]"`.

The texts are given one by one, or stand in a file beside the table, which also says how the table is written.
"""

import difflib
import json
import os
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, NamedTuple

from quickreturn.cases.files.errors import Argument, CaseError, as_written, path_shown, similar_name, texts_given
from quickreturn.cases.files.number_rows import ADVICE, NAMED, PLAIN, SEPARATORS, Form, TableText, name_and_unit, unit_factor
from quickreturn.cases.files.text_file import read_text
from quickreturn.reference_model.columns import COLUMNS, MOMENTS, SHAPE

COLUMN: Final = Argument("columns")
_MEANT: Final = tuple(name for name in COLUMNS if name not in (*SHAPE, *MOMENTS))  # columns that a heading may mean
_NEAR: Final = 0.45  # share of letters in the same order: "crank.phi" is near to crank_angle, "value0" to none
#: Words of other programs -> those of columns.
_WORDS: Final = {"phi": "angle", "theta": "angle", "w": "speed", "omega": "speed", "acc": "acceleration", "f": "force", "tau": "torque"}
IGNORED: Final = "-"  # in place of a column
#: Member of a `Form` -> the signs that it accepts.
_OF_FORM: Final[Mapping[str, tuple[str, ...]]] = {"separator": (*NAMED, *SEPARATORS), "decimal": (".", ","), "skip": ()}
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


class UsedColumn(NamedTuple):
    """A column of a table that is used."""

    place: int  # counted from 0
    target: Target
    factor: float  # SI value of its unit


@dataclass(frozen=True)
class ColumnMapping:
    """Headings with their columns, and how the table is written."""

    targets: Mapping[str, Target] = field(default_factory=dict)  # by heading; "1", "2", ... stand for the position
    form: Form = PLAIN
    file: str = ""  # of the mapping, if there is one


def mapping_of(path: str, columns: Sequence[str] | Mapping[str, str], form: Form) -> ColumnMapping:
    """The mapping of the file beside a table, if there is one, changed by texts such as "crank.phi = crank_angle [deg]" and by `form`.

    CaseError: a text, the form or the file cannot be read.
    """
    for name in _OF_FORM:
        _checked(Argument(name), None, name, getattr(form, name))
    beside = mapping_file(path)
    targets, file = dict[str, Target](), ""
    if path != beside and os.path.isfile(beside):
        shown = path_shown(beside)
        try:
            document = tomllib.loads(read_text(beside, "a mapping"))
        except tomllib.TOMLDecodeError as wrong:
            raise CaseError(shown, None, None, f"is no TOML ({wrong})", "mend it, or give the file another name") from None
        if "columns" in document and "mechanism" not in document:
            file, form = shown, _form_in(shown, document, form)
            for heading, text in document["columns"].items():
                targets[heading] = _target(shown, heading, text)
    if isinstance(columns, Mapping):
        columns = [f"{heading} = {target}" for heading, target in columns.items()]
    for text in texts_given(columns, COLUMN, "crank.phi = crank_angle [deg]"):
        heading, sign, target = (part.strip() for part in text.rpartition("="))
        if not (heading and sign):
            raise CaseError(COLUMN, None, as_written(text), "names no column", f"write {_EXAMPLE}")
        targets[heading] = _target(COLUMN, heading, target)
    return ColumnMapping(targets, form, file)


def mapping_file(path: str) -> str:
    """The path of the mapping beside a table: the same name with the ending .toml."""
    return str(Path(path).with_suffix(".toml"))


def suggested(headings: Sequence[str], known: Mapping[str, str], form: Form) -> str:
    """The text of a mapping file for headings; `known`: heading -> the column and unit that it gives. Others are ignored until edited."""
    lines = ["# What each heading is: a column of a trajectory with its unit; - is ignored. See docs/your-tool.md."]
    lines += [f"{name} = {json.dumps(value)}" for name in _OF_FORM if (value := getattr(form, name))]
    lines.append("[columns]")
    for heading in headings:
        text = known.get(heading, IGNORED)
        column = "" if heading in known else near_column(heading)
        near = f"  # perhaps {column} [{unit_in(heading, column) or _si_unit(column)}]" if column else ""
        lines.append(f"{json.dumps(heading, ensure_ascii=False)} = {json.dumps(text, ensure_ascii=False)}{near}")
    return "\n".join(lines) + "\n"


def near_column(heading: str) -> str:
    """The column whose name resembles a heading most; "" if none does."""
    words = re.split(r"[\W_]+", heading.partition("[")[0].partition("(")[0].strip().lower())
    name = "_".join(_WORDS.get(word, word) for word in words)
    return next(iter(difflib.get_close_matches(name, _MEANT, 1, _NEAR)), "")


def unit_in(heading: str, column: str) -> str:
    """The unit of a column that a heading names in brackets or as its last word, such as "mm" in "tip_deflection_mm"; "" if none."""
    bracketed = re.search(r"[\[(]([^\])]*)[\])]\s*$", heading)
    unit = bracketed[1].strip() if bracketed else re.split(r"[\s_.]+", heading.strip())[-1]
    try:
        unit_factor("", "", _si_unit(column), unit)
    except CaseError:
        return ""
    return unit


def _si_unit(column: str) -> str:
    return COLUMNS[column].unit.replace(" ", "*")


def _form_in(shown: str, document: Mapping[str, object], form: Form) -> Form:
    """The form that a mapping file states where `form` leaves it open. CaseError: the file cannot be read."""
    if unknown := [key for key in document if key not in ("columns", *_OF_FORM)]:
        raise CaseError(shown, unknown[0], None, "is no key of a mapping", f"write {', '.join(_OF_FORM)} or a table [columns]")
    if not isinstance(document["columns"], dict):
        raise CaseError(shown, "columns", None, "is no table", f'write lines below [columns], such as "phi" = "{next(iter(COLUMNS))}"')
    stated = {name: document[name] for name in _OF_FORM if name in document and not getattr(form, name)}
    for name, value in stated.items():
        _checked(shown, name, name, value)
    return replace(form, **stated)  # type: ignore[arg-type]


def _checked(source: str, key: str | None, name: str, value: object) -> None:
    """Raise the CaseError of a member of a `Form` that has another value than is accepted."""
    if name == "skip":
        if not isinstance(value, int) or value < 0:
            raise CaseError(source, key, as_written(value), "is no number of lines", "give a whole number")
    elif value not in (None, *_OF_FORM[name]):
        signs = " or ".join(map(as_written, _OF_FORM[name]))
        raise CaseError(source, key, as_written(value), f"is no {name} sign" if name == "decimal" else "is no separator", f"give {signs}")


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
        unit_factor(source, heading, _si_unit(column), unit.strip())
    offset, drift = (float(f"{line[at] or ''}{line[at + 1] or 0}") for at in (0, 2))
    return Target(column, unit if unit is None else unit.strip(), factor, offset, drift)


def own_name(heading: str) -> Target | None:
    """The column that a heading names, however it writes capitals and blanks; None: none of a trajectory."""
    name, unit = name_and_unit(heading)
    column = re.sub(r"[\s_-]+", "_", name.strip().lower())
    return Target(column, unit) if column in COLUMNS else None


def columns_used(written: TableText, mapping: ColumnMapping) -> tuple[list[UsedColumn], list[str]]:
    """Columns that a table gives, and headings ignored. CaseError: headings are not understood; it names all of them."""
    shown, headings, targets = written.source, written.headings, dict(mapping.targets)
    if headings is None and not targets:
        write = "".join(f' --column "{number + 1} = {name}"' for number, name in enumerate(["time [s]", "crank_angle [deg]"]))
        accepted = f"name the columns by position:{write}, or write them into {path_shown(mapping_file(shown))} (--write-mapping)"
        raise CaseError(shown, written.place, None, "has numbers where a heading is due", accepted)
    used, ignored, unknown = list[UsedColumn](), list[str](), list[str]()
    for place in range(written.width):
        number, heading = str(place + 1), "" if headings is None else headings[place]
        name, unit = name_and_unit(heading)
        given = [targets.pop(each) for each in [*targets] if each in (number, *filter(None, (heading, name)))]  # an option after the file
        target = given[-1] if given else own_name(heading)
        if target is None or target.column == IGNORED:
            is_unknown = target is None and headings is not None and _is_misspelt(name, heading, unit)
            (unknown if is_unknown else ignored).append(heading or f"column {number}")
            continue
        if any(target.column == other.target.column for other in used):
            accepted = f'ignore one of the two and, for another rate, its columns: --column "{number} = -"'
            raise CaseError(shown, written.place, as_written(heading), f"gives {target.column} a second time", accepted)
        unit = unit if target.unit is None else target.unit
        factor = 1.0 if unit is None else unit_factor(shown, f"{written.place}, {target.column}", _si_unit(target.column), unit)
        used.append(UsedColumn(place, replace(target, unit=unit), factor))
    if targets:
        heads = ", ".join(headings or [f"1 to {written.width}"])
        raise CaseError(shown, None, as_written(next(iter(targets))), "is no heading of this table", f"it has {heads}; or {ADVICE}")
    names = [each.target.column for each in used]
    if unknown or "time" not in names or len(names) < 2:
        _refuse(shown, written.place, names, unknown, ignored)
    return used, ignored


def _refuse(shown: str, place: str, names: Sequence[str], unknown: Sequence[str], ignored: Sequence[str]) -> None:
    """Raise the CaseError of a table that lacks time or all other columns, or has headings near to a column; it names them all."""
    complete = "time" in names and len(names) > 1
    near = {each: near_column(each) for each in (*unknown, *(() if complete else ignored))}
    listed = [as_written(each) + (f" (nearest: {_with_unit(each, column)})" if column else "") for each, column in near.items()]
    lacks = "" if complete else ", and no column time" if "time" not in names else ", and time alone is left"
    accepted = (
        'name them by --column "HEADING = column [unit]" or --write-mapping; `quickreturn show CASE --for-other-tools` lists all columns'
    )
    if "time" not in names:
        accepted += f"; or {ADVICE}"
    if listed:
        verb = "is no column of a trajectory" if len(listed) == 1 else "are no columns of a trajectory"
        raise CaseError(shown, place, None, f"{', '.join(listed)} {verb}{lacks}", accepted)
    lacks = "has no column time" if "time" not in names else "holds time alone"
    raise CaseError(shown, place, None, lacks, "give time and what was recorded, e.g. crank_angle and tip_deflection")


def _with_unit(heading: str, column: str) -> str:
    """A column with the unit that a heading names, if it names one."""
    return f"{column} [{unit}]" if (unit := unit_in(heading, column)) else column


def _is_misspelt(name: str, heading: str, unit: str | None) -> bool:
    """Whether a heading is nearly the name of a column, in a unit of that column if it has one."""
    column = similar_name(name, _MEANT)
    return bool(column) and (unit is None or bool(unit_in(heading, column)))
