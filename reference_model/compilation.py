"""How the explicit model is compiled: cached on disk, reductions vectorised, not-a-number kept meaningful."""

import os
from collections.abc import Callable
from typing import Any, Final, TypeVar, cast

import numba
from numba import njit

from reference_model.machine_code import VARIABLE

# numba reads its environment once; it may have been imported before this package
numba.config.CACHE_DIR = os.environ.get(VARIABLE, numba.config.CACHE_DIR)  # type: ignore[attr-defined]

#: Reordering of sums and fused multiply-add, but no assumption that nan and infinity are absent: they mark states that cannot be.
FASTMATH: Final = {"reassoc", "contract", "nsz", "arcp"}

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile on first use and cache on disk."""
    return cast(Function, njit(cache=True, error_model="numpy", fastmath=FASTMATH)(function))


def borrowing(function: Function) -> Function:
    """Like `compiled`, for functions that neither make nor keep arrays: without numba's reference counts (and refused with any array)."""
    return cast(Function, njit(cache=True, error_model="numpy", fastmath=FASTMATH, _nrt=False)(function))  # type: ignore[call-overload]


def merged(function: Function) -> Function:
    """Like `borrowing`, for a large function inside a loop: its machine code becomes part of the caller's, without passing arguments.

    The tuples travel by value, some 200 numbers: a third of the time that a right-hand side with two modes takes.
    """
    return cast(Function, njit(cache=True, error_model="numpy", fastmath=FASTMATH, _nrt=False, forceinline=True)(function))  # type: ignore[call-overload]


def embedded(function: Function) -> Function:
    """Like `compiled`, its machine code part of every caller's: with several callers less to compile than `inlined`."""
    return cast(Function, njit(cache=True, error_model="numpy", fastmath=FASTMATH, forceinline=True)(function))


def inlined(function: Function) -> Function:
    """Compile into each caller: passing the tuples of arrays between functions would cost more than most of these do."""
    return cast(Function, njit(cache=True, error_model="numpy", fastmath=FASTMATH, inline="always")(function))
