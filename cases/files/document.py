"""The text of a case file as raw values by dotted key, before they are read as quantities; its changes, and the names of changed copies."""

import hashlib
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from quickreturn.cases.files.errors import Argument, CaseError, as_written, attempted, nearest_or_all, shortened, together
from quickreturn.cases.files.keys import HEADER, PATHS, SECTIONS, dimension_of, shown_value, text_of, usual_unit
from quickreturn.cases.files.table import read_table
from quickreturn.cases.files.text_file import LONGEST_LINE, toml_of
from quickreturn.reference_model.scene_values import changed_values, replaced_by

#: Largest number of characters of a name, and of a title.
LONGEST_NAME: Final = 64
LONGEST_TITLE: Final = 200
#: Characters of the hash at the end of a shortened name: two copies share it with a probability of 2^-32.
_HASH: Final = 8


def in_words(value: Any) -> str:
    """A raw value, such as "5 in", or several as "(0 m/s^2, -9.81 m/s^2)"."""
    return value if isinstance(value, str) else f"({', '.join(map(str, value))})"


def with_changes(title: str, overridden: Mapping[str, Any]) -> str:
    """A title with the values that override those of the file, because it may contain the old ones; their number if there is no room."""
    if not overridden:
        return title
    *others, last = (f"{path} = {in_words(value)}" for path, value in overridden.items())
    told = f"{title}, with {', '.join(others)}{' and ' if others else ''}{last}"
    return told if len(told) <= LONGEST_TITLE else f"{title}, with {len(overridden)} other values"


def name_of_copy(name: str, before: Mapping[str, Any], changes: Mapping[str, Any]) -> str:
    """The name with the changes; earlier changes of the same key are removed from it.

    A name that would be too long ends in a hash of the whole name.
    """
    for path in changes:
        if path in before:
            name = name.replace(_part(path, before[path]), "")
    full_name = name + "".join(_part(path, value) for path, value in changes.items())
    if len(full_name) <= LONGEST_NAME:
        return full_name
    return f"{full_name[: LONGEST_NAME - _HASH - 1]}-{hashlib.sha256(full_name.encode()).hexdigest()[:_HASH]}"


def _part(path: str, value: Any) -> str:
    """A change as a part of a name: "-crank.length-5-in". Characters that a name cannot have become hyphens."""
    return "-" + re.sub(r"[^A-Za-z0-9._-]", "-", f"{path}-{in_words(value)}".replace("+", ""))


#: Names of cases and tags.
NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")

#: Source of a value set from outside, in messages.
OVERRIDES: Final = Argument("overrides")


@dataclass(frozen=True)
class Document:
    """Raw values of a case."""

    source: str  # file or case name, for messages
    header: Mapping[str, Any]  # name, title and tags as read
    # section -> key -> string or list as read, or numbers in SI if the case was not a text; a table always with its numbers
    values: Mapping[str, Mapping[str, Any]]
    overridden: Mapping[str, Any] = field(default_factory=dict)  # dotted key -> text(s) of a value set from outside, latest last
    set_by: str = OVERRIDES  # source of these values, for messages
    mistakes: tuple[CaseError, ...] = ()  # mistakes in sections and keys, which the values therefore lack
    replaced: Mapping[str, str] = field(default_factory=dict)  # dotted key that they removed -> the key that takes its place

    def at(self, path: str) -> Any:
        """The value at a dotted key, or at a key of the header; None if there is none."""
        section, _, key = path.partition(".")
        return self.values.get(section, {}).get(key) if key else self.header.get(path)

    def error(self, path: str, problem: str, accepted: str = "", *, value: Any = None) -> CaseError:
        """The mistake at a dotted key, with its value as written (or a part of it, `value`) if there is one."""
        given = self.at(path) if value is None else value
        if path in self.overridden:
            given = text_of(path, given)
        shown = None if given is None else as_written(given)
        if isinstance(given, (float, tuple)):
            shown = f"{shown_value(given)} {PATHS[path].unit}"
        return CaseError(self.set_by if path in self.overridden else self.source, path, shown, problem, accepted)

    def blame(self, *paths: str) -> str:
        """Of keys that contradict each other the one to name: the first that was set from outside, otherwise the first."""
        return next((path for path in paths if path in self.overridden), paths[0])

    def changed(self, changes: Mapping[str, Any], by: str) -> "Document":
        """The document with raw values, or numbers in SI, set from outside, by dotted key; see `changed_values`.

        Messages name `by` as the source of the new values.
        """
        given = {path: text_of(path, value) for path, value in changes.items() if value is not None}
        gone = [path for path in replaced_by(given) if path not in given]
        instead = {path: next(key for key in given if path in replaced_by([key])) for path in gone if self.at(path) is not None}
        return replace(
            self,
            values=changed_values(self.values, changes),
            overridden={path: text for path, text in self.overridden.items() if path not in (*gone, *changes)} | given,
            set_by=by,
            replaced={**self.replaced, **instead},
        )

    def overridden_by(self, texts: Mapping[str, str], by: str = OVERRIDES) -> "Document":
        """`changed` by texts as on the command line: as in the file, or as TOML reads them.

        Raises:
            CaseError: a key that cannot be set, or a value of the wrong kind.
        """
        values, mistakes = dict[str, Any](), list[CaseError]()
        for path, text in texts.items():
            values[path] = _value_of(text) if isinstance(text, str) else list(text) if isinstance(text, tuple) else text
            if path in HEADER:
                mistakes.append(CaseError(by, path, as_written(text), "cannot be set", "only quantities can, such as crank.torque"))
            else:
                values[path] = attempted(mistakes, _accepted, by, path, values[path], "", self.values)
        if mistakes:
            raise together([*self.mistakes, *mistakes])
        return self.changed(values, by)


