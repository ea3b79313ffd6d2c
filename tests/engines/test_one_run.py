"""A run that breaks down, or whose trajectory is wrong, on an engine that misbehaves as told."""

from typing import Any

import numpy as np
import pytest

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from tests.engines.fake_engine import FakeEngine, FakeSettings
from tests.engines.scenes import run_24
from tests.engines.test_accurate import DURATION, STEP, misbehaving, run, step_of


def test_an_engine_whose_library_gets_no_memory_is_not_accused() -> None:
    """The caller, who knows the limit, tells of the lack."""

    class Hungry(ReferenceEngine):
        def prepare(self, *_: Any) -> Any:
            raise ValueError("Error: engine error: Could not allocate memory")

    scene = run_24()
    with pytest.raises(MemoryError, match="Could not allocate memory"):
        run_once(Hungry(), scene, standard_start(scene), 0.01, 1e-3, ReferenceSettings())


def test_ladder_gets_past_an_unstable_step() -> None:
    result = run(engine=misbehaving("unstable"))
    # 0.1 turns to NaN; so does the coarser run of 0.05, whose estimate is therefore unknown; 0.025 has a good one.
    assert step_of(result) == pytest.approx(0.025)
    assert result.reached


@pytest.mark.parametrize(
    ("behaviour", "words"),
    [("nan", "strain_2 is no longer a finite number"), ("short", "500 rows"), ("raises", r"at fake_engine.py, line \d+: a bug")],
)
def test_wrong_trajectories_are_failures(behaviour: str, words: str) -> None:
    scene = run_24()
    with pytest.raises(EngineFailure, match=words):
        run_once(FakeEngine(), scene, standard_start(scene), DURATION, STEP, FakeSettings(behaviour=behaviour))


def test_values_that_are_no_numbers_end_the_kept_part() -> None:
    with pytest.raises(EngineFailure) as caught:
        run({"behaviour": "nan"})
    assert len(caught.value.partial) == 5
    assert caught.value.time == pytest.approx(4 * STEP)
    assert np.isfinite(caught.value.partial["strain_2"]).all()
