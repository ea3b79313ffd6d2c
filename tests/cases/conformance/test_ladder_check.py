"""The check that an engine's ladder gets finer: further rungs are run where neighbours are equally good by chance."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.conformance.bench import Truth
from quickreturn.cases.conformance.checks import Fault
from quickreturn.cases.conformance.motion import MistakesInMildScene
from quickreturn.cases.conformance.resolution import _climb, _gets_finer

RIGHT = Truth({"tip_deflection": np.ones(3)}, {})
NO_MISTAKES = MistakesInMildScene({}, {}, {}, None)


class Run(dict[str, Any]):
    solve_seconds = 0.0


def climbed(errors: list[float]) -> list[float]:
    """Errors of the rungs that the check runs, of an engine whose rungs have these errors."""
    bench: Any = SimpleNamespace(
        mild=None,
        scene=None,
        run=lambda _, rung: Run(tip_deflection=np.full(3, 1.0 + errors[rung])),
        finer=lambda _, rung: rung + 1 if rung + 1 < len(errors) else None,
    )
    first: Any = 0
    return _climb(bench, RIGHT, first, 3, 2)


@pytest.mark.parametrize(
    ("errors", "rungs"),
    [
        ([0.05, 0.03, 0.02, 0.01], 3),
        ([0.05487, 0.0476, 0.04942, 0.016, 0.01], 4),  # the rungs of `nodal-load`, whose errors change their sign
        ([0.05, 0.05, 0.05], 3),
        ([1e-6, 1e-6, 1e-6, 1e-6], 3),
    ],
)
def test_further_rungs_are_run_until_one_is_better(errors: list[float], rungs: int) -> None:
    np.testing.assert_allclose(climbed(errors), errors[:rungs], rtol=1e-9)


def test_a_ladder_whose_rungs_are_all_equally_good_fails() -> None:
    found = climbed([0.05] * 9)
    assert len(found) == 5
    with pytest.raises(Fault, match=r"finer rungs are no better: errors of the tip deflection are (0.05, ){4}0.05"):
        _gets_finer(found, [0.05], NO_MISTAKES)
    assert _gets_finer(climbed([0.05487, 0.0476, 0.04942, 0.016]), [0.016], NO_MISTAKES) == "errors 0.055, 0.048, 0.049, 0.016"
