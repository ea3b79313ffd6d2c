"""Output: files written as a whole or not at all, standard JSON, and rows in a terminal."""

import dataclasses
import json
import math
import os
import stat
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from typing import Any, Final

import click

from quickreturn.cases.files.errors import printable, shortened
from quickreturn.cases.files.shown import Cell, Rows
from quickreturn.cases.running.store import words_of, write_atomically
from quickreturn.reference_model.errors import ToldError

#: Extra of this package -> modules that it installs, and by which name.
EXTRAS: Final = {
    "plot": {"matplotlib": "matplotlib", "PIL": "pillow"},
    "tables": {name: name for name in ("xarray", "h5netcdf", "h5py", "pyarrow")},
}
#: Endings of pictures, and of moving ones.
PICTURES: Final = (".png", ".svg", ".pdf", ".webp")
MOVING: Final = (".webp", ".gif", ".mp4", ".html")
#: Ending of a file -> the extra that writes it.
WRITTEN_BY: Final = {**dict.fromkeys((*PICTURES, ".gif", ".mp4"), "plot"), **dict.fromkeys((".nc", ".parquet"), "tables")}


class OutputError(ToldError):
    """A file cannot be written; the text is one sentence."""


class MissingExtra(ToldError):
    """An extra of this package is not installed; the text is one sentence."""


def require(extra: str, purpose: str) -> None:
    """Raise MissingExtra, which names the purpose, if a module of `EXTRAS` is missing."""
    if missing := [name for module, name in EXTRAS[extra].items() if find_spec(module) is None]:
        raise MissingExtra(f"{purpose} needs {missing[0]}, which is not installed; pip install 'quickreturn[{extra}]'")


def check_writable(path: Path, keep: str, *endings: str) -> None:
    """Check beforehand that a file can be written, and that its ending names the format.

    Args:
        path: of the file.
        keep: path of a file that must not be replaced, if any.
        endings: accepted endings, e.g. ".csv", in small or capital letters; devices and pipes may have any name.

    Raises:
        OutputError: the folder is missing or cannot be written to, the path is a folder or the file to keep, or has another ending.
        MissingExtra: what writes such a file is not installed.
    """
    target = _resolved(path)
    try:
        if target.is_dir():
            raise OutputError(f"{_shown(path)}: this is a folder; give the name of a file")
        if not target.parent.is_dir():
            raise OutputError(f"{_shown(path)}: there is no folder {printable(str(target.parent))}")
        if target.exists() and os.path.exists(keep) and target.samefile(keep):
            raise OutputError(f"{_shown(path)}: this is the case file itself, which would be lost; give another name")
        if _is_special(target):
            target.open("ab").close()
        elif path.suffix.lower() not in endings:
            wrong = f'"{shortened(path.suffix)}" is no known format' if path.suffix else "no ending tells the format"
            raise OutputError(f"{_shown(path)}: {wrong}; accepted: {', '.join(endings)}, such as {shortened(path.stem)}{endings[0]}")
        else:
            if extra := WRITTEN_BY.get(path.suffix.lower()):
                require(extra, _shown(path))
            if path.suffix.lower() == ".mp4" and which("ffmpeg") is None:
                raise MissingExtra(f"{_shown(path)} needs ffmpeg, which is not installed; install it, or choose .webp, .gif or .html")
            with tempfile.TemporaryFile(dir=target.parent):
                pass
    except OSError as error:
        raise _output_error(path, error) from error


def check_folder(folder: Path, page: str) -> None:
    """Check beforehand that a file can be written to a folder, and create the folder.

    Raises:
        OutputError: `folder` is a file, or cannot be created or written to; or it has a folder with the page's name.
    """
    target = _resolved(folder)
    try:
        if target.exists() and not target.is_dir():
            raise OutputError(f"{_shown(folder)}: this is a file; give a folder")
        target.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=target):
            pass
        if (target / page).is_dir():
            raise OutputError(f"{_shown(folder)}: {page} in it is a folder; give another folder")
    except OSError as error:
        raise _output_error(folder, error) from error


def write_file(path: Path, content: bytes) -> None:
    """Write a file completely or leave the old one; devices and pipes are written to directly.

    Raises:
        OutputError: it cannot be written.
    """
    target = _resolved(path)
    try:
        if _is_special(target):
            with target.open("wb") as file:
                file.write(content)
        else:
            write_atomically(target, content)
    except OSError as error:
        raise _output_error(path, error) from error


def print_json(document: Any) -> None:
    """Print one JSON document."""
    click.echo(json.dumps(plain(document), indent=2, allow_nan=False))


def plain(value: Any) -> Any:
    """A value for JSON: dataclasses become objects, numpy's numbers and arrays plain ones, infinity the text "inf", NaN null."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = vars(value)
    if isinstance(value, Mapping):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value


def print_table(rows: Iterable[Sequence[Cell]], heads: Sequence[str] = ()) -> None:
    """Print rows of texts in aligned columns."""
    click.echo(Rows(list(rows), heads).text())


def _resolved(path: Path) -> Path:
    """The file behind symbolic links, so that the file is replaced and not the link."""
    try:
        os.fsencode(path)
        return path.resolve()
    except OSError as error:
        raise _output_error(path, error) from error
    except (RuntimeError, ValueError) as error:
        raise OutputError(f"{_shown(path)}: this is no usable path (a loop of links, or no name of a file)") from error


def _is_special(path: Path) -> bool:
    """Whether a path is a device or a pipe, which must be written to and not replaced."""
    try:
        return not stat.S_ISREG(os.stat(path).st_mode)
    except FileNotFoundError:
        return False


def _output_error(path: Path, error: OSError) -> OutputError:
    return OutputError(f"{_shown(path)}: it cannot be written ({words_of(error)})")


def _shown(path: Path) -> str:
    return shortened(str(path))
