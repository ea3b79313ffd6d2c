"""Every output has a witness, and every witness a test that exists; `tests/verification/test_witnesses.py` computes the differences."""

import ast
import dataclasses
import re
from functools import cache
from pathlib import Path

import pytest

from quickreturn.cases.witnesses import RESULTS, outputs, table

ROOT = Path(__file__).parents[2]
#: Numbers that a result repeats from its request.
GIVEN = {"Quantile.probability", "FittedParameter.start", "Result.accuracy", "ResonanceCurve.settings"}


@pytest.mark.parametrize("result", RESULTS, ids=lambda result: result.__name__)
def test_every_number_of_a_result_has_a_witness(result: type) -> None:
    numbers = {field.name for field in dataclasses.fields(result) if re.search(r"\b(float|Array|complex)\b", str(field.type))}
    assert {f"{result.__name__}.{name}" for name in numbers - result.witnesses.keys()} <= GIVEN  # type: ignore[attr-defined]
    assert result.witnesses.keys() <= {field.name for field in dataclasses.fields(result)}  # type: ignore[attr-defined]


@cache
def functions_of(file: str) -> frozenset[str]:
    parsed = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return frozenset(node.name for node in parsed.body if isinstance(node, ast.FunctionDef))


def test_every_witness_names_a_test() -> None:
    named = {witness.test for *_, witness in outputs()}
    assert {test for test in named if test.partition("::")[2] not in functions_of(test.partition("::")[0])} == set()


def test_the_document_shows_the_table() -> None:
    """Its rows come from `python -m quickreturn.cases.witnesses`."""
    assert table() in (ROOT / "docs" / "belief.md").read_text(encoding="utf-8")
