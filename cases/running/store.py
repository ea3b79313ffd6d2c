"""Results on disk, stored one by one: an interrupted run continues where it stopped, and stale or damaged results are never shown.

An entry is one file named by its key, a hash of everything that determines the result (scene, engine, settings, versions, code).
It is written to a temporary file, forced to the disk and renamed, so that it is complete or absent even with several writers. A checksum
over key and content finds truncated, edited or misplaced files: such an entry counts as absent, its result is computed anew, and a notice
says so. If a result cannot be written, a notice says so and the run goes on: only this result must be computed again.

File format: one line `quickreturn-store 1 <sha256>`, then numpy's npz with the JSON document as UTF-8 bytes and the arrays.

Typed results become records and come back: dataclasses are JSON objects of their fields, arrays and bytes stay apart. Results may consist
of dataclasses, tuples, lists, mappings from texts, None, texts, numbers with infinities, numpy arrays, bytes, and unions of these; of
several dataclasses the first that takes a record counts. NaN is not a result: the store refuses it. `Pieces` of a long job are stored while
it runs, so that a job that is stopped goes on where it was the next time.
"""

import contextlib
import dataclasses
import hashlib
import io
import json
import math
import os
import secrets
import tempfile
import time
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Final, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.errors import ToldError


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file completely or, on any failure, leave the old one. OSError: it cannot be written."""
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        with temporary.open("xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def words_of(error: OSError) -> str:
    """The system's message, in lower case."""
    return (error.strerror or str(error)).lower()


#: Environment variable that names the folder.
VARIABLE: Final = "QUICKRETURN_STORE"
#: Folder under the current directory if the variable is not set.
DEFAULT_FOLDER: Final = ".quickreturn"

_MAGIC: Final = "quickreturn-store 1"
_DOCUMENT: Final = "document"
_ABANDONED: Final = 3600.0  # s: no write takes an hour, so an older temporary file belongs to a run that was killed


class StoreError(ToldError):
    """The store's folder cannot be used; the text is one sentence."""


@dataclass(frozen=True)
class Record:
    """What is stored under a key: a JSON document and arrays by name; see the top of this file for what it is made of."""

    document: Any
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)


class Store:
    """Entries by key in a folder; safe to use from several processes at once.

    Args:
        folder: None for that of the environment variable.
        tell: called with each notice at once.

    Raises:
        StoreError: the folder cannot be created or written to.
    """

    def __init__(self, folder: Path | None = None, tell: Callable[[str], object] | None = None) -> None:
        self.folder = folder if folder is not None else Path(os.environ.get(VARIABLE) or DEFAULT_FOLDER).expanduser()
        self.notices: list[str] = []  # sentences on damaged entries and on results that could not be written, so far
        self.lost = 0  # number of results that could not be written
        self._tell = tell
        self.is_new = not self.folder.exists()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            self._clear_abandoned()
            with tempfile.TemporaryFile(dir=self.folder):
                pass
        except OSError as error:
            raise StoreError(
                f"store folder {self.folder}: it cannot be created or written ({words_of(error)});"
                f" set {VARIABLE} to a folder that can be written"
            ) from error

    def get(self, key: str) -> Record | None:
        """The entry under `key`, or None if there is none or it is damaged (then a notice says so)."""
        try:
            content = self._path(key).read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            self.note_damage(key, f"cannot be read ({words_of(error)})")
            return None
        head, _, body = content.partition(b"\n")
        if head != _head(key, body):
            self.note_damage(key, "is truncated or was edited")
            return None
        try:
            with np.load(io.BytesIO(body), allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in archive.files}
            return Record(json.loads(arrays.pop(_DOCUMENT).tobytes()), arrays)
        except (ValueError, KeyError, OSError, EOFError, zipfile.BadZipFile) as error:  # a good head over other content
            self.note_damage(key, f"cannot be read ({error})")
            return None

    def put(self, key: str, record: Record) -> None:
        """Store an entry, replacing one of the same key.

        If it cannot be written (full disk, ...) a notice says so, and an earlier entry stays.

        Raises:
            ValueError: an array is called "document" or holds Python objects, or the document holds NaN or infinities.
            TypeError: the document holds what JSON does not know.
        """
        arrays = {name: np.asarray(values) for name, values in record.arrays.items()}
        if _DOCUMENT in arrays or any(array.dtype.hasobject for array in arrays.values()):
            raise ValueError(f'an array must hold plain numbers and must not be called "{_DOCUMENT}"')
        text = json.dumps(record.document, allow_nan=False).encode()
        buffer = io.BytesIO()
        np.savez(buffer, **{_DOCUMENT: np.frombuffer(text, dtype=np.uint8)}, **arrays)  # type: ignore[arg-type]
        body = buffer.getvalue()
        try:
            write_atomically(self._path(key), _head(key, body) + b"\n" + body)
        except OSError as error:
            self.lost += 1
            self._note(f"store folder {self.folder}: results cannot be written ({words_of(error)}); they are computed anew next time")

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.result"

    def note_damage(self, key: str, what: str) -> None:
        """Say that an entry is damaged; `what`: a clause on how."""
        self._note(f"stored result {self._path(key)} {what}; it is computed anew")

    def _note(self, sentence: str) -> None:
        if sentence not in self.notices:
            self.notices.append(sentence)
            if self._tell is not None:
                self._tell(sentence)

    def _clear_abandoned(self) -> None:
        for file in self.folder.glob("*.part"):
            with contextlib.suppress(FileNotFoundError):  # another run cleared it first
                if time.time() - file.stat().st_mtime > _ABANDONED:
                    file.unlink()


