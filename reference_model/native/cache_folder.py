"""Where compiled functions are kept on disk: one folder per state of their sources. One process compiles, and the others wait for it.

Numba recompiles a cached function when the function's own file changes, but not when a file that it calls into does. The folder is named
by the hash of this package's sources, so that code compiled from other sources is never taken. It is in the folder that the user has named
for numba's cache, else beside the sources; where these cannot be written it is in the user's cache, and where there is none in a temporary
folder that is removed when the process ends.
"""

import atexit
import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, Final

#: Names the folder of numba's cache, if the user has chosen one.
VARIABLE: Final = "NUMBA_CACHE_DIR"
#: Tells the processes that this one starts of its temporary folder.
_TEMPORARY: Final = "QUICKRETURN_TEMPORARY_CODE"
_PACKAGE: Final = Path(__file__).resolve().parents[1]
#: Where a wheel has its objects (`objects.Entry`).
SHIPPED: Final = Path(__file__).parent / "shipped"


def folder() -> Path:
    """The folder, which need not exist yet."""
    chosen, of_user = os.environ.get(VARIABLE), os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    homes = [_PACKAGE / "__pycache__", Path(of_user) / "quickreturn"]
    for home in [Path(chosen).absolute(), *homes] if chosen else homes:
        if home.is_absolute() and _writable(home):
            return home / f"quickreturn-{source_hash()}"
    return _temporary()


def _temporary() -> Path:
    if _TEMPORARY not in os.environ:
        os.environ[_TEMPORARY] = tempfile.mkdtemp(prefix="quickreturn-")
        atexit.register(shutil.rmtree, os.environ[_TEMPORARY], ignore_errors=True)
    return Path(os.environ[_TEMPORARY]) / source_hash()


def notice_if_none() -> str:
    """A sentence that the first run of an engine compiles, if no compiled code is kept yet; "" otherwise."""
    if any(folder().glob("*.*")) or any(SHIPPED.glob(f"*-{source_hash()}.object")):
        return ""
    return "no compiled code is kept yet: an engine's first run begins with compiling, once for this machine, up to two minutes"


def warning_if_not_kept() -> str:
    """A sentence that compiled code is not kept, and what to do about it; "" if it is kept."""
    folder()
    if _TEMPORARY not in os.environ:
        return ""
    return (
        "compiled code cannot be kept here, so every call begins with up to a minute of compiling;"
        f" set {VARIABLE} to a folder that can be written"
    )


def _writable(folder: Path) -> bool:
    """Whether a folder can be written to, or made."""
    while not os.path.lexists(folder) and folder != folder.parent:
        folder = folder.parent
    return folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)


@cache
def source_hash() -> str:
    """Hash of the sources of this package, without what the folders of compiled code hold, such as unpacked FMUs."""
    return hash_of(file for file in _PACKAGE.rglob("*.py") if "__pycache__" not in file.relative_to(_PACKAGE).parts)


def hash_of(files: Iterable[Path]) -> str:
    """Hash of the texts of files."""
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:16]


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
