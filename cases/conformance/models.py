"""Which quantity of the scene an engine has wrong, from how its motion differs."""

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, Final

import numpy as np

from cases.conformance.bench import Truth, truth
from cases.conformance.checks import Array
from cases.conformance.suspects import Finding
from engines.base import EngineFailure
from engines.relative import rms
from reference_model.mechanism import ImpossibleMechanism, Mechanism, PrescribedSpeed, TorqueDrive, changed

#: By how much a quantity is changed to see what it does; small enough for the effect to be in proportion. The inertias of base and tip
#: are small beside the follower's.
_TRIED: Final = 1.02
_TRIED_OF_SMALL: Final = 2.0
#: Factors to begin with: the others where the first finds nothing and a column is farther off than this part of itself, for the motion is
#: in proportion to small mistakes alone.
_BEGIN: Final = (1.0, 1.3, 0.75)
_SMALL: Final = 0.1
#: Scenes that are tried for one quantity; those of which the first, in proportion, would leave more than this part are not; and what is
#: found leaves no more than this.
_ROUNDS: Final = 4
_PROMISING: Final = 0.9
_FOUND: Final = 0.02
#: A quantity explains a difference if it leaves no more than this part of it.
_EXPLAINED: Final = 0.25
_SCALED: Final = (
    "follower.bending_stiffness", "follower.mass_per_length", "follower.length", "pivot_distance", "crank.length", "crank.mass",
    "crank.inertia", "crank.center_of_mass", "crank.drive.torque", "crank.drive.damping", "crank.drive.initial_speed", "tip.mass",
    "tip.inertia", "base.inertia",
)  # fmt: skip


def acts_as_if(scene: Mechanism, moves: Mapping[str, Array], known: Truth, tolerances: Mapping[str, float] | None) -> Finding | None:
    """The one quantity that makes the motion from the standard start what it is, if there is one.

    Args:
        scene: what was asked for.
        moves: columns of the engine.
        known: the right motion.
        tolerances: by how much columns may be off; None: the engine does not say.
    """
    names = [name for name in moves if rms(known.columns[name]) > 0.0]
    weights = {name: 1.0 / _noise(name, known, tolerances) for name in names}

    def stacked(columns: Mapping[str, Array]) -> Array:
        return np.concatenate([weights[name] * (columns[name] - known.columns[name]) for name in names])

    shown = stacked(moves)
    if rms(shown) <= 1.0:  # these columns are as good as they may be
        return None
    small = all(rms(moves[name] - known.columns[name]) <= _SMALL * rms(known.columns[name]) for name in names)
    least, best = _EXPLAINED, None

    def effect(other: Mechanism) -> Array:
        return stacked(truth(other, float(known.columns["time"][-1])).columns)

    def looks() -> Iterator[tuple[str, Callable[[], tuple[float, str]]]]:
        for words, other in _models(scene):
            yield words, partial(_left, shown, effect, other)
        for begin in _BEGIN[:1] if small else _BEGIN:
            if best is None or begin == 1.0:
                for words, model, tried in _scaled(scene):
                    yield words, partial(_left_scaled, shown, effect, model, tried, begin)

    for words, look in looks():
        with contextlib.suppress(EngineFailure, ImpossibleMechanism):
            left, scaled = look()
            if left < least:
                least = 0.7 * left  # another must explain clearly more
                best = Finding(f"the motion is that with {words}{scaled}", f"look where {words.split()[0]} enters", True)
    return best


def _left(shown: Array, effect: Callable[[Mechanism], Array], other: Mechanism) -> tuple[float, str]:
    """What part of the difference another scene leaves."""
    return rms(shown - effect(other)) / rms(shown), ""


def _left_scaled(
    shown: Array, effect: Callable[[Mechanism], Array], model: Callable[[float], Mechanism], tried: float, begin: float
) -> tuple[float, str]:
    """The same for the quantity as many times as large as explains most, from `begin` on by secants, and that factor in words."""
    factor, there = begin, effect(model(begin))
    slope, left = (effect(model(begin * tried)) - there) / (begin * tried - begin), shown - there
    for _ in range(_ROUNDS):
        step = float(left @ slope / (slope @ slope or math.inf))
        if rms(left - step * slope) > _PROMISING * rms(left):
            break
        before, factor = there, factor + step
        there = effect(model(factor))
        left = shown - there
        if rms(left) <= _FOUND * rms(shown):
            break
        slope = (there - before) / step
    return rms(left) / rms(shown), f" {factor:.4g} times as large"


def _noise(name: str, known: Truth, tolerances: Mapping[str, float] | None) -> float:
    return (0.01 if tolerances is None else 1e-4) * rms(known.columns[name]) + (0.0 if tolerances is None else tolerances[name])


def _models(scene: Mechanism) -> Iterator[tuple[str, Mechanism]]:
    """What it may be, and the scene."""
    crank, drive = scene.crank, scene.crank.drive
    own_words: list[tuple[str, dict[str, Any]]] = [
        ("no tip body", {"tip": None}),
        ("tip.mass ignored", {"tip.mass": 0.0}),
        ("tip.inertia ignored", {"tip.inertia": 0.0}),
        ("base.inertia ignored", {"base.inertia": 0.0}),
        ("crank.inertia taken about O: the crank's mass is not counted", {"crank.center_of_mass": 0.0}),
        ("crank.inertia ignored", {"crank.inertia": 0.0}),
        ("the crank's centre of mass at the slider", {"crank.center_of_mass": crank.length}),
        ("the crank's centre of mass in the middle", {"crank.center_of_mass": 0.5 * crank.length}),
    ]
    if isinstance(drive, TorqueDrive):
        own_words += [
            ("crank.damping ignored", {"crank.drive.damping": 0.0}),
            ("crank.torque ignored", {"crank.drive.torque": 0.0}),
            ("crank.torque of the wrong sign", {"crank.drive.torque": -drive.torque}),
            (
                "crank.damping of the wrong sign, as a drive",
                {"crank.drive.torque": drive.torque + 2.0 * drive.damping * drive.initial_speed},
            ),
            ("the crank's speed prescribed", {"crank.drive": PrescribedSpeed(speed=drive.initial_speed)}),
        ]
    for words, values in own_words:
        yield words, changed(scene, values)


def _scaled(scene: Mechanism) -> Iterator[tuple[str, Callable[[float], Mechanism], float]]:
    """Quantities, the scene by the factor on each, and a factor to begin with."""
    for path in _SCALED:
        owner: object = scene
        for part in path.split("."):
            owner = getattr(owner, part, None)
        if isinstance(owner, float) and math.isfinite(owner) and owner != 0.0:
            tried = _TRIED_OF_SMALL if path in ("base.inertia", "tip.inertia") else _TRIED
            yield path.replace("drive.", ""), partial(_changed_by, scene, path, owner), tried


def _changed_by(scene: Mechanism, path: str, value: float, factor: float) -> Mechanism:
    return changed(scene, {path: factor * value})
