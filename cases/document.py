"""The text of a case file as raw values by dotted key, before anything is read as a quantity; and changes made to it by `--set`."""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from cases.broken_toml import broken_toml
from cases.errors import CaseError, as_written, nearest, nearest_or_all, shortened
from cases.keys import (
    HEADER,
    OPTIONAL_SECTIONS,
    PRESCRIBED,
    SECTIONS,
    SECTIONS_OF_MECHANISM,
    SPIN_UP,
    TORQUE_DRIVEN,
    all_paths,
    key_of,
)
from cases.text_file import LARGEST_TEXT

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
        values: dotted key -> string or list, as read.
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
        return CaseError(source, path, None if given is None else as_written(given), problem, accepted)

    def blame(self, *paths: str) -> str:
        """Of keys that do not fit together the one to name: the first that `--set` gave, else the first."""
        return next((path for path in paths if path in self.overridden), paths[0])


def read_document(text: str, source: str) -> Document:
    """Parse TOML and check that it holds only known sections and keys of the right TOML types.

    Raises:
        CaseError: broken TOML, an unknown or misplaced key, a value that is no string.
    """
    if len(text) > LARGEST_TEXT:
        raise CaseError(source, None, None, f"the text has {len(text)} characters", f"at most {LARGEST_TEXT} are accepted")
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > LONGEST_LINE:
            raise CaseError(source, None, None, f"line {number} has {len(line)} characters", f"at most {LONGEST_LINE} are accepted")
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise CaseError(source, None, None, "is nested too deeply", "sections with strings and lists of strings are accepted") from None
    except ValueError as broken:
        raise broken_toml(source, text, str(broken)) from None

    header = {key: value for key, value in content.items() if key in HEADER}
    values: dict[str, Any] = {}
    for name, section in content.items():
        if name in HEADER:
            continue
        _check_section(source, name, section)
        for key, value in section.items():
            _check_key(source, name, key, value)
            values[f"{name}.{key}"] = value
    return Document(source, header, values, frozenset(content) & frozenset(SECTIONS))


def _check_section(source: str, name: str, section: Any) -> None:
    if name not in SECTIONS:
        shown = shortened(name)
        if isinstance(section, dict):
            raise CaseError(source, shown, None, "unknown section", nearest_or_all(name, tuple(SECTIONS)))
        if homes := [path for path in all_paths() if path.endswith(f".{name}")]:
            raise CaseError(source, shown, as_written(section), "stands outside its section", f"accepted as {' or '.join(homes)}")
        raise CaseError(source, shown, as_written(section), "belongs to an unknown key", nearest_or_all(name, (*HEADER, *SECTIONS)))
    if not isinstance(section, dict):
        raise CaseError(source, name, as_written(section), "is no section", f"write [{name}] with its keys below")


def _check_key(source: str, section: str, key: str, value: Any) -> None:
    path = f"{section}.{key}"
    if key not in SECTIONS[section]:
        raise unknown_key(source, path, value)
    wanted = key_of(path)
    example = wanted.dimension.example
    if wanted.count is None:
        if not isinstance(value, str):
            also = ', or "inf"' if wanted.infinity_accepted else ""
            accepted = f"write a string with number and unit, such as {example}{also}"
            raise CaseError(source, path, as_written(value), _wrong_type(value), accepted)
    elif not isinstance(value, list) or len(value) != wanted.count or not all(isinstance(item, str) for item in value):
        problem = (
            f"has {len(value)} {'entry' if len(value) == 1 else 'entries'}"
            if isinstance(value, list) and len(value) != wanted.count
            else "is no list of strings"
        )
        raise CaseError(source, path, as_written(value), problem, f"a list of exactly {wanted.count} strings such as {example} is accepted")


def _wrong_type(value: Any) -> str:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return "is a bare number"
    return "is no string"


def unknown_key(source: str, path: str, value: Any) -> CaseError:
    """The message for a dotted key that no case file has."""
    section, _, key = path.partition(".")
    if isinstance(value, dict):
        accepted = f"the keys of [{shortened(section)}] stand directly below it"
        return CaseError(source, shortened(path), None, "is a section inside a section", accepted)
    return CaseError(source, shortened(path), as_written(value), "belongs to an unknown key", _known_instead(section, key))


