"""What this package takes from inside numba: its cache on disk, in a folder of the package's own, and its compiler.

One process compiles what several need. Every process runs the same code, and nobody else's code changes.

Numba copies callees into each caller and optimises them there, with reordered sums and fused multiply-adds. It gives the copies weak
symbols: of several the one that a process has loaded first serves all callers. In the process that compiles that is the callee's own
code, in one that loads from the disk the copy in the first caller. Results then differed in their last digits, and from there in up to
1e-4 of an acceleration. With local symbols a function's code is what was compiled for it, whatever else is loaded.

For some operations (a power, a quotient of complex numbers) numba compiles a helper, once for each signature: with the floating-point
flags of the first function in the process that needs it. The functions here share helpers only with functions of the same flags.
"""

import sys
from collections import defaultdict
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from llvmlite.binding import Linkage
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

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
