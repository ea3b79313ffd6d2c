"""Every quantity of the scene changed in turn, and all at once: the engine follows as `reference` does, or refuses.

All at once, because quantities that are right one by one may be wrong in pairs.
"""

import contextlib
import functools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from quickreturn.cases.conformance.bench import DECISIVE, Bench, Motion, compared_columns, possible_results, solution, truth
from quickreturn.cases.conformance.checks import Array, Check, Fault, Unjudged, check_by, some
from quickreturn.cases.conformance.motion import MistakesInMildScene, falling, findings, mistakes_in_mild_scene
from quickreturn.cases.conformance.scenes import CHANGES, SPRING, Change
from quickreturn.cases.mistakes.diagnosis import Finding, share_of
from quickreturn.cases.mistakes.explanation import UNEXPLAINED, Hypothesis, explain
from quickreturn.cases.variation import Variation
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.relative import rms
from quickreturn.engines.scene import check_scene
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed, Scene
from quickreturn.reference_model.scene_values import OF_TORQUE, changed

#: Part of the effect below which a quantity counts as without effect.
_NONE: Final = 0.02
#: Accepted from an engine without an error estimate: the range of the ratio of a quantity's effect to the right one, and the largest
#: difference of the effects, relative to the right one.
_HALF_TO_DOUBLE: Final = (0.5, 2.0)
_APART: Final = 0.9
#: An effect with a larger relative error is examined further, even if the engine's claim allows it.
_SUSPICIOUS: Final = 0.3
#: Columns of the motion without the follower's bend: they show mistakes that a scene can only imitate as a whole.
_RIGID: Final = ("crank_angle", "crank_speed", "follower_angle", "slider_position")
#: Part of the quantities above which, if so many are ignored, the whole scene counts as ignored.
_MOST: Final = 0.6
_IGNORED: Final = "is ignored in silence: another value changes nothing"
#: Duration of the motion, s: three quarters of a turn.
_TOGETHER: Final = 0.4
#: Output step, s: an engine may integrate powers over its rows, and the pivot's damper slows the light base at a rate of 1 over 0.6 ms.
_FINE_ROWS: Final = 5e-4
#: Optional features of a scene: name -> values. Each is added if the engine accepts it.
PARTS: Final[Mapping[str, Mapping[str, Any]]] = {
    "crank.initial_angle": {"crank.initial_angle": 2.3},
    "mechanism.gravity": {"mechanism.gravity": (5.0, -7.0)},
    "base.damping": {"base.damping": 0.03},
    "follower.damping": {"follower.damping": 2.0},
    "tip.center_of_mass": {"tip.center_of_mass": 0.06, "tip.inertia": 4e-4},
    "tip.force": {"tip.force": (-1.0, 1.5), "tip.force_from": 3.3, "tip.force_to": 5.3},
    "tip.friction_force": {"tip.friction_force": 0.2, "tip.friction_speed": 0.3},
    "spring.stiffness": SPRING,
    "spring.damping": {"spring.damping": 0.5},
    "slider.mass": {"slider.mass": 0.3},
    "slider.inertia": {"slider.inertia": 1e-3},
    "slider.joint_stiffness": {"slider.joint_stiffness": 2e4},
    "slider.joint_damping": {"slider.joint_damping": 40.0},
    "slider.joint_stiffness_minus": {
        "slider.joint_stiffness": math.inf, "slider.joint_stiffness_plus": 2e4, "slider.joint_stiffness_minus": 8e3
    },
    "slider.preload": {"slider.preload": 1.0},
    "slider.contact_damping": {"slider.contact_damping": 2.0},
    "slider.friction": {"slider.friction": 0.2, "slider.friction_speed": 0.1},
    "slider.friction_force": {"slider.friction_force": 0.5, "slider.friction_speed": 0.1},
    "base.friction_torque": {"base.friction_torque": 0.03},
    "follower.material_damping": {"follower.material_damping": 1e-3},
}  # fmt: skip
#: Largest part of an error that remains if a quantity that causes it is left out of the scene.
_VANISHES: Final = 0.3
_NAME: Final = "quantities together"


def quantities(bench: Bench) -> Iterator[Check]:
    """A check for each of `CHANGES`, and one of all together, which comes first if there is no time for all."""
    try:
        wrong = mistakes_in_mild_scene(bench)
    except EngineFailure:
        yield Check("quantities", "not judged", "there is no trajectory in the mild scene", "mend that first")
        return
    if bench.seconds is not None:
        yield _together(bench, wrong)
    checks = list(_each(bench, wrong))
    yield from checks
    if bench.seconds is not None:
        return
    if any(check.status == "failed" for check in checks):
        yield Check(_NAME, "not judged", "one by one they are not followed", "mend those first")
    else:
        yield _together(bench, wrong)


