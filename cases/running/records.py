"""Converts typed results to records of the store and back: dataclasses become JSON objects of their fields, arrays and bytes stay apart.

Results may consist of dataclasses, tuples, lists, mappings from texts, None, texts, numbers with infinities, numpy arrays, bytes, and
unions of these; of several dataclasses the first that takes a record counts. NaN is not a result: the store refuses it.

`Pieces` of a long job are stored while it runs, so that a job that is stopped goes on where it was the next time.
"""

import contextlib
import dataclasses
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Final, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.running.store import Record, Store, StoreError

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
