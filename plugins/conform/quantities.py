"""Every quantity of the scene changed in turn, and all at once: the engine follows as `reference` does, or refuses.

One rule judges them all: the share of the right effect that a quantity has in the engine, and what is left of the effect beside that share.
"""

import contextlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.relative import rms
from quickreturn.engines.scene import check_scene
from quickreturn.plugins.conform.bench import (
    DECISIVE,
    MEND_FIRST,
    Array,
    Bench,
    Check,
    Fault,
    Motion,
    Unjudged,
    check_by,
    compared_columns,
    solution,
    some,
    truth,
)
from quickreturn.plugins.conform.columns import COARSELY, UNEXPLAINED, Examined, Model, examined, falling
from quickreturn.plugins.conform.motion import check_first_row, look_at
from quickreturn.plugins.conform.scenes import (
    ALONE,
    CHANGES,
    CHANGES_ALONE,
    FEATURES,
    FEATURES_ALONE,
    LONG_CRANK,
    SPUN_UP,
    TURNED,
    Change,
)  # fmt: skip
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import PrescribedSpeed, Scene
from quickreturn.reference_model.scene_values import OF_TORQUE, AnyScene, changed

#: Part of the effect below which a quantity counts as without effect.
_NONE: Final = 0.02
#: Accepted from an engine without an error estimate: the share of the right effect, and the largest difference relative to it.
_HALF_TO_DOUBLE: Final = (0.5, 2.0)
_APART: Final = 0.9
#: An effect that is off by more is examined further, even if the engine's claim allows it.
_SUSPICIOUS: Final = 0.3
#: Duration of the motion with all features, s: three quarters of a turn; and its output step, s: an engine may integrate powers over its
#: rows, and the pivot's damper slows the light base at a rate of 1 over 0.6 ms.
_TOGETHER: Final = 0.4
_FINE_ROWS: Final = 5e-4


def quantities(bench: Bench) -> Iterator[Check]:
    """A check of each of `CHANGES`, of all features at once, and of a crank with which the arm turns fully."""
    yield from _each("quantity ", bench, bench.mild, CHANGES, FEATURES)
    yield check_by("an arm that turns fully", turning, bench)


def alone(bench: Bench) -> Iterator[Check]:
    """The same for the follower alone, and its columns; a single check that says so if the engine does not model it."""
    try:
        scene = follower_alone(bench)
    except Refusal as refusal:
        yield Check("the follower alone", "passed", f"refused: {refusal}")
        return
    motion = Motion(scene, SPUN_UP)
    yield check_by("the follower alone", look_at, bench, motion, frozenset())
    changes = [change for change in CHANGES_ALONE if scene.tip or not change.name.startswith("tip.")]
    yield from _each("the follower alone: ", bench, motion, changes, FEATURES_ALONE)


def _each(kind: str, bench: Bench, motion: Motion, changes: Iterable[Change], features: Sequence[Mapping[str, Any]]) -> Iterator[Check]:
    """A check of each change of a scene, and of all features at once."""
    try:
        found = examined(bench, motion)
    except EngineFailure as failure:
        yield Check(f"{kind}by quantity", "not judged", f"there is no trajectory to compare with: {failure.cause}", failure.advice)
        return
    skipped = set(found.rows)
    for change in changes:
        yield check_by(f"{kind}{change.name}", followed, bench, motion.scene, change, skipped, found)
    yield check_by(f"{kind}with everything on", together, bench, motion.scene, features, found)


def follower_alone(bench: Bench) -> Scene:
    """The follower on a turning base, without the body at its end where the engine models none. Refusal: it models neither."""
    try:
        check_scene(bench.engine, ALONE)
    except Refusal:
        check_scene(bench.engine, replace(ALONE, tip=None))
        return replace(ALONE, tip=None)
    return ALONE


def followed(bench: Bench, scene: Scene, change: Change, skipped: set[str], found: Examined) -> str:
    """Check that the engine follows a change of a scene in which its motion has been `examined`.

    A motion that is wrong may be that of another scene: beside that mistake the change may be followed. Columns with wrong rows that are
    found here are added to `skipped`, so that they are reported once.
    """
    motions = _motions(bench, scene, change)
    given, right = [bench.run(motion).columns for motion in motions], [solution(motion) for motion in motions]
    decisive = compared_columns(bench.run(motions[1]), DECISIVE, right[1])
    names = [name for name in decisive if name not in skipped]
    (whole,), (due, shown) = _effects(decisive, right, right), _effects(names, right, right, given)
    if rms(due) * math.sqrt(len(names)) <= _NONE * rms(whole) * math.sqrt(len(decisive)):
        raise Unjudged(f"it shows in {some(sorted(skipped))} alone, whose rows are wrong already", MEND_FIRST)
    share = float(shown @ due / (due @ due))
    off, left, ignored = rms(shown - due) / rms(due), rms(shown - share * due) / rms(due), rms(shown) <= _NONE * rms(due)
    words = f"{share:.3g} times the right effect of {change.name}, and {100.0 * left:.3g} % of it beside"
    wrong = Fault(words, f"model {change.name} or refuse it in `check`, with a sentence")
    if found.motion:
        if found.model is not None and _left_by(found.model, names, right, given, motions) <= UNEXPLAINED:
            return f"it is followed beside the mistake in the mild scene: {found.model.words}"
        raise wrong if ignored else Unjudged(f"{words}, but the motion in the mild scene is wrong already", MEND_FIRST)
    worst = _worst(bench, motions, [name for name in compared_columns(bench.run(motions[1]), right=right[1]) if name not in skipped])
    if worst is None:
        # half of the right effect may be coarse; what is mostly a share of it, and far from one, is not
        if off <= _APART and _HALF_TO_DOUBLE[0] <= share <= _HALF_TO_DOUBLE[1]:
            return f"coarse: {words}" if off > UNEXPLAINED else ""
        raise wrong if ignored or left <= COARSELY * abs(share) else Unjudged(f"coarse, and no claim says how much: {words}")
    if not worst:
        if ignored or (off > _SUSPICIOUS and left <= UNEXPLAINED * off):
            raise wrong
        return f"coarse: {words}" if off > _SUSPICIOUS else ""
    if off <= UNEXPLAINED:  # rows of a column that is at rest in the mild scene may be wrong
        after = examined(bench, motions[1], frozenset(skipped))
        if not after.motion:
            skipped.update(after.wrong)
            after.raise_fault(bench.errors(motions[1]))
    if worst in falling(bench, motions[1], (worst,)):
        return f"coarse: {words}, but it depends on the resolution"
    raise Fault(f"{words}, most in {worst}, beyond what the engine says of its own error", wrong.advice)


