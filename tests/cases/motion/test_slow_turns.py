"""A crank that hardly turns: said before anything is computed."""

import pytest

from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.motion.slow_turns import warning


def test_a_turn_with_thousands_of_vibrations_is_told_with_its_time_and_what_to_do() -> None:
    told = warning(load_case("thesis-24", {"crank.prescribed_speed": "0.1 rpm"}))
    assert "600 s for a turn" in told
    assert "about 10,000 times" in told
    assert "about 12 min" in told
    assert "higher speed" in told


@pytest.mark.parametrize("name", ["thesis-24", "rigid", "spin-up"])
def test_usual_machines_are_not_spoken_of(name: str) -> None:
    assert warning(load_case(name)) == ""
