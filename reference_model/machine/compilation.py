"""Decorators that compile the explicit model with numba: cached on disk, sums vectorised, not-a-number and infinity respected."""

import os
from collections.abc import Callable
from typing import Any, Final, TypeVar, cast

import numba
from numba import njit

from quickreturn.reference_model.machine.linking import compile_alike
from quickreturn.reference_model.machine.machine_code import VARIABLE

# numba reads its environment once; it may have been imported before this package
numba.config.CACHE_DIR = os.environ.get(VARIABLE, numba.config.CACHE_DIR)  # type: ignore[attr-defined]

compile_alike()

#: LLVM's flags for reordered sums and fused multiply-add. None assumes that nan and infinity are absent: they mark impossible states.
FASTMATH: Final = {"reassoc", "contract", "nsz", "arcp"}

_njit: Any = njit  # its type hints lack some of its options
#: For all compiled code: division as in numpy, and no entry for C callers, for there are none.
_OPTIONS: Final[dict[str, Any]] = {"error_model": "numpy", "fastmath": FASTMATH, "no_cfunc_wrapper": True}
#: For code that compiled code alone calls: without the entry from Python, which unpacks tuples of 200 numbers.
_INSIDE: Final[dict[str, Any]] = {**_OPTIONS, "no_cpython_wrapper": True}

#: For the equations of motion, which are called by address.
KERNEL: Final[dict[str, Any]] = {"error_model": "numpy", "fastmath": FASTMATH, "_nrt": False}

Function = TypeVar("Function", bound=Callable[..., Any])


def stage(function: Function) -> Function:
    """A part of the equations of motion: without entries of its own and without reference counts."""
    return cast(Function, _njit(cache=True, **_INSIDE, _nrt=False)(function))


def compiled(function: Function) -> Function:
    """Compile on first use and cache on disk."""
    return cast(Function, _njit(cache=True, **_OPTIONS)(function))


def without_references(function: Function) -> Function:
    """Like `compiled`, but without numba's reference counts: for functions that create no array, which numba refuses here."""
    return cast(Function, _njit(cache=True, **_OPTIONS, _nrt=False)(function))


def inlined(function: Function) -> Function:
    """Compile into each caller: for functions that cost less than the call."""
    return cast(Function, _njit(cache=True, **_OPTIONS, inline="always")(function))
