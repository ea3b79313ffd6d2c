"""A user's own numba functions are compiled, kept and computed as without this package, and numba without its insides will do."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.package_copy import ROOT

#: A user's module. A power and a complex quotient: numba compiles helpers for them.
OWN = """
import numba
@numba.njit(cache=True)
def own(x, n, z):
    return max(x ** n, x ** 2, 1.0) + int(x) + abs(z / (1j + z) * z ** 2)
"""
#: Compiles a user's function of one of two folders, and prints what came of it.
COMPILES = """
import importlib, json, os, re, sys
def compiled(folder):
    sys.path.insert(0, folder)
    sys.modules.pop("user", None)
    importlib.invalidate_caches()
    own = importlib.import_module("user").own
    sys.path.remove(folder)
    digits = own(1.1, 3, 0.3 + 0.7j).hex()
    (code,) = own.inspect_asm().values()
    # numba numbers the functions of a process, so that a name in a text has more digits, and names some constants by their place in memory
    code = re.sub(r"B\\d+v\\d+(?=B)|(?<=picklebuf\\.)\\d+|(?<=pickledata\\.)\\d+|(?<=object at )0x[0-9a-f]+", "", code)
    code = re.sub(r"\\.size\\s+.*missing Environment.*", "", code)
    return digits, code, os.path.relpath(own.stats.cache_path, folder), sorted(os.listdir(own.stats.cache_path))
"""
USES = """
import quickreturn as qr
qr.simulate(qr.case("thesis-24", duration=0.02), "reference", store=False, estimate=False)
qr.simulate(qr.case("thesis-24", duration=0.02), "mujoco", store=False, estimate=False)
"""
#: Numba's classes with their members, its settings, and the environment.
STATE = """
def state():
    import inspect, numba
    from numba.core import caching, ccallback, codegen, compiler, cpu, dispatcher
    found = {"environment": dict(os.environ)}
    found["settings"] = {name: repr(value) for name, value in vars(numba.config).items() if name.isupper()}
    for module in (caching, ccallback, codegen, compiler, cpu, dispatcher):
        for name, kind in inspect.getmembers(module, inspect.isclass):
            found[f"{module.__name__}.{name}"] = {member: repr(value) for member, value in vars(kind).items() if callable(value)}
    return found
"""

DIFFERENCES = """
print([f"{name}.{each}" for name in before for each in {**before[name], **after[name]} if before[name].get(each) != after[name].get(each)])
"""


def printed(code: str, tmp_path: Path, *arguments: str) -> str:
    """What a program prints, in a process without a folder for numba's cache."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA")}
    path = os.pathsep.join(filter(None, (environment.get("PYTHONPATH"), str(ROOT))))
    environment |= {"PYTHONPATH": path, "QUICKRETURN_STORE": str(tmp_path / "store")}
    command = [sys.executable, "-P", "-c", code, *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    return done.stdout


def folders(tmp_path: Path) -> list[str]:
    """Folders with the same module of a user."""
    for name in ("alone", "before", "after"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "user.py").write_text(OWN)
    return [str(tmp_path / name) for name in ("alone", "before", "after")]


@pytest.mark.verify
def test_a_users_function_is_the_same_before_and_after_a_simulation(tmp_path: Path) -> None:
    alone, before, after = folders(tmp_path)
    code = f"{COMPILES}print(json.dumps(compiled(sys.argv[1])));{USES}print(json.dumps(compiled(sys.argv[2])))"
    (expected,) = printed(f"{COMPILES}print(json.dumps(compiled(sys.argv[1])))", tmp_path, alone).splitlines()
    digits, _, place, files = json.loads(expected)
    assert (float.fromhex(digits), place) == (pytest.approx(3.0, abs=1.0), "__pycache__")
    assert any(file.endswith(".nbi") for file in files)
    assert [json.loads(line) for line in printed(code, tmp_path, before, after).splitlines()] == 2 * [json.loads(expected)]


@pytest.mark.verify
def test_numba_its_settings_and_the_environment_stay_as_they_are(tmp_path: Path) -> None:
    """`threadpoolctl`, which counts threads, sets a variable at its import."""
    code = f"import os, threadpoolctl{STATE}before = state(){USES}after = state(){DIFFERENCES}"
    assert printed(code, tmp_path).splitlines() == ["[]"]


#: Compiles and calls a function of this package's without one of numba's insides.
WITHOUT = """
import numba, warnings
{hidden}
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    from quickreturn.reference_model.native.compilation import compiled, entry
print(*(str(each.message) for each in told if "numba" in str(each.message)), sep="|")
import ctypes
def double(x):
    return x + x
print(compiled(double)(4.0), ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64)(entry(double, "i").address)(4))
{simulates}
"""
HIDDEN = {
    "library": "import numba.core.codegen as codegen\ndel codegen.JITCodeLibrary",
    "cache": "import numba.core.caching as caching\ndel caching.CompileResultCacheImpl",
}


@pytest.mark.parametrize("what", HIDDEN)
@pytest.mark.verify
def test_without_an_inside_of_numba_each_process_compiles_and_says_so(what: str, tmp_path: Path) -> None:
    said, result = printed(WITHOUT.format(hidden=HIDDEN[what], simulates=""), tmp_path).splitlines()
    assert said.count("every process compiles its equations again") == 1
    assert result == "8.0 8"


@pytest.mark.parametrize("module", ["native/pointers", "native/simd", "compiled_state"])
def test_what_reads_by_address_imports_numbas_interface_for_extensions_alone(module: str) -> None:
    """It has no slower way: without these modules no extension of numba works."""
    text = (ROOT / f"reference_model/{module}.py").read_text()
    imported = {
        f"{home or '.'} {name}"
        for home, names in re.findall(r"^(?:from (numba[\w.]*) )?import (.*)$", text, re.M)
        for name in names.split(", ")
    }
    interface = {"numba.core cgutils", "numba.core.typing.templates AttributeTemplate", "numba extending", "numba types"}
    assert {each for each in imported if each.startswith("numba")} - interface <= {
        each for each in imported if each.startswith("numba.extending ")
    }


@pytest.mark.verify
def test_a_run_without_an_inside_of_numba_differs_by_rounding_alone(tmp_path: Path) -> None:
    run = """
from quickreturn.reference_model.model import BeamModel
from tests.engines.scenes import run_24
model = BeamModel.following(run_24(), 2)
print(model.observe(model.integrate(model.straight_state(1.0, 16.0), 1e-3, 50, 1e-6).states)["tip_deflection"][-1].hex())
"""
    expected = float.fromhex(printed(run, tmp_path).strip())
    *_, found = printed(WITHOUT.format(hidden=HIDDEN["library"], simulates=run), tmp_path).splitlines()
    assert float.fromhex(found) == pytest.approx(expected, rel=1e-9)
