"""A hash of everything that determines a result besides its inputs: the code, and the libraries that the code computes with.

It is part of the key under which a result is stored, so that a result computed by other code is never taken for today's.
"""

import hashlib
import inspect
from collections.abc import Iterator
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from engines.base import Engine

#: What trajectories and natural frequencies depend on, besides a third-party engine's own code.
SIMULATION: Final = ("reference_model", "engines")

#: Libraries that compute; an engine's own library is named by `Engine.version`.
LIBRARIES: Final = ("numpy", "scipy", "numba")


def code_fingerprint(parts: tuple[str, ...] = SIMULATION, engine: Engine | None = None) -> str:
    """SHA-256 (hex) of the source text of `parts` and of the engine's own package, with the versions of the libraries used.

    Args:
        parts: names of packages (with everything below them) or modules, e.g. ("reference_model", "engines", "cases.measures").
        engine: an engine from elsewhere; its code counts as well.

    Raises:
        ModuleNotFoundError: a part does not exist.
    """
    digest = hashlib.sha256()
    for part in sorted(set(parts)):
        digest.update(_source_hash(part).encode())
    if engine is not None:
        digest.update(_file_hash(inspect.getsourcefile(type(engine)) or "").encode())
    for library in LIBRARIES:
        digest.update(f"{library} {_version(library)}\n".encode())
    return digest.hexdigest()


@cache
def _source_hash(part: str) -> str:
    spec = find_spec(part)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(f"no module named {part!r}", name=part)
    origin = Path(spec.origin)
    return _hash_of(origin.parent.rglob("*.py") if spec.submodule_search_locations else iter([origin]), origin.parent)


@cache
def _file_hash(source: str) -> str:
    """Of an engine's file and of those beside it: a small engine is one file, a larger one a package."""
    file = Path(source)
    if not file.is_file():
        return source
    in_package = (file.parent / "__init__.py").is_file()
    return _hash_of(file.parent.rglob("*.py") if in_package else iter([file]), file.parent)


def _hash_of(files: Iterator[Path], root: Path) -> str:
    digest = hashlib.sha256()
    for file in sorted(files):
        text = file.read_bytes()
        # Name and length before each text: moving a line from one file to the next must not go unnoticed.
        digest.update(f"{file.relative_to(root).as_posix()} {len(text)}\n".encode())
        digest.update(text)
    return digest.hexdigest()


@cache
def _version(library: str) -> str:
    try:
        return metadata.version(library)
    except metadata.PackageNotFoundError:
        return "not installed"
