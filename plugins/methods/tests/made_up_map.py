"""A map of classes with known numbers: two scenes of the grid, and one without a solution."""

import math

from quickreturn.plugins.methods.groups import grid, name_of
from quickreturn.plugins.methods.map import LEVELS, ClassScene, Map
from quickreturn.plugins.methods.row import NOT_REACHED, REACHED, REFUSED, TOO_SLOW, Row

SCENES = tuple(groups for groups in grid() if groups.tip == 0.5 and groups.crank == 0.25 and math.isinf(groups.joint))
BY_SPEED = {groups.speed: groups for groups in SCENES if groups.damping == 0.003}


def made_up_map() -> Map:
    """At a speed of 0.05 `reference` solves first and `fixed-shapes` is done first, at 0.2 `mujoco` is the first in both; 0.5 is open.

    `thesis` is 60 % off everywhere, `multiplier` refuses, and `exudyn` at 0.2 gets there and does not know it.
    """
    scenes = tuple(
        ClassScene(name_of(BY_SPEED[speed]), BY_SPEED[speed], difference, failure)
        for speed, difference, failure in ((0.05, 1e-5, ""), (0.2, 3e-4, ""), (0.5, None, "the slider left the follower"))
    )
    slow, fast = (scene.name for scene in scenes[:2])
    trials = []
    for level, times in zip(LEVELS, (1.0, 10.0), strict=True):
        for scene in (slow, fast):
            trials.append(_trial(scene, "thesis", level, NOT_REACHED, error=0.6))
            trials.append(_trial(scene, "multiplier", level, REFUSED, remark="slider.joint_stiffness: not modelled"))
        trials.append(_trial(slow, "reference", level, REACHED, 2e-3 * times, 0.4 * times, 2e-4))
        trials.append(_trial(slow, "fixed-shapes", level, REACHED, 7e-3 * times, 0.1 * times, 2e-4))
        trials.append(_trial(fast, "mujoco", level, REACHED, 4e-2 * times, 0.2 * times, 2e-4))
        trials.append(_trial(fast, "reference", level, REACHED, 8e-2 * times, 0.3 * times, 2e-4))
        trials.append(_trial(fast, "exudyn", level, REACHED, 2.0 * times, None, 2e-4, TOO_SLOW))
    return Map(scenes, tuple(trials))


def _trial(
    scene: str,
    engine: str,
    level: float,
    status: str,
    solved: float | None = None,
    waited: float | None = None,
    error: float | None = None,
    remark: str = "",
) -> Row:
    known = {"scene": scene, "engine": engine, "level": level, "status": status, "remark": remark}
    errors = {} if error is None else {"tip_deflection": error}
    return Row(**known, solve_seconds=solved, answer_seconds=waited, errors=errors)  # type: ignore[arg-type]