def _motions(bench: Bench, scene: Scene, change: Change) -> tuple[Motion, Motion]:
    """The motions before and after a change. Refusal, Unjudged, Fault: the engine does not compute them."""
    if isinstance(bench.scene.crank.drive, PrescribedSpeed) and any(path in OF_TORQUE for path in change.given):
        raise Refusal("a driven crank is not modelled")
    context = changed(scene, change.context)
    before, after = Motion(context, change.duration), Motion(change.of(context), change.duration)
    if before == after:
        raise Refusal("the scene has it already")
    try:
        bench.run(after)
        bench.run(before)
    except EngineFailure as failure:
        kind = Fault if failure.cause.startswith("the engine r") else Unjudged  # "raised" or "returned": words for what no adapter reports
        raise kind(f"with another value the run breaks down: {failure.cause}", failure.advice) from failure
    return before, after


def _effects(names: Sequence[str], right: Sequence[Mapping[str, Array]], *of: Sequence[Mapping[str, Array]]) -> tuple[Array, ...]:
    """Effects of a change on columns, one after the other, each relative to the column's range in `reference`."""
    sizes = {name: max(rms(run[name] - np.mean(run[name])) for run in right) + 1e-6 * rms(right[1][name]) for name in names}
    return tuple(np.concatenate([(pair[1][name] - pair[0][name]) / sizes[name] for name in names] or [np.zeros(0)]) for pair in of)


def _left_by(
    model: Model,
    names: Sequence[str],
    right: Sequence[Mapping[str, Array]],
    given: Sequence[Mapping[str, Array]],
    motions: Sequence[Motion],
) -> float:
    """Part of the effect in the scene that an engine acts as which its own leaves; infinite if there is no such scene."""
    with contextlib.suppress(EngineFailure, ImpossibleMechanism):
        acting = [solution(replace(motion, scene=model.of(motion.scene))) for motion in motions]
        due, shown = _effects(names, right, acting, given)
        return rms(shown - due) / (rms(due) or math.inf)
    return math.inf


def _worst(bench: Bench, motions: Sequence[Motion], names: Sequence[str]) -> str | None:
    """The column whose effect exceeds the engine's own error estimates most; "" if none does, None if there is no estimate."""
    first, second = (bench.tolerances(motion) for motion in motions)
    if first is None or second is None:
        return None

    def error(name: str) -> Array:
        before, after = (bench.run(motion)[name] - truth(motion).columns[name] for motion in motions)
        return after - before

    off = {name: rms(error(name)) / (first.get(name, 0.0) + second[name] or 1e-300) for name in names}
    worst = max(off, key=lambda name: off[name])
    return worst if off[worst] > 1.0 else ""


def together(bench: Bench, scene: Scene, features: Sequence[Mapping[str, Any]], found: Examined) -> str:
    """Check the scene with all features that the engine accepts: quantities that are right one by one may be wrong in pairs."""
    if found.motion:
        raise Unjudged("its motion is wrong already", MEND_FIRST)
    everything, accepted = with_everything(bench, scene, features)
    if len(accepted) < 2:
        raise Unjudged("the engine accepts nothing beside what the scene has")
    motion = Motion(everything, *((_TOGETHER, _FINE_ROWS) if scene.crank is not None else (SPUN_UP,)))
    try:
        return f"{len(accepted)} features at once: {look_at(bench, motion, found.rows)}"
    except Fault as fault:
        raise type(fault)(f"{fault.cause}; with {', '.join(accepted)} at once", "leave out one after the other") from fault


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


def turning(bench: Bench) -> str:
    """Check an arm that turns fully."""
    mild = examined(bench, bench.mild)
    if mild.motion:
        raise Unjudged("the motion in the mild scene is wrong already", MEND_FIRST)
    motion = Motion(changed(bench.scene, LONG_CRANK), TURNED)
    remark = look_at(bench, motion, mild.rows)
    check_first_row(bench, motion, set(mild.rows))
    return remark
