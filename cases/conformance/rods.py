"""Checks of an engine that models a follower alone: a clamped rod that is let go, against closed forms, at three resolutions.

Each record of a free vibration about the sag tells where the rod comes to rest, its frequencies and its decay. What a mistake does to them
together, and how that changes with the resolution, names it.
"""

import contextlib
import dataclasses
import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.optimize import least_squares

from quickreturn.cases.conformance.alone import BARE
from quickreturn.cases.conformance.alone import DURATION as SPIN_UP_DURATION
from quickreturn.cases.conformance.alone import SCENE as SPUN_UP
from quickreturn.cases.conformance.bench import TOLERANCE_FACTOR, Bench, Motion, solution
from quickreturn.cases.conformance.checks import Array, Check, Fault, LeftOut, Unjudged, check_by, ended
from quickreturn.cases.conformance.clamped import Mistake, Ring, Rod, by_piece_words, right, ring, staying_words
from quickreturn.cases.conformance.rod_rows import acceleration, strains
from quickreturn.cases.conformance.scenes import BASE, OUTPUT_STEP, PRESCRIBED
from quickreturn.cases.mistakes.diagnosis import share_of
from quickreturn.cases.mistakes.explanation import Hypothesis, explain
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.scene import check_scene
from quickreturn.engines.settings import Settings, as_texts
from quickreturn.reference_model.mechanism import Base, FollowerAlone, SpinUp
from quickreturn.reference_model.scene_values import changed

#: The mild scene's follower, clamped to a base that is held, and let go from straight: it sinks by 0.4 % of its length.
SCENE: Final = FollowerAlone(spin_up=SpinUp(speed=0.0, time=1.0), base=Base(), follower=BASE.follower, gravity=(0.0, -9.81))
_DURATION: Final = 0.66  # s: eight vibrations
_MASS: Final = 0.1  # kg, hung on the end for a force there: it sinks by 0.6 % of the length more
_RIGHT: Final = right(SCENE.follower, SCENE.gravity[1], _MASS)
_OMEGA: Final = 2.0 * math.pi * float(_RIGHT.frequencies[0])  # rad/s
#: Ratios of the first mode's damping to critical damping that are tried; and the quantity that gives a ratio of one.
_RATIOS: Final = (0.02, 0.08)
_CRITICAL: Final = {
    "follower.material_damping": 2.0 / _OMEGA,
    "follower.damping": 2.0 * _OMEGA * SCENE.follower.mass_per_length,
}
#: A soft strip that sinks by a third of its length and comes to rest; its duration and output step, s.
_SOFT: Final = {"follower.bending_stiffness": 0.55, "follower.damping": 17.0, "tip": None, "tip.mass": _MASS, "tip.inertia": 0.0}
_SUNK: Final = (2.0, 0.01)
#: Accuracies asked of the engine, over its default one, from coarse to fine; and the coarsest one.
_LEVELS: Final = (4.0, 1.0, 0.25)
_COARSEST: Final = 0.3
#: Parts of a sag, and of each frequency, that may be off beside the engine's error: small deflections, the record's length.
_FLOOR: Final = np.array([0.003, 0.003, 0.003, 0.006, 0.02])
#: Error of each over that of the tip deflection; and what an engine without a claim may be off.
_HARDER: Final = np.array([1.0, 1.0, 1.0, 2.0, 3.0])
_UNCLAIMED: Final = 0.3 * _HARDER
#: Part by which a rate of decay may be off beside the engine's error, and damping ratio of an integrator, over the engine's error.
_OF_RATE: Final = 0.05
_ADDED: Final = 0.1
#: Smallest part that is named as a mistake though the engine's claim covers it; largest spread of rates that depend on the mesh alike.
_NAMED: Final = 0.01
_ALIKE: Final = 0.25
#: Number of pieces at which an error in proportion to one is looked at: it is small there.
_FINELY: Final = 100.0
#: Least ratio of the numbers of pieces by which a dependence on the mesh is seen.
_APART: Final = 1.2
#: Part by which damping may change the sag.
_SOFTER: Final = 0.02
_UNDAMPED: Final = "no damping"
_MEND: Final = "mend that first"