def check_mapping(overrides: Any) -> Mapping[str, str]:
    """The argument itself. CaseError: it is not a mapping."""
    if not isinstance(overrides, Mapping):
        raise CaseError("overrides", None, None, f"{as_written(overrides)} is not a dictionary", 'such as {"crank.length": "5 in"}')
    return overrides


def read_document(text: str, source: str, folder: str = "") -> Document:
    """Parse TOML, and keep the known sections and keys whose values have the right TOML types; read the table that a key names.

    An unknown or misplaced key, a value that is not a string, or a mistake in a table becomes one of the document's mistakes.

    Args:
        text: TOML.
        source: its name, for messages.
        folder: where the paths in it begin; "": the present one.

    Raises:
        CaseError: broken TOML.
    """
    content = toml_of(text, source)
    header: dict[str, Any] = {key: content.pop(key) for key in HEADER if key in content}
    mistakes: list[CaseError] = []
    values: dict[str, dict[str, Any]] = {}
    for name, section in content.items():
        if name not in SECTIONS:
            mistakes.append(_unknown(source, name, section))
        elif not isinstance(section, dict):
            mistakes.append(CaseError(source, name, as_written(section), "is not a section", f"write [{name}] with its keys below"))
        else:
            read = {key: attempted(mistakes, _accepted, source, f"{name}.{key}", value, folder, content) for key, value in section.items()}
            values[name] = {key: value for key, value in read.items() if value is not None}
    return Document(source, header, values, mistakes=tuple(mistakes))


def _accepted(source: str, path: str, value: Any, folder: str, others: Mapping[str, Any]) -> Any:
    """The value itself, or the table that it names.

    CaseError: an unknown key; a value that is neither a string nor, for a vector, a list of so many strings; a mistake in a table.
    """
    if path not in PATHS:
        raise _unknown(source, path, value)
    wanted, example = PATHS[path], dimension_of(path).example_in(usual_unit(path, others))
    if wanted.count is None:
        fits, problem = isinstance(value, str), "is a bare number" if type(value) in (int, float) else "is not a string"
        accepted = f"write a string with number and unit, such as {example}" + (', or "inf"' if wanted.infinity else "")
        if wanted.in_file:
            accepted = 'write the path of a CSV file, such as "cutting.csv"'
    else:
        fits = isinstance(value, list) and len(value) == (wanted.count or len(value)) and all(isinstance(item, str) for item in value)
        what = f"{path.partition('.')[2].replace('_', ' ')}: {wanted.meaning}"
        problem = f"is not a list of {wanted.count or ''} strings ({what})".replace("  ", " ")
        accepted = f"write one such as [{', '.join([example] * (wanted.count or 2))}]"
    if not fits:
        raise CaseError(source, path, as_written(value), problem, accepted)
    return read_table(value, source, path, folder) if wanted.in_file else value


def _unknown(source: str, path: str, value: Any) -> CaseError:
    """The message for an unknown section or key: where such a key belongs, otherwise the known names."""
    section, _, key = path.rpartition(".")
    section = section or path
    alike = [f"{section}.{name}" for name in SECTIONS.get(section, ()) if name.endswith(f"_{key}")]
    whole = [f"{section}.{name}" for name in SECTIONS.get(section, ()) if key.startswith(f"{name}_")]
    if homes := [*alike, *(known for known in PATHS if known.endswith(f".{key}"))] or whole:
        accepted = f"the nearest known one is {' or '.join(homes)}"
    elif section in SECTIONS:
        accepted = nearest_or_all(key, tuple(SECTIONS[section]), f"{section}.")
    else:
        accepted = nearest_or_all(key, (*HEADER, *SECTIONS))
    problem = "is an unknown section" if isinstance(value, dict) else "belongs to an unknown key"
    return CaseError(source, shortened(path), as_written(value), problem, accepted)


def header_of(document: Document) -> tuple[str, str, tuple[str, ...]]:
    """Name, title and tags; only the name must be there. CaseError: all mistakes in them."""
    name: Any = document.header.get("name")
    mistakes = list[CaseError]()
    if name is None:
        mistakes.append(document.error("name", "this key is missing", 'write a name, such as name = "stiffer-follower"'))
    elif not isinstance(name, str) or not NAME.fullmatch(name):
        signs = "up to 64 letters from a to z, digits, points, hyphens and underscores in quotes"
        accepted = f"{signs}, beginning with a letter or digit, are accepted"
        mistakes.append(document.error("name", "is not a name", accepted))
    title = document.header.get("title", name or "")
    if not isinstance(title, str) or not title.isprintable() or len(title) > LONGEST_TITLE:
        mistakes.append(document.error("title", "is not a title", f"one line of up to {LONGEST_TITLE} characters in quotes is accepted"))
    tags = document.header.get("tags", [])
    if not isinstance(tags, list) or not all(isinstance(tag, str) and NAME.fullmatch(tag) for tag in tags):
        mistakes.append(document.error("tags", "is not a list of tags", 'write one such as ["thesis", "fast"], each tag like a name'))
    if mistakes:
        raise together(mistakes)
    return name, title, tuple(tags)


def _value_of(text: str) -> Any:
    """A text of the command line as TOML reads it, or else the text itself: quotes are optional there."""
    if len(text) <= LONGEST_LINE and re.fullmatch(r"\[.*\]|\".*\"|'.*'", text):
        try:
            return tomllib.loads(f"value = {text}")["value"]
        except ValueError:
            return text
    return text
