"""Compiles the explicit models with numba: cached on disk, sums vectorised, not-a-number and infinity respected.

Python enters compiled code in two ways: by an `objects.Entry`, which is kept and then needs no compiler, and by a function that is
`compiled`. What these two call is `inner` or `inlined`.
"""

import os
from collections.abc import Callable
from typing import Any, Final, TypeVar, cast

import numba
from numba import cfunc, njit, types

from quickreturn.reference_model.native.cache_folder import VARIABLE
from quickreturn.reference_model.native.linking import compile_alike

# numba reads its environment once; it may have been imported before this package
numba.config.CACHE_DIR = os.environ.get(VARIABLE, numba.config.CACHE_DIR)  # type: ignore[attr-defined]

compile_alike()

#: LLVM's flags for reordered sums and fused multiply-add. None assumes that nan and infinity are absent: they mark impossible states.
FASTMATH: Final = {"reassoc", "contract", "nsz", "arcp"}
#: The same for code that is written in LLVM's language.
FAST: Final = tuple(sorted(FASTMATH))

_njit: Any = njit  # their type hints lack some of their options
_cfunc: Any = cfunc
#: For all compiled code: division as in numpy, and no entry for C callers, for there are none.
_OPTIONS: Final[dict[str, Any]] = {"error_model": "numpy", "fastmath": FASTMATH, "no_cfunc_wrapper": True}
#: For code that compiled code alone calls: without the entry from Python, which unpacks tuples of 200 numbers.
_INSIDE: Final[dict[str, Any]] = {**_OPTIONS, "no_cpython_wrapper": True}

#: Letter of an argument of an entry -> its type; an address is a whole number.
_LETTERS: Final[dict[str, Any]] = {"i": types.int64, "f": types.float64}

Function = TypeVar("Function", bound=Callable[..., Any])


def entry(function: Callable[..., int], arguments: str) -> Any:
    """Compile a function of numbers and addresses to one that is called by address, for `objects.Entry`."""
    signature = types.int64(*(_LETTERS[letter] for letter in arguments))
    return _cfunc(signature, cache=True, error_model="numpy", fastmath=FASTMATH, _nrt=False)(function)


def compiled(function: Function) -> Function:
    """Compile on first use, for callers in Python that pass arrays."""
    return cast(Function, _njit(cache=True, **_OPTIONS)(function))


def inner(function: Function) -> Function:
    """Compile for compiled code alone: without an entry, and without reference counts, so that it can create no array."""
    return cast(Function, _njit(cache=True, **_INSIDE, _nrt=False)(function))


def inlined(function: Function) -> Function:
    """Compile into each caller: for functions that cost less than the call."""
    return cast(Function, _njit(cache=True, **_OPTIONS, inline="always")(function))