@dataclass(frozen=True)
class Level:
    """What the engine's rod shows with some settings."""

    settings: Settings
    accuracy: float  # asked of them
    rod: Rod
    rate: float  # of decay without damping, 1/s
    damped: dict[str, tuple[Ring, ...]]  # by the quantity: records with each of `_RATIOS`

    @property
    def off(self) -> Array:
        """Relative errors: of the sags under weight and force, of the frequencies."""
        return self.rod.over(_RIGHT) - 1.0


def motion_alone(engine: AnyEngine) -> Motion | None:
    """The motion in which an engine is tried that refuses the mechanism and models a follower alone; None for any other engine."""
    for scene in (BASE, PRESCRIBED, SPUN_UP, BARE, SCENE):
        try:
            check_scene(engine, scene)
        except Refusal:
            continue
        except Exception:  # an author's engine may raise anything: the checks of its motion tell
            return None
        return Motion(scene, SPIN_UP_DURATION) if scene.crank is None else None
    return None


def rods(bench: Bench) -> Iterator[Check]:
    """All checks of a clamped rod."""
    try:
        check_scene(bench.engine, SCENE)
        levels = _levels(bench)
    except Refusal as refusal:
        yield Check("rod: sag and vibration", "not judged", f"refused: {refusal}", "without gravity nothing bends a clamped rod")
        return
    except (EngineFailure, Fault) as error:
        yield ended("rod: sag and vibration", error)
        return
    checks = [check_by("rod: sags and frequencies together", _together, bench, levels)]
    if checks[0].status == "passed":
        parts = enumerate(("sag under its weight", "sag by a force at its end", "three frequencies"))
        checks = [check_by(f"rod: {what}", _sizes, bench, levels, look) for look, what in parts]
    yield from checks
    wrong = any(check.status == "failed" for check in checks)
    for quantity in _CRITICAL:
        yield check_by(f"rod: decay by {quantity}", _decay, bench, levels, quantity, wrong)
    if wrong:
        yield Check(
            "rod: strains, tip_acceleration and large deflections", "not judged", "its sags or frequencies are wrong already", _MEND
        )
        return
    for name, rows in (("strains at rest", strains), ("tip_acceleration", acceleration)):
        yield check_by(f"rod: {name}", rows, bench, Motion(SCENE, _DURATION, OUTPUT_STEP))
    yield check_by("rod: sag beyond small deflections", _sunk, bench)


def _levels(bench: Bench) -> list[Level]:
    """The rod at the engine's coarse, default and fine resolution, each once. Raises Fault: it does not come back."""
    levels, engine = list[Level](), bench.engine
    for times in _LEVELS:
        accuracy = min(times * engine.default_accuracy, max(_COARSEST, engine.default_accuracy))
        settings = engine.settings_for(accuracy, SCENE)
        with contextlib.suppress(LeftOut) if levels else contextlib.nullcontext():  # where time is short, one resolution has to do
            if all(level.settings != settings for level in levels):
                levels.append(_level(bench, settings, accuracy))
    return levels


