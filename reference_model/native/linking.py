"""Numba's compiler with code libraries of this package's own, so that every process runs the same code, and nobody else's code changes.

Numba copies callees into each caller and optimises them there, with reordered sums and fused multiply-adds. It gives the copies weak
symbols: of several the one that a process has loaded first serves all callers. In the process that compiles that is the callee's own
code, in one that loads from the disk the copy in the first caller. Results then differed in their last digits, and from there in up to
1e-4 of an acceleration. With local symbols a function's code is what was compiled for it, whatever else is loaded.

For some operations (a power, a quotient of complex numbers) numba compiles a helper, once for each signature: with the floating-point
flags of the first function in the process that needs it. The functions here share helpers only with functions of the same flags.
"""

from collections import defaultdict
from collections.abc import Callable
from typing import Any, Final

from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

#: Part of the mangled names of this package's functions.
_OURS: Final = "11quickreturn"
#: Helpers that numba has compiled for functions of this package, by the floating-point flags.
_helpers: Final[dict[frozenset[str], dict[Any, Any]]] = defaultdict(dict)


#: Absent from a numba that this package does not know.
_ = JITCodeLibrary._finalize_final_module, Compiler.compile_extra


class Library(JITCodeLibrary):
    """Machine code of a function, in which the functions of this package that were copied into it have local symbols.

    Attributes:
        needed: names that it refers to and that others define, but for the compiler's own instructions.
    """

    def _finalize_final_module(self) -> None:
        module: Any = self._final_module
        named = [*module.functions, *module.global_variables]
        self.needed = [each.name for each in named if each.is_declaration and not each.name.startswith("llvm.")]
        if copies := [each.name for each in _defined(module, Linkage.linkonce_odr) if _OURS in each.name]:
            # as in numba's `_get_module_for_linking`: what callers link keeps weak symbols, so that they hold each function once
            self._shared_module = module.clone()
            for function in _defined(self._shared_module, Linkage.external):
                function.linkage = "linkonce_odr"
            for name in copies:
                module.get_function(name).linkage = "internal"
        super()._finalize_final_module()  # type: ignore[no-untyped-call]


class OwnCompiler(Compiler):
    """Compiles one function into a `Library`."""

    def __init__(self, typing_context: Any, target_context: Any, *rest: Any) -> None:
        super().__init__(typing_context, target_context, *rest)  # type: ignore[no-untyped-call]
        context = self.state.targetctx  # a copy of numba's, for this function alone
        context.cached_internal_func = _helpers[frozenset(context.fastmath.flags if context.fastmath else ())]

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """See numba's."""
        library = self.state.library = Library(self.state.targetctx.codegen(), func.__qualname__)  # type: ignore[no-untyped-call]
        library.enable_object_caching()  # type: ignore[no-untyped-call]
        return super().compile_extra(func)  # type: ignore[no-untyped-call]


def _defined(module: Any, linkage: Linkage) -> list[Any]:
    """Functions that are defined in a module with a linkage."""
    return [each for each in module.functions if not each.is_declaration and each.linkage == linkage]
