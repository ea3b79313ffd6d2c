"""Every output has a witness, and every witness a test that exists; `tests/verification/test_witnesses.py` computes the differences."""

import ast
from functools import cache
from pathlib import Path

from tests.witnesses import GIVEN, WITNESSES, outputs, table, unconfirmed

ROOT = Path(__file__).parents[1]


def test_every_column_measure_and_number_of_a_result_has_a_witness() -> None:
    assert unconfirmed() == set()


def test_every_witness_belongs_to_an_output() -> None:
    assert WITNESSES.keys() | GIVEN <= outputs()


@cache
def functions_of(file: str) -> frozenset[str]:
    parsed = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return frozenset(node.name for node in parsed.body if isinstance(node, ast.FunctionDef))


def test_every_witness_names_a_test() -> None:
    named = {witness.test for witness in WITNESSES.values()}
    assert {test for test in named if test.partition("::")[2] not in functions_of(test.partition("::")[0])} == set()


def test_the_document_shows_the_table() -> None:
    """Its rows come from `python -m tests.witnesses`."""
    assert table() in (ROOT / "docs" / "belief.md").read_text(encoding="utf-8")