def _level(bench: Bench, settings: Settings, accuracy: float) -> Level:
    def record(scene: FollowerAlone, damping: str = _UNDAMPED) -> Ring:
        try:
            run = bench.run(Motion(scene, _DURATION, OUTPUT_STEP), settings)
        except EngineFailure as failure:
            told = ", ".join(f"{name}={text}" for name, text in as_texts(settings.as_dict()).items())
            raise replace(failure, cause=f"{failure.cause}, with {told} and {damping}") from failure
        earlier, later = np.array_split(np.abs(run["tip_deflection"]), 2)
        if damping == _UNDAMPED and later.min() > earlier.max() and later[-1] == later.max():
            cause = f"in {_DURATION:g} s the rod does not come back; a right one vibrates eight times"
            raise Fault(cause, "its stiffness is far too small, its mass too large, or the integrator adds damping")
        found = ring(run["tip_deflection"], OUTPUT_STEP)
        if not len(found.frequencies):
            return replace(found, rest=float(np.mean(run["tip_deflection"][-len(run) // 4 :])))
        return found

    free, force = record(SCENE), math.nan
    with_mass = changed(SCENE, {"tip": None, "tip.mass": _MASS, "tip.inertia": 0.0})
    try:
        check_scene(bench.engine, with_mass)
        force = record(with_mass).rest - free.rest
    except Refusal:
        pass
    damped = dict[str, tuple[Ring, ...]]()
    for quantity, critical in _CRITICAL.items():
        scenes = [changed(SCENE, {quantity: ratio * critical}) for ratio in _RATIOS]
        try:
            for scene in scenes:
                check_scene(bench.engine, scene)
        except Refusal:
            continue
        damped[quantity] = tuple(record(scene, f"a damping ratio of {ratio:g}") for ratio, scene in zip(_RATIOS, scenes, strict=True))
    rate = float(free.rates[0]) if len(free.rates) else math.nan
    length = float(bench.run(Motion(SCENE, _DURATION, OUTPUT_STEP), settings)["tip_x"][0])
    return Level(settings, accuracy, Rod(free.rest, force, free.frequencies, length), rate, damped)


def _default(bench: Bench, levels: list[Level]) -> Level:
    return next((level for level in levels if level.accuracy == bench.engine.default_accuracy), levels[-1])


def _allowed(bench: Bench, levels: list[Level], level: Level) -> Array:
    """Parts that each size may be off: the engine's claim, or the change to its next finer resolution."""
    n = len(level.off)
    if not bench.claims:
        return _FLOOR[:n] + _UNCLAIMED[:n]
    k = levels.index(level)
    other = levels[k + 1] if k + 1 < len(levels) else levels[max(k - 1, 0)]
    n = min(n, len(other.off))
    shown = np.abs(other.off[:n] - level.off[:n])
    allowed: Array = _FLOOR[:n] + TOLERANCE_FACTOR * np.maximum(level.accuracy * _HARDER[:n], np.nan_to_num(shown))
    return allowed


def _sizes(bench: Bench, levels: list[Level], first: int) -> str:
    """Check a sag (0, 1), or the frequencies (2), at each level."""
    worst = list[str]()
    for level in levels:
        off, allowed = level.off[first : first + 1 if first < 2 else None], _allowed(bench, levels, level)
        allowed = allowed[first : first + 1 if first < 2 else None]
        off = off[: len(allowed)]
        if first == 1 and np.isnan(off).any():
            return "refused: a mass at the end"
        if first == 2 and not len(off):
            raise Fault("the rod does not vibrate when it is let go", "an undamped one vibrates for ever: look at stiffness and integrator")
        if (np.abs(off) > allowed).any():
            k = int(np.argmax(np.abs(off) / allowed))
            what = ("its sag", "its sag", f"frequency {k + 1}")[first]
            cause = f"{what} is {1.0 + off[k]:.4g} times the closed form, at an accuracy of {share_of(level.accuracy)}"
            raise Fault(cause, "hold stiffness, mass and length of the rod against the closed form")
        worst.append(share_of(float(np.max(np.abs(off)))))
    return f"from coarse to fine off by {', '.join(worst)}"


def pieces(levels: list[Level]) -> Array | None:
    """Number of segments, elements or links at each level: the first whole-numbered setting that grows; None if there is none."""
    for name in (each.name for each in dataclasses.fields(levels[0].settings)):
        values = [getattr(level.settings, name) for level in levels]
        if all(isinstance(value, int) and not isinstance(value, bool) for value in values) and values[-1] > _APART * values[0]:
            return np.array(values, dtype=float)
    return None


def _fitted(shown: Array, kind: str) -> tuple[float, Array]:
    """The amount of one mistake that comes nearest to `Rod.decisive`, and what that would be with it."""
    neutral, seen = getattr(Mistake(), kind), np.isfinite(shown)

    def gone(x: float) -> Array:
        rod = Mistake(**{kind: neutral * math.exp(x) if neutral else x})
        return rod.acts(SCENE.follower, SCENE.gravity[1], _MASS).decisive(_RIGHT)

    found = least_squares(lambda x: (gone(float(x[0])) - shown)[seen], [0.0], bounds=(-3.0, 3.0) if neutral else (-0.2, 3.0), xtol=1e-10)
    x = float(found.x[0])
    return neutral * math.exp(x) if neutral else x, gone(x)


def _trends(levels: list[Level], default: Level) -> Iterator[tuple[Array, bool]]:
    """Errors of `Rod.decisive` that stay however fine the resolution is, then those in proportion to a piece's length; whether by piece.

    An error is c + a / N + b / N^2. Where the number of pieces is unknown, all of the default level's error may be one that stays.
    """
    n, shown = pieces(levels), np.array([level.rod.decisive(_RIGHT) for level in levels])
    if n is None or len(n) < len(_LEVELS):
        yield shown[levels.index(default)], False
        return
    terms = np.linalg.solve(np.array([np.ones(3), 1.0 / n, 1.0 / n**2]).T, np.nan_to_num(shown))
    staying = np.where(np.isfinite(shown).all(axis=0), terms[0], np.nan)
    first = (shown[2] * n[2] ** 2 - shown[1] * n[1] ** 2) / (n[2] - n[1])
    for part, by_piece, fine in ((staying, False, staying), (first / _FINELY, True, first / n[2])):
        large = np.nanmax(np.abs(first / n[1] if by_piece else staying)) > _NAMED
        if large and np.nanmax(np.abs(shown[2])) > 0.4 * np.nanmax(np.abs(fine)):
            yield part, by_piece


def _together(bench: Bench, levels: list[Level]) -> None:
    """Name the one mistake that explains sags and frequencies at all levels, if there is one."""
    default = _default(bench, levels)
    allowed = _allowed(bench, levels, default)
    beyond = bool((np.abs(default.off[: len(allowed)]) > allowed).any())
    for shown, by_piece in _trends(levels, default):
        seen = np.isfinite(shown)
        if seen.sum() < 3 or np.max(np.abs(shown[seen])) < (0.0 if by_piece else _NAMED):
            continue
        hypotheses = list[Hypothesis]()
        for kind in (field.name for field in dataclasses.fields(Mistake)):
            amount, predicted = _fitted(shown, kind)
            words, advice = by_piece_words(kind, amount, _FINELY) if by_piece else staying_words(kind, amount, SCENE.follower)
            hypotheses.append(Hypothesis(words, advice, predicted[seen], fitted=1))
        explained = explain(shown[seen], 0.0 * shown[seen], hypotheses)
        if explained is not None and (beyond or len(levels) == len(_LEVELS)):
            told = ", ".join(f"{1.0 + value:.4g}" for value in default.off if math.isfinite(value))
            raise Fault(f"{explained.words} (sags and frequencies are {told} times the closed forms)", explained.advice)


def _spread(values: Array) -> float:
    """Spread of numbers over the size of the largest."""
    return float(np.ptp(values) / max(np.max(np.abs(values)), 1e-12)) if np.isfinite(values).all() else math.inf


def _decay(bench: Bench, levels: list[Level], quantity: str, wrong: bool) -> str:
    """Check the decay of the first mode with two dampings, at each level, and that damping leaves the stiffness."""
    if quantity not in levels[-1].damped:
        return "refused"
    rates, added = list[float](), list[float]()
    for level in levels:
        if level.rod.weight == 0.0:
            raise Unjudged("without damping no sag is seen, whatever it vibrates", _MEND)
        records = level.damped[quantity]
        for ratio, record in zip(_RATIOS, records, strict=True):
            softer = record.rest / level.rod.weight
            if abs(softer - 1.0) > _SOFTER + (level.accuracy if bench.claims else 0.1):
                lost = "lost" if softer > 1.0 else "added"
                cause = f"stiffness is {lost} with damping: with a damping ratio of {ratio:g} the sag is {softer:.3g} times that without"
                raise Fault(cause, "damping changes no sag: look what it replaces or adds")
        if wrong or not all(len(record.rates) for record in records):
            continue
        omega = 2.0 * math.pi * float(level.rod.frequencies[0])
        of_both = [(record.rates[0] - level.rate) / (ratio * omega) for ratio, record in zip(_RATIOS, records, strict=True)]
        if _spread(np.array(of_both)) > _ALIKE + (TOLERANCE_FACTOR * level.accuracy if bench.claims else 1.0):
            both = " and ".join(f"{each:.3g}" for each in of_both)
            raise Fault(
                f"with damping ratios of 0.02 and 0.08 it decays {both} times as fast as it should", "damping is linear: look at its law"
            )
        rates.append(float(np.mean(of_both)))
        added.append(level.rate / omega)
    if wrong:
        raise Unjudged("its stiffness or mass is wrong already", _MEND)
    if len(rates) < len(levels):
        raise Fault("with damping the rod does not vibrate", "a damping ratio of 0.08 leaves twelve vibrations: look at its unit")
    n, off = pieces(levels), np.array(rates)
    told = ", ".join(f"{rate:.3g}" for rate in rates)
    if n is not None and np.max(np.abs(off - 1.0)) > 2.0 * _OF_RATE:
        for power, words in ((1.0, "grows with the number of pieces"), (-1.0, "falls with the number of pieces")):
            if _spread(off * n**-power) < _ALIKE and _spread(off) > _ALIKE / 2.0:
                advice = "a joint between pieces of the length h has EI eta / h, a node c h"
                raise Fault(f"the damping {words}: {told} times the right one with {', '.join(f'{each:.0f}' for each in n)}", advice)
    for level, rate, extra in zip(levels, rates, added, strict=True):
        part = TOLERANCE_FACTOR * level.accuracy if bench.claims else 0.9
        if abs(rate - 1.0) > _OF_RATE + part and (bench.claims or abs(rate) < 0.02 or _spread(off) < _ALIKE):
            cause = f"the first mode decays {rate:.3g} times as fast as it should (at {len(rates)} resolutions: {told})"
            raise Fault(cause, "look at its unit, and for a factor of 2")
        if bench.claims and extra > 1e-3 + _ADDED * part:
            raise Fault(f"without damping it decays as with a damping ratio of {extra:.2g}", "the integrator adds it: take smaller steps")
    return f"{told} times the closed form at {len(levels)} resolutions"


def _sunk(bench: Bench) -> str:
    """Check where a soft strip comes to rest, against `reference`."""
    soft = changed(SCENE, _SOFT)
    check_scene(bench.engine, soft)
    motion = Motion(soft, *_SUNK)
    run, known = bench.run(motion), functools.partial(lambda name: float(solution(motion)[name][-1]))
    size = math.hypot(known("tip_x") - soft.follower.length, known("tip_y"))
    off = math.hypot(*(float(run[name][-1]) - known(name) for name in ("tip_x", "tip_y"))) / size
    if off > (2.0 * float(_FLOOR[0]) + TOLERANCE_FACTOR * bench.engine.default_accuracy if bench.claims else 0.3):
        place = ", ".join(f"{float(run[name][-1]):.5g}" for name in ("tip_x", "tip_y"))
        right_place = ", ".join(f"{known(name):.5g}" for name in ("tip_x", "tip_y"))
        cause = f"the end comes to rest at ({place}) m, that of reference at ({right_place}) m"
        raise Fault(cause, "small deflections are right: look at geometry, as the direction of forces on a bent rod")
    return f"{share_of(off)} off"
