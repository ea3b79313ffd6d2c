"""Natural frequencies with the crank held: shape, order, unit, and what they are."""

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from quickreturn.cases.conformance.bench import Bench
from quickreturn.cases.conformance.checks import Array, Check, Fault, Unjudged, looked_at
from quickreturn.cases.explanation import Hypothesis, explain
from quickreturn.cases.mistakes import share_of
from quickreturn.cases.units import in_si
from quickreturn.engines.base import Refusal
from quickreturn.engines.settings import Settings
from quickreturn.reference_model.mechanism import Mechanism, changed
from quickreturn.reference_model.natural_modes import frozen_crank_modes

_COUNT: Final = 3
_ANGLES: Final = (180.0, 90.0, 0.0)
#: By how much they may be off beside three times the change that finer settings make; what one that makes no claim may be off by in
#: the first, where one cubic is 12 to 16 % too high; and what even a coarse model must not miss.
_FLOOR: Final = np.array([0.005, 0.015, 0.04])
_REFINED: Final = 3.0
_COARSE: Final = (0.3, 0.6, 0.9)
#: Support of a uniform beam, pinned at one end, over its length, and beta L of its first mode (Blevins, or any text on vibration).
_SUPPORT: Final = 0.5
_OVERHUNG: Final = 3.01183092
#: Inertia (kg m^2) of a base that does not move.
_HEAVY: Final = 1e4
#: Other unit -> the number for one Hz, a turn per second.
_UNITS: Final = {unit: in_si("turn/s") / in_si(unit) for unit in ("rad/s", "rpm")} | {"kHz": 1e-3}
_RETURN: Final = "return an ascending array of at most `count` frequencies"


def frequencies(bench: Bench) -> Iterator[Check]:
    """All checks of natural frequencies; none of their values where they are no list of frequencies."""
    form = looked_at("frequencies: form", _form, bench)
    yield form
    if form.status != "failed":
        yield looked_at("frequencies: values", _values, bench)
        yield looked_at("frequencies: closed form", _closed_form, bench)
        yield looked_at("frequencies: undamped, at rest, without gravity", _left_out, bench)


def _asked(bench: Bench, scene: Mechanism, degrees: float, count: int = _COUNT, settings: Settings | None = None) -> Array:
    """With the settings for the mild scene unless others are given."""
    found: Any = bench.engine.natural_frequencies(scene, math.radians(degrees), count, settings or bench.settings(bench.scene))
    try:
        values = np.asarray(found, dtype=np.float64)
    except (TypeError, ValueError):
        raise Fault(f"they are no numbers: {str(found)[:60]}", _RETURN) from None
    if not values.size:
        raise Unjudged("the engine gives none")
    return values


def _form(bench: Bench) -> None:
    values = _asked(bench, bench.scene, 180.0)
    if values.ndim != 1:
        raise Fault(f"they have the shape {values.shape}, not (count,)", _RETURN)
    if not np.isfinite(values).all():
        raise Fault(f"they are not finite: {values}", "leave out what the model does not have; look for a division by zero")
    if (values <= 0.0).any():
        raise Fault(f"zero or negative ones are among them: {values}", "leave out rigid motions: the crank is held")
    if (np.diff(values) < 0.0).any():
        raise Fault(f"they do not ascend: {values}", "sort them")
    if len(values) > _COUNT or len(_asked(bench, bench.scene, 180.0, 1)) > 1:
        raise Fault(f"more than the {_COUNT} asked for, or than 1", "cut them at `count`")


def _values(bench: Bench) -> str:
    coarse, finer = 0.0, bench.settings(bench.scene)
    for _ in range(3):  # the next rungs may be finer in time alone
        finer = bench.engine.finer(finer, (), 1e-3) or finer
    for degrees in _ANGLES:
        found = _asked(bench, bench.scene, degrees)
        count = len(found)
        known = _known(bench.scene, degrees, count)
        off = np.abs(found / known - 1.0)
        allowed: Array = np.array(_COARSE[:count])
        if bench.claims:
            better = _asked(bench, bench.scene, degrees, settings=finer)[:count]
            if len(better) == count:
                allowed = np.minimum(_FLOOR[:count] + _REFINED * np.abs(better / found - 1.0), 0.6)
        if (off > allowed).any():
            raise Fault(*_cause(bench.scene, degrees, found, known))
        coarse = max(coarse, float(off.max()))
    return f"coarse: up to {share_of(coarse)} off" if coarse > 0.02 else ""


