"""The fingerprint changes with the code and with nothing else."""

import importlib
from pathlib import Path

import pytest

from cases import fingerprint
from cases.fingerprint import code_fingerprint
from tests.engines.fake_engine import FakeEngine


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
    fingerprint._source_hash.cache_clear()
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
