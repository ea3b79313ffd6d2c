"""Checks of an engine that models a follower alone: a clamped rod that is let go, against closed forms, at three resolutions.

Each record of a free vibration about the sag shows where the rod comes to rest, its frequencies and its decay.
"""

import contextlib
import functools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.integrate import cumulative_trapezoid

from quickreturn.engines.base import AnyEngine, Refusal
from quickreturn.engines.rod import RodEngine
from quickreturn.engines.scene import check_scene
from quickreturn.engines.settings import Settings
from quickreturn.plugins.conform.bench import (
    MEND_FIRST,
    TOLERANCE_FACTOR,
    Array,
    Bench,
    Check,
    Fault,
    Motion,
    check_by,
    share_of,
    solution,
)
from quickreturn.plugins.conform.scenes import ALONE, BASE, CLAMPED, OUTPUT_STEP, PRESCRIBED, SPUN_UP
from quickreturn.reference_model.mechanism import FollowerAlone
from quickreturn.reference_model.scene_values import changed

#: b of the modes of a clamped beam, 1 + cos b cosh b = 0 (Blevins, Formulas for Natural Frequency and Mode Shape, table 8-1).
ROOTS: Final = np.array([1.875104068711961, 4.694091132974175, 7.854757438237613])
#: Part of the largest singular value of the table of shifted records below which there is no further vibration; largest number of
#: vibrations; and smallest amplitude that counts, over that of the largest.
_NOISE: Final = 1e-6
_MOST: Final = 24
_AUDIBLE: Final = 2e-4

_DURATION: Final = 0.66  # s: eight vibrations
_MASS: Final = 0.1  # kg, hung on the end for a force there: it sinks by 0.6 % of the length more
_BEAM: Final = CLAMPED.follower
_WEIGHT: Final = _BEAM.mass_per_length * CLAMPED.gravity[1]  # N/m
#: Closed forms for small deflections: sag under the weight and by the force, m; frequencies, Hz.
_SAGS: Final = np.array([_WEIGHT * _BEAM.length / 8.0, _MASS * CLAMPED.gravity[1] / 3.0]) * _BEAM.length**3 / _BEAM.bending_stiffness
_FREQUENCIES: Final = (ROOTS / _BEAM.length) ** 2 * math.sqrt(_BEAM.bending_stiffness / _BEAM.mass_per_length) / (2.0 * math.pi)
_RIGHT: Final = np.append(_SAGS, _FREQUENCIES)
_NAMES: Final = ("sag under its weight", "sag by a force at its end", "first frequency", "second frequency", "third frequency")
_OMEGA: Final = 2.0 * math.pi * float(_RIGHT[2])  # rad/s
#: Ratios of the first mode's damping to critical damping that are tried; and the quantity that gives a ratio of one.
_RATIOS: Final = (0.02, 0.08)
_CRITICAL: Final = {"follower.material_damping": 2.0 / _OMEGA, "follower.damping": 2.0 * _OMEGA * _BEAM.mass_per_length}
#: A soft strip that sinks by a third of its length and comes to rest; its duration and output step, s.
_SOFT: Final = {"follower.bending_stiffness": 0.55, "follower.damping": 17.0, "tip": None, "tip.mass": _MASS, "tip.inertia": 0.0}
_SUNK: Final = (2.0, 0.01)
#: Accuracies asked of the engine, over its default one, from coarse to fine; and the coarsest one.
_LEVELS: Final = (4.0, 1.0, 0.25)
_COARSEST: Final = 0.3
#: Parts of a sag, and of each frequency, that may be off beside the engine's error: small deflections, the record's length; error of each
#: over that of the tip deflection; and what an engine without a claim may be off.
_FLOOR: Final = np.array([0.003, 0.003, 0.003, 0.006, 0.02])
_HARDER: Final = np.array([1.0, 1.0, 1.0, 2.0, 3.0])
_UNCLAIMED: Final = 0.3
#: Part by which a rate of decay may be off beside the engine's error, and damping ratio of an integrator, over the engine's error.
_OF_RATE: Final = 0.05
_ADDED: Final = 0.1
_LEAST: Final = 1e-3
#: Part by which damping may change the sag, and part by which a strain may be off.
_SOFTER: Final = 0.02
_OF_STRAIN: Final = 0.01
#: Range of the factor between the integral of the acceleration and the velocity, and part of gravity that its mean may be off. The rows are
#: too far apart for the fastest vibrations of a fine, undamped rod, which add up to 0.4 of it, and 0.01 g, in the ladders of four rods.
_FACTOR: Final = (0.6, 1.5)
_OF_GRAVITY: Final = 0.2


