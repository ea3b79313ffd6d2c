"""Keys of results, which change with what determines the result and nothing else; what a module imports, as the code among it."""

import dataclasses
import importlib
import json
import math
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.solving import frequencies_job
from quickreturn.cases.running import key
from quickreturn.cases.running.job import Job, Limits
from quickreturn.cases.running.key import ONLY_TALK, code_of, hash_of, imported_modules, key_of, names_imported, sources_of
from quickreturn.engines.plugins import plugins
from quickreturn.plugins.studies.sweep import grid
from quickreturn.plugins.studies.sweep.rows import MeasureRequest
from tests.engines.scenes import run_24


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package `fingerprinted` of two files and a folder."""
    folder = tmp_path / "fingerprinted"
    (folder / "inner").mkdir(parents=True)
    for name, text in {"__init__": "", "one": "a = 1\n", "inner/__init__": "", "inner/two": "b = 2\n"}.items():
        (folder / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.partition(".")[0] == "fingerprinted"]:  # of another test
        monkeypatch.delitem(sys.modules, name)
    importlib.invalidate_caches()
    return folder


def test_own_code_of_a_third_party_engine_counts(package: Path) -> None:
    """That of all files of its package; not its data, nor what is unpacked beside compiled code."""
    (package / "one.py").write_text("class Engine:\n    pass\n")
    chosen, seen = importlib.import_module("fingerprinted.one").Engine, list[str]()
    for name, text in (("apart.txt", ""), ("__pycache__/machine.py", "import math\n"), ("inner/two.py", "b = 3\n"), ("three.py", "")):
        (package / name).parent.mkdir(exist_ok=True)
        (package / name).write_text(text)
        key._code_of_engine.cache_clear()
        key.text_of.cache_clear()
        seen.append(key._code_of_engine(chosen))
    assert seen[0] == seen[1]
    assert len(set(seen)) == 3


def function_in(module: str) -> Any:
    """A function of a module, read anew."""
    key._hash_of_module.cache_clear()
    key._imports.cache_clear()
    key.text_of.cache_clear()
    return SimpleNamespace(__module__=module)


def test_what_a_function_imports_counts_and_nothing_else(package: Path) -> None:
    (package / "one.py").write_text("def work():\n    from fingerprinted.inner import two\n    return two.b\n")
    (package / "apart.py").write_text("")
    before = code_of(function_in("fingerprinted.one"))
    for name, text, counts in (("apart", "c = 1\n", False), ("inner/two", "b = 3\n", True), ("inner/__init__", "d = 4\n", True)):
        (package / f"{name}.py").write_text(text)
        after = code_of(function_in("fingerprinted.one"))
        assert (after != before) == counts, name
        before = after


#: Function of a stored job -> some of the modules that it uses, and some that it does not.
USES = """
plugins.studies.sweep.grid.measured_row: cases.files.document cases.files.document cases.files.units cases.files.reading
    cases.motion.catalogue cases.motion.steady_state plugins.strength.measures plugins.strength.stress,
    not plugins.studies.sweep.study cases.comparison.engines
plugins.conform.contract.conform: plugins.conform.quantities plugins.conform.rods, not cases.comparison.engines
cases.motion.steady_state.steady_state: cases.motion.drifting_fit cases.motion.marching plugins.strength.measures,
    not cases.comparison.engines plugins.strength.words cases.comparison.causes plugins.studies.sweep.rows
cases.motion.orbit.find_orbit: cases.motion.orbit, not cases.comparison.engines
cases.motion.solving.answer_to: cases.motion.solving, not cases.files.document cases.motion.steady_state plugins.strength.measures
plugins.studies.resonance_curve.search.resonance_curve: cases.files.document cases.files.reading cases.motion.extremes,
    not cases.comparison.engines
