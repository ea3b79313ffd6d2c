"""Natural frequencies with the crank held: shape, order, unit, and what they are."""

import math
from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np

from cases.conformance.bench import Bench
from cases.conformance.checks import Array, Check, percent
from engines.base import Refusal
from engines.settings import Settings
from reference_model.mechanism import Mechanism, changed
from reference_model.natural_modes import frozen_crank_modes

_COUNT: Final = 3
_ANGLES: Final = (180.0, 90.0, 0.0)
#: By how much they may be off beside three times the change that finer settings make; what one that makes no claim may be off by in
#: the first, where one cubic is 12 to 16 % too high; and what even a coarse model must not miss.
_FLOOR: Final = np.array([0.005, 0.015, 0.04])
_REFINED: Final = 3.0
_COARSE: Final = (0.3, 0.6, 0.9)
#: Support of a uniform beam, pinned at one end, over its length -> beta L of its first mode (Blevins, or any text on vibration).
_OVERHUNG: Final = {0.5: 3.01183092, 0.7: 3.88535145}


def frequencies(bench: Bench) -> Iterator[Check]:
    """All checks of natural frequencies."""
    settings = bench.settings(bench.scene)
    for check in (_form, _values, _closed_form, _left_out):
        try:
            found = check(bench, settings)
            yield found
            if check is _form and found.status == "failed":
                return
        except Refusal as refusal:
            yield Check("frequencies", "not judged", f"refused: {refusal}", "")
        except Exception as error:  # an author's engine may raise anything
            cause = f"natural_frequencies raises {type(error).__name__}: {error}"
            yield Check("frequencies", "failed", cause, "return an array of frequencies in Hz; of shape (0,) where nothing can vibrate")
            return


def _asked(bench: Bench, scene: Mechanism, degrees: float, settings: Settings, count: int = _COUNT) -> Any:
    return bench.engine.natural_frequencies(scene, math.radians(degrees), count, settings)


def _form(bench: Bench, settings: Settings) -> Check:
    name, advice = "frequencies: form", "return an ascending array of at most `count` frequencies"
    found: Any = _asked(bench, bench.scene, 180.0, settings)
    try:
        values = np.asarray(found, dtype=np.float64)
    except (TypeError, ValueError):
        return Check(name, "failed", f"they are no numbers: {str(found)[:60]}", advice)
    if values.ndim != 1:
        return Check(name, "failed", f"they have the shape {values.shape}, not (count,)", advice)
    if not np.isfinite(values).all():
        return Check(
            name, "failed", f"they are not finite: {values}", "leave out what the model does not have; look for a division by zero"
        )
    if (values <= 0.0).any():
        return Check(name, "failed", f"zero or negative ones are among them: {values}", "leave out rigid motions: the crank is held")
    if (np.diff(values) < 0.0).any():
        return Check(name, "failed", f"they do not ascend: {values}", "sort them")
    more = len(values) > _COUNT or len(np.asarray(_asked(bench, bench.scene, 180.0, settings, 1))) > 1
    return Check(name, "failed", f"more than the {_COUNT} asked for, or than 1", "cut them at `count`") if more else Check(name, "passed")


def _finer(bench: Bench, settings: Settings) -> Settings:
    """Three rungs up: the next ones may be finer in time alone."""
    for _ in range(3):
        settings = bench.engine.finer(settings, (), 1e-3) or settings
    return settings


def _values(bench: Bench, settings: Settings) -> Check:
    name, coarse = "frequencies: values", 0.0
    for degrees in _ANGLES:
        found = np.asarray(_asked(bench, bench.scene, degrees, settings), dtype=np.float64)
        known = _known(bench.scene, degrees)[: len(found)]
        if not len(found):
            return Check(name, "not judged", "the engine gives none", "")
        off = np.abs(found / known - 1.0)
        allowed: Array = np.array(_COARSE[: len(found)])
        if bench.claims:
            better = np.asarray(_asked(bench, bench.scene, degrees, _finer(bench, settings)), dtype=np.float64)[: len(found)]
            allowed = (
                np.minimum(_FLOOR[: len(found)] + _REFINED * np.abs(better / found[: len(better)] - 1.0), 0.6)
                if len(better) == len(found)
                else allowed
            )
        if (off > allowed).any():
            return Check(name, "failed", *_cause(bench.scene, degrees, found, known))
        coarse = max(coarse, float(off.max()))
    return Check(name, "passed", f"coarse: up to {percent(coarse)} off" if coarse > 0.02 else "")


def _known(scene: Mechanism, degrees: float, count: int = _COUNT) -> Array:
    return frozen_crank_modes(scene, math.radians(degrees), count).frequencies


