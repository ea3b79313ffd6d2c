"""A check with a crank that is longer than the distance of the pivots: the arm turns fully, as Whitworth's.

Where the arm only swings, its angle stays within a quarter turn of the line of the pivots, so that a wrapped angle, an inverse tangent of
one argument or a slider on the wrong side of P do not show.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Final

from quickreturn.cases.conformance.bench import Bench, Motion, truth
from quickreturn.cases.conformance.checks import Check, Fault, Unjudged, check_by, some
from quickreturn.cases.conformance.motion import check_first_row, findings, mistakes_in_mild_scene
from quickreturn.cases.mistakes.diagnosis import Finding, share_of
from quickreturn.engines.base import EngineFailure
from quickreturn.reference_model.scene_values import changed

NAME: Final = "an arm that turns fully"
#: Changes of the mild scene: half a radian before the slider is farthest from P, and 220 deg of the crank, so that the arm passes half a
#: turn and a whole one. The slider comes as near to P as a quarter of the follower's length.
_LONG_CRANK: Final = {"mechanism.pivot_distance": 0.1, "crank.length": 0.25, "crank.initial_angle": math.pi - 0.5}
_DURATION: Final = 0.32  # s
#: Largest part by which the angle may miss half a turn, where the slider is on the wrong side of the pivot.
_NEAR: Final = 0.1


def turning(bench: Bench) -> Iterator[Check]:
    """The check, unless the engine refuses the scene."""
    yield check_by(NAME, _look, bench)


def _look(bench: Bench) -> str:
    motion = Motion(changed(bench.scene, _LONG_CRANK), _DURATION)
    try:
        known = mistakes_in_mild_scene(bench)
    except EngineFailure:
        raise Unjudged("there is no trajectory in the mild scene", "mend that first") from None
    if known.motion:
        raise Unjudged("the motion in the mild scene is wrong already", "mend that first")
    wrong, off = findings(bench, motion, known.columns), bench.errors(motion)
    if not wrong:
        check_first_row(bench, motion, set(known.columns))
        return f"{len(off)} columns, the worst off by {share_of(max(off.values()))}"
    if _on_the_wrong_side(bench, motion, wrong):
        cause = "the slider is taken on the wrong side of the pivot: slider_position is negative, follower_angle off by half a turn"
        raise Fault(cause, "the arm's angle is atan2 of the slider's place seen from P, which runs on from turn to turn")
    explained = [finding for finding in wrong.values() if finding.explained]
    if explained:
        raise Fault("; ".join(finding.cause for finding in explained[:3]), explained[0].advice)
    worst = sorted(wrong, key=lambda name: -off[name])
    raise Fault(
        some([f"{name} is off by {share_of(off[name])}" for name in worst]), "a crank as short as the distance of the pivots is right"
    )


def _on_the_wrong_side(bench: Bench, motion: Motion, wrong: Mapping[str, Finding]) -> bool:
    if not {"slider_position", "follower_angle"} <= wrong.keys():
        return False
    run, right = bench.run(motion), truth(motion).columns
    turned = abs((run["follower_angle"] - right["follower_angle"]).mean()) / math.pi
    return bool(run["slider_position"].max() < 0.0 and abs(turned - round(turned)) < _NEAR and round(turned) % 2 == 1)
