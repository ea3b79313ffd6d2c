"""Tuples whose members compiled code reads by address."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from quickreturn.reference_model.native.compilation import compiled
from quickreturn.reference_model.native.memory import ComplexVector, Cube, Matrix, Placed, Vector
from quickreturn.reference_model.native.pointers import reader

FACTS = np.dtype((np.record, [("whole", np.int64), ("part", np.float64)]))


class Inner(NamedTuple):
    """A tuple in a tuple."""

    real: "float"
    vector: "Vector"


class Outer(NamedTuple):
    """One member of each kind."""

    yes: "bool"
    no: "bool"
    whole: "int"
    inner: "Inner"
    complexes: "ComplexVector"
    matrix: "Matrix"
    cube: "Cube"
    facts: "Any"


outer_at = reader(Outer, facts=FACTS)


def example() -> Outer:
    facts = np.zeros(1, FACTS)[0]
    facts.whole, facts.part = 4, 0.5
    inner = Inner(2.5, np.array([3.0, 5.0]))
    return Outer(True, False, -7, inner, np.array([1.0 + 2.0j]), np.arange(6.0).reshape(2, 3), np.arange(24.0).reshape(2, 3, 4), facts)


@compiled
def read(address: int) -> tuple[Any, ...]:
    t = outer_at(address)
    t.matrix[0, 1] = 11.0
    t.facts.part = 12.0
    members = t.yes, t.no, t.whole, t.inner.real, t.inner.vector[1], t.complexes[0], t.matrix[1, 2], t.cube[1, 2, 3], t.facts.whole
    return *members, t.matrix.shape, t.cube.shape


def test_compiled_code_reads_and_writes_the_members() -> None:
    value = example()
    assert read(Placed(value).address) == (True, False, -7, 2.5, 5.0, 1.0 + 2.0j, 5.0, 23.0, 4, (2, 3), (2, 3, 4))
    assert (value.matrix[0, 1], value.facts.part) == (11.0, 12.0)


@pytest.mark.parametrize(
    "wrong",
    [
        {"whole": 1.0},
        {"inner": Inner(1, np.zeros(2))},
        {"inner": Inner(1.0, np.zeros(2, dtype=np.float32))},
        {"complexes": np.zeros(2)},
        {"matrix": np.zeros((3, 2)).T},
        {"cube": np.zeros((3, 2))},
        {"facts": np.zeros(1)[0]},
    ],
    ids=str,
)
def test_a_member_of_another_type_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(TypeError, match="not as annotated"):
        Placed(example()._replace(**wrong))