def _cause(scene: Mechanism, degrees: float, found: Array, known: Array) -> tuple[str, str]:
    """What is wrong with frequencies, and what to do."""
    n = len(found)
    at: Callable[[float], Array] = lambda angle: _known(scene, angle, n)  # noqa: E731
    tried: list[tuple[str, str, Array]] = [
        ("they are in rad/s, not in Hz", "divide them by 2 pi", 2.0 * math.pi * known),
        ("they are divided by 2 pi once too often", "multiply them by 2 pi", known / (2.0 * math.pi)),
        ("they are eigenvalues, squares of angular frequencies", "take the root and divide by 2 pi", (2.0 * math.pi * known) ** 2),
        ("they are squares of frequencies", "take the root", known**2),
        ("they are in rpm, not in Hz", "divide them by 60", 60.0 * known),
        ("they are in kHz", "multiply them by 1000", known / 1e3),
        ("they are twice what they should be", "look for a factor of 2", 2.0 * known),
        ("they are half what they should be", "look for a factor of 2", 0.5 * known),
        ("the lowest one is missing", "begin with the lowest", _known(scene, degrees, n + 1)[1:]),
        ("each comes twice", "take one of each pair of eigenvalues", np.repeat(known, 2)[:n]),
        ("the crank angle is taken for degrees", "it comes in rad", at(math.radians(degrees))),
        ("the crank is at its initial angle, whatever is asked for", "hold it at `crank_angle`", at(180.0)),
        ("the crank angle is counted from -n1", "count it from n1, counter-clockwise", at(degrees + 180.0)),
        ("the tip body is left out", "count its mass and inertia", _known(changed(scene, {"tip": None}), degrees, n)),
        ("the inertia of the base is left out", "count it", _known(changed(scene, {"base.inertia": 0.0}), degrees, n)),
    ]
    off = float(np.max(np.abs(found / known - 1.0)))
    ratio = found / known
    if np.ptp(ratio) < 0.1 * off and 0.9 < ratio[0] < 1.1:
        return f"they are {ratio[0]:.4g} times those of reference", "stiffness and mass enter as their ratio's root: look for such a factor"
    for words, advice, values in tried:
        if np.max(np.abs(found / values - 1.0)) < 0.2 * min(off, 1.0):
            return words, advice
    if np.ptp(ratio) < 0.1 * off:
        return f"they are {ratio[0]:.4g} times those of reference", "look for such a factor, or its square in stiffness or mass"
    return f"with the crank at {degrees:g} deg they are {np.round(found, 3)} Hz where reference has {np.round(known, 3)}", (
        "linearize about the straight follower at rest, undamped, without gravity, the crank held"
    )


def _closed_form(bench: Bench, settings: Settings) -> Check:
    """A uniform pinned beam over a support, without tip and base."""
    name = "frequencies: closed form"
    bare = changed(bench.scene, {"tip": None, "base.inertia": 0.0})
    bench.engine.check(bare)
    for part, root in _OVERHUNG.items():
        length, d = bench.scene.follower.length, bench.scene.pivot_distance
        scene = changed(bare, {"crank.length": abs(d - part * length)})
        degrees = 0.0 if part * length < d else 180.0
        if abs(d - part * length) < 1e-6:
            continue
        follower = scene.follower
        known = root**2 / (2.0 * math.pi * length**2) * math.sqrt(follower.bending_stiffness / follower.mass_per_length)
        found = float(np.asarray(_asked(bench, scene, degrees, bench.settings(scene), 1))[0])
        if abs(found / known - 1.0) > (0.02 if bench.claims else _COARSE[0]):
            cause = f"a pinned beam over a support at {part:g} of its length has {known:.4f} Hz, the engine gives {found:.4f} Hz"
            return Check(name, "failed", cause, "look at stiffness and mass of the follower: there is nothing else in this scene")
    return Check(name, "passed")


def _left_out(bench: Bench, settings: Settings) -> Check:
    """Gravity, damping and motion do not enter."""
    name = "frequencies: undamped, at rest, without gravity"
    plain = np.asarray(_asked(bench, bench.scene, 90.0, settings), dtype=np.float64)
    tried: dict[str, dict[str, Any]] = {"gravity": {"gravity": (0.0, 30.0)}, "follower.damping": {"follower.damping": 30.0}}
    for words, values in tried.items():
        scene = changed(bench.scene, values)
        try:
            bench.engine.check(scene)
        except Refusal:
            continue
        found = np.asarray(_asked(bench, scene, 90.0, settings), dtype=np.float64)
        if found.shape != plain.shape or not np.allclose(found, plain, rtol=1e-6):
            return Check(name, "failed", f"{words} changes them", "leave it out of the linearization")
    return Check(name, "passed")
