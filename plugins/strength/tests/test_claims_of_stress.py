"""The largest stress along the arm: alike by engines with files of their own, within their claims."""

import itertools
import math
from typing import Any, Final

import numpy as np
import pytest

from quickreturn.cases.motion.number import Number
from quickreturn.engines.accurate import simulate
from quickreturn.engines.registry import usable_engine
from quickreturn.engines.start import standard_start
from quickreturn.plugins.strength.loads import loads_of
from quickreturn.reference_model.rigid import crank_pace
from tests.slices import Portion
from tests.verification.random_machines import heavy_ends
from tests.verification.random_scenes import Scene

MACHINES = 200
#: Machines that a slice of the long tests computes.
DRAWN = 10
SEED: Final = 2027
#: Engines with equations of their own, and accuracies that they are asked for; None: their default.
ASKED: Final = (("reference", None), ("reference", 1e-2), ("mujoco", None), ("exudyn", None))
#: Accuracy of `reference` that confirms them.
CONFIRMING: Final = 1e-4
IN_A_TURN: Final = 500  # rows


def machines(count: int) -> list[Scene]:
    return list(itertools.islice(heavy_ends(SEED), count))


def largest_stress(scene: Scene, engine: str, accuracy: float | None) -> Number:
    """In the first turn from the standard start."""
    mechanism = scene.mechanism
    step = 2.0 * math.pi / crank_pace(mechanism) / IN_A_TURN
    result = simulate(usable_engine(engine), mechanism, standard_start(mechanism), IN_A_TURN * step, step, accuracy=accuracy)
    stress = loads_of(mechanism, result.trajectory.columns, lambda name, _: result.largest_errors.get(name)).stress
    assert stress is not None
    return stress.largest


def ratios(scene: Scene) -> dict[tuple[str, float | None], float]:
    """Difference of each engine's largest stress from the confirmed one over the sum of both claims."""
    right, found = largest_stress(scene, "reference", CONFIRMING), {}
    for engine, accuracy in ASKED:
        peak = largest_stress(scene, engine, accuracy)
        assert right.error is not None
        assert peak.error is not None
        found[engine, accuracy] = abs(peak.value - right.value) / (peak.error + right.error)
    return found


def check(found: dict[str, dict[tuple[str, float | None], float]], record_property: Any) -> None:
    """95 % of all claims hold, and none is too small by more than half."""
    every = np.array([ratio for of_machine in found.values() for ratio in of_machine.values()])
    record_property("claims", len(every))
    record_property("beyond", int((every > 1.0).sum()))
    record_property("worst", float(every.max()))
    worst = {name: {each: round(ratio, 2) for each, ratio in of_machine.items() if ratio > 1.0} for name, of_machine in found.items()}
    assert every.max() <= 1.5, {name: each for name, each in worst.items() if each}
    assert (every > 1.0).mean() <= 0.05, {name: each for name, each in worst.items() if each}


@pytest.mark.verify
def test_the_largest_stress_of_three_engines_is_within_their_claims(portion: Portion, record_property: Any) -> None:
    check({scene.name: ratios(scene) for scene in portion(machines(MACHINES), DRAWN)}, record_property)
