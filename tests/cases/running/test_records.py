"""A result comes back from its record as what it was."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from quickreturn.cases.running.records import decoded, encoded
from quickreturn.cases.running.store import Record, Store
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.trajectory import FollowerTrajectory, Trajectory


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
    columns: dict[str, NDArray[np.float64]] = field(default_factory=dict)
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


@pytest.mark.parametrize("document", [{}, {"name": "a", "size": 1.0}, []])
def test_a_record_of_something_else_is_no_result(document: Any) -> None:
    with pytest.raises((KeyError, TypeError, ValueError)):
        decoded(Part, Record(document))


@pytest.mark.parametrize("kind", [Trajectory, FollowerTrajectory])
def test_of_several_classes_the_one_that_takes_the_record_comes_back(kind: type[Trajectory], tmp_path: Path) -> None:
    partial = kind({name: np.zeros(3) for name in kind.required}, 0.5)
    found = there_and_back(Part | EngineFailure, EngineFailure(0.25, "it snapped", "try another", partial), tmp_path)
    assert str(found) == "failed at t = 0.25 s: it snapped; try another"
    assert type(found.partial) is kind
    assert isinstance(there_and_back(Part | EngineFailure, WHOLE.parts[0], tmp_path), Part)