plugins.methods.race.raced: plugins.methods.search plugins.methods.asked plugins.methods.truth, not plugins.methods.studies
plugins.methods.truth.truth_of: plugins.methods.truth plugins.methods.row, not plugins.methods.search cases.comparison.engines
plugins.thesis.inference.response.respond: cases.motion.time_scale cases.motion.marching, not cases.comparison.engines
""".strip().replace("\n    ", " ")


@pytest.mark.parametrize("line", USES.splitlines(), ids=lambda line: line.partition(":")[0])
def test_the_key_of_a_stored_job_has_what_it_uses_and_not_what_only_talks(line: str) -> None:
    name, _, modules = line.partition(": ")
    used, others = map(str.split, modules.split(", not "))
    module, _, function = f"quickreturn.{name}".rpartition(".")
    assert callable(getattr(importlib.import_module(module), function))
    sources = sources_of(module)
    assert {f"quickreturn.{each}" for each in used} <= sources.keys()
    assert {"quickreturn.reference_model.model", "quickreturn.engines.own.reference", "quickreturn.cases.running.store"} <= sources.keys()
    assert not {f"quickreturn.{each}" for each in others} & sources.keys()
    assert not {"quickreturn.cases.running.display", "quickreturn.engines.progress", "quickreturn.cases.files.shown"} & sources.keys()


RUNNING = """
import pickle, sys
function, arguments = pickle.load(sys.stdin.buffer)
function(*arguments)
print(*(name for name in sys.modules if name.startswith("quickreturn.")))
"""


def row() -> Job[Any]:
    asked = MeasureRequest(measures=("peak.stress", "multiplier"), claims=False, accuracy=0.05)
    return grid.job(load_case("shaper-cutting"), [{"follower.thickness": "50 mm"}], asked)


def frequencies() -> Job[Any]:
    return frequencies_job("frequencies", run_24(), "reference", [1.0], 2, {})


@pytest.mark.parametrize("made", [frequencies, pytest.param(row, marks=pytest.mark.verify)])
def test_a_job_loads_no_module_that_its_key_lacks(made: Callable[[], Job[Any]]) -> None:
    """In a process of its own, as a worker gets it."""
    asked = made()
    order = pickle.dumps((asked.function, asked.arguments))
    loaded = subprocess.run([sys.executable, "-P", "-c", RUNNING], input=order, capture_output=True, check=True).stdout.decode().split()
    assert asked.function.__module__ in loaded
    quiet = tuple(f"{each}." for each in ONLY_TALK)
    registry = {f"quickreturn.plugins.{name}{of}" for name in plugins() for of in ("", ".plugin")}  # texts of what there is
    registry |= {each.rpartition(".")[0] for each in ONLY_TALK}  # the packages of such modules hold no code
    assert {name for name in loaded if not f"{name}.".startswith(quiet)} - sources_of(asked.function.__module__).keys() <= registry


def job(**changes: Any) -> Job[Any]:
    return dataclasses.replace(Job("one", len, ((1, 2),), "trial", ("reference",)), **changes)


def test_a_result_is_told_apart_by_all_that_determines_it_and_by_nothing_else() -> None:
    changes: list[dict[str, Any]] = [{"function": sum}, {"arguments": ((1, 3),)}, {"inputs": "other"}, {"kind": "other"}, {"engines": ()}]
    others = [job(**change) for change in changes]
    assert len({key_of(each) for each in (job(), *others)}) == 1 + len(others)
    assert key_of(job()) == key_of(job(name="two", limits=Limits(seconds=1.0))) == key_of(job(inputs=((1, 2),)))


def test_key_tells_everything_apart_that_matters() -> None:
    one_bit = math.nextafter(0.1, 1.0)
    values = [1, 1.0, "1", True, None, [1], math.inf, math.nan, 0.1, one_bit, np.zeros(3), np.zeros((3, 1)), np.ones(3)]
    scenes = [run_24(), run_24(tip=None), run_24(gravity=(0.0, -9.81))]
    contents = [{"b": 1}, *({"a": value} for value in (*values, *scenes))]
    assert len({hash_of(content) for content in contents}) == len(contents)


def test_key_does_not_depend_on_the_order_of_names_or_on_the_process() -> None:
    assert hash_of({"a": 1, "b": (2, 3)}) == hash_of({"b": [2, 3], "a": 1})
    code = "from quickreturn.cases.running.key import hash_of; from tests.engines.scenes import run_24; print(hash_of({'scene': run_24()}))"
    root = Path(__file__).parents[3]
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    assert answer.stdout.strip() == hash_of({"scene": run_24()})


def test_key_refuses_what_has_no_canonical_form() -> None:
    with pytest.raises(TypeError, match="object has no canonical form"):
        hash_of({"a": object()})


SOURCE = '''"""A docstring.

from the model import nothing.
"""
from typing import TYPE_CHECKING, Final
import quickreturn.a, quickreturn.b as b  # why
from quickreturn.c import (
    d,  # with (brackets
    e as f,
)

if TYPE_CHECKING:
    from quickreturn.types_alone import T

    from quickreturn.more_types import U
FIND: Final = "quickreturn.quoted.one:function"

def function() -> None:
    from quickreturn.inside import g
    print(g, "the text quickreturn.not_a_name is longer")
'''


def test_imports_are_read_from_a_source() -> None:
    at_the_head = {"quickreturn.a", "quickreturn.b", "quickreturn.c", "quickreturn.c.d", "quickreturn.c.e"}
    found = {name for name in names_imported(SOURCE) if name.startswith("quickreturn")}
    assert found == at_the_head | {"quickreturn.quoted.one", "quickreturn.inside", "quickreturn.inside.g"}


@pytest.mark.parametrize("module", ["quickreturn.engines.accurate", pytest.param("quickreturn.reports.report", marks=pytest.mark.verify)])
def test_python_imports_no_module_that_is_not_found(module: str) -> None:
    """What Python has imported after an import is among what is found; plugins, which no statement names, have their own tests above."""
    asked = f"import json, sys, {module}; print(json.dumps(sorted(name for name in sys.modules if name.startswith('quickreturn.'))))"
    told = subprocess.run([sys.executable, "-P", "-c", asked], capture_output=True, text=True, check=True).stdout
    named = {name for name in json.loads(told) if not name.startswith("quickreturn.plugins")}
    assert named <= set(imported_modules([module]))
