"""The key under which a result is stored: a hash of everything that determines it.

It contains the function and its arguments, the engines' versions, the code, and the libraries for computation. So a result of other code,
or of another library, is never reused.
"""

import dataclasses
import hashlib
import inspect
import json
import math
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import numpy as np

from quickreturn.cases.running.imported_modules import PACKAGE, imported_modules, source_of, text_of
from quickreturn.cases.running.job import Job
from quickreturn.engines.base import AnyEngine
from quickreturn.engines.plugins import places
from quickreturn.engines.registry import MAIN, engine

#: Code of simulations, besides a third-party engine's own code.
SIMULATION: Final = ("quickreturn.reference_model", "quickreturn.engines")

#: Code that converts results to records and back.
_RECORDS: Final = "quickreturn.cases.running.records"
#: Module that takes measures from plugins: what imports it depends on their code as well.
_MEASURES: Final = "quickreturn.cases.motion.of_turn"
#: Packages and modules that start jobs, write files, or show results and progress: no result depends on them.
ONLY_TALK: Final = (
    "quickreturn.cases.running",
    "quickreturn.cases.files.shown",
    "quickreturn.cases.files.shown",
    "quickreturn.engines.progress",
)

#: Libraries that compute; an engine's own library is named by `Engine.version`.
LIBRARIES: Final = ("numpy", "scipy", "numba")


def key_of(job: Job[Any]) -> str:
    """Key of a job's result. Raises TypeError as `hash_of`, and UnknownEngine."""
    return hash_of(
        {
            "kind": job.kind,
            "function": f"{job.function.__module__}.{job.function.__qualname__}",
            "inputs": job.arguments if job.inputs is None else job.inputs,
            "engines": [version_of(name) for name in job.engines],
            "code": code_of(job.function),
        }
    )


def hash_of(content: Any) -> str:
    """SHA-256 (hexadecimal) of content.

    Content consists of mappings, lists, tuples, dataclasses (class name and fields that count in comparisons), texts, whole numbers, floats
    (distinguished to the last bit, infinities and NaN included), booleans, None, paths and numpy arrays. TypeError: anything else.
    """
    text = json.dumps(_canonical(content), sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def version_of(name: str) -> list[str]:
    """Version of an engine: name, library, and its code if it is of another package."""
    chosen = engine(name)
    if chosen.unavailable():
        return [name]
    return [name, chosen.version(), "" if name in MAIN else code_fingerprint((), chosen)]


def code_of(function: Callable[..., Any]) -> str:
    """SHA-256 (hexadecimal) of all sources on which a function's result depends, with the versions of the libraries used.

    These are its module and the modules that this imports, directly and through others, at their heads and inside functions; of this
    package, or of the function's own. Those of `ONLY_TALK` are left out, with what they alone import.
    """
    return _hash_of_module(function.__module__)


@cache
def _hash_of_module(module: str) -> str:
    digest = hashlib.sha256()
    for name, file in sources_of(module).items():
        text = text_of(file)
        digest.update(f"{name} {len(text)}\n".encode())
        digest.update(text)
    return _with_libraries(digest)


def sources_of(module: str) -> dict[str, Path]:
    """Modules whose code determines the results of a module's functions, with their files; see `code_of`."""
    home = module.partition(".")[0]

    def find(name: str) -> Path | None:
        if name != _RECORDS and any(f"{name}.".startswith(f"{quiet}.") for quiet in ONLY_TALK):
            return None
        if name.partition(".")[0] != home or home == PACKAGE:
            return source_of(name)
        try:
            spec = find_spec(name)
        except (ModuleNotFoundError, ValueError):  # a name that a module defines; or a module without a specification, such as __main__
            return None
        return Path(spec.origin) if spec is not None and spec.origin is not None and spec.origin.endswith(".py") else None

    found = imported_modules([module, _RECORDS], find=find)
    of_plugins = [place.partition(":")[0] for place in places("measures")] if _MEASURES in found else []
    return imported_modules([*found, *of_plugins], find=find) if of_plugins else found


def code_fingerprint(parts: tuple[str, ...] = SIMULATION, engine: AnyEngine | None = None) -> str:
    """SHA-256 (hexadecimal) of source text, with the versions of the libraries used.

    Args:
        parts: names of packages (with everything below them) or modules; ModuleNotFoundError: one does not exist.
        engine: an engine of another package; its code counts as well.
    """
    digest = hashlib.sha256()
    for part in sorted(set(parts)):
        digest.update(_source_hash(part).encode())
    if engine is not None:
        digest.update(_file_hash(inspect.getsourcefile(type(engine)) or "").encode())
    return _with_libraries(digest)


def _with_libraries(digest: "hashlib._Hash") -> str:
    for library in LIBRARIES:
        digest.update(f"{library} {library_version(library)}\n".encode())
    return digest.hexdigest()


@cache
def library_version(library: str) -> str:
    """Version of an installed library."""
    return metadata.version(library)


@cache
def _source_hash(part: str) -> str:
    spec = find_spec(part)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(f"no module named {part!r}", name=part)
    origin = Path(spec.origin)
    return _hash_of(origin.parent.rglob("*.py") if spec.submodule_search_locations else iter([origin]), origin.parent)


@cache
def _file_hash(source: str) -> str:
    """Hash of an engine's file and of those beside it: a small engine is one file, a larger one a package."""
    file = Path(source)
    if not file.is_file():
        return source
    in_package = (file.parent / "__init__.py").is_file()
    return _hash_of(file.parent.rglob("*.py") if in_package else iter([file]), file.parent)


def _hash_of(files: Iterator[Path], root: Path) -> str:
    digest = hashlib.sha256()
    for file in sorted(each for each in files if "__pycache__" not in each.relative_to(root).parts):  # a Python FMU is unpacked there
        text = file.read_bytes()
        # Name and length before each text, so that a line that moves from one file to the next changes the hash.
        digest.update(f"{file.relative_to(root).as_posix()} {len(text)}\n".encode())
        digest.update(text)
    return digest.hexdigest()


def _canonical(value: Any) -> Any:
    if value is None or isinstance(value, (bool, str, int)):
        return value
    if isinstance(value, (float, np.floating)):
        return {"float": float(value).hex() if math.isfinite(value) else repr(float(value))}
    if isinstance(value, Mapping):
        return {str(name): _canonical(item) for name, item in value.items()}
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, (list, tuple)):
        return [_canonical(item) for item in value]
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        return {"array": hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest(), "shape": value.shape, "type": value.dtype.str}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {field.name: _canonical(getattr(value, field.name)) for field in dataclasses.fields(value) if field.compare}
        return {"class": type(value).__qualname__, "fields": fields}
    raise TypeError(f"{type(value).__name__} has no canonical form for a key")
