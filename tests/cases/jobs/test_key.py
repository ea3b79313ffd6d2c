"""Keys of results: they change with what determines the result, the code among it, and with nothing else."""

import dataclasses
import importlib
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.jobs import key
from quickreturn.cases.jobs.job import Job, Limits
from quickreturn.cases.jobs.key import code_fingerprint, hash_of, key_of
from tests.engines.fake_engine import FakeEngine
from tests.engines.scenes import run_24


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package `fingerprinted` of two files and a folder."""
    folder = tmp_path / "fingerprinted"
    (folder / "inner").mkdir(parents=True)
    for name, text in {"__init__": "", "one": "a = 1\n", "inner/__init__": "", "inner/two": "b = 2\n"}.items():
        (folder / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    importlib.invalidate_caches()
    return folder


def fresh(*parts: str) -> str:
    """As a new process would compute it: a process reads the sources once."""
    key._source_hash.cache_clear()
    return code_fingerprint(parts)


def test_every_edit_counts_and_undoing_it_restores(package: Path) -> None:
    seen = {fresh("fingerprinted")}
    (package / "inner" / "two.py").write_text("b = 3\n")
    seen.add(fresh("fingerprinted"))
    (package / "three.py").write_text("")
    seen.add(fresh("fingerprinted"))
    (package / "one.py").rename(package / "four.py")
    seen.add(fresh("fingerprinted"))
    assert len(seen) == 4
    (package / "four.py").rename(package / "one.py")
    (package / "three.py").unlink()
    (package / "inner" / "two.py").write_text("b = 2\n")
    assert fresh("fingerprinted") in seen


def test_data_files_do_not_count(package: Path) -> None:
    before = fresh("fingerprinted")
    (package / "notes.md").write_text("nothing")
    assert fresh("fingerprinted") == before


def test_a_module_can_be_a_part(package: Path) -> None:
    before = fresh("fingerprinted.one")
    (package / "inner" / "two.py").write_text("b = 4\n")
    assert fresh("fingerprinted.one") == before
    (package / "one.py").write_text("a = 2\n")
    assert fresh("fingerprinted.one") != before


def test_own_code_of_a_third_party_engine_counts() -> None:
    assert code_fingerprint(engine=FakeEngine()) != code_fingerprint()


def test_missing_part_is_an_error() -> None:
    with pytest.raises(ModuleNotFoundError, match="no_such_part"):
        code_fingerprint(("no_such_part",))


def job(**changes: Any) -> Job[Any]:
    return dataclasses.replace(Job("one", len, ((1, 2),), "trial", ("reference",)), **changes)


def test_a_result_is_told_apart_by_all_that_determines_it_and_by_nothing_else() -> None:
    changes: list[dict[str, Any]] = [{"function": sum}, {"arguments": ((1, 3),)}, {"inputs": "other"}, {"kind": "other"}, {"engines": ()}]
    others = [job(**change) for change in (*changes, {"code": ("quickreturn.cases.jobs.worker",)})]
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
    code = "from quickreturn.cases.jobs.key import hash_of; from tests.engines.scenes import run_24; print(hash_of({'scene': run_24()}))"
    root = Path(__file__).parents[3]
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    assert answer.stdout.strip() == hash_of({"scene": run_24()})


def test_key_refuses_what_has_no_canonical_form() -> None:
    with pytest.raises(TypeError, match="object has no canonical form"):
        hash_of({"a": object()})
