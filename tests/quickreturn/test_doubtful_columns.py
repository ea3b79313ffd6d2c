"""A column whose error may be larger than the column itself is named."""

from dataclasses import replace

import pytest

import quickreturn as qr
from quickreturn.cases.case_file import load_case, with_times


@pytest.mark.parametrize(
    ("estimate", "told"), [(1.42, ["follower_acceleration: the error may be larger than the column itself"]), (0.98, [])]
)
def test_a_column_that_is_all_error_is_named(estimate: float, told: list[str]) -> None:
    found = qr.simulate(with_times(load_case("thesis-24"), duration=0.01), settings={"modes": 2}, store=False, quiet=True)
    small: dict[str, float | None] = dict.fromkeys(found.result.error_estimates, 1e-3)
    changed = replace(found, result=replace(found.result, error_estimates=small | {"follower_acceleration": estimate}))
    assert [text for name, text in changed.rows("", "") if name == "doubtful"] == told