def _known_instead(section: str, key: str) -> str:
    """What to write instead of an unknown key: where it belongs, a near one, or all of its section."""
    if homes := [known for known in all_paths() if known.endswith(f".{key}")]:
        return f"the nearest known one is {' or '.join(homes)}"
    if section not in SECTIONS:
        return f"the nearest known one is {nearest(f'{section}.{key}', all_paths())}"
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


def overridden(document: Document, overrides: Mapping[str, str]) -> Document:
    """The document with values replaced.

    The two ways of driving the crank replace each other as a whole: setting `crank.prescribed_speed` drops the file's torque,
    damping and initial speed, and setting any of these drops the file's prescribed speed. Setting both is a conflict and stays one.
    An initial speed that the file states stays when torque or damping change: only where it is left out the crank starts at
    torque / damping.

    Args:
        document: as read.
        overrides: dotted key -> text as in the file, without the quotes (they are accepted, too); lists as in the file.

    Raises:
        CaseError: an unknown key, or a text that is no list where one is needed.
    """
    values = dict(document.values)
    if PRESCRIBED in overrides and not any(path in overrides for path in TORQUE_DRIVEN):
        values = {path: value for path, value in values.items() if path not in TORQUE_DRIVEN}
    if PRESCRIBED not in overrides and any(path in overrides for path in TORQUE_DRIVEN):
        values.pop(PRESCRIBED, None)
    for path, text in overrides.items():
        if path in HEADER:
            raise CaseError(OVERRIDE, path, as_written(text), "cannot be set", "only quantities can, such as crank.torque")
        if path not in all_paths():
            raise unknown_key(OVERRIDE, path, text)
        value = _value_of(text)
        section, _, key = path.partition(".")
        _check_key(OVERRIDE, section, key, value)
        values[path] = value
    sections = document.sections | {path.partition(".")[0] for path in overrides}
    return replace(document, values=values, sections=frozenset(sections), overridden=frozenset(overrides))


def _value_of(text: str) -> Any:
    """A text of the command line as TOML reads it, or else the text itself: quotes are optional there."""
    if len(text) <= LONGEST_LINE and re.fullmatch(r"\[.*\]|\".*\"|'.*'", text):
        try:
            return tomllib.loads(f"value = {text}")["value"]
        except ValueError:
            return text
    return text


def check_complete(document: Document) -> None:
    """Raise CaseError, naming it, if a section or key is missing that cannot be left out, or where crank and spin-up do not go together.

    The crank's drive is checked apart.
    """
    alone = _is_alone(document)
    for section, keys in SECTIONS.items():
        if section not in document.sections:
            if section in OPTIONAL_SECTIONS or (alone and section in SECTIONS_OF_MECHANISM):
                continue
            raise CaseError(document.source, f"[{section}]", None, "this section is missing", f"its keys are {', '.join(keys)}")
        for name, key in keys.items():
            path = f"{section}.{name}"
            optional = (
                path in (PRESCRIBED, *TORQUE_DRIVEN) or (path in SPIN_UP and not alone) or (alone and path == "mechanism.pivot_distance")
            )
            if path not in document.values and key.default is None and not optional:
                raise missing(document, path)


def _is_alone(document: Document) -> bool:
    """Whether the scene is a follower alone: no crank, and a base that is spun up.

    Raises:
        CaseError: a crank and a base that is spun up, neither, or without a crank what only a crank gives a meaning.
    """
    given = [path for path in SPIN_UP if path in document.values]
    choice = f"give either [crank], or {' and '.join(SPIN_UP)} for the follower alone"
    if "crank" in document.sections:
        if given:
            raise document.error(given[0], "conflicts with [crank], which turns the follower", choice)
        return False
    if not given:
        raise CaseError(document.source, "[crank]", None, "this section is missing", choice)
    if "slider" in document.sections:
        raise CaseError(document.source, "[slider]", None, "conflicts with the missing [crank], on whose tip it would sit", choice)
    if "mechanism.pivot_distance" in document.values:
        raise document.error(
            "mechanism.pivot_distance",
            "conflicts with the missing [crank], from whose axis it is measured",
            "leave it out, or give [crank]",
        )
    return True


def missing(document: Document, path: str) -> CaseError:
    """The message for a key that must be there."""
    key = key_of(path)
    return document.error(path, "this key is missing", f"write {key.dimension.name}, such as {key.dimension.example}")
