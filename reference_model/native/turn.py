"""Turns of processes: one compiles, and the others wait for it."""

import os
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

#: Time (s) after which a process waits no longer and compiles itself.
PATIENCE: Final = 600.0
_LOOK_INTERVAL: Final = 0.02  # s
#: The process that this one waits for, if any.
_waits_for: Final[list[int]] = []


def waits_for() -> int:
    """Number of the process that compiles what this one needs; 0 if this one does not wait."""
    return _waits_for[-1] if _waits_for else 0


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
                self._lock = sqlite3.connect(self._path, timeout=0.0, isolation_level=None, check_same_thread=False)
                self._wait()
                self._holder.write_text(str(os.getpid()))

    def give_back(self) -> None:
        """Let another process take the turn."""
        if self._lock is not None:
            with suppress(OSError):
                self._holder.unlink()
            self._lock.close()
            self._lock = None

    def _wait(self) -> None:
        import sqlite3

        until = time.monotonic() + PATIENCE
        try:
            while time.monotonic() < until:
                try:
                    self._lock.execute("BEGIN EXCLUSIVE")
                    return
                except sqlite3.OperationalError as error:
                    if error.sqlite_errorcode != sqlite3.SQLITE_BUSY:
                        raise
                _waits_for[:] = [self._number()]
                if waits_for() == os.getpid():  # an attempt that has failed
                    return
                time.sleep(_LOOK_INTERVAL)
        finally:
            _waits_for.clear()

    def _number(self) -> int:
        """The process that has the turn; 0 while it is not known."""
        with suppress(OSError, ValueError):
            return int(self._holder.read_text())
        return 0