def _each(bench: Bench, wrong: MistakesInMildScene) -> Iterator[Check]:
    """A check for each of `CHANGES`; a single check if most are ignored."""
    told = set(wrong.columns)
    acts_as = wrong.model and wrong.model.acts_as
    look = functools.partial(followed, wrong=wrong.motion, told=told, acts_as=acts_as)
    checks = [check_by(f"quantity {change.name}", look, bench, bench.scene, change) for change in CHANGES]
    ignored = [check for check in checks if check.cause.endswith(_IGNORED)]
    if len(ignored) > _MOST * len(checks):
        names = some([check.check.removeprefix("quantity ") for check in ignored])
        cause = f"most quantities are ignored, {len(ignored)} of {len(checks)} ({names}): the scene of an earlier run is simulated again"
        yield Check("quantities", "failed", cause, "keep nothing of a scene between runs: no class attribute, module variable or cache")
        checks = [check for check in checks if check not in ignored]
    yield from checks


def followed(bench: Bench, scene: Scene, change: Change, wrong: bool, told: set[str], acts_as: Variation | None = None) -> str:
    """Check that the engine follows a change of a scene; its motion without the change is right or `wrong`.

    A motion that is wrong may be that of another scene, which the engine `acts_as`: beside that mistake the change may be followed. Columns
    with wrong rows are reported once: those found here are added to `told`. Raises as a function for `check_by` may.
    """
    advice = f"model {change.name} or refuse it in `check`, with a sentence"
    of_drive = any(path in OF_TORQUE for path in change.given)
    if scene is bench.scene and isinstance(bench.scene.crank.drive, PrescribedSpeed) and of_drive:
        return "refused: a driven crank is not modelled"
    context = changed(scene, change.context)
    before, after = Motion(context, change.duration), Motion(change.of(context), change.duration)
    if after.scene == before.scene:
        return "the scene has it already"
    try:
        check_scene(bench.engine, after.scene)
        runs = [bench.run(motion) for motion in (before, after)]
    except EngineFailure as failure:
        kind = Fault if failure.cause.startswith("the engine r") else Unjudged  # "raised" or "returned": words for what no adapter reports
        raise kind(f"with another value the run breaks down: {failure.cause}", failure.advice) from failure
    given, right = (runs[0].columns, runs[1].columns), (solution(before), solution(after))
    names = list(compared_columns(runs[0], DECISIVE, right[1]))
    effect = _Effects(right, names)
    shown, due = effect.between(*given), effect.between(*right)
    if rms(shown) <= _NONE * rms(due):
        raise Fault(f"{change.name} {_IGNORED}", advice)
    if left_out := told & set(names):
        everything, effect = rms(due) * math.sqrt(len(names)), _Effects(right, [name for name in names if name not in left_out])
        if not effect.names or rms(due := effect.between(*right)) * math.sqrt(len(effect.names)) <= _NONE * everything:
            raise Unjudged(f"it shows in {', '.join(sorted(left_out))} alone, whose rows are wrong already", "mend those first")
        shown = effect.between(*given)
    worst = _worst(bench, (before, after), [name for name in compared_columns(runs[1], right=right[1]) if name not in told])
    share = float(shown @ due / (due @ due))
    left = rms(shown - due) / rms(due)
    if worst == "" and left <= _SUSPICIOUS:
        return ""
    if worst is None and left <= _APART and _HALF_TO_DOUBLE[0] <= share <= _HALF_TO_DOUBLE[1]:
        return f"coarse: its effect is {share:.2g} times that in reference" if left > 0.1 else ""
    if worst and not wrong:
        tell_of_rows(findings(bench, after, told), told)
    if acts_as is not None and effect.left(given, (before, after), acts_as) <= UNEXPLAINED:
        return f"it is followed beside the mistake in the mild scene, {acts_as.name}"
    if mistake := _mistake(change, context, given, right, effect, worst, None if worst is None or wrong else share):
        raise Fault(mistake, advice)
    off = f"the effect is off by {share_of(left)}"
    if worst == "":
        return f"coarse: {off}"
    if worst is None:
        raise Unjudged(f"coarse: {off}, and the engine does not say how much it may be")
    if wrong:
        raise Unjudged(f"{off}, and so is the motion in the mild scene", "mend that first")
    if worst in falling(bench, after, [worst]):
        return f"coarse: {off}, but it depends on the resolution"
    raise Fault(f"{change.name} is not followed as reference does: {off}, most in {worst}, beyond what it says of its own error", advice)


class _Effects:
    """The effect of a change on columns, each relative to the column's range in `reference`."""

    def __init__(self, right: Sequence[Mapping[str, Array]], names: Sequence[str]) -> None:
        self.names = list(names)
        self._sizes = {name: max(rms(run[name] - np.mean(run[name])) for run in right) + 1e-6 * rms(right[1][name]) for name in names}

    def between(self, first: Mapping[str, Array], second: Mapping[str, Array], among: Iterable[str] | None = None) -> Array:
        """The effect as one array, column after column; `among`: these columns, None: all."""
        names = self.names if among is None else [name for name in self.names if name in among]
        return np.concatenate([(second[name] - first[name]) / self._sizes[name] for name in names]) if names else np.zeros(0)

    def left(self, given: Sequence[Mapping[str, Array]], motions: Sequence[Motion], acts_as: Variation) -> float:
        """Part of the effect in the scene that an engine acts as which its own leaves; infinite if there is no such scene."""
        with contextlib.suppress(EngineFailure, ImpossibleMechanism):
            due = self.between(*(solution(replace(motion, scene=acts_as.of(motion.scene))) for motion in motions))
            return rms(self.between(*given) - due) / (rms(due) or math.inf)
        return math.inf