@dataclass(frozen=True)
class Ring:
    """A free vibration: where it comes to rest, and its modes by frequency."""

    rest: float
    frequencies: Array  # Hz
    rates: Array  # of decay, 1/s


def motion_alone(engine: AnyEngine) -> Motion | None:
    """The motion in which an engine is tried that refuses the mechanism and models a follower alone; None for any other engine."""
    for scene in (BASE, PRESCRIBED, ALONE, replace(ALONE, tip=None), CLAMPED):
        try:
            check_scene(engine, scene)
        except Refusal:
            continue
        except Exception:  # an author's engine may raise anything: the checks of its motion tell
            return None
        return Motion(scene, SPUN_UP) if scene.crank is None else None
    return None


def ring(signal: Array, step: float) -> Ring:
    """The exponentials in a record, by the matrix pencil (Hua and Sarkar, IEEE Trans. Acoustics, Speech, Signal Proc. 38 (1990) 814-824).

    Args:
        signal: the record, shape (n,).
        step: between two values, s.
    """
    columns = len(signal) // 3
    shifted = np.lib.stride_tricks.sliding_window_view(signal, columns)
    _, sizes, right_vectors = np.linalg.svd(shifted, full_matrices=False)
    modes = right_vectors[: min(_MOST, int(np.sum(sizes > _NOISE * sizes[0])))].T
    poles = np.linalg.eigvals(np.linalg.pinv(modes[:-1]) @ modes[1:]).astype(complex)
    poles = poles[np.abs(poles) > 1e-9]
    exponents = np.log(poles) / step
    basis = np.exp(np.outer(step * np.arange(len(signal)), exponents))
    sizes = np.linalg.lstsq(basis, signal.astype(complex), rcond=None)[0]
    resting = np.abs(exponents) < 0.2 / (step * len(signal))
    turning = np.flatnonzero((exponents.imag > math.pi / (step * len(signal))) & (np.abs(sizes) > 0.0))  # half a vibration or more
    turning = turning[np.abs(sizes[turning]) > _AUDIBLE * np.max(np.abs(sizes[turning]), initial=0.0)]
    loudest = turning[np.argsort(-np.abs(sizes[turning]))][: len(ROOTS)]
    loudest = loudest[np.argsort(exponents[loudest].imag)]
    return Ring(float(np.sum(sizes[resting]).real), np.abs(exponents[loudest]) / (2.0 * math.pi), -exponents[loudest].real)


def rods(bench: Bench) -> Iterator[Check]:
    """All checks of a clamped rod."""
    sizes = check_by("rod: sags and frequencies", _sizes, bench)
    yield sizes
    if sizes.status == "failed":
        yield Check("rod: decay, columns and large deflections", "not judged", "its sags or frequencies are wrong already", MEND_FIRST)
        return
    for quantity, critical in _CRITICAL.items():
        yield check_by(f"rod: decay by {quantity}", _decay, bench, quantity, critical)
    for name, look in (("strains at rest", strains), ("tip_acceleration", acceleration), ("sag beyond small deflections", _sunk)):
        yield check_by(f"rod: {name}", look, bench)


def _levels(bench: Bench) -> dict[Settings, float]:
    """Settings from coarse to fine, each once, and the accuracies asked of them."""
    default, levels = bench.engine.default_accuracy, dict[Settings, float]()
    for times in _LEVELS:
        accuracy = min(times * default, max(_COARSEST, default))
        levels.setdefault(bench.engine.settings_for(accuracy, CLAMPED), accuracy)
    return levels


