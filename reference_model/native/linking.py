"""Binds the calls of a compiled function to its own copies of the functions that it calls, so that every process runs the same code.

Numba copies callees into each caller and optimises them there, with reordered sums and fused multiply-adds. It gives the copies weak
symbols: of several the one that a process has loaded first serves all callers. In the process that compiles that is the callee's own
code, in one that loads from the disk the copy in the first caller. Results then differed in their last digits, and from there in up to
1e-4 of an acceleration. With local symbols a function's code is what was compiled for it, whatever else is loaded.

For some operations (a power, a quotient of complex numbers) numba compiles a helper, once for each signature: with the floating-point
flags of the first function in the process that needs it. Which one that is depends on what was compiled before, by another engine or by
the user. With one helper for each set of flags it no longer does.
"""

from collections import defaultdict
from typing import Any, Final

from llvmlite.binding import Linkage
from numba.core.codegen import CPUCodeLibrary
from numba.core.cpu import CPUContext

#: Part of the mangled names of this package's functions.
_OURS: Final = "11quickreturn"
#: Helpers that numba has compiled, by the identity of its code generator and the floating-point flags.
_helpers: Final[dict[tuple[int, frozenset[str]], dict[Any, Any]]] = defaultdict(dict)


def compile_alike() -> None:
    """Let numba compile a function of this package to the same code in every process."""
    _bind_inside()
    _keep_flags_apart()


def _keep_flags_apart() -> None:
    """Let a context of numba's take only helpers that were compiled with its own floating-point flags."""
    numbas: Any = CPUContext.subtarget

    def subtarget(context: Any, **options: Any) -> Any:
        found = numbas(context, **options)
        flags = found.fastmath.flags if found.fastmath else ()
        found.cached_internal_func = _helpers[id(found.codegen()), frozenset(flags)]
        return found

    if numbas.__name__ != subtarget.__name__ or numbas.__module__ != subtarget.__module__:
        CPUContext.subtarget = subtarget  # type: ignore[assignment]


def _bind_inside() -> None:
    """Let numba's libraries emit the functions of this package that were copied into them with local symbols."""
    numbas: Any = CPUCodeLibrary._finalize_final_module

    def finalize(library: Any) -> None:
        module = library._final_module
        if copies := [each.name for each in _defined(module, Linkage.linkonce_odr) if _OURS in each.name]:
            # as in numba's `_get_module_for_linking`: what callers link keeps weak symbols, so that they hold each function once
            library._shared_module = module.clone()
            for function in _defined(library._shared_module, Linkage.external):
                function.linkage = "linkonce_odr"
            for name in copies:
                module.get_function(name).linkage = "internal"
        numbas(library)

    if numbas.__name__ != finalize.__name__:
        CPUCodeLibrary._finalize_final_module = finalize  # type: ignore[method-assign]


def _defined(module: Any, linkage: Linkage) -> list[Any]:
    """Functions that are defined in a module with a linkage."""
    return [each for each in module.functions if not each.is_declaration and each.linkage == linkage]
