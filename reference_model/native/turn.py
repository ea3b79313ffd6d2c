"""Turns of processes: one compiles, and the others wait for it."""

import os
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

#: Time (s) after which a process waits no longer and compiles itself.
PATIENCE: Final = 600.0
#: The file that names the process that this one waits for, if any.
_waits_for: Final[list[Path]] = []


def waits_for() -> int:
    """Number of the process that compiles what this one needs; 0 if this one does not wait."""
    with suppress(OSError, ValueError, IndexError):
        return int(_waits_for[-1].read_text())
    return 0


class Turn:
    """The right to compile something, which one process has at a time; it ends with the process.

    It is a lock on a file, by SQLite, which knows how on each system.

    Args:
        path: of the file, which is made.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._holder = path, path.with_suffix(".process")
        self._lock: Any = None

    def take(self) -> None:
        """Take the turn, once no other process has it.

        Where nothing can be locked, and after `PATIENCE`, the turn is taken without a lock.
        """
        if self._lock is not None:
            return
        with suppress(ImportError, OSError):  # no SQLite, or a folder that cannot be written
            import sqlite3

            self._path.parent.mkdir(parents=True, exist_ok=True)
            with suppress(sqlite3.Error):  # a file system without locks
                self._lock = sqlite3.connect(self._path, timeout=PATIENCE, isolation_level=None, check_same_thread=False)
                _waits_for.append(self._holder)
                try:
                    if waits_for() != os.getpid():  # otherwise an attempt has failed in this process
                        self._lock.execute("BEGIN EXCLUSIVE")
                finally:
                    _waits_for.clear()
                self._holder.write_text(str(os.getpid()))

    def give_back(self) -> None:
        """Let another process take the turn."""
        if self._lock is not None:
            with suppress(OSError):
                self._holder.unlink()
            self._lock.close()
            self._lock = None
