"""Checks of an engine that models a follower alone: a clamped rod that is let go, against closed forms, at three resolutions.

Each record of a free vibration about the sag shows where the rod comes to rest, its frequencies and its decay.
"""

import contextlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.integrate import cumulative_trapezoid

from quickreturn.engines.base import Refusal
from quickreturn.engines.rod import RodEngine
from quickreturn.engines.settings import Settings
from quickreturn.plugins.conform.bench import TOLERANCE_FACTOR, Bench, Check, Fault, Motion, check_by, solution
from quickreturn.plugins.conform.scenes import CLAMPED, OUTPUT_STEP
from quickreturn.reference_model.arrays import Array
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
_RATE_UNCLAIMED: Final = 0.9
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
        yield Check("rod: decay, columns and large deflections", "not judged", "its sags or frequencies are wrong already")
        return
    for quantity, critical in _CRITICAL.items():
        yield check_by(f"rod: decay by {quantity}", _decay, bench, quantity, critical)
    yield check_by("rod: strains at rest", strains, bench)
    yield check_by("rod: tip_acceleration", acceleration, bench)
    yield check_by("rod: sag beyond small deflections", _sunk, bench)


def _levels(bench: Bench) -> dict[Settings, float]:
    """Settings from coarse to fine, each once, and the relative error that each may have: as claimed."""
    default, levels = bench.engine.default_accuracy, dict[Settings, float]()
    for times in _LEVELS:
        accuracy = min(times * default, max(_COARSEST, default))
        levels.setdefault(bench.engine.settings_for(accuracy, CLAMPED), _claimed(bench, accuracy))
    return levels


def _claimed(bench: Bench, accuracy: float) -> float:
    """Tolerance of a relative error with settings for an accuracy."""
    return TOLERANCE_FACTOR * accuracy if bench.claims else _UNCLAIMED


