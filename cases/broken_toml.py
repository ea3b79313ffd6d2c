"""A TOML text that cannot be parsed: which line, what is written there, and what is accepted."""

import re
from typing import Final

from quickreturn.cases.errors import CaseError, as_written

_ACCEPTED: Final = 'write [section] or key = "number unit", such as length = "4 in"'
#: What the parser says at the end of a text, and the quote that nothing closes: the last one that there is.
_NEVER_CLOSED: Final = {"Unterminated string": '"""', 'Expected "\'"': "'", "Expected \"'''\"": "'''"}
_TYPOGRAPHIC: Final = re.compile(r"[“”„‟‘’‚‛«»]")


def broken_toml(source: str, text: str, complaint: str) -> CaseError:
    """The mistake that Python's parser complains of, told with its line.

    Args:
        source: what messages call the text.
        text: of the file.
        complaint: the parser's sentence, which ends in "(at line 3, column 7)" or "(at end of document)".
    """
    words, place = re.fullmatch(r"(.*?)(?: \(at (?:line (\d+), column \d+|end of document)\))?", complaint, re.DOTALL).groups()  # type: ignore[union-attr]
    number = int(place) if place else _line_of_the_end(text, words)
    line = text.split("\n")[number - 1].strip()
    key, value = f"line {number}", as_written(line)
    if re.match(r"Cannot (overwrite|declare|mutate)", words):
        return CaseError(source, key, value, "repeats a key or section that is there already", "give each of them once")
    if _TYPOGRAPHIC.search(line):
        return CaseError(source, key, value, "is no valid TOML: it has typographic quotes", _ACCEPTED)
    return CaseError(source, key, value, f"is no valid TOML: {words[:1].lower()}{words[1:]}", _ACCEPTED)


def _line_of_the_end(text: str, words: str) -> int:
    """Line to blame for a text that ends too early: where a quote stands that nothing closes, else the last one that is not blank."""
    place = text.rfind(_NEVER_CLOSED[words]) if words in _NEVER_CLOSED else -1
    return text.count("\n", 0, place if place >= 0 else len(text.rstrip())) + 1
