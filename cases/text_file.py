"""Reads a text file that a person names, and says in one sentence why it cannot."""

import os
import stat
from dataclasses import dataclass
from typing import Final

from cases.errors import CaseError, path_shown


@dataclass(frozen=True)
class Kind:
    """What a file shall be.

    Attributes:
        name: with its article.
        form: of the text.
        largest: size in bytes.
        usual: size, in words.
        instead: what may be given instead of its path, as a clause that follows "give the path of a ...".
    """

    name: str
    form: str
    largest: int
    usual: str
    instead: str = ""


CASE_FILE: Final = Kind("a case file", "a TOML text", 64_000, "some 2 kB", " or the name of a library case")


def read_text(path: str, kind: Kind = CASE_FILE) -> str:
    """The text of a file, without byte order mark and with plain line ends.

    Raises:
        CaseError: missing, a directory, no regular file, unreadable, too large or not in UTF-8.
    """
    shown = path_shown(path)
    try:
        mode = os.stat(path).st_mode
        if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):  # opening a pipe would wait for ever
            raise CaseError(shown, None, None, "is no regular file", f"{kind.name} is {kind.form}")
        with open(path, "rb") as file:
            content = file.read(kind.largest + 1)
    except FileNotFoundError:
        raise CaseError(shown, None, None, "there is no such file", f"give the path of {kind.name}{kind.instead}") from None
    except IsADirectoryError:
        raise CaseError(shown, None, None, "is a directory", f"give the path of {kind.name} in it") from None
    except (OSError, ValueError) as trouble:  # ValueError: a null character in the path
        reason = trouble.strerror if isinstance(trouble, OSError) else str(trouble)
        raise CaseError(shown, None, None, f"cannot be read ({reason})") from None
    if len(content) > kind.largest:
        raise CaseError(shown, None, None, f"is larger than {kind.largest // 1000} kB", f"{kind.name} has {kind.usual}")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as wrong:
        line = content.count(b"\n", 0, wrong.start) + 1
        raise CaseError(shown, None, None, f"is not in UTF-8 (line {line})", "save it as plain text in UTF-8") from None
