"""Names and titles of copies of a case: they state the changes."""

import hashlib
import re
from collections.abc import Mapping
from typing import Any, Final

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
