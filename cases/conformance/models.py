"""Which quantity of the scene an engine has wrong, from how its motion differs."""

import contextlib
import math
from collections.abc import Iterator, Mapping
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
    least, best = _EXPLAINED, None
    for words, other, tried in _models(scene):
        try:
            effect = stacked(truth(other, float(known.columns["time"][-1])).columns)
        except EngineFailure:
            continue
        if rms(effect) == 0.0:
            continue
        amount = float(shown @ effect / (effect @ effect)) if tried else 1.0
        left = rms(shown - amount * effect) / rms(shown)
        if left < least:
            least = 0.7 * left  # another must explain clearly more
            scaled = f" {1.0 + amount * (tried - 1.0):.4g} times as large" if tried else ""
            best = Finding(f"the motion is that with {words}{scaled}", f"look where {words.split()[0]} enters", True)
    return best


def _noise(name: str, known: Truth, tolerances: Mapping[str, float] | None) -> float:
    return (0.01 if tolerances is None else 1e-4) * rms(known.columns[name]) + (0.0 if tolerances is None else tolerances[name])


def _models(scene: Mechanism) -> Iterator[tuple[str, Mechanism, float | None]]:
    """What it may be, the scene, and the factor that was tried where the effect is in proportion."""
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
        yield words, changed(scene, values), None
    for path in _SCALED:
        owner: object = scene
        for part in path.split("."):
            owner = getattr(owner, part, None)
        if isinstance(owner, float) and math.isfinite(owner) and owner != 0.0:
            tried = _TRIED_OF_SMALL if path in ("base.inertia", "tip.inertia") else _TRIED
            with contextlib.suppress(ImpossibleMechanism):
                yield path.replace("drive.", ""), changed(scene, {path: tried * owner}), tried
