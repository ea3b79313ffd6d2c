"""Pieces of a long job that are stored while it runs, so that a job that is stopped goes on where it was the next time."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from quickreturn.cases.running.records import decoded, encoded
from quickreturn.cases.running.store import Store, StoreError

T = TypeVar("T")


@dataclass(frozen=True)
class Pieces:
    """The pieces of one job in a store.

    A worker on another machine has no such folder, and keeps nothing.
    """

    folder: str  # path of the store
    key: str  # of the job

    def piece(self, number: int, kind: type[T], compute: Callable[[], T]) -> T:
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
