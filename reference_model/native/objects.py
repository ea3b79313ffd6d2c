"""Compiled functions that Python calls, kept on the disk as objects that load without the compiler, whose import takes longer than a run.

An object serves on the processor and by the version of LLVM that it was made for, if it is whole and all that it refers to is there. A
wheel brings objects along (`reference_model.entries`), for the sources in it and all processors of one level. Where none serves, the
compiler compiles the function, or loads it from its own cache.
"""

import ctypes
import hashlib
import pkgutil
import secrets
from contextlib import suppress
from functools import cache, cached_property
from pathlib import Path
from typing import Any, Final

import llvmlite
import llvmlite.binding as llvm

from quickreturn.reference_model.native import cache_folder

_ARGUMENTS: Final[dict[str, Any]] = {"i": ctypes.c_int64, "f": ctypes.c_double}
#: The level of processors that a wheel's objects are for, and what LLVM says of such a processor.
LEVEL: Final = "x86-64-v3"
_NEEDED: Final = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")
#: What holds the loaded code.
_engines: Final[list[Any]] = []


class Entry:
    """A compiled function of numbers, and of arrays by their addresses, that returns a whole number.

    Args:
        source: module and name of the function, "package.module:function", which is imported, and with it the compiler, to be compiled.
        arguments: a letter for each argument: "i" for a whole number or an address, "f" for a number.
    """

    def __init__(self, source: str, arguments: str) -> None:
        self._source, self._arguments = source, arguments

    @cached_property
    def address(self) -> int:
        """Its address, for other compiled code."""
        for path in [self.shipped, self.path] if _of_level() else [self.path]:
            with suppress(OSError, KeyError, ValueError, AttributeError, RuntimeError):  # there is none, or of another system or library
                return _loaded(path)
        return self.compiled()

    @cached_property
    def _call(self) -> Any:
        return ctypes.PYFUNCTYPE(ctypes.c_int64, *(_ARGUMENTS[each] for each in self._arguments))(self.address)

    def __call__(self, *arguments: float) -> int:
        """Call it."""
        return int(self._call(*arguments))

    def compiled(self) -> int:
        """Its address, from the compiler; the object is kept."""
        from quickreturn.reference_model.native.compilation import entry

        function = entry(pkgutil.resolve_name(self._source), self._arguments)
        with suppress(AttributeError, RuntimeError, OSError):  # another numba, its own cache, or a full disk: nothing is kept
            code, written = function._library._get_compiled_object(), self.path.with_suffix(f".{secrets.token_hex(4)}.part")
            head = " ".join((hashlib.sha256(code).hexdigest(), function.native_name, *function._library.needed))
            written.write_bytes(f"{head}\n".encode() + code)
            written.replace(self.path)
        return int(function.address)

    @property
    def path(self) -> Path:
        """Of its object for this processor."""
        return cache_folder.folder() / f"{self._name}-{_made_for()}.object"

    @property
    def shipped(self) -> Path:
        """Of its object in a wheel."""
        return cache_folder.SHIPPED / f"{self._name}-{cache_folder.source_hash()}.object"

    @property
    def _name(self) -> str:
        return self._source.replace(":", ".")


@cache
def _of_level() -> bool:
    """Whether this processor is of the level that a wheel's objects are for."""
    features = llvm.get_host_cpu_features()
    return all(features.get(each, False) for each in _NEEDED)


@cache
def _made_for() -> str:
    """A hash of the sources, of LLVM's version and of the processor."""
    made_for = cache_folder.source_hash(), llvmlite.__version__, llvm.get_default_triple(), llvm.get_host_cpu_name()
    return hashlib.sha256(" ".join((*made_for, llvm.get_host_cpu_features().flatten())).encode()).hexdigest()[:16]


def _loaded(path: Path) -> int:
    """The address of the function in an object.

    Raises:
        OSError: there is no such file.
        KeyError, ValueError, AttributeError, RuntimeError: it is of another system or library, truncated, or refers to what is not there.
    """
    head, _, content = path.read_bytes().partition(b"\n")
    digest, name, *needed = head.decode().split(" ")
    if digest != hashlib.sha256(content).hexdigest():
        raise ValueError(f"{path} is truncated")
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), llvm.Target.from_default_triple().create_target_machine())
    for symbol in needed:
        if llvm.address_of_symbol(symbol) is None:
            if not symbol.startswith("numba_"):
                raise KeyError(symbol)
            # the compiler's own, for exceptions, which this code never raises
            llvm.add_symbol(symbol, ctypes.cast(ctypes.CDLL(None).abort, ctypes.c_void_p).value)
    engine.add_object_file(llvm.ObjectFileRef.from_data(content))
    engine.finalize_object()
    _engines.append(engine)
    return int(engine.get_function_address(name))
