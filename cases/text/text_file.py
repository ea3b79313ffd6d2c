"""Reads a text file that the user names, or says in one sentence why it cannot be read."""

import os
import re
import stat
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Final

from quickreturn.cases.errors import CaseError, path_shown, similar_name

#: Largest number of entries of a folder that are searched; a user's own folder has fewer.
_MOST_ENTRIES: Final = 10_000
#: Python's name of an encoding -> its name in messages.
_NAMES: Final = {"utf-8": "", "utf-16": "UTF-16", "utf-16-le": "UTF-16", "utf-16-be": "UTF-16", "cp1252": "Windows-1252"}
#: Characters that no text has: control characters other than tabulators, line ends, form feeds and the end of a file of DOS.
_OF_NO_TEXT: Final = re.compile(r"[\x00-\x08\x0e-\x19\x1b-\x1f\x7f]")
#: Number of bytes in which zeros are counted, and their least part of every second byte in UTF-16: all but a few characters are ASCII.
_SAMPLE, _ZEROS = 4096, 0.7


def read_text(
    path: str, what: str = "a case file or the name of a library case", largest: int = 64_000, library: Sequence[str] = ()
) -> str:
    """The text of a file, without byte order mark and with plain line ends.

    Args:
        path: of the file.
        what: kind of file, for messages.
        largest: size in bytes.
        library: names of the library; one of them may be meant.

    Raises:
        CaseError: the file is missing, not a regular file, unreadable, too large or not in UTF-8.
    """
    content = _content(path, what, largest, library)
    try:
        return _plain(content.decode("utf-8-sig"))
    except UnicodeDecodeError as wrong:
        line = content.count(b"\n", 0, wrong.start) + 1
        raise CaseError(path_shown(path), None, None, f"is not in UTF-8 (line {line})", "save it as plain text in UTF-8") from None


def read_foreign_text(path: str, what: str, largest: int) -> tuple[str, str]:
    """The text of a file of any program, and the name of its encoding; "" for UTF-8.

    UTF-16, which Excel calls Unicode text, has a byte order mark, or a zero in nearly every second byte. Other bytes that are not UTF-8 are
    read as Windows-1252, in which degree sign, micro sign and umlauts are those of Latin-1.

    Raises:
        CaseError: as of `read_text`, but for the encoding; or the file holds bytes that no text has.
    """
    content = _content(path, what, largest)
    for name in _encodings(content):
        try:
            text = content.decode(name)
        except UnicodeDecodeError:
            continue
        if not _OF_NO_TEXT.search(text):
            return _plain(text.removeprefix("\ufeff")), _NAMES[name]
    accepted = "export it as plain text, such as CSV"
    raise CaseError(path_shown(path), None, None, "is no text, but a program's own binary form", accepted)


def _encodings(content: bytes) -> Sequence[str]:
    """The encodings that a content may have, the most probable one first."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return ("utf-16",)
    zeros = [content[:_SAMPLE][first::2].count(0) for first in (0, 1)]
    if max(zeros) > _ZEROS * len(content[:_SAMPLE]) / 2 and min(zeros) == 0:
        return ("utf-16-be",) if zeros[0] else ("utf-16-le",)
    return ("utf-8", "cp1252")


def _plain(text: str) -> str:
    """A text with plain line ends."""
    return text.replace("\r\n", "\n")


def _content(path: str, what: str, largest: int, library: Sequence[str] = ()) -> bytes:
    """The bytes of a file. CaseError: as of `read_text`, but for the encoding."""
    shown, instead = path_shown(path), f"give the path of {what}"
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):  # opening a pipe would wait for ever
            raise CaseError(shown, None, None, "is no regular file", instead)
        with open(path, "rb") as file:
            content = file.read(largest + 1)
    except FileNotFoundError:
        known = similar_name(Path(path).stem, library)
        near = similar_file(path) or (known and f"the library case {known}")
        raise CaseError(shown, None, None, "there is no such file", f"did you mean {near}?" if near else instead) from None
    except (OSError, ValueError) as trouble:  # ValueError: a null character in the path
        reason = trouble.strerror if isinstance(trouble, OSError) else trouble
        raise CaseError(shown, None, None, f"cannot be read ({reason})", instead) from None
    if len(content) > largest:
        raise CaseError(shown, None, None, f"is larger than {largest // 1000} kB", instead)
    if content.startswith(b"PK\x03\x04"):
        raise CaseError(shown, None, None, "is an Excel workbook or another archive", "save it as plain text in UTF-8, such as CSV")
    return content


def similar_file(path: str) -> str:
    """The file in the same folder, with the same ending, whose name resembles that of a path most; "" if there is none."""
    folder, (stem, ending) = os.path.dirname(path), os.path.splitext(os.path.basename(path))
    try:
        with os.scandir(folder or ".") as entries:
            names = [entry.name for entry in islice(entries, _MOST_ENTRIES) if os.path.isfile(entry)]
    except (OSError, ValueError):  # no such folder
        return ""
    near = similar_name(stem, sorted(name.removesuffix(ending) for name in names if ending and name.endswith(ending)))
    return near and path_shown(os.path.join(folder, near + ending))