def _record(bench: Bench, settings: Settings, changes: Mapping[str, float | None]) -> Ring:
    """The vibration with changes of the scene. Refusal, EngineFailure: there is none."""
    deflection = bench.run(Motion(changed(CLAMPED, changes), _DURATION), settings)["tip_deflection"]
    found = ring(deflection, OUTPUT_STEP)
    return found if len(found.frequencies) else replace(found, rest=float(np.mean(deflection[-len(deflection) // 4 :])))


def _sizes(bench: Bench) -> None:
    """Check sags and frequencies at each resolution, over the closed forms; nan for what is not there."""
    levels, overs = _levels(bench), list[Array]()
    for settings in levels:
        free, over = _record(bench, settings, {}), np.full(len(_RIGHT), math.nan)
        with contextlib.suppress(Refusal):
            over[1] = _record(bench, settings, {"tip": None, "tip.mass": _MASS, "tip.inertia": 0.0}).rest - free.rest
        over[0], over[2 : 2 + len(free.frequencies)] = free.rest, free.frequencies
        overs.append(over / _RIGHT)
    for k, (over, claimed) in enumerate(zip(overs, levels.values(), strict=True)):
        allowed = _FLOOR + claimed * _HARDER
        if len(overs) > 1:  # higher frequencies may not be there, or not be heard
            allowed[3:] += TOLERANCE_FACTOR * np.nan_to_num(np.abs(over - overs[k + 1 if k + 1 < len(overs) else k - 1])[3:], nan=1.0)
        if math.isnan(over[2]) or (np.abs(over - 1.0) > allowed).any():
            listed = ", ".join(f"{name} {times:.4g}" for name, times in zip(_NAMES, over, strict=True) if not math.isnan(times))
            raise Fault(f"times the closed forms, at resolution {k + 1} of {len(overs)}: {listed}{', no vibration' * math.isnan(over[2])}")


def _decay(bench: Bench, quantity: str, critical: float) -> None:
    """Check the decay of the first mode with two dampings, at each resolution, and that damping leaves the sag."""
    for settings, claimed in _levels(bench).items():
        free = _record(bench, settings, {})
        omega = 2.0 * math.pi * free.frequencies[0]
        for ratio in _RATIOS:
            record = _record(bench, settings, {quantity: ratio * critical})
            if abs(record.rest / free.rest - 1.0) > _SOFTER + claimed / TOLERANCE_FACTOR:
                raise Fault(f"with a damping ratio of {ratio:g} the sag is {record.rest / free.rest:.3g} times that without")
            if not len(record.rates):
                raise Fault("with damping the rod does not vibrate: a damping ratio of 0.08 leaves twelve vibrations")
            rate = float(record.rates[0] - free.rates[0]) / (ratio * omega)
            if abs(rate - 1.0) > _OF_RATE + (claimed if bench.claims else _RATE_UNCLAIMED):
                raise Fault(f"a damping ratio of {ratio:g} has {rate:.3g} times the right decay with {settings}")
        if bench.claims and free.rates[0] / omega > _LEAST + _ADDED * claimed:
            raise Fault(f"without damping it decays as with a damping ratio of {free.rates[0] / omega:.2g}: the integrator adds it")


def strains(bench: Bench) -> None:
    """Check where the three strains come to rest; of a `RodEngine` they are differences of points, which the sags and frequencies hold."""
    if isinstance(bench.engine, RodEngine):
        return
    run, places = bench.run(Motion(CLAMPED, _DURATION)), np.array(_BEAM.strain_gauges)
    rest = np.array([ring(run[f"strain_{k}"], OUTPUT_STEP).rest for k in (1, 2, 3)])
    times = rest / (_WEIGHT * (_BEAM.length - places) ** 2 / 2.0 / _BEAM.bending_stiffness * _BEAM.extreme_fibre)
    if np.abs(times - 1.0).max() > _OF_STRAIN + 3.0 * _claimed(bench, bench.engine.default_accuracy):
        raise Fault(f"the strains come to rest at {', '.join(f'{each:.4g}' for each in times)} times the closed form")


def acceleration(bench: Bench) -> None:
    """Check that the acceleration of the end, integrated, is the rate of its deflection."""
    run, inner = bench.run(Motion(CLAMPED, _DURATION)), slice(1, -1)  # differences are one-sided at the ends
    velocity = np.gradient(run["tip_deflection"], OUTPUT_STEP)[inner]
    integral = cumulative_trapezoid(run["tip_acceleration"], dx=OUTPUT_STEP, initial=0.0)[inner]
    slope, gravity = float(np.polyfit(run["time"][inner], integral - velocity, 1)[0]), math.hypot(*CLAMPED.gravity)
    if abs(slope) > _OF_GRAVITY * gravity:
        raise Fault(
            f"tip_acceleration is {slope:.3g} m/s^2 too large on average; an accelerometer's reading lacks gravity, {gravity:g} m/s^2"
        )
    times = float(integral @ velocity / (velocity @ velocity or math.inf))
    if not _FACTOR[0] < times < _FACTOR[1]:
        raise Fault(f"tip_acceleration is {times:.3g} times the second derivative of tip_deflection, along the rod's normal at its end")


def _sunk(bench: Bench) -> None:
    """Check where a soft strip comes to rest, against `reference`."""
    soft: FollowerAlone = changed(CLAMPED, _SOFT)
    motion = Motion(soft, *_SUNK)
    place, right = (np.array([columns["tip_x"][-1], columns["tip_y"][-1]]) for columns in (bench.run(motion).columns, solution(motion)))
    off = float(np.linalg.norm(place - right) / np.linalg.norm(right - [soft.follower.length, 0.0]))
    if off > 2.0 * float(_FLOOR[0]) + _claimed(bench, bench.engine.default_accuracy):
        raise Fault(f"the end comes to rest at {place.round(5)} m, that of reference at {right.round(5)} m; small deflections are right")
