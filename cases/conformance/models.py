"""Finds the quantity of the scene that an engine has wrong, from the difference of its motion."""

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np

from quickreturn.cases.conformance.bench import Motion, possible_results, solution
from quickreturn.cases.conformance.checks import Array
from quickreturn.cases.mistakes.diagnosis import Finding
from quickreturn.cases.mistakes.explanation import Hypothesis, explain
from quickreturn.cases.variation import Variation
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.relative import rms
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Crank, Scene, TorqueDrive
from quickreturn.reference_model.scene_values import value_at

#: Factor by which a quantity is changed to see its effect, which is then proportional; and that of the inertias of base and tip, which are
#: small compared with the follower's.
_TRIED: Final = 1.02
_TRIED_OF_SMALL: Final = 2.0
#: Factors on a quantity from which the search begins. The others are tried if the first one leads to nothing and a column is off by more
#: than the part `_SMALL` of itself, because only small mistakes have a proportional effect.
_BEGIN: Final = (1.0, 1.3, 0.75)
_SMALL: Final = 0.1
#: Largest number of steps of the search for one quantity.
_ROUNDS: Final = 4
#: Largest part of the difference that a proportional effect may leave for the search to go on, and the part at which it ends.
_PROMISING: Final = 0.9
_EXPLAINED: Final = 0.02
#: Common mistakes by a factor.
_SIMPLE: Final = {0.5: "half", 2.0: "twice"}
_SCALED: Final = (
    "follower.bending_stiffness", "follower.mass_per_length", "follower.length", "mechanism.pivot_distance", "crank.length", "crank.mass",
    "crank.inertia", "crank.center_of_mass", "crank.torque", "crank.damping", "crank.initial_speed", "tip.mass", "tip.inertia",
    "base.inertia", "base.spin_up_speed", "base.spin_up_time",
)  # fmt: skip
#: Scene -> the weighted difference of its motion from that of the scene asked for, column after column.
Departure = Callable[[Scene], Array]


class WrongModel(NamedTuple):
    """A mistake of the model that explains a motion."""

    finding: Finding
    acts_as: Variation  # the scene that the engine computes, as a variation of the one asked for


def acts_as_if(motion: Motion, moves: Mapping[str, Array], tolerances: Mapping[str, float] | None) -> WrongModel | None:
    """The single wrong quantity that explains the motion from the standard start, if there is one.

    Args:
        motion: the motion asked for.
        moves: columns of the engine.
        tolerances: tolerances of the columns; None: the engine does not say.
    """
    right, scene = solution(motion), motion.scene
    part, allowed = (0.01, dict[str, float]()) if tolerances is None else (1e-4, tolerances)
    sizes = {name: rms(right[name]) for name in moves if rms(right[name]) > 0.0}

    def stacked(columns: Mapping[str, Array]) -> Array:
        weighted = [(columns[name] - right[name]) / (part * size + allowed.get(name, 0.0)) for name, size in sizes.items()]
        return np.concatenate(weighted)

    def effect(other: Scene) -> Array:
        return stacked(solution(replace(motion, scene=other)))

    shown = stacked(moves)
    if rms(shown) <= 1.0:  # these columns are as good as they may be
        return None
    small = all(rms(moves[name] - right[name]) <= _SMALL * size for name, size in sizes.items())
    tried = list(_others(scene, effect))
    for begin in _BEGIN[:1] if small else _BEGIN:
        tried += _factors(scene, shown, effect, begin)
        if explained := explain(shown, 0.0 * shown, [hypothesis for _, hypothesis in tried], noise=1.0):
            finding = Finding(f"the motion is that with {explained.words}", explained.advice, explained.remainder)
            return WrongModel(finding, next(of for of, hypothesis in tried if explained.words.startswith(hypothesis.words)))
    return None


def _others(scene: Scene, effect: Departure) -> Iterator[tuple[Variation, Hypothesis]]:
    """Scenes with a mistake that has no free number."""
    others: dict[str, dict[str, Any]] = {
        "no tip body": {"tip": None},
        "tip.mass ignored": {"tip.mass": 0.0},
        "tip.inertia ignored": {"tip.inertia": 0.0},
        "base.inertia ignored": {"base.inertia": 0.0},
        **({} if scene.crank is None else _of_crank(scene.crank)),
    }
    tried = [Variation(words, values) for words, values in others.items()]
    for path in _scaled(scene):
        tried += [Variation(f"{path} {words} as large", scaled={path: factor}) for factor, words in _SIMPLE.items()]
    of = {each.name: each for each in tried}
    for words, values in possible_results(scene, tried, effect):
        yield of[words], Hypothesis(words, _advice(words), values)


def _advice(words: str) -> str:
    return f"look where {words.split()[0]} enters"


def _of_crank(crank: Crank) -> dict[str, dict[str, Any]]:
    """Mistakes of the crank and its drive: words -> the scene with the mistake."""
    drive = crank.drive
    others: dict[str, dict[str, Any]] = {
        "crank.inertia taken about O: the crank's mass is not counted": {"crank.center_of_mass": 0.0},
        "crank.inertia shifted to O twice": {"crank.inertia": crank.inertia + crank.mass * crank.center_of_mass**2},
        "crank.inertia ignored": {"crank.inertia": 0.0},
        "the crank's centre of mass at the slider": {"crank.center_of_mass": crank.length},
        "the crank's centre of mass in the middle": {"crank.center_of_mass": 0.5 * crank.length},
    }
    if isinstance(drive, TorqueDrive):
        turned = drive.torque + 2.0 * drive.damping * drive.initial_speed
        others |= {
            "crank.damping ignored": {"crank.damping": 0.0},
            "crank.torque ignored": {"crank.torque": 0.0},
            "crank.torque of the wrong sign": {"crank.torque": -drive.torque},
            "crank.damping of the wrong sign, as a drive": {"crank.torque": turned},
            "the crank's speed prescribed": {"crank.prescribed_speed": drive.initial_speed},
        }
    return others


def _scaled(scene: Scene) -> list[str]:
    """The quantities of `_SCALED` that may be off by a factor in a scene: finite and not zero."""
    values = {path: value_at(scene, path) for path in _SCALED}
    return [path for path, value in values.items() if isinstance(value, float) and math.isfinite(value) and value != 0.0]


def _factors(scene: Scene, shown: Array, effect: Departure, begin: float) -> Iterator[tuple[Variation, Hypothesis]]:
    """For each quantity the factor that explains most, found by secants from `begin`."""
    for path in _scaled(scene):

        def times(factor: float, path: str = path) -> Array:
            return effect(Variation(path, scaled={path: factor}).of(scene))

        tried = begin * (_TRIED_OF_SMALL if path in ("base.inertia", "tip.inertia") else _TRIED)
        with contextlib.suppress(EngineFailure, ImpossibleMechanism):
            factor, there = begin, times(begin)
            slope, left = (times(tried) - there) / (tried - begin), shown - there
            for _ in range(_ROUNDS):
                step = float(left @ slope / (slope @ slope or math.inf))
                if rms(left - step * slope) > _PROMISING * rms(left):
                    break
                before, factor = there, factor + step
                there = times(factor)
                left = shown - there
                if rms(left) <= _EXPLAINED * rms(shown):
                    break
                slope = (there - before) / step
            words = f"{path} {factor:.4g} times as large"
            yield Variation(words, scaled={path: factor}), Hypothesis(words, _advice(words), there, fitted=1)
