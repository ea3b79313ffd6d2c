"""Reads a text file that a person names, and says in one sentence why it cannot."""

import os
import stat

from cases.errors import CaseError, path_shown


def read_text(path: str, what: str = "a case file or the name of a library case", largest: int = 64_000) -> str:
    """The text of a file, without byte order mark and with plain line ends.

    Args:
        path: of the file.
        what: may be given, for messages.
        largest: size in bytes.

    Raises:
        CaseError: missing, no regular file, unreadable, too large or not in UTF-8.
    """
    shown, instead = path_shown(path), f"give the path of {what}"
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):  # opening a pipe would wait for ever
            raise CaseError(shown, None, None, "is no regular file", instead)
        with open(path, "rb") as file:
            content = file.read(largest + 1)
    except FileNotFoundError:
        raise CaseError(shown, None, None, "there is no such file", instead) from None
    except (OSError, ValueError) as trouble:  # ValueError: a null character in the path
        reason = trouble.strerror if isinstance(trouble, OSError) else trouble
        raise CaseError(shown, None, None, f"cannot be read ({reason})", instead) from None
    if len(content) > largest:
        raise CaseError(shown, None, None, f"is larger than {largest // 1000} kB", instead)
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as wrong:
        line = content.count(b"\n", 0, wrong.start) + 1
        raise CaseError(shown, None, None, f"is not in UTF-8 (line {line})", "save it as plain text in UTF-8") from None