def _head(key: str, body: bytes) -> bytes:
    return f"{_MAGIC} {hashlib.sha256(key.encode() + body).hexdigest()}".encode()


_ARRAY: Final = "$array"
_BYTES: Final = "$bytes"
_FLOAT: Final = "$float"


def encoded(value: Any) -> Record:
    """The record of a result."""
    arrays: dict[str, NDArray[Any]] = {}

    def plain(item: Any, place: str) -> Any:
        if isinstance(item, (np.ndarray, bytes)):
            arrays[place] = np.frombuffer(item, dtype=np.uint8) if isinstance(item, bytes) else item
            return {_BYTES if isinstance(item, bytes) else _ARRAY: place}
        if isinstance(item, np.generic):
            item = item.item()
        if isinstance(item, float) and math.isinf(item):
            return {_FLOAT: str(item)}
        if dataclasses.is_dataclass(item):
            item = {field.name: getattr(item, field.name) for field in dataclasses.fields(item)}
        if isinstance(item, Mapping):
            return {str(name): plain(each, f"{place}.{name}") for name, each in item.items()}
        if isinstance(item, (list, tuple)):
            return [plain(each, f"{place}.{number}") for number, each in enumerate(item)]
        return item

    return Record(plain(value, "value"), arrays)


def can_be_stored(value: Any) -> bool:
    """Whether the store takes the record of a result."""
    try:
        json.dumps(encoded(value).document, allow_nan=False)
    except (TypeError, ValueError):
        return False
    return True


def decoded(kind: Any, record: Record) -> Any:
    """The result of type `kind` that a record was made of. KeyError, TypeError, ValueError: it was made of something else."""
    return _typed(kind, record.document, record.arrays)


def _typed(kind: Any, item: Any, arrays: Mapping[str, NDArray[Any]]) -> Any:
    if isinstance(item, dict) and len(item) == 1:
        ((name, place),) = item.items()
        if name == _FLOAT:
            return float(place)
        if name in (_ARRAY, _BYTES):
            return arrays[place] if name == _ARRAY else arrays[place].tobytes()
    origin, arguments, fields = _parts_of(kind)
    if origin in (Union, UnionType):
        return None if item is None else _first(arguments, item, arrays)
    if fields is not None:
        return kind(**{name: _typed(each, item[name], arrays) for name, each in fields.items()})
    if isinstance(item, dict):
        return {name: _typed(arguments[1] if arguments else Any, part, arrays) for name, part in item.items()}
    if origin is tuple and arguments[-1] is not Ellipsis:
        return tuple(_typed(each, part, arrays) for each, part in zip(arguments, item, strict=True))
    if isinstance(item, list):
        return (origin or list)(_typed(arguments[0] if arguments else Any, part, arrays) for part in item)
    return item


def _first(kinds: Sequence[Any], item: Any, arrays: Mapping[str, NDArray[Any]]) -> Any:
    """The result of the first of some types that takes the record. Raises as `decoded` if none does."""
    for kind in kinds[:-1]:
        with contextlib.suppress(KeyError, TypeError, ValueError):
            return _typed(kind, item, arrays)
    return _typed(kinds[-1], item, arrays)


@cache
def _parts_of(kind: Any) -> tuple[Any, tuple[Any, ...], dict[str, Any] | None]:
    """Origin of a type such as `tuple[float, ...]`, its arguments but for None, and the fields of a dataclass with their types."""
    arguments = tuple(each for each in get_args(kind) if each is not NoneType)
    if not (isinstance(kind, type) and dataclasses.is_dataclass(kind)):
        return get_origin(kind), arguments, None
    hints = get_type_hints(kind)
    return get_origin(kind), arguments, {field.name: hints[field.name] for field in dataclasses.fields(kind)}


P = TypeVar("P")


@dataclass(frozen=True)
class Pieces:
    """The pieces of one job in a store.

    A worker on another machine has no such folder, and keeps nothing.
    """

    folder: str  # path of the store
    key: str  # of the job

    def piece(self, number: int, kind: type[P], compute: Callable[[], P]) -> P:
        """A piece from the store, or else computed and stored.

        Args:
            number: of the piece, which together with the job determines it.
            kind: its type, a dataclass.
            compute: computes it.
        """
        if self._store is None:
            return compute()
        key = f"{self.key}-{number}"
        if (record := self._store.get(key)) is not None:
            try:
                return decoded(kind, replace(record, document=record.document["piece"]))
            except (TypeError, ValueError, KeyError) as error:
                self._store.note_damage(key, f"cannot be read ({error})")
        value = compute()
        record = encoded(value)
        self._store.put(key, replace(record, document={"piece": record.document}))
        return value

    @cached_property
    def _store(self) -> Store | None:
        try:
            return Store(Path(self.folder)) if Path(self.folder).is_dir() else None
        except StoreError:
            return None
