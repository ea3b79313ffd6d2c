"""Compiled functions from objects, and from the compiler where an object does not serve."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from quickreturn.reference_model.entries import KERNEL, LOOP, OBSERVATIONS
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.native import objects
from quickreturn.reference_model.native.objects import Entry
from tests.engines.scenes import run_24
from tests.reference_model.native.test_linking import symbols

#: A few steps of run 24 by objects, then a function that the compiler makes, with an exception; prints what was imported.
AFTERWARDS = """
import sys
from quickreturn.reference_model.model import BeamModel
from tests.engines.scenes import run_24
model = BeamModel.following(run_24(), 2)
model.observe(model.integrate(model.straight_state(1.0, 0.0), 1e-3, 3, 1e-5).states)
print(*sys.modules)
import numba
@numba.njit
def refuse(x):
    if x > 1.0:
        raise ValueError("too large")
    return x
try:
    refuse(2.0)
except ValueError as error:
    print(error)
"""


@pytest.fixture(scope="module", autouse=True)
def kept() -> None:
    """The objects exist."""
    model = BeamModel.following(run_24(), 2)
    model.observe(model.integrate(model.straight_state(1.0, 0.0), 1e-3, 3, 1e-5).states)


@pytest.fixture
def loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Entry:
    """The integrator's loop, its object where a test may damage it."""
    kept = LOOP.path
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    LOOP.path.parent.mkdir()
    shutil.copy(kept, LOOP.path)
    return Entry(LOOP._source, LOOP._arguments)


def test_a_run_needs_no_compiler_and_leaves_it_unharmed() -> None:
    run = subprocess.run([sys.executable, "-c", AFTERWARDS], capture_output=True, text=True, check=True)
    imported, told = run.stdout.splitlines()
    assert not {"numba", "scipy.integrate", "scipy.linalg"} & set(imported.split())
    assert told == "too large"


@pytest.mark.parametrize("entry", [KERNEL, OBSERVATIONS, LOOP], ids=["kernel", "observations", "loop"])
def test_an_object_names_all_that_it_refers_to(entry: Entry) -> None:
    """But for what any C library has."""
    head, _, code = entry.path.read_bytes().partition(b"\n")
    undefined = {name for name, symbol in symbols(code) if symbol["section"] == 0}
    assert undefined <= {*head.decode().split(" "), "memset", "memcpy", "fmod", "pow", "sin", "cos", "sincos"}
    assert {name for name in undefined if name.startswith("numba_")} <= {
        *("numba_do_raise", "numba_gil_ensure", "numba_gil_release", "numba_runtime_build_excinfo_struct", "numba_unpickle")
    }
    assert not any(name.startswith("NRT_") for name in undefined)


@pytest.mark.parametrize(
    "damage", [lambda content: content[:-100], lambda content: b"", lambda content: b"\0" + content], ids=["short", "empty", "odd"]
)
@pytest.mark.verify
def test_a_damaged_object_is_not_loaded(loop: Entry, damage: object) -> None:
    loop.path.write_bytes(damage(loop.path.read_bytes()))  # type: ignore[operator]
    assert loop.address
    assert loop.address != LOOP.address


@pytest.mark.verify
def test_an_object_that_refers_to_the_unknown_is_not_loaded(loop: Entry) -> None:
    loop.path.write_bytes(loop.path.read_bytes().replace(b"\n", b" nobody_has_this\n", 1))
    with pytest.raises(KeyError, match="nobody_has_this"):
        objects._loaded(loop.path)
    assert loop.address


def test_an_object_for_another_processor_is_not_found(loop: Entry, monkeypatch: pytest.MonkeyPatch) -> None:
    path = loop.path
    monkeypatch.setattr(objects.llvm, "get_host_cpu_name", lambda: "another")
    objects._made_for.cache_clear()
    try:
        assert loop.path != path
    finally:
        objects._made_for.cache_clear()
