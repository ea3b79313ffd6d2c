"""The modules of this package that a module imports, directly and through others, found in the text of the sources.

Nothing is imported for it, so that the hash of the compiled code costs milliseconds at each start (`native.cache_folder`), and so that a
stored result knows the code that it depends on.
"""

import os
import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Final

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
