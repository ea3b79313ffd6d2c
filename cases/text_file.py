"""Reads a text file that a person names, and says in one sentence why it cannot."""

import os
import stat
from typing import Final

from cases.errors import CaseError, path_shown

#: Characters of a case file, which has some 2000.
LARGEST_TEXT: Final = 64_000


def read_text(path: str) -> str:
    """The text of a file, without byte order mark and with plain line ends.

    Raises:
        CaseError: missing, a directory, no regular file, unreadable, too large or not in UTF-8.
    """
    shown = path_shown(path)
    try:
        mode = os.stat(path).st_mode
        if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):  # opening a pipe would wait for ever
            raise CaseError(shown, None, None, "is no regular file", "a case file is a TOML text")
        with open(path, "rb") as file:
            content = file.read(LARGEST_TEXT + 1)
    except FileNotFoundError:
        raise CaseError(shown, None, None, "there is no such file", "give the path of a case file or the name of a library case") from None
    except IsADirectoryError:
        raise CaseError(shown, None, None, "is a directory", "give the path of a case file in it") from None
    except (OSError, ValueError) as trouble:  # ValueError: a null character in the path
        reason = trouble.strerror if isinstance(trouble, OSError) else str(trouble)
        raise CaseError(shown, None, None, f"cannot be read ({reason})") from None
    if len(content) > LARGEST_TEXT:
        raise CaseError(shown, None, None, f"is larger than {LARGEST_TEXT // 1000} kB", "a case file has some 2 kB")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as wrong:
        line = content.count(b"\n", 0, wrong.start) + 1
        raise CaseError(shown, None, None, f"is not in UTF-8 (line {line})", "save it as plain text in UTF-8") from None
