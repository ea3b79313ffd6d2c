"""Compiles the explicit models with numba: kept on disk, sums vectorised, not-a-number and infinity respected.

Python enters compiled code in two ways: by an `objects.Entry`, which is kept and then needs no compiler, and by a function that is
`compiled`. What these two call is `inner` or `inlined`. Numba itself, its settings, and functions of others stay as they are.
"""

import warnings
from collections.abc import Callable
from typing import Any, Final, TypeVar

import numba
from numba import cfunc, njit, types

try:
    from numba.core.ccallback import CFunc

    from quickreturn.reference_model.native.kept import Kept, OwnCompiler

    MISSING = ""
except (ImportError, AttributeError) as missing:
    MISSING = str(missing)
    warnings.warn(
        f"numba {numba.__version__} is unlike those that this package knows ({MISSING}): every process compiles its equations again",
        RuntimeWarning,
        stacklevel=2,
    )

#: The option that names this package's compiler.
_OWN: Final[dict[str, Any]] = {} if MISSING else {"pipeline_class": OwnCompiler}

#: LLVM's flags for reordered sums and fused multiply-add. None assumes that nan and infinity are absent: they mark impossible states.
FASTMATH: Final = {"reassoc", "contract", "nsz", "arcp"}
#: The same for code that is written in LLVM's language.
FAST: Final = tuple(sorted(FASTMATH))

#: For all compiled code: division as in numpy, and no entry for C callers, for there are none.
_OPTIONS: Final[dict[str, Any]] = {"error_model": "numpy", "fastmath": FASTMATH, "no_cfunc_wrapper": True}
#: For code that compiled code alone calls: without the entry from Python, which unpacks tuples of 200 numbers.
_INSIDE: Final[dict[str, Any]] = {**_OPTIONS, "no_cpython_wrapper": True}

#: Letter of an argument of an entry -> its type; an address is a whole number.
_LETTERS: Final[dict[str, Any]] = {"i": types.int64, "f": types.float64}

Function = TypeVar("Function", bound=Callable[..., Any])


def jitted(function: Callable[..., Any], signature: Any = None, *, kept: bool = True, **options: Any) -> Any:
    """As `numba.njit`: compiled now for a signature, or at each first call with other types.

    Args:
        function: of Python.
        signature: None: that of each call.
        kept: whether the code is kept on disk.
        options: of numba.
    """
    dispatcher: Any = njit(**_OWN, **options)(function)
    if kept and not MISSING:
        dispatcher._cache = Kept(function)
    if signature is not None:
        dispatcher.compile(signature)
        dispatcher.disable_compile()
    return dispatcher


def callback(function: Callable[..., Any], signature: Any, **options: Any) -> Any:
    """As `numba.cfunc`: compiled now, to be called by address."""
    if MISSING:
        return cfunc(signature, **options)(function)
    found: Any = CFunc(function, (signature.args, signature.return_type), locals={}, options=options, **_OWN)
    found._cache = Kept(function)
    found.compile()
    return found


def entry(function: Callable[..., int], arguments: str) -> Any:
    """Compile a function of numbers and addresses to one that is called by address, for `objects.Entry`."""
    signature = types.int64(*(_LETTERS[letter] for letter in arguments))
    return callback(function, signature, error_model="numpy", fastmath=FASTMATH, _nrt=False)


def compiled(function: Function) -> Function:
    """Compile on first use, for callers in Python that pass arrays."""
    return jitted(function, **_OPTIONS)


def inner(function: Function) -> Function:
    """Compile for compiled code alone: without an entry, and without reference counts, so that it can create no array."""
    return jitted(function, kept=False, **_INSIDE, _nrt=False)


def inlined(function: Function) -> Function:
    """Compile into each caller: for functions that cost less than the call."""
    return jitted(function, kept=False, **_OPTIONS, inline="always")
