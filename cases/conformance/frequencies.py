"""Checks of natural frequencies with the crank held: shape, order, unit and values."""

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from quickreturn.cases.conformance.bench import Bench
from quickreturn.cases.conformance.checks import Array, Check, Fault, Unjudged, check_by
from quickreturn.cases.conformance.scenes import OUTPUT_STEP
from quickreturn.cases.mistakes.diagnosis import share_of
from quickreturn.cases.mistakes.explanation import Hypothesis, explain
from quickreturn.cases.units import in_si
from quickreturn.engines.base import Refusal
from quickreturn.engines.settings import Settings
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.scene_values import changed

#: Number of frequencies, and crank angles (deg), that are compared.
_COUNT: Final = 3
_ANGLES: Final = (180.0, 90.0, 0.0)
#: Relative tolerance of each frequency: `_FLOOR` plus `_REFINED` times the change by finer settings, at most 0.6 ...
_FLOOR: Final = np.array([0.005, 0.015, 0.04])
_REFINED: Final = 3.0
#: ... or this, if the engine makes no claim or states an error of 30 %: one cubic is 12 to 16 % too high in the first, two modes that are
#: right in the first are 20 to 60 % off in the next. For a smaller stated error it is in proportion.
_COARSE: Final = (0.3, 0.6, 0.9)
#: Place of the support of a uniform beam that is pinned at one end, over its length, and beta L of its first mode (Blevins, Formulas for
#: Natural Frequency and Mode Shape, or any text on vibration).
_SUPPORT: Final = 0.5
_OVERHUNG: Final = 3.01183092
#: Inertia (kg m^2) of a base that does not move: its own slow vibration comes first, then those of a follower that is clamped to it.
_HEAVY: Final = 1e4
#: Other unit -> the number for one Hz, a turn per second.
_UNITS: Final = {unit: in_si("turn/s") / in_si(unit) for unit in ("rad/s", "rpm")} | {"kHz": 1.0 / in_si("kHz")}
_RETURN: Final = "return an ascending array of at most `count` frequencies"


def frequencies(bench: Bench) -> Iterator[Check]:
    """All checks of natural frequencies; values are checked only if they are a list of frequencies."""
    form = check_by("frequencies: form", _form, bench)
    yield form
    if form.status != "failed":
        yield check_by("frequencies: values", _values, bench)
        yield check_by("frequencies: closed form", _closed_form, bench)
        yield check_by("frequencies: undamped, at rest, without gravity", _left_out, bench)


def _given(bench: Bench, scene: Mechanism, degrees: float, count: int = _COUNT, settings: Settings | None = None) -> Array:
    """The engine's frequencies, by default with the settings for the mild scene."""
    given: Any = bench.engine.natural_frequencies(scene, math.radians(degrees), count, settings or bench.settings(bench.scene))
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise Fault(f"they are not numbers: {str(given)[:60]}", _RETURN) from None
    if not values.size:
        raise Unjudged("the engine gives none")
    return values


def _form(bench: Bench) -> None:
    """Check that they are at most as many finite positive numbers as asked for, ascending."""
    values = _given(bench, bench.scene, 180.0)
    if values.ndim != 1:
        raise Fault(f"they have the shape {values.shape}, not (count,)", _RETURN)
    if not np.isfinite(values).all():
        raise Fault(f"they are not finite: {values}", "leave out what the model does not have; look for a division by zero")
    if (values <= 0.0).any():
        raise Fault(f"zero or negative ones are among them: {values}", "leave out rigid motions: the crank is held")
    if (np.diff(values) < 0.0).any():
        raise Fault(f"they do not ascend: {values}", "sort them")
    if len(values) > _COUNT or len(_given(bench, bench.scene, 180.0, 1)) > 1:
        raise Fault(f"more than the {_COUNT} asked for, or than 1", "cut them at `count`")


def _values(bench: Bench) -> str:
    """Check the frequencies against those of the model by `reference`."""
    coarse, finer = 0.0, bench.settings(bench.scene)
    for _ in range(3):  # the next rungs may be finer in time alone
        finer = bench.engine.finer(finer, {}, OUTPUT_STEP) or finer
    for degrees in _ANGLES:
        given = _given(bench, bench.scene, degrees)
        count = len(given)
        expected = _expected(bench.scene, degrees, count)
        off = np.abs(given / expected - 1.0)
        allowed: Array = np.array(_COARSE[:count])
        if bench.claims:
            better = _given(bench, bench.scene, degrees, settings=finer)[:count]
            shown = np.abs(better / given - 1.0) if len(better) == count else np.zeros(count)
            stated = min(bench.engine.default_accuracy / _COARSE[0], 1.0) * allowed
            allowed = np.maximum(np.minimum(_FLOOR[:count] + _REFINED * shown, 0.6), stated)
        if (off > allowed).any():
            raise Fault(*_cause(bench.scene, degrees, given, expected))
        coarse = max(coarse, float(off.max()))
    return f"coarse: up to {share_of(coarse)} off" if coarse > 0.02 else ""