def tell_of_rows(wrong: Mapping[str, Finding], told: set[str], most: int = 2) -> None:
    """Fault if at most so many columns are wrong, each by a mistake of its own: their rows are wrong. Their names are added to `told`."""
    if 0 < len(wrong) <= most and all(finding.explained for finding in wrong.values()):
        told.update(wrong)
        raise Fault("; ".join(finding.cause for finding in list(wrong.values())[:3]), next(iter(wrong.values())).advice)


def _worst(bench: Bench, motions: Sequence[Motion], names: Sequence[str]) -> str | None:
    """The column that exceeds the engine's own error estimate most; "" if none does, None if there is no estimate."""
    first, second = (bench.tolerances(motion) for motion in motions)
    if first is None or second is None:
        return None
    off = {name: rms(_error(bench, motions, name)) / (first.get(name, 0.0) + second[name] or 1e-300) for name in names}
    worst = max(off, key=lambda name: off[name])
    return worst if off[worst] > 1.0 else ""


def _error(bench: Bench, motions: Sequence[Motion], name: str) -> Array:
    """Error of a quantity's effect on a column."""
    before, after = (bench.run(motion)[name] - truth(motion).columns[name] for motion in motions)
    return after - before


def _mistake(
    change: Change,
    context: Scene,
    given: tuple[Mapping[str, Array], Mapping[str, Array]],
    right: tuple[Mapping[str, Array], Mapping[str, Array]],
    effect: _Effects,
    worst: str | None,
    share: float | None,
) -> str:
    """The engine's mistake with the quantity, in words; "" if no simple mistake explains it."""
    scenes = list(possible_results(context, change.mistakes(), lambda scene: solution(Motion(scene, change.duration))))
    for among in (None, _RIGID) if worst else (None,):
        shown, due = (effect.between(first, second, among) for first, second in (given, right))
        tried = [Hypothesis(f"{change.name} acts with the wrong sign", "", -due)]
        tried += [Hypothesis(words, "", effect.between(right[0], columns, among)) for words, columns in scenes]
        if share is not None and among is None:
            words = f"{change.name} acts {share:.3g} times as strongly as it should"
            tried.append(Hypothesis(words, "", share * due, fitted=1))
        if explained := explain(shown, due, tried, coarse=among is None):
            return explained.words
    return ""


def _together(bench: Bench, wrong: MistakesInMildScene) -> Check:
    """A check of the scene with everything: its columns, and the quantities that are wrong together."""
    if wrong.motion:
        return Check(_NAME, "not judged", "the motion in the mild scene is wrong already", "mend that first")
    return check_by(_NAME, _look, bench, wrong)


def _look(bench: Bench, wrong: MistakesInMildScene) -> str:
    scene, parts = everything(bench)
    motion = Motion(scene, _TOGETHER, _FINE_ROWS)
    try:
        wrong_columns = findings(bench, motion, wrong.columns)
    except EngineFailure as failure:
        raise Fault(f"with {', '.join(parts)} at once the run breaks down: {failure.cause}", failure.advice) from failure
    if not wrong_columns:
        return f"{len(parts)} at once: {', '.join(parts)}"
    tell_of_rows(wrong_columns, set())
    off = bench.errors(motion)
    worst = max(wrong_columns, key=lambda name: off[name])
    told = f"with everything at once {worst} is off by {share_of(off[worst])}"
    if not (concerned := [name for name in parts if _vanishes_without(bench, name, parts, worst, off[worst])]):
        raise Fault(f"{told}; no single quantity is to blame ({', '.join(parts)})", "leave out one after the other")
    names = " and ".join(concerned) if len(concerned) <= 2 else some(concerned)
    raise Fault(f"{told}; it is not without {names.replace(' and ', ', nor without ')}", f"look where {names} act together")


def everything(bench: Bench) -> tuple[Mechanism, list[str]]:
    """The scene, and its optional features. Raises Unjudged if the engine accepts none."""
    scene, parts = bench.scene, list[str]()
    for name in PARTS:
        try:
            other = changed(scene, PARTS[name])
            bench.engine.check(other)
        except (Refusal, ImpossibleMechanism):  # or a part of a joint that the engine does not have
            continue
        scene, parts = other, [*parts, name]
    if len(parts) < 2:
        raise Unjudged("the engine accepts nothing beside what the mild scene has")
    return scene, parts


def _vanishes_without(bench: Bench, name: str, parts: list[str], column: str, off: float) -> bool:
    """Whether a column is right in the scene without one of its parts."""
    scene = bench.scene
    try:
        for other in parts:
            if other != name:
                scene = changed(scene, PARTS[other])
        bench.engine.check(scene)
        return bench.errors(Motion(scene, _TOGETHER, _FINE_ROWS)).get(column, 0.0) <= _VANISHES * off
    except (Refusal, EngineFailure, ImpossibleMechanism):  # a damper needs its spring
        return False
