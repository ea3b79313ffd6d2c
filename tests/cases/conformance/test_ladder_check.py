"""The check that an engine's ladder gets finer: further rungs are run where neighbours are equally good by chance."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.conformance.bench import Truth
from quickreturn.cases.conformance.checks import Fault, Unjudged
from quickreturn.cases.conformance.motion import MistakesInMildScene
from quickreturn.cases.conformance.resolution import _climb, _gets_finer

RIGHT = Truth({"tip_deflection": np.ones(3)}, {})
NO_MISTAKES = MistakesInMildScene({}, {}, {}, None)


class Run(dict[str, Any]):
    def __init__(self, tip_deflection: np.ndarray, seconds: float) -> None:
        super().__init__(tip_deflection=tip_deflection)
        self.solve_seconds = seconds


def climbed(errors: list[float], seconds: float = 0.0) -> tuple[list[float], bool]:
    """Errors of the rungs that the check runs, and whether time ended it: rungs with these errors, the third one takes `seconds`."""
    bench: Any = SimpleNamespace(
        mild=None,
        scene=None,
        run=lambda _, rung: Run(np.full(3, 1.0 + errors[rung]), seconds if rung == 2 else 0.0),
        finer=lambda _, rung: rung + 1 if rung + 1 < len(errors) else None,
    )
    first: Any = 0
    return _climb(bench, RIGHT, first, 3, 2)


#: The rungs of `nodal-load`, whose errors change their sign.
CHANGING_SIGN = [0.05487, 0.0476, 0.04942, 0.016, 0.01]


@pytest.mark.parametrize(
    ("errors", "seconds", "rungs", "ended"),
    [
        ([0.05, 0.03, 0.02, 0.01], 0.0, 3, False),
        (CHANGING_SIGN, 0.0, 4, False),
        (CHANGING_SIGN, 7.0, 4, False),
        (CHANGING_SIGN, 100.0, 3, True),
        ([0.05, 0.05, 0.05], 100.0, 3, False),
        ([1e-6, 1e-6, 1e-6, 1e-6], 0.0, 3, False),
    ],
)
def test_further_rungs_are_run_until_one_is_better(errors: list[float], seconds: float, rungs: int, ended: bool) -> None:
    found, by_time = climbed(errors, seconds)
    np.testing.assert_allclose(found, errors[:rungs], rtol=1e-9)
    assert by_time is ended


def test_a_ladder_whose_rungs_are_all_equally_good_fails() -> None:
    found, ended = climbed([0.05] * 9)
    assert len(found) == 5
    with pytest.raises(Fault, match=r"finer rungs are no better: errors of the tip deflection are (0.05, ){4}0.05") as caught:
        _gets_finer(found, [0.05], NO_MISTAKES, ended)
    assert caught.value.status == "failed"
    found, ended = climbed(CHANGING_SIGN)
    assert _gets_finer(found, [0.016], NO_MISTAKES, ended) == "errors 0.055, 0.048, 0.049, 0.016"


def test_rungs_that_take_long_are_not_judged_by_chance() -> None:
    """On a slow machine the third rung of `nodal-load`, no better than the second, is the last that can be run."""
    found, ended = climbed(CHANGING_SIGN, 100.0)
    with pytest.raises(Unjudged, match=r"no better: .*, and the next one takes long"):
        _gets_finer(found, [0.016], NO_MISTAKES, ended)