def _expected(scene: Mechanism, degrees: float, count: int) -> Array:
    """The right frequencies, Hz."""
    return frozen_crank_modes(scene, math.radians(degrees), count).frequencies


def _cause(scene: Mechanism, degrees: float, given: Array, expected: Array) -> tuple[str, str]:
    """The mistake in the engine's frequencies, and what to do."""
    n = len(given)

    def at(angle: float, **quantities: Any) -> Array:
        return _expected(changed(scene, quantities), angle, n)

    ratio, clamped = given / expected, _expected(changed(scene, {"base.inertia": _HEAVY}), degrees, n + 1)[1:]
    tried: list[tuple[str, str, Array]] = [
        *((f"they are in {unit}, not in Hz", f"divide them by {factor:.6g}", factor * expected) for unit, factor in _UNITS.items()),
        ("they are divided by 2 pi once too often", "multiply them by 2 pi", expected / (2.0 * math.pi)),
        ("they are eigenvalues, squares of angular frequencies", "take the root and divide by 2 pi", (2.0 * math.pi * expected) ** 2),
        ("they are squares of frequencies", "take the root", expected**2),
        ("they are twice what they should be", "look for a factor of 2", 2.0 * expected),
        ("they are half what they should be", "look for a factor of 2", 0.5 * expected),
        ("the lowest one is missing", "begin with the lowest", _expected(scene, degrees, n + 1)[1:]),
        ("each comes twice", "take one of each pair of eigenvalues", np.repeat(expected, 2)[:n]),
        ("the crank angle is taken for degrees", "it comes in rad", at(math.radians(degrees))),
        ("the crank is at its initial angle, whatever is asked for", "hold it at `crank_angle`", at(180.0)),
        ("the crank angle is counted from -n1", "count it from n1, counter-clockwise", at(degrees + 180.0)),
        ("the tip body is left out", "count its mass and inertia", at(degrees, tip=None)),
        ("the base is held", "it turns about P: its inertia is all that is there", clamped),
        ("the inertia of the base is left out", "count it", at(degrees, **{"base.inertia": 0.0})),
    ]
    usual = [Hypothesis(words, advice, np.log(values)) for words, advice, values in tried if len(values) == n]
    words, root = f"they are {ratio[0]:.4g} times those of reference", "look for such a factor, or its square in stiffness or mass"
    factor = Hypothesis(words, root, np.log(ratio[0] * expected), fitted=1)
    if explained := explain(np.log(given), np.log(expected), [*usual, factor]):
        return explained.words, explained.advice
    return f"with the crank at {degrees:g} deg they are {np.round(given, 3)} Hz where reference has {np.round(expected, 3)}", (
        "linearize about the straight follower at rest, undamped, without gravity, the crank held"
    )


def _closed_form(bench: Bench) -> None:
    """Check a uniform pinned beam over a support, without tip and base."""
    follower, d = bench.scene.follower, bench.scene.pivot_distance
    overhang = _SUPPORT * follower.length - d  # of the support beyond O, along n1
    scene = changed(bench.scene, {"tip": None, "base.inertia": 0.0, "crank.length": abs(overhang)})
    bench.engine.check(scene)
    expected = _OVERHUNG**2 / (2.0 * math.pi * follower.length**2) * math.sqrt(follower.bending_stiffness / follower.mass_per_length)
    given = float(_given(bench, scene, 0.0 if overhang < 0.0 else 180.0, 1, bench.settings(scene))[0])
    if abs(given / expected - 1.0) > (0.02 if bench.claims else _COARSE[0]):
        cause = f"a pinned beam over a support at {_SUPPORT:g} of its length has {expected:.4f} Hz, the engine gives {given:.4f} Hz"
        raise Fault(cause, "look at stiffness and mass of the follower: there is nothing else in this scene")


def _left_out(bench: Bench) -> None:
    """Check that gravity, damping and motion do not change the frequencies."""
    plain = _given(bench, bench.scene, 90.0)
    tried: dict[str, dict[str, Any]] = {"gravity": {"mechanism.gravity": (0.0, 30.0)}, "follower.damping": {"follower.damping": 30.0}}
    for words, values in tried.items():
        scene = changed(bench.scene, values)
        try:
            bench.engine.check(scene)
        except Refusal:
            continue
        given = _given(bench, scene, 90.0)
        if given.shape != plain.shape or not np.allclose(given, plain, rtol=1e-6):
            raise Fault(f"{words} changes them", "leave it out of the linearization")
