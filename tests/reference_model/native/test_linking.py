"""The same bits on one processor, whether a process has compiled the code or loaded it, and wherever the package lies."""

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import FunctionType
from typing import Any

import llvmlite.binding as llvm
import numba
import numpy as np
import pytest

from quickreturn.reference_model.native.compilation import FASTMATH, jitted
from quickreturn.reference_model.native.kept import _OURS
from tests.package_copy import copied_package

#: Prints what engines make of a vibrating start, to the last bit. The models' code is compiled in several ways.
CODE = """
import hashlib
import sys
from quickreturn.engines.registry import engine
from quickreturn.engines.accurate import simulate
from quickreturn.engines.start import standard_start
from tests.engines.scenes import run_24
for name in sys.argv[1:]:
    columns = simulate(engine(name), run_24(), standard_start(run_24()), 0.02, 1e-3, estimate=False).trajectory.columns
    print(name, hashlib.sha256(b"".join(columns[each].tobytes() for each in sorted(columns))).hexdigest())
"""
ENGINES = ("reference", "thesis", "mujoco")
#: What a user may have compiled before: powers and complex quotients, for which numba compiles helpers.
BEFORE = """
import numba
@numba.njit
def own(x, n, z):
    return max(x ** n, x ** 2, 1.0) + int(x) + abs(z / (1j + z) * z ** 2)
own(2.0, 3, 1j)
"""
ROOT = Path(__file__).resolve().parents[3]
#: An entry in the table of symbols of an object (ELF, 64 bit); one in section 0 is defined elsewhere.
SYMBOL = np.dtype([("name", "<u4"), ("kind", "u1"), ("seen", "u1"), ("section", "<u2"), ("value", "<u8"), ("size", "<u8")])


def total(x, y):
    sums = 0.0
    for i in range(len(x)):
        sums += x[i] * y[i]
    return sums


def both(x, y):
    return total(x, x) + total(x, y)


def weak(library: object) -> list[str]:
    """Names of this package's functions that a library's object defines by weak symbols."""
    found = symbols(library._get_compiled_object())  # type: ignore[attr-defined]
    return [name for name, symbol in found if symbol["kind"] >> 4 == 2 and symbol["section"] and _OURS in name]


def symbols(content: bytes) -> Iterator[tuple[str, Any]]:
    """The symbols of an object, with their names."""
    code = llvm.ObjectFileRef.from_data(content)
    sections = {section.name(): section.data() for section in code.sections()}
    names = sections[b".strtab"]
    for symbol in np.frombuffer(sections[b".symtab"], SYMBOL)[1:]:
        yield names[symbol["name"] : names.index(b"\0", symbol["name"])].decode(), symbol


def made_up(function: FunctionType, **names: object) -> FunctionType:
    """A copy of a function of a module of the package."""
    return FunctionType(function.__code__, {"__name__": "quickreturn.made_up", "range": range, "len": len, **names}, function.__name__)


def test_a_compiled_function_calls_its_own_copies() -> None:
    """A weak symbol would be replaced by whatever of this name the process has loaded before."""
    inner = jitted(made_up(total), kept=False, fastmath=FASTMATH, _dbg_optnone=True)
    outer = jitted(made_up(both, total=inner), kept=False, fastmath=FASTMATH)
    assert outer(np.ones(7), np.ones(7)) == 14.0
    for compiled, own in ((inner, "total"), (outer, "both")):
        (found,) = (made.library for made in compiled.overloads.values())
        defined = [each.name for each in found.get_defined_functions() if _OURS in each.name]
        assert any(own in name for name in defined)
        assert weak(found) == []
    assert any("total" in name for name in defined), "the callee was inlined, so that nothing was tested"


def power(x, n):
    return x**n


def test_a_helper_is_not_shared_with_code_that_has_other_floating_point_flags() -> None:
    numba.njit(power)(2.0, 3)
    fast = jitted(made_up(power), kept=False, fastmath=FASTMATH)
    assert fast(2.0, 3) == 8.0
    (text,) = fast.inspect_llvm().values()
    assert " fmul " in text
    assert " fmul double" not in text


@pytest.mark.verify
def test_results_are_the_same_bits_compiled_loaded_and_installed(tmp_path: Path) -> None:
    """They differed by up to 1e-4 of an acceleration: callees, copied into each caller, were taken from another one."""
    package = copied_package(tmp_path / "installed", "reference_model", "engines", "cases", "reports")

    def printed(cache: str, path: Path, code: str = CODE, engines: Sequence[str] = ENGINES) -> str:
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / cache), "PYTHONPATH": os.pathsep.join((str(path), str(ROOT)))}
        done = subprocess.run([sys.executable, "-P", "-c", code, *engines], env=environment, capture_output=True, text=True, check=True)
        return "".join(sorted(done.stdout.splitlines(keepends=True)))

    compiled = printed("cache", ROOT)
    assert compiled.count("\n") == len(ENGINES)
    assert printed("cache", ROOT) == compiled  # loaded
    assert printed("another", package.parent) == compiled  # compiled at another place
    assert printed("another", package.parent) == compiled
    assert printed("other engine first", ROOT, engines=ENGINES[::-1]) == compiled
    assert printed("other code first", ROOT, BEFORE + CODE) == compiled
