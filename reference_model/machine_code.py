"""Where compiled functions are kept on disk: one folder per state of the sources.

Numba recompiles a cached function when the function's own file changes, but not when a file that it calls into does. With a folder
named by the hash of all sources, code compiled from other sources is never taken.
"""

import hashlib
import os
from pathlib import Path
from typing import Final

VARIABLE: Final = "NUMBA_CACHE_DIR"
_PACKAGE: Final = Path(__file__).resolve().parent


def keep_apart_by_source() -> None:
    """Name the folder by the environment variable that numba reads at its import, unless the user has set it."""
    if VARIABLE in os.environ and "quickreturn-" not in os.environ[VARIABLE]:
        return
    folder = _PACKAGE / "__pycache__" / f"quickreturn-{_source_hash()}"
    if os.access(_PACKAGE, os.W_OK):
        os.environ[VARIABLE] = str(folder)


def _source_hash() -> str:
    """Of this package and of the engines beside it, which compile code that calls into it."""
    digest = hashlib.sha256()
    for folder in (_PACKAGE, _PACKAGE.parent / "engines"):
        for file in sorted(folder.rglob("*.py")):
            digest.update(file.relative_to(folder).as_posix().encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]
