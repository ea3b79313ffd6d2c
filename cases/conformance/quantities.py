"""Every quantity of the scene changed in turn: the engine follows as `reference` does, or refuses."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from cases.conformance.bench import Bench, Truth, truth
from cases.conformance.checks import Array, Check, Fault, Unjudged, looked_at, percent
from cases.conformance.motion import FALLS, Amiss, amiss
from cases.conformance.scenes import CHANGES, Change
from engines.base import EngineFailure, Refusal
from engines.relative import rms
from engines.trajectory import Trajectory
from reference_model.mechanism import Mechanism, PrescribedSpeed, changed

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
    before = changed(bench.scene, change.context)
    after = changed(before, change.values)
    try:
        bench.engine.check(after)
        found = [bench.run(scene, duration=_DURATION) for scene in (before, after)]
    except Refusal as refusal:
        return f"refused: {refusal}"
    except EngineFailure as failure:
        kind = Fault if failure.cause.startswith("the engine r") else Unjudged  # raised, returned: no adapter says so
        raise kind(f"with another value the run breaks down: {failure.cause}", failure.advice) from failure
    known = [truth(scene, _DURATION) for scene in (before, after)]
    names = [column for column in bench.columns(found[0].columns) if rms(known[1].columns[column]) > 0.0]
    scale = {column: 1.0 / _size(known, column) for column in names}

    def effect(first: Mapping[str, Array], second: Mapping[str, Array]) -> Array:
        return np.concatenate([scale[column] * (second[column] - first[column]) for column in names])

    shown, due = effect(found[0].columns, found[1].columns), effect(known[0].columns, known[1].columns)
    if rms(shown) <= _NONE * rms(due):
        raise Fault(f"{change.name} is ignored in silence: another value changes nothing", advice)
    if left_out := wrong.columns & set(names):
        everything, names = rms(due) * math.sqrt(len(names)), [name for name in names if name not in left_out]
        if not names or rms(due := effect(known[0].columns, known[1].columns)) * math.sqrt(len(names)) <= _NONE * everything:
            raise Unjudged(f"it shows in {', '.join(sorted(left_out))} alone, whose rows are wrong already", "mend those first")
        shown = effect(found[0].columns, found[1].columns)
    worst = _worst(bench, before, after, found, known, names)
    share = float(shown @ due / (due @ due))
    left = rms(shown - due) / rms(due)
    if worst == "" and left <= _SUSPICIOUS:
        return ""
    if worst is None and left <= _APART and _HALF_TO_DOUBLE[0] <= share <= _HALF_TO_DOUBLE[1]:
        return f"coarse: its effect is {share:.2g} times that in reference" if left > 0.1 else ""
    if cause := _mistake(change, before, shown, due, known[0], effect, None if worst is None or wrong.motion else share):
        raise Fault(cause, advice)
    off = f"the effect is {percent(left)} off"
    if worst == "":
        return f"coarse: {off}"
    if worst is None:
        raise Unjudged(f"coarse: {off}, and the engine does not say how much it may be")
    if wrong.motion:
        raise Unjudged(f"{off}, and so is the motion in the mild scene", "mend that first")
    if _falls(bench, (before, after), found, known, worst):
        return f"coarse: {off}, less on a finer rung"
    raise Fault(f"{change.name} is not followed as reference does: {off}, most in {worst}, beyond what it says of its own error", advice)


def _size(known: list[Truth], column: str) -> float:
    return max(rms(each.columns[column] - np.mean(each.columns[column])) for each in known) + 1e-6 * rms(known[1].columns[column])


def _worst(bench: Bench, before: Mechanism, after: Mechanism, found: list[Trajectory], known: list[Truth], names: list[str]) -> str | None:
    """The column that is farthest beyond what the engine says of its own error; "" if none is, None where it does not say."""
    over: dict[str, float] = dict.fromkeys(names, 0.0)
    for number, scene in enumerate((before, after)):
        tolerances = bench.tolerances(known[number], scene, duration=_DURATION)
        if tolerances is None:
            return None
        for name in names:
            over[name] += tolerances[name]
    off = {
        name: rms((found[1][name] - known[1].columns[name]) - (found[0][name] - known[0].columns[name])) / (over[name] or 1e-300)
        for name in names
    }
    worst = max(off, key=lambda name: off[name])
    return worst if off[worst] > 1.0 else ""


def _falls(bench: Bench, scenes: Sequence[Mechanism], found: list[Trajectory], known: list[Truth], column: str) -> bool:
    """Whether a finer rung is nearer in this column: then it is the estimate that is wrong, which is told there."""
    finer = [bench.sharpened(scene, duration=_DURATION) for scene in scenes]
    due = known[1].columns[column] - known[0].columns[column]
    if finer[0] is None or finer[1] is None:
        return False
    return rms(finer[1][column] - finer[0][column] - due) <= FALLS * rms(found[1][column] - found[0][column] - due)


def _mistake(change: Change, before: Mechanism, shown: Array, due: Array, known: Truth, effect: Any, share: float | None) -> str:
    """What the engine does with the quantity, in words; "" where no simple mistake makes it."""
    left = rms(shown - due)
    tried: list[tuple[float, str]] = [(rms(shown + due), f"{change.name} acts with the wrong sign")]
    for words, values in change.alike.items():
        scene = changed(before, values)
        tried.append((rms(shown - effect(known.columns, truth(scene, _DURATION).columns)), words))
    if share is not None:
        tried.append((rms(shown - share * due), f"{change.name} acts {share:.3g} times as strongly as it should"))
    best = min(tried, key=lambda each: each[0])
    return best[1] if best[0] <= _EXPLAINED * left else ""
