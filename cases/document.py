"""The text of a case file as raw values by dotted key, before anything is read as a quantity; and changes made to it by `--set`."""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from cases.broken_toml import broken_toml
from cases.case import Case
from cases.errors import CaseError, as_written, nearest, nearest_or_all, shortened
from cases.keys import HEADER, PATHS, SECTIONS, dimension_of
from cases.text_file import CASE_FILE
from reference_model.scene_values import ALTERNATIVES, values_of

#: Lines are limited, because one long dotted key costs the TOML parser quadratic time and memory.
LONGEST_LINE: Final = 1_000

_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
_LONGEST_TITLE: Final = 200

#: Named as the source of a value that came from the command line.
OVERRIDE: Final = "--set"


@dataclass(frozen=True)
class Document:
    """Raw values of a case.

    Attributes:
        source: file or case name, for messages.
        header: name, title and tags as read.
        values: dotted key -> string or list as read, or numbers in SI of a case that was no text.
        sections: those present.
        overridden: dotted keys that `--set` gave.
    """

    source: str
    header: Mapping[str, Any]
    values: Mapping[str, Any]
    sections: frozenset[str]
    overridden: frozenset[str] = frozenset()

    def error(self, path: str, problem: str, accepted: str = "", *, value: Any = None) -> CaseError:
        """The mistake at a dotted key, with its value as written (or a part of it, `value`) if there is one."""
        given = value if value is not None else self.values.get(path, self.header.get(path))
        source = OVERRIDE if path in self.overridden else self.source
        if given is None:
            return CaseError(source, path, None, problem, accepted)
        in_si = isinstance(given, (float, tuple))
        shown = f"{given:.9g} {PATHS[path].unit}" if isinstance(given, float) else str(given) if in_si else as_written(given)
        return CaseError(source, path, shown, problem, accepted)

    def blame(self, *paths: str) -> str:
        """Of keys that do not fit together the one to name: the first that `--set` gave, else the first."""
        return next((path for path in paths if path in self.overridden), paths[0])

    def overridden_by(self, texts: Mapping[str, str]) -> "Document":
        """The document with values replaced as on the command line: dotted key -> text as in the file, or as TOML reads it.

        Of keys that replace each other, such as the two ways of driving the crank, those that are set drop those that are not. Setting
        both is a conflict and stays one.

        Raises:
            CaseError: a key that cannot be set, or a value of the wrong kind.
        """
        values = dict(self.values)
        for first, others in ALTERNATIVES:
            if first in texts:
                for path in others:
                    values.pop(path, None)
            elif any(path in texts for path in others):
                values.pop(first, None)
        for path, text in texts.items():
            if path in HEADER:
                raise CaseError(OVERRIDE, path, as_written(text), "cannot be set", "only quantities can, such as crank.torque")
            if path not in PATHS:
                raise unknown_key(OVERRIDE, path, text)
            values[path] = _value_of(text) if isinstance(text, str) else list(text) if isinstance(text, tuple) else text
            _check_kind(OVERRIDE, path, values[path])
        sections = self.sections | {path.partition(".")[0] for path in texts}
        return replace(self, values=values, sections=sections, overridden=frozenset(texts))


def values_in_si(case: Case) -> dict[str, dict[str, Any]]:
    """Values of a case by section and key of the case file; sections and keys that the scene lacks are left out."""
    return {**values_of(case.scene), "simulation": {"duration": case.duration, "output_step": case.output_step}}


def document_of(case: Case) -> Document:
    """A case as a document, its values in SI."""
    sections = values_in_si(case)
    values = {f"{section}.{key}": value for section, keys in sections.items() for key, value in keys.items()}
    return Document(case.name, {"name": case.name, "title": case.title, "tags": list(case.tags)}, values, frozenset(sections))


def read_document(text: str, source: str) -> Document:
    """Parse TOML and check that it holds only known sections and keys of the right TOML types.

    Raises:
        CaseError: broken TOML, an unknown or misplaced key, a value that is no string.
    """
    if len(text) > CASE_FILE.largest:
        raise CaseError(source, None, None, f"the text has {len(text)} characters", f"at most {CASE_FILE.largest} are accepted")
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > LONGEST_LINE:
            raise CaseError(source, None, None, f"line {number} has {len(line)} characters", f"at most {LONGEST_LINE} are accepted")
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise CaseError(source, None, None, "is nested too deeply", "sections with strings and lists of strings are accepted") from None
    except ValueError as broken:
        raise broken_toml(source, text, str(broken)) from None

    values: dict[str, Any] = {}
    for name, section in content.items():
        if name in HEADER:
            continue
        _check_section(source, name, section)
        for key, value in section.items():
            path = f"{name}.{key}"
            if path not in PATHS:
                raise unknown_key(source, path, value)
            _check_kind(source, path, value)
            values[path] = value
    header = {key: value for key, value in content.items() if key in HEADER}
    return Document(source, header, values, frozenset(content) & frozenset(SECTIONS))


