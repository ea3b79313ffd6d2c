"""Numba's cache on disk for this package's functions, in a folder of their own; one process compiles what several need."""

import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

from quickreturn.reference_model.native.cache_folder import Turn, folder, hash_of


class _Locator(_CacheLocator):
    """Where the code of a function is kept, whatever its file: in the folder named for the sources of `reference_model`.

    A function of another folder is compiled anew where a file in that folder has changed.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._code = function.__code__

    def get_cache_path(self) -> str:
        return str(folder())

    def get_source_stamp(self) -> str:
        return hash_of(Path(self._code.co_filename).parent.glob("*.py"))

    def get_disambiguator(self) -> str:
        return str(self._code.co_firstlineno)


class _Files(CompileResultCacheImpl):
    """How the code of a function is written and read."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._lineno, self._locator = function.__code__.co_firstlineno, _Locator(function)
        name = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        self._filename_base = f"{name}-{self._lineno}.{sys.implementation.cache_tag}"


class Kept(FunctionCache):
    """The kept code of a function. While one process compiles it, the others wait, and load it then."""

    _impl_class = _Files

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._turn = Turn(Path(self.cache_path) / f"{self._impl.filename_base}.turn")

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The code for a signature, or None if this process is to compile it."""
        found = super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        if found is None:
            self._turn.take()
            found = super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
            if found is not None:  # another process has compiled it meanwhile
                self._turn.give_back()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled; on a full disk nothing is kept."""
        with suppress(OSError):
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]
        self._turn.give_back()
