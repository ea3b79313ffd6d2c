"""The largest stress of a machine by an engine, with its claim; and machines whose ends are heavy or whose arm is soft."""

import itertools
import math
from typing import Final

from quickreturn.cases.loads import loads_of
from quickreturn.cases.motion.number import Number
from quickreturn.engines.accurate import simulate
from quickreturn.engines.registry import usable_engine
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.rigid import crank_pace
from tests.verification.random_machines import heavy_ends
from tests.verification.random_scenes import Scene

SEED: Final = 2027
#: Engines with equations of their own, and accuracies that they are asked for; None: their default.
ASKED: Final = (("reference", None), ("reference", 1e-2), ("mujoco", None), ("exudyn", None))
#: Accuracy of `reference` that confirms them.
CONFIRMING: Final = 1e-4
ROWS: Final = 500  # of a turn


def machines(count: int) -> list[Scene]:
    return list(itertools.islice(heavy_ends(SEED), count))


def largest_stress(scene: Scene, engine: str, accuracy: float | None) -> Number:
    """In the first turn from the standard start."""
    mechanism = scene.mechanism
    step = 2.0 * math.pi / crank_pace(mechanism) / ROWS
    result = simulate(usable_engine(engine), mechanism, standard_start(mechanism), ROWS * step, step, accuracy=accuracy)
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