def _check_section(source: str, name: str, section: Any) -> None:
    if name not in SECTIONS:
        shown = shortened(name)
        if isinstance(section, dict):
            raise CaseError(source, shown, None, "unknown section", nearest_or_all(name, tuple(SECTIONS)))
        if homes := [path for path in PATHS if path.endswith(f".{name}")]:
            raise CaseError(source, shown, as_written(section), "stands outside its section", f"accepted as {' or '.join(homes)}")
        raise CaseError(source, shown, as_written(section), "belongs to an unknown key", nearest_or_all(name, (*HEADER, *SECTIONS)))
    if not isinstance(section, dict):
        raise CaseError(source, name, as_written(section), "is no section", f"write [{name}] with its keys below")


def _check_kind(source: str, path: str, value: Any) -> None:
    """Raise CaseError for what is no string or, where several are wanted, no list of so many."""
    wanted, example = PATHS[path], dimension_of(path).example
    if wanted.count is None:
        if not isinstance(value, str):
            number = isinstance(value, (int, float)) and not isinstance(value, bool)
            also = ', or "inf"' if wanted.infinity else ""
            accepted = f"write a string with number and unit, such as {example}{also}"
            raise CaseError(source, path, as_written(value), "is a bare number" if number else "is no string", accepted)
    elif not isinstance(value, list) or len(value) != wanted.count or not all(isinstance(item, str) for item in value):
        problem = "is no list of strings"
        if isinstance(value, list) and len(value) != wanted.count:
            problem = f"has {len(value)} {'entry' if len(value) == 1 else 'entries'}"
        raise CaseError(source, path, as_written(value), problem, f"a list of exactly {wanted.count} strings such as {example} is accepted")


def unknown_key(source: str, path: str, value: Any) -> CaseError:
    """The message for a dotted key that no case file has."""
    section, _, key = path.partition(".")
    if isinstance(value, dict):
        accepted = f"the keys of [{shortened(section)}] stand directly below it"
        return CaseError(source, shortened(path), None, "is a section inside a section", accepted)
    return CaseError(source, shortened(path), as_written(value), "belongs to an unknown key", _known_instead(section, key))


def _known_instead(section: str, key: str) -> str:
    """What to write instead of an unknown key: where it belongs, a near one, or all of its section."""
    if homes := [known for known in PATHS if known.endswith(f".{key}")]:
        return f"the nearest known one is {' or '.join(homes)}"
    if section not in SECTIONS:
        return f"the nearest known one is {nearest(f'{section}.{key}', PATHS)}"
    answer = nearest_or_all(key, tuple(SECTIONS[section]))
    return answer.replace("one is ", f"one is {section}.") if "one is " in answer else f"{answer.replace('known', f'known in [{section}]')}"


def header_of(document: Document) -> tuple[str, str, tuple[str, ...]]:
    """Name, title and tags; only the name must be there. Raises CaseError."""
    name = document.header.get("name")
    if name is None:
        raise CaseError(document.source, "name", None, "this key is missing", 'write a name, such as name = "stiffer-follower"')
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        accepted = "up to 64 letters, digits, points, hyphens and underscores in quotes, beginning with a letter or digit, are accepted"
        raise document.error("name", "is no name", accepted)
    title = document.header.get("title", name)
    if not isinstance(title, str) or not title.isprintable() or len(title) > _LONGEST_TITLE:
        raise document.error("title", "is no title", f"one line of up to {_LONGEST_TITLE} characters in quotes is accepted")
    tags = document.header.get("tags", [])
    if not isinstance(tags, list) or not all(isinstance(tag, str) and _NAME.fullmatch(tag) for tag in tags):
        raise document.error("tags", "is no list of tags", 'write one such as ["thesis", "fast"], each tag like a name')
    return name, title, tuple(tags)


def _value_of(text: str) -> Any:
    """A text of the command line as TOML reads it, or else the text itself: quotes are optional there."""
    if len(text) <= LONGEST_LINE and re.fullmatch(r"\[.*\]|\".*\"|'.*'", text):
        try:
            return tomllib.loads(f"value = {text}")["value"]
        except ValueError:
            return text
    return text
