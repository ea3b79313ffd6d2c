"""The key under which a result is stored: a hash of everything that determines it.

It contains the function and its arguments, the engines' versions, the code, and the libraries for computation. So a result of other code,
or of another library, is never reused. The modules of this package that a module imports, directly and through others, are found in the
text of the sources: nothing is imported for it, so that the hash costs milliseconds.
"""

import dataclasses
import hashlib
import inspect
import json
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import numpy as np

from quickreturn.cases.running.job import Job
from quickreturn.engines.plugins import places
from quickreturn.engines.registry import MAIN, engine

PACKAGE: Final = "quickreturn"
#: The folder of the package; a checkout has links in it to the folders beside it, such as this one.
_HOME: Final = Path(__file__).parents[2]

_NAMES: Final = r"from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)|import[ \t]+([^\n]+)"
_STATEMENT: Final = re.compile(rf"^[ \t]*(?:{_NAMES})", re.MULTILINE)
#: Imports for the type checker alone: the line and the lines below that are indented further.
_FOR_TYPES: Final = re.compile(r"^([ \t]*)if TYPE_CHECKING:\n(?:\1[ \t]+[^\n]*\n|[ \t]*\n)+", re.MULTILINE)
#: A module, or one of its functions, by its name in quotes: imported when it is needed.
_IN_QUOTES: Final = re.compile(rf"({PACKAGE}(?:\.\w+)+)(?::\w+)?[\"']")
_COMMENT: Final = re.compile(r"#[^\n]*")

Find = Callable[[str], Path | None]


@cache
def source_of(module: str) -> Path | None:
    """The file of a module of this package, or None if there is no such module."""
    first, _, rest = module.partition(".")
    return _modules_of(rest.partition(".")[0]).get(module) if first == PACKAGE else None


@cache
def _modules_of(part: str) -> dict[str, Path]:
    """All modules of a part of this package, or a module of that name; of "" the package alone."""
    if (_HOME / part / "__init__.py").is_file():
        return dict(_below(str(_HOME / part), f"{PACKAGE}.{part}")) if part else {PACKAGE: _HOME / "__init__.py"}
    file = _HOME / f"{part}.py"
    return {f"{PACKAGE}.{part}": file} if file.is_file() else {}


def _below(folder: str, package: str) -> Iterator[tuple[str, Path]]:
    """The modules of a package in a folder, without its tests."""
    for entry in os.scandir(folder):
        if entry.name.endswith(".py") and entry.is_file():
            yield package if entry.name == "__init__.py" else f"{package}.{entry.name[:-3]}", Path(entry.path)
        elif entry.name not in ("__pycache__", "tests") and entry.is_dir():
            yield from _below(entry.path, f"{package}.{entry.name}")


@cache
def text_of(file: Path) -> bytes:
    """The text of a source, read once."""
    return file.read_bytes()


def modules_in(package: str) -> dict[str, Path]:
    """All modules of a package of this project, itself included, with their files. Empty if there is no such package."""
    file = source_of(package)
    if file is None or file.name != "__init__.py":
        return {} if file is None else {package: file}
    return dict(sorted(_below(str(file.parent), package)))


def imported_modules(modules: Iterable[str], find: Find = source_of) -> dict[str, Path]:
    """Modules that are imported from some modules, directly and through others, themselves included, with their files, sorted by name.

    Imports inside functions count, and modules named in quotes, but not what is imported for the type checker alone. The packages around a
    module count, for Python runs them first; the outermost one does not, for it only hands names on.

    Args:
        modules: full names, those of packages too. Those that do not exist here are left out.
        find: finds the file of a module; None where it is not of this package.
    """
    found: dict[str, Path] = {}
    waiting = list(modules)
    while waiting:
        module = waiting.pop()
        if module in found or (file := find(module)) is None:
            continue
        found[module] = file
        waiting += _imports(file)
        parts = module.split(".")
        waiting += (".".join(parts[:count]) for count in range(2, len(parts)))
    return dict(sorted(found.items()))


@cache
def _imports(file: Path) -> tuple[str, ...]:
    """Names that may be modules, as a file imports them."""
    return tuple(dict.fromkeys(names_imported(text_of(file).decode())))


def names_imported(text: str) -> Iterator[str]:
    """Names that a source imports and that may be modules: of `from a import b`, a and a.b.

    Raises:
        ValueError: an import is relative, which this project does not use.
    """
    if "if TYPE_CHECKING:" in text:
        text = _FOR_TYPES.sub("", text)
    yield from (quoted[1] for quoted in _IN_QUOTES.finditer(text) if text[quoted.start() - 1] in "\"'")
    for home, names, whole in _STATEMENT.findall(text):
        plain = _COMMENT.sub("", names or whole) if "#" in names or "#" in whole else names or whole
        listed = [name.split()[0] for name in plain.strip("() \t\n").split(",") if name.strip()]
        if home.startswith("."):
            raise ValueError(f"relative import: from {home} import {', '.join(listed)}")
        if home:
            yield home
        yield from (f"{home}.{name}" if home else name for name in listed)


#: Packages of this project that compute.
COMPUTING: Final = ("quickreturn.reference_model", "quickreturn.engines", "quickreturn.cases")

#: Code that converts results to records and back.
_RECORDS: Final = "quickreturn.cases.running.store"
#: Module that takes measures from plugins: what imports it depends on their code as well.
_MEASURES: Final = "quickreturn.cases.motion.of_turn"
#: Packages and modules that start jobs, write files, or show results and progress: no result depends on them.
ONLY_TALK: Final = ("quickreturn.cases.running", "quickreturn.cases.files.shown", "quickreturn.engines.progress")

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
    return [name, chosen.version(), "" if name in MAIN else _code_of_engine(type(chosen))]


def code_of(function: Callable[..., Any]) -> str:
    """SHA-256 (hexadecimal) of all sources on which a function's result depends, with the versions of the libraries used.

    These are its module and the modules that this imports, directly and through others, at their heads and inside functions; of this
    package, or of the function's own. Those of `ONLY_TALK` are left out, with what they alone import.
    """
    return _hash_of_module(function.__module__)


@cache
def _hash_of_module(module: str) -> str:
    return _hash_of(sources_of(module))


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


def code_fingerprint() -> str:
    """SHA-256 (hexadecimal) of all code that computes (`COMPUTING`), with the versions of the libraries used."""
    return _hash_of({name: file for package in COMPUTING for name, file in modules_in(package).items()})


@cache
def _code_of_engine(chosen: type) -> str:
    """The same of an engine's file and of those beside it: a small engine is one file, a larger one a package."""
    file = Path(inspect.getsourcefile(chosen) or "")
    in_package = (file.parent / "__init__.py").is_file()
    return _hash_of(dict(sorted(_below(str(file.parent), ""))) if in_package else {file.name: file} if file.is_file() else {})


def _hash_of(sources: Mapping[str, Path]) -> str:
    """SHA-256 (hexadecimal) of sources by name, with the versions of the libraries used."""
    digest = hashlib.sha256()
    for name, file in sources.items():
        # name and length before each text, so that a line that moves from one file to the next changes the hash
        digest.update(f"{name} {len(text_of(file))}\n".encode())
        digest.update(text_of(file))
    for library in LIBRARIES:
        digest.update(f"{library} {library_version(library)}\n".encode())
    return digest.hexdigest()


@cache
def library_version(library: str) -> str:
    """Version of an installed library."""
    return metadata.version(library)


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
