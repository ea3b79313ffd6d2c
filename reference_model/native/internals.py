"""What this package takes from inside numba, beyond what numba documents for extensions; `pyproject.toml` bounds numba's version by it.

Attributes:
    MISSING: what this numba lacks of it; "" if nothing.
"""

__all__ = ["MISSING", "CFunc", "CacheLocator", "CompileResultCacheImpl", "Compiler", "FunctionCache", "JITCodeLibrary"]

try:
    from numba.core.caching import CompileResultCacheImpl, FunctionCache
    from numba.core.caching import _CacheLocator as CacheLocator
    from numba.core.ccallback import CFunc
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler

    _ = JITCodeLibrary._finalize_final_module, Compiler.compile_extra, FunctionCache.load_overload
    MISSING = ""
except (ImportError, AttributeError) as missing:
    MISSING = str(missing)
    CompileResultCacheImpl = FunctionCache = CacheLocator = CFunc = JITCodeLibrary = Compiler = object  # type: ignore[assignment, misc]
