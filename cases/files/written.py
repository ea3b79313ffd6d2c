"""Writes a case file: values with their meanings, and further possible keys as comments.

Meanings come from the quantities in `reference_model.mechanism`; a new quantity needs no change here.
"""

import json
import math
import textwrap
from collections.abc import Sequence
from typing import Any, Final

from quickreturn.cases.files.document import Document
from quickreturn.cases.files.keys import PATHS, SECTIONS, dimension_of, si_text
from quickreturn.cases.files.table import text_of_table
from quickreturn.reference_model.scene_values import ALTERNATIVES, DESCRIPTIONS, OPTIONAL_SECTIONS, SPIN_UP
from quickreturn.reference_model.table import Table

_WIDTH: Final = 110  # characters of a line of prose
_COLUMN: Final = 50  # largest width of keys with values, before their comments; longer ones push their own comment

_MACHINE: Final = (
    "A crank turns about O. Its end carries a slider, which rides along the follower, a flexible arm that turns about P. P lies on the"
    " axis n1 from O; n2 is a quarter turn counter-clockwise from n1."
)
_SYNTAX: Final = (
    'Each number is a text: one plain decimal number, one space, one unit, such as "450 mm", "2 N*m" or "120 rpm".',
    'What follows a "#" is a comment. To use a key behind one, remove the "#" and write a number for "...".',
)


def as_toml(document: Document, remarks: Sequence[str] = ()) -> str:
    """The text of a case file; what it describes is the same to the last digit.

    Args:
        document: the values; texts stay as written, numbers in SI get their unit.
        remarks: sentences for the head of the file.

    Raises:
        CaseError: a case file cannot hold a value, such as NaN.
    """
    machine = [_MACHINE] if "crank" in document.values else []
    lines = [*_prose(*remarks, *machine, *_SYNTAX), *(f"{key} = {_toml(value)}" for key, value in document.header.items())]
    for section in SECTIONS:
        lines += _section(document, section)
    return "\n".join(lines) + "\n"


def _prose(*sentences: str) -> list[str]:
    return [f"# {line}" for sentence in sentences for line in textwrap.wrap(sentence, _WIDTH)]


def _section(document: Document, section: str) -> list[str]:
    """The lines of a section; all are comments if the document lacks the section but could have it."""
    paths = [f"{section}.{key}" for key in SECTIONS[section]]
    rows = [_row(document, path) for path in paths if document.at(path) is not None or _possible(document, path)]
    if not rows:
        return []
    optional = "Optional. " if section in OPTIONAL_SECTIONS else ""
    about = _prose(optional + DESCRIPTIONS[section]) if section in DESCRIPTIONS else []
    width = min(max(len(text) for text, _ in rows), _COLUMN)
    lines = [f"{text:{width}}  # {comment}" if comment else text for text, comment in rows]
    return ["", *about, f"[{section}]" if section in document.values else f"# [{section}]", *lines]


def _row(document: Document, path: str) -> tuple[str, str]:
    """Key with value, and a comment; a key that is absent becomes a comment as a whole."""
    key, value = path.partition(".")[2], document.at(path)
    text = f"# {key} = {_default(path)}" if value is None else f"{key} = {_value(document, path, value)}"
    return text, _comment(path, absent=value is None)


def _possible(document: Document, path: str) -> bool:
    """Whether an absent key could be there: the follower alone has no crank and no slider, the others no spin-up."""
    if all(document.at(spun) is None for spun in SPIN_UP):
        return path not in SPIN_UP
    return not path.startswith(("crank.", "slider.", "spring.", "tip.force", "tip.friction")) and path != "mechanism.pivot_distance"


def _comment(path: str, *, absent: bool) -> str:
    """The meaning of a key, whether it is optional, and the keys that it replaces."""
    wanted, key = PATHS[path], path.partition(".")[2]
    parts = ["" if wanted.meaning == key.replace("_", " ") else wanted.meaning]
    if wanted.infinity:
        parts.append('"inf": rigid')
    others = dict(ALTERNATIVES).get(path, ()) if absent else ()
    replaced = [other.partition(".")[2] for other in others if other not in dict(ALTERNATIVES)]
    if replaced:
        parts.append(f"in place of {' and '.join(filter(None, (', '.join(replaced[:-1]), replaced[-1])))}")
    told = "; ".join(filter(None, parts))
    return ": ".join(filter(None, ("optional" * wanted.optional, told)))


def _default(path: str) -> str:
    """The default value of an absent key; dots for the number if there is no single default."""
    wanted, dimension = PATHS[path], dimension_of(path)
    values = wanted.default if isinstance(wanted.default, tuple) else (wanted.default,) * (wanted.count or 1)
    if all(isinstance(value, float) and (math.isfinite(value) or (wanted.infinity and value == math.inf)) for value in values):
        texts = [f'"{math.degrees(value):.9g} deg"' if wanted.unit == "rad" else f'"{si_text(path, value)}"' for value in values]
    else:
        unit = wanted.unit if wanted.unit in dimension.examples else dimension.examples[0]
        texts = [f'"...{" .csv" if wanted.in_file else "" if wanted.unit == "1" else f" {unit}"}"'] * (wanted.count or 1)
    return texts[0] if wanted.count is None else f"[{', '.join(texts)}]"


def _value(document: Document, path: str, value: Any) -> str:
    """A value as TOML: a text as it is written, a number in SI with all its digits."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_value(document, path, one) for one in value)}]"
    if isinstance(value, str):
        return _toml(value)
    if isinstance(value, Table):
        return f'"""\n{text_of_table(value)}\n"""'
    wanted = PATHS[path]
    if not math.isfinite(value) and not (wanted.infinity and value == math.inf):
        raise document.error(path, "cannot stand in a case file", "a finite number is needed", value=value)
    return f'"{si_text(path, value)}"'


def _toml(value: Any) -> str:
    """A text, or a list of texts, as TOML writes it: as JSON does."""
    return json.dumps(value, ensure_ascii=False)
