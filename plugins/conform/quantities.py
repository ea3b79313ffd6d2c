"""Every quantity of the scene changed in turn, and all at once: the engine follows as `reference` does, or refuses.

One rule judges them all: the share of the right effect that a quantity has in the engine, and what is left of the effect beside that share.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from quickreturn.engines.accurate import check_scene
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.trajectory import rms
from quickreturn.plugins.conform.bench import (
    DECISIVE,
    FOLLOWERS,
    Bench,
    Check,
    Fault,
    Motion,
    Unjudged,
    check_by,
    compared_columns,
    first_modelled,
    solution,
)
from quickreturn.plugins.conform.columns import UNEXPLAINED, beyond_claims, examined, look_at
from quickreturn.plugins.conform.scenes import CHANGES, CHANGES_ALONE, FEATURES, FEATURES_ALONE, LONG_CRANK, SPUN_UP, TURNED, Change
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.scene_values import OF_TORQUE, AnyScene, changed

#: Part of the effect below which a quantity counts as without effect.
_NONE: Final = 0.02
#: Part by which an effect may be off that is mostly a share of the right one: with a claim, which allows more to coarse models, or
#: without; and without a claim what it leaves then, over that share.
_OFF: Final = 0.3
_OFF_UNCLAIMED: Final = 0.6
_LEFT: Final = 0.4
#: Duration of the motion with all features, s: three quarters of a turn; and its output step, s: an engine may integrate powers over its
#: rows, and the pivot's damper slows the light base at a rate of 1 over 0.6 ms.
_TOGETHER: Final = (0.4, 5e-4)


def quantities(bench: Bench) -> Iterator[Check]:
    """A check of each of `CHANGES`, of all features at once, and of a crank with which the arm turns fully."""
    yield from _each("quantity ", bench, bench.mild, CHANGES, FEATURES)
    yield check_by("an arm that turns fully", turning, bench)


def alone(bench: Bench) -> Iterator[Check]:
    """The same for the follower alone, and its columns; a single check that says so if the engine does not model it."""
    try:
        motion = first_modelled(bench.engine, FOLLOWERS[:2])
    except Refusal as refusal:
        yield Check("the follower alone", "passed", f"refused: {refusal}")
        return
    yield check_by("the follower alone", look_at, bench, motion)
    changes = [change for change in CHANGES_ALONE if motion.scene.tip or not change.name.startswith("tip.")]
    yield from _each("the follower alone: ", bench, motion, changes, FEATURES_ALONE)


def _each(kind: str, bench: Bench, motion: Motion, changes: Iterable[Change], features: Sequence[Mapping[str, Any]]) -> Iterator[Check]:
    """A check of each change of a scene, and of all features at once; one that says so if the motion is wrong before any change."""
    found = examined(bench, motion)
    if found.motion:
        yield Check(f"{kind}by quantity", "not judged", "the motion is wrong already")
        return
    for change in changes:
        yield check_by(f"{kind}{change.name}", followed, bench, motion.scene, change, frozenset(found.wrong))
    yield check_by(f"{kind}with everything on", together, bench, motion.scene, features, frozenset(found.wrong))


def followed(bench: Bench, scene: Scene, change: Change, skipped: frozenset[str]) -> None:
    """Check that the engine follows a change of a scene, in the columns that are not `skipped`."""
    if not bench.scene.crank_is_free and any(path in OF_TORQUE for path in change.given):
        raise Refusal("a driven crank is not modelled")
    context = changed(scene, change.context)
    motions = Motion(context, change.duration), Motion(changed(context, change.given), change.duration)
    if motions[0] == motions[1]:
        raise Refusal("the scene has it already")
    try:
        given = [bench.run(motion).columns for motion in reversed(motions)][::-1]
    except EngineFailure as failure:
        kind = Fault if failure.cause.startswith("the engine r") else Unjudged  # "raised" or "returned": words for what no adapter reports
        raise kind(f"with another value the run breaks down: {failure.cause}") from failure
    right = [solution(motion) for motion in motions]
    names = [name for name in compared_columns(bench.run(motions[1]), right=right[1]) if name not in skipped]
    due, shown = (_effect([name for name in DECISIVE if name in names], right, of) for of in (right, given))
    if not due.any():
        raise Unjudged("it shows in columns alone that are wrong already")
    share = float(shown @ due / (due @ due))
    off, left, beyond = rms(shown - due) / rms(due), rms(shown - share * due) / rms(due), beyond_claims(bench, motions, names)
    limit, rest = (_OFF, UNEXPLAINED * off) if bench.claims else (_OFF_UNCLAIMED, _LEFT * abs(share))
    words = f"{round(share, 3) or 0.0:.3g} times the right effect of {change.name}, and {100.0 * left:.3g} % of it beside"
    if beyond or rms(shown) <= _NONE * rms(due) or (off > limit and left <= rest):
        raise Fault(words)
    if beyond is None and off > limit:
        raise Unjudged(f"coarse, and no claim says how much: {words}")


def _effect(names: Sequence[str], right: Sequence[Mapping[str, Array]], of: Sequence[Mapping[str, Array]]) -> Array:
    """Effect of a change on columns, one after the other, each relative to the column's range in `reference`."""
    sizes = {name: max(rms(run[name] - np.mean(run[name])) for run in right) + 1e-6 * rms(right[1][name]) for name in names}
    return np.concatenate([(of[1][name] - of[0][name]) / sizes[name] for name in names] or [np.zeros(0)])


def together(bench: Bench, scene: Scene, features: Sequence[Mapping[str, Any]], skipped: frozenset[str]) -> None:
    """Check the scene with all features that the engine accepts: quantities that are right one by one may be wrong in pairs."""
    everything, accepted = with_everything(bench, scene, features)
    if len(accepted) < 2:
        raise Unjudged("the engine accepts nothing beside what the scene has")
    look_at(bench, Motion(everything, *(_TOGETHER if scene.crank is not None else (SPUN_UP,))), skipped)


def with_everything(bench: Bench, scene: AnyScene, features: Sequence[Mapping[str, Any]]) -> tuple[AnyScene, list[str]]:
    """The scene with all features that the engine accepts, and their keys."""
    accepted = list[str]()
    for values in features:
        try:
            other = changed(scene, values)
            check_scene(bench.engine, other)
        except (Refusal, ImpossibleMechanism):  # or a part of a joint that the engine does not have
            continue
        scene, accepted = other, [*accepted, next(iter(values))]
    return scene, accepted


def turning(bench: Bench) -> None:
    """Check an arm that turns fully."""
    if (mild := examined(bench, bench.mild)).motion:
        raise Unjudged("the motion in the mild scene is wrong already")
    look_at(bench, Motion(changed(bench.scene, LONG_CRANK), TURNED), frozenset(mild.wrong))
