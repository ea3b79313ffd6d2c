"""Parses a TOML text, or says why it cannot be parsed: the line, its text, and what is accepted."""

import re
import tomllib
from typing import Any, Final

from quickreturn.cases.files.errors import CaseError, as_written

#: Lines are limited, because one long dotted key costs the TOML parser quadratic time and memory.
LONGEST_LINE: Final = 1_000
_ACCEPTED: Final = 'write [section] or key = "number unit", such as length = "4 in"'
#: The parser's message at the end of a text -> the quote that is not closed: the last one in the text.
_NEVER_CLOSED: Final = {"Unterminated string": '"""', 'Expected "\'"': "'", "Expected \"'''\"": "'''"}
_TYPOGRAPHIC: Final = re.compile(r"[“”„‟‘’‚‛«»]")


def toml_of(text: str, source: str) -> dict[str, Any]:
    """The content of a TOML text. CaseError, which names `source`: it is none, or has a line that is too long."""
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > LONGEST_LINE:
            raise CaseError(source, None, None, f"line {number} has {len(line)} characters", f"at most {LONGEST_LINE} are accepted")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise CaseError(source, None, None, "is nested too deeply", "sections with strings and lists of strings are accepted") from None
    except ValueError as broken:
        raise broken_toml(source, text, str(broken)) from None


def broken_toml(source: str, text: str, complaint: str) -> CaseError:
    """The CaseError for a complaint of Python's parser, with its line.

    Args:
        source: name of the text in messages.
        text: text of the file.
        complaint: the parser's sentence, which ends in "(at line 3, column 7)" or "(at end of document)".
    """
    words, place = re.fullmatch(r"(.*?)(?: \(at (?:line (\d+), column \d+|end of document)\))?", complaint, re.DOTALL).groups()  # type: ignore[union-attr]
    number = int(place) if place else _line_of_the_end(text, words)
    line = text.split("\n")[number - 1].strip()
    key, value = f"line {number}", as_written(line)
    if re.match(r"Cannot (overwrite|declare|mutate)", words):
        return CaseError(source, key, value, "repeats an earlier key or section", "give each of them once")
    if _TYPOGRAPHIC.search(line):
        return CaseError(source, key, value, "is no valid TOML: it has typographic quotes", _ACCEPTED)
    return CaseError(source, key, value, f"is no valid TOML: {words[:1].lower()}{words[1:]}", _ACCEPTED)


def _line_of_the_end(text: str, words: str) -> int:
    """The line of the mistake in a text that ends too early: the line of an unclosed quote, otherwise the last line that is not blank."""
    place = text.rfind(_NEVER_CLOSED[words]) if words in _NEVER_CLOSED else -1
    return text.count("\n", 0, place if place >= 0 else len(text.rstrip())) + 1
