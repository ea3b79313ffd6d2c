"""Where compiled functions are kept on disk: one folder per state of their sources.

Numba recompiles a cached function when the function's own file changes, but not when a file that it calls into does. With a folder
named by the hash of the sources that are compiled, and of all that these import, code compiled from other sources is never taken. It is
beside the sources; where these cannot be written it is in the user's cache, and where there is none in a temporary folder that is removed
when the process ends.
"""

import atexit
import hashlib
import os
import re
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Final

from quickreturn.reference_model.imported_modules import imported_modules, modules_in, text_of

VARIABLE: Final = "NUMBA_CACHE_DIR"
_PACKAGE: Final = Path(__file__).resolve().parents[1]
#: How the name of a cache folder of this package begins, and what follows the hash in that of a temporary one.
_OURS: Final = "quickreturn-"
_TEMPORARY: Final = "-temporary-"
#: Imports of a module whose functions are compiled: of the compiler, or of this package's decorators for it.
_COMPILES: Final = re.compile(rb"^(?:from|import) (?:numba\b|quickreturn\.reference_model\.native\.compilation\b)", re.MULTILINE)


def choose_cache_folder() -> None:
    """Set the environment variable that numba reads at its import, unless the user has set it to a folder that can be written."""
    given, name = os.environ.get(VARIABLE), f"{_OURS}{source_hash()}"
    if given and (not Path(given).name.startswith(_OURS) or Path(given).name.startswith(f"{name}{_TEMPORARY}")) and _writable(Path(given)):
        return
    for home in (_PACKAGE / "__pycache__", Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "quickreturn"):
        if home.is_absolute() and _writable(home):
            os.environ[VARIABLE] = str(home / name)
            return
    temporary = tempfile.mkdtemp(prefix=f"{name}{_TEMPORARY}")
    atexit.register(shutil.rmtree, temporary, ignore_errors=True)
    os.environ[VARIABLE] = temporary


def notice_if_none() -> str:
    """A sentence that the first run of an engine compiles, if no compiled code is kept yet; "" otherwise."""
    if any(Path(os.environ.get(VARIABLE, "")).glob("*.object")):
        return ""
    return "no compiled code is kept yet: an engine's first run begins with compiling, once for this machine, up to two minutes"


def warning_if_not_kept() -> str:
    """A sentence that compiled code is not kept, and what to do about it; "" if it is kept."""
    if _TEMPORARY not in os.environ.get(VARIABLE, ""):
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
    """Hash of the sources of compiled code, of this package and of the engines beside it."""
    digest = hashlib.sha256()
    for module, file in compiled_sources().items():
        digest.update(module.encode())
        digest.update(text_of(file))
    return digest.hexdigest()[:16]


def compiled_sources() -> dict[str, Path]:
    """Modules that have functions compiled, and those that they import at their head, with their files.

    The compiler takes what a function uses (constants, callees, types of tuples) from its module, which has it from there.
    """
    both = {**modules_in("quickreturn.reference_model"), **modules_in("quickreturn.engines")}
    return imported_modules((module for module, file in both.items() if _COMPILES.search(text_of(file))), late=False, find=both.get)