def _record(bench: Bench, settings: Settings, changes: Mapping[str, float | None]) -> Ring:
    """The vibration with changes of the scene. Refusal, EngineFailure: there is none."""
    deflection = bench.run(Motion(changed(CLAMPED, changes), _DURATION), settings)["tip_deflection"]
    found = ring(deflection, OUTPUT_STEP)
    return found if len(found.frequencies) else replace(found, rest=float(np.mean(deflection[-len(deflection) // 4 :])))


@functools.lru_cache(maxsize=8)
def _free(bench: Bench, settings: Settings) -> Ring:
    """The vibration without damping."""
    return _record(bench, settings, {})


def _claimed(bench: Bench, accuracy: float, otherwise: float) -> float:
    """Tolerance of a relative error with settings for an accuracy: by the engine's claim, or `otherwise`."""
    return TOLERANCE_FACTOR * accuracy if bench.claims else otherwise


def _sizes(bench: Bench) -> str:
    """Check sags and frequencies at each resolution."""
    accuracies = list(_levels(bench).values())
    sizes = [_over(bench, settings) for settings in _levels(bench)]
    for k, (over, accuracy) in enumerate(zip(sizes, accuracies, strict=True)):
        off, allowed = np.abs(over - 1.0), _FLOOR + _claimed(bench, accuracy, _UNCLAIMED) * _HARDER
        if len(sizes) > 1:  # higher frequencies may not be there, or not be heard
            allowed[3:] += TOLERANCE_FACTOR * np.nan_to_num(np.abs(over - sizes[k + 1 if k + 1 < len(sizes) else k - 1])[3:], nan=1.0)
        if math.isnan(over[2]) or (off > allowed).any():
            told = ", ".join(f"{name} {times:.4g}" for name, times in zip(_NAMES, over, strict=True) if not math.isnan(times))
            cause = f"times the closed forms, at an accuracy of {share_of(accuracy)}: {told}{', no vibration' * math.isnan(over[2])}"
            raise Fault(cause, "hold stiffness, mass and length of the rod against the closed forms, and look what the integrator adds")
    return f"from coarse to fine off by {', '.join(share_of(float(np.nanmax(np.abs(over[:3] - 1.0)))) for over in sizes)}"


def _over(bench: Bench, settings: Settings) -> Array:
    """Sags and frequencies over the closed forms; nan for what is not there."""
    free, over = _free(bench, settings), np.full(len(_RIGHT), math.nan)
    with contextlib.suppress(Refusal):
        over[1] = _record(bench, settings, {"tip": None, "tip.mass": _MASS, "tip.inertia": 0.0}).rest - free.rest
    over[0], over[2 : 2 + len(free.frequencies)] = free.rest, free.frequencies
    return over / _RIGHT


def _decay(bench: Bench, quantity: str, critical: float) -> str:
    """Check the decay of the first mode with two dampings, at each resolution, and that damping leaves the sag."""
    rates, most, added = list[float](), 0.0, 0.0
    for settings, accuracy in _levels(bench).items():
        free, part = _free(bench, settings), _claimed(bench, accuracy, 0.9)
        records = [_record(bench, settings, {quantity: ratio * critical}) for ratio in _RATIOS]
        softer = [record.rest / free.rest for record in records]
        if np.abs(np.array(softer) - 1.0).max() > _SOFTER + (accuracy if bench.claims else 0.1):
            told = " and ".join(f"{times:.3g}" for times in softer)
            raise Fault(
                f"with damping ratios of 0.02 and 0.08 the sag is {told} times that without", "damping leaves the stiffness as it is"
            )
        if not all(len(record.rates) for record in records):
            raise Fault("with damping the rod does not vibrate", "a damping ratio of 0.08 leaves twelve vibrations: look at its unit")
        omega = 2.0 * math.pi * free.frequencies[0]
        rates += [float(record.rates[0] - free.rates[0]) / (ratio * omega) for ratio, record in zip(_RATIOS, records, strict=True)]
        most = max(most, *(abs(rate - 1.0) - part for rate in rates[-2:]))
        added = max(added, float(free.rates[0]) / omega - _ADDED * part)
    told = f"{', '.join(f'{rate:.3g}' for rate in rates)} times the right decay, by two dampings at each resolution"
    if most > _OF_RATE:
        raise Fault(told, "look at its unit, its law, for a factor of 2, and what the number of pieces does to it")
    if bench.claims and added > _LEAST:
        raise Fault(f"without damping it decays as with a damping ratio of {added:.2g}", "the integrator adds it: take smaller steps")
    return told


def strains(bench: Bench) -> str:
    """Check where the three strains come to rest."""
    if isinstance(bench.engine, RodEngine):
        return "they are differences of the rod's points, which the sags and frequencies hold"
    run, times = bench.run(Motion(CLAMPED, _DURATION)), list[float]()
    for k, place in enumerate(_BEAM.strain_gauges, 1):
        right = _WEIGHT * (_BEAM.length - place) ** 2 / 2.0 / _BEAM.bending_stiffness * _BEAM.extreme_fibre
        times.append(ring(run[f"strain_{k}"], OUTPUT_STEP).rest / right)
    told = ", ".join(f"{each:.4g}" for each in times)
    if np.abs(np.array(times) - 1.0).max() > _OF_STRAIN + _claimed(bench, 3.0 * bench.engine.default_accuracy, 0.5):
        cause = f"the strains come to rest at {told} times the closed form"
        raise Fault(cause, "a strain is the curvature times the distance of the surface from the axis of bending, positive where W'' > 0")
    return f"{told} times the closed form"


def acceleration(bench: Bench) -> str:
    """Check that the acceleration of the end, integrated, is the rate of its deflection."""
    run, inner = bench.run(Motion(CLAMPED, _DURATION)), slice(1, -1)  # differences are one-sided at the ends
    velocity = np.gradient(run["tip_deflection"], OUTPUT_STEP)[inner]
    integral = cumulative_trapezoid(run["tip_acceleration"], dx=OUTPUT_STEP, initial=0.0)[inner]
    slope, gravity = float(np.polyfit(run["time"][inner], integral - velocity, 1)[0]), math.hypot(*CLAMPED.gravity)
    if abs(slope) > _OF_GRAVITY * gravity:
        cause = f"tip_acceleration is {slope:.3g} m/s^2 too large on average"
        raise Fault(cause, f"an accelerometer's reading lacks gravity, {gravity:g} m/s^2: add it; or look at its frame")
    if not np.any(velocity):
        raise Fault("tip_deflection does not change", "it is the end's displacement along the base's normal, in m")
    times = float(integral @ velocity / (velocity @ velocity))
    if not _FACTOR[0] < times < _FACTOR[1]:
        cause = f"tip_acceleration is {times:.3g} times the second derivative of tip_deflection"
        raise Fault(cause, "it is that of the end along the rod's normal there, in m/s^2")
    return f"its integral is {times:.3g} times the rate of tip_deflection"


def _sunk(bench: Bench) -> str:
    """Check where a soft strip comes to rest, against `reference`."""
    soft: FollowerAlone = changed(CLAMPED, _SOFT)
    motion = Motion(soft, *_SUNK)
    run, right = bench.run(motion), solution(motion)
    place, right_place = (np.array([columns["tip_x"][-1], columns["tip_y"][-1]]) for columns in (run.columns, right))
    off = float(np.linalg.norm(place - right_place) / np.linalg.norm(right_place - [soft.follower.length, 0.0]))
    if off > 2.0 * float(_FLOOR[0]) + _claimed(bench, bench.engine.default_accuracy, _UNCLAIMED):
        cause = f"the end comes to rest at {place.round(5)} m, that of reference at {right_place.round(5)} m"
        raise Fault(cause, "small deflections are right: look at geometry, as the direction of forces on a bent rod")
    return f"{share_of(off)} off"