def _known(scene: Mechanism, degrees: float, count: int) -> Array:
    return frozen_crank_modes(scene, math.radians(degrees), count).frequencies


def _cause(scene: Mechanism, degrees: float, found: Array, known: Array) -> tuple[str, str]:
    """What is wrong with frequencies, and what to do."""
    n = len(found)

    def at(angle: float, **quantities: object) -> Array:
        return _known(changed(scene, quantities), angle, n)

    ratio = found / known
    tried: list[tuple[str, str, Array]] = [
        *((f"they are in {unit}, not in Hz", f"divide them by {factor:.6g}", factor * known) for unit, factor in _UNITS.items()),
        ("they are divided by 2 pi once too often", "multiply them by 2 pi", known / (2.0 * math.pi)),
        ("they are eigenvalues, squares of angular frequencies", "take the root and divide by 2 pi", (2.0 * math.pi * known) ** 2),
        ("they are squares of frequencies", "take the root", known**2),
        ("they are twice what they should be", "look for a factor of 2", 2.0 * known),
        ("they are half what they should be", "look for a factor of 2", 0.5 * known),
        ("the lowest one is missing", "begin with the lowest", _known(scene, degrees, n + 1)[1:]),
        ("each comes twice", "take one of each pair of eigenvalues", np.repeat(known, 2)[:n]),
        ("the crank angle is taken for degrees", "it comes in rad", at(math.radians(degrees))),
        ("the crank is at its initial angle, whatever is asked for", "hold it at `crank_angle`", at(180.0)),
        ("the crank angle is counted from -n1", "count it from n1, counter-clockwise", at(degrees + 180.0)),
        ("the tip body is left out", "count its mass and inertia", at(degrees, tip=None)),
        ("the base is held", "it turns about P: its inertia is all that is there", _base_held(scene, degrees, n)),
        ("the inertia of the base is left out", "count it", at(degrees, **{"base.inertia": 0.0})),
    ]
    usual = [Hypothesis(words, advice, np.log(values)) for words, advice, values in tried if len(values) == n]
    words, root = f"they are {ratio[0]:.4g} times those of reference", "look for such a factor, or its square in stiffness or mass"
    factor = Hypothesis(words, root, np.log(ratio[0] * known), fitted=True)
    if explained := explain(np.log(found), np.log(known), [*usual, factor]):
        return explained.words, explained.advice
    return f"with the crank at {degrees:g} deg they are {np.round(found, 3)} Hz where reference has {np.round(known, 3)}", (
        "linearize about the straight follower at rest, undamped, without gravity, the crank held"
    )


def _base_held(scene: Mechanism, degrees: float, count: int) -> Array:
    """Frequencies of a follower that is clamped at its base: of one so heavy that its own slow vibration comes first."""
    return _known(changed(scene, {"base.inertia": _HEAVY}), degrees, count + 1)[1:]


def _closed_form(bench: Bench) -> None:
    """A uniform pinned beam over a support, without tip and base."""
    follower, d = bench.scene.follower, bench.scene.pivot_distance
    overhang = _SUPPORT * follower.length - d  # of the support beyond O, along n1
    scene = changed(bench.scene, {"tip": None, "base.inertia": 0.0, "crank.length": abs(overhang)})
    bench.engine.check(scene)
    known = _OVERHUNG**2 / (2.0 * math.pi * follower.length**2) * math.sqrt(follower.bending_stiffness / follower.mass_per_length)
    found = float(_asked(bench, scene, 0.0 if overhang < 0.0 else 180.0, 1, bench.settings(scene))[0])
    if abs(found / known - 1.0) > (0.02 if bench.claims else _COARSE[0]):
        cause = f"a pinned beam over a support at {_SUPPORT:g} of its length has {known:.4f} Hz, the engine gives {found:.4f} Hz"
        raise Fault(cause, "look at stiffness and mass of the follower: there is nothing else in this scene")


def _left_out(bench: Bench) -> None:
    """Gravity, damping and motion do not enter."""
    plain = _asked(bench, bench.scene, 90.0)
    tried: dict[str, dict[str, Any]] = {"gravity": {"gravity": (0.0, 30.0)}, "follower.damping": {"follower.damping": 30.0}}
    for words, values in tried.items():
        scene = changed(bench.scene, values)
        try:
            bench.engine.check(scene)
        except Refusal:
            continue
        found = _asked(bench, scene, 90.0)
        if found.shape != plain.shape or not np.allclose(found, plain, rtol=1e-6):
            raise Fault(f"{words} changes them", "leave it out of the linearization")
