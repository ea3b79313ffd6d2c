"""Every quantity of the scene changed in turn: the engine follows as `reference` does, or refuses."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from cases.conformance.bench import Bench, Motion, columns_of, truth
from cases.conformance.checks import Array, Check, Fault, Unjudged, looked_at, percent
from cases.conformance.motion import FALLS, Amiss, amiss
from cases.conformance.scenes import CHANGES, Change
from engines.base import EngineFailure
from engines.relative import rms
from reference_model.mechanism import PrescribedSpeed, changed

_DURATION: Final = 0.4  # s: three quarters of a turn
#: Of the effect a quantity must have: less is none.
_NONE: Final = 0.02
#: A mistake explains what an engine does with a quantity if it leaves no more than this part of the difference.
_EXPLAINED: Final = 0.45
#: What a coarse model may make of a quantity's effect, and how far its own may be from it.
_HALF_TO_DOUBLE: Final = (0.5, 2.0)
_APART: Final = 0.9

#: An effect that is as far off is looked at more closely, even if the engine says that it may be.
_SUSPICIOUS: Final = 0.3


def quantities(bench: Bench) -> Iterator[Check]:
    """A check for each of `CHANGES`."""
    try:
        wrong = amiss(bench)
    except EngineFailure:
        yield Check("quantities", "not judged", "there is no trajectory in the mild scene", "mend that first")
        return
    for change in CHANGES:
        yield looked_at(f"quantity {change.name}", _followed, bench, change, wrong)


def _followed(bench: Bench, change: Change, wrong: Amiss) -> str:
    advice = f"model {change.name} or refuse it in `check`, with a sentence"
    if isinstance(bench.scene.crank.drive, PrescribedSpeed) and any(path.startswith("crank.drive.") for path in change.values):
        return "refused: a driven crank is not modelled"
    context = changed(bench.scene, change.context)
    before, after = Motion(context, _DURATION), Motion(changed(context, change.values), _DURATION)
    try:
        bench.engine.check(after.scene)
        found = [bench.run(motion).columns for motion in (before, after)]
    except EngineFailure as failure:
        kind = Fault if failure.cause.startswith("the engine r") else Unjudged  # raised, returned: no adapter says so
        raise kind(f"with another value the run breaks down: {failure.cause}", failure.advice) from failure
    known = [truth(motion).columns for motion in (before, after)]
    names = [column for column in columns_of(bench.run(before)) if rms(known[1][column]) > 0.0]
    sizes = {name: max(rms(each[name] - np.mean(each[name])) for each in known) + 1e-6 * rms(known[1][name]) for name in names}

    def effect(first: Mapping[str, Array], second: Mapping[str, Array]) -> Array:
        return np.concatenate([(second[column] - first[column]) / sizes[column] for column in names])

    shown, due = effect(*found), effect(*known)
    if rms(shown) <= _NONE * rms(due):
        raise Fault(f"{change.name} is ignored in silence: another value changes nothing", advice)
    if left_out := wrong.columns & set(names):
        everything, names = rms(due) * math.sqrt(len(names)), [name for name in names if name not in left_out]
        if not names or rms(due := effect(*known)) * math.sqrt(len(names)) <= _NONE * everything:
            raise Unjudged(f"it shows in {', '.join(sorted(left_out))} alone, whose rows are wrong already", "mend those first")
        shown = effect(*found)
    worst = _worst(bench, (before, after), names)
    share = float(shown @ due / (due @ due))
    left = rms(shown - due) / rms(due)
    if worst == "" and left <= _SUSPICIOUS:
        return ""
    if worst is None and left <= _APART and _HALF_TO_DOUBLE[0] <= share <= _HALF_TO_DOUBLE[1]:
        return f"coarse: its effect is {share:.2g} times that in reference" if left > 0.1 else ""

    def of(values: Mapping[str, object]) -> Array:
        return effect(known[0], truth(Motion(changed(context, values), _DURATION)).columns)

    if cause := _mistake(change, shown, due, of, None if worst is None or wrong.motion else share):
        raise Fault(cause, advice)
    off = f"the effect is {percent(left)} off"
    if worst == "":
        return f"coarse: {off}"
    if worst is None:
        raise Unjudged(f"coarse: {off}, and the engine does not say how much it may be")
    if wrong.motion:
        raise Unjudged(f"{off}, and so is the motion in the mild scene", "mend that first")
    if _falls(bench, (before, after), worst):
        return f"coarse: {off}, less on a finer rung"
    raise Fault(f"{change.name} is not followed as reference does: {off}, most in {worst}, beyond what it says of its own error", advice)


def _worst(bench: Bench, motions: Sequence[Motion], names: Sequence[str]) -> str | None:
    """The column that is farthest beyond what the engine says of its own error; "" if none is, None where it does not say."""
    first, second = (bench.tolerances(motion) for motion in motions)
    if first is None or second is None:
        return None
    off = {name: rms(_error(bench, motions, name)) / (first[name] + second[name] or 1e-300) for name in names}
    worst = max(off, key=lambda name: off[name])
    return worst if off[worst] > 1.0 else ""


def _error(bench: Bench, motions: Sequence[Motion], name: str) -> Array:
    """Of a quantity's effect on a column."""
    before, after = (bench.run(motion)[name] - truth(motion).columns[name] for motion in motions)
    return after - before


def _falls(bench: Bench, motions: Sequence[Motion], column: str) -> bool:
    """Whether a finer rung is nearer in this column: then it is the estimate that is wrong, which is told there."""
    before, after = (bench.sharpened(motion) for motion in motions)
    if before is None or after is None:
        return False
    due = truth(motions[1]).columns[column] - truth(motions[0]).columns[column]
    return rms(after[column] - before[column] - due) <= FALLS * rms(_error(bench, motions, column))


def _mistake(change: Change, shown: Array, due: Array, effect: Callable[[Mapping[str, object]], Array], share: float | None) -> str:
    """What the engine does with the quantity, in words; "" where no simple mistake makes it."""
    tried = {f"{change.name} acts with the wrong sign": -due}
    tried |= {words: effect(values) for words, values in change.alike.items()}
    if share is not None:
        tried[f"{change.name} acts {share:.3g} times as strongly as it should"] = share * due
    left = {words: rms(shown - values) for words, values in tried.items()}
    best = min(left, key=lambda words: left[words])
    return best if left[best] <= _EXPLAINED * rms(shown - due) else ""
