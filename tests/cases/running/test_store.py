"""Stored results: what comes back from a record is what went in, or nothing at all and a notice."""

import math
import os
import subprocess
import sys
import textwrap
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.running.store import Record, Store, StoreError, decoded, encoded
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.trajectory import FollowerTrajectory, Trajectory
from quickreturn.reference_model.arrays import Array

KEY = 64 * "a"


def filled(folder: Path) -> tuple[Store, Path]:
    store = Store(folder)
    store.put(KEY, Record({"error": 1e-3, "names": ["a", "ä"]}, {"time": np.arange(4) / 3.0, "empty": np.zeros((0, 2))}))
    (file,) = folder.glob("*.result")
    return store, file


def fetched(store: Store) -> Record:
    entry = store.get(KEY)
    assert entry is not None
    return entry


def test_entry_comes_back_bit_for_bit(tmp_path: Path) -> None:
    filled(tmp_path)
    entry = fetched(Store(tmp_path))
    assert entry.document == {"error": 1e-3, "names": ["a", "ä"]}
    assert np.array_equal(entry.arrays["time"], np.arange(4) / 3.0)
    assert entry.arrays["empty"].shape == (0, 2)


@pytest.mark.parametrize("length", [0, 10, 90, 300, -1])
def test_truncated_entry_is_found_and_said(tmp_path: Path, length: int) -> None:
    store, file = filled(tmp_path)
    file.write_bytes(file.read_bytes()[:length])
    assert store.get(KEY) is None
    assert len(store.notices) == 1
    assert "is truncated or was edited; it is computed anew" in store.notices[0]


@pytest.mark.parametrize("place", [0, 30, 100, -1])
def test_one_edited_byte_is_found(tmp_path: Path, place: int) -> None:
    store, file = filled(tmp_path)
    content = bytearray(file.read_bytes())
    content[place] ^= 1
    file.write_bytes(content)
    assert store.get(KEY) is None
    assert len(store.notices) == 1
    store.put(KEY, Record({"error": 2e-3}))
    assert fetched(store).document == {"error": 2e-3}


def test_folder_from_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("QUICKRETURN_STORE", str(tmp_path / "deep" / "store"))
    assert Store().folder == tmp_path / "deep" / "store"
    monkeypatch.delenv("QUICKRETURN_STORE")
    monkeypatch.chdir(tmp_path)
    Store()
    assert (tmp_path / ".quickreturn").is_dir()


def test_file_where_the_folder_should_be(tmp_path: Path) -> None:
    (tmp_path / "store").write_text("")
    with pytest.raises(StoreError, match=r"cannot be created or written .* set QUICKRETURN_STORE"):
        Store(tmp_path / "store")


def test_nothing_but_plain_data_is_stored(tmp_path: Path) -> None:
    store = Store(tmp_path)
    with pytest.raises(ValueError, match="plain numbers"):
        store.put(KEY, Record({}, {"a": np.array([object()])}))
    with pytest.raises(ValueError, match="JSON compliant"):
        store.put(KEY, Record({"a": math.nan}))
    assert list(tmp_path.iterdir()) == []


def test_temporary_files_of_killed_runs_are_cleared_but_not_those_of_living_ones(tmp_path: Path) -> None:
    old, new = tmp_path / ".a.part", tmp_path / ".b.part"
    for file in (old, new):
        file.write_text("half a result")
    hours_ago = time.time() - 7200.0
    os.utime(old, (hours_ago, hours_ago))
    Store(tmp_path)
    assert not old.exists()
    assert new.exists()


def test_two_runs_on_one_store_never_see_half_an_entry(tmp_path: Path) -> None:
    code = f"""
        import sys, numpy
        from pathlib import Path
        from quickreturn.cases.running.store import Record, Store
        store, number = Store(Path({str(tmp_path)!r})), int(sys.argv[1])
        for turn in range(30):
            store.put({KEY!r}, Record({{"number": number}}, {{"a": numpy.full(2000, float(number))}}))
            entry = store.get({KEY!r})
            assert (entry.arrays["a"] == entry.document["number"]).all()
        assert store.notices == []
    """
    runs = [subprocess.Popen([sys.executable, "-c", textwrap.dedent(code), number]) for number in ("1", "2")]
    assert [run.wait() for run in runs] == [0, 0]


@dataclass(frozen=True)
class Part:
    name: str
    size: float | None
    place: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Whole:
    parts: tuple[Part, ...]
    one: Part | None
    by_name: Mapping[str, Part]
    settings: dict[str, Any]
    columns: dict[str, Array] = field(default_factory=dict)
    picture: bytes = b""


WHOLE = Whole(
    parts=(Part("a", 1.5), Part("b", None, (1.0, -math.inf))),
    one=None,
    by_name={"c": Part("c", math.inf)},
    settings={"modes": 5, "list": [1, None, True], "nested": {"tolerance": 1e-7}},
    columns={"time": np.arange(3) / 3.0},
    picture=b"\x00\xff",
)


def there_and_back(kind: Any, value: Any, folder: Path) -> Any:
    store = Store(folder)
    store.put("key", encoded(value))
    record = store.get("key")
    assert record is not None
    return decoded(kind, record)


def test_what_comes_back_is_what_went_in(tmp_path: Path) -> None:
    found = there_and_back(Whole, WHOLE, tmp_path)
    assert (found.parts, found.one, found.by_name, found.settings) == (WHOLE.parts, None, WHOLE.by_name, WHOLE.settings)
    assert np.array_equal(found.columns["time"], WHOLE.columns["time"])
    assert found.picture == WHOLE.picture


def test_numbers_of_numpy_are_plain_ones(tmp_path: Path) -> None:
    found = there_and_back(list[Any], [np.float64(0.1), np.int64(3), np.bool_(True)], tmp_path)
    assert found == [0.1, 3, True]
    assert [type(value) for value in found] == [float, int, bool]


@pytest.mark.parametrize("kind", [Trajectory, FollowerTrajectory])
def test_of_several_classes_the_one_that_takes_the_record_comes_back(kind: type[Trajectory], tmp_path: Path) -> None:
    partial = kind({name: np.zeros(3) for name in kind.required}, 0.5)
    found = there_and_back(Part | EngineFailure, EngineFailure(0.25, "it snapped", "try another", partial), tmp_path)
    assert str(found) == "failed at t = 0.25 s: it snapped; try another"
    assert type(found.partial) is kind
    assert isinstance(there_and_back(Part | EngineFailure, WHOLE.parts[0], tmp_path), Part)
