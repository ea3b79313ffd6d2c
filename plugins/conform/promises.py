"""Checks of what an engine says of itself: its ladder, its estimates, its natural frequencies with the crank held."""

import itertools
import math
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np

from quickreturn.cases.files.case_file import load_case
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.relative import relative_error, rms
from quickreturn.engines.settings import Settings
from quickreturn.engines.simple import SimpleEngine, SimpleSettings
from quickreturn.plugins.conform.bench import (
    MEND_FIRST,
    Array,
    Bench,
    Check,
    Fault,
    Motion,
    Truth,
    Unjudged,
    check_by,
    share_of,
    solution,
    truth,
)
from quickreturn.plugins.conform.columns import examined
from quickreturn.plugins.conform.quantities import with_everything
from quickreturn.plugins.conform.scenes import OUTPUT_STEP
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes

#: Largest number of rungs of a ladder.
_MOST_RUNGS: Final = 200
#: Accuracy of coarse settings, or the engine's default if that is coarser.
_COARSE: Final = 0.05
#: Number of rungs that are run, the same while none is better, because neighbours may be equally good by chance; and solve time, s, after
#: which no finer rung is run.
_RUN: Final = 3
_AT_MOST: Final = 5
_SLOW: Final = 5.0
#: Largest ratio of an error to its estimate, by what the estimate covers: errors of an integration with adaptive steps scatter.
_MISSED: Final = {"total": 1.5, "integration": 2.5}
#: Logarithm of a ratio of errors from which it shows which of two runs is finer.
_CLEARLY: Final = math.log(2.5)
#: Largest ratio of a finer rung's error to a coarser one's, some of which are better by chance; and of the finest one's to the coarsest's.
_WORSE: Final = 1.1
_BETTER: Final = 0.9
#: Smaller relative errors of the tip deflection are not compared: they are errors of the integration.
_NOISE: Final = 5e-5
#: Case and duration, s, for which the errors of a `SimpleEngine` are stated; longest wall time, s, and largest ratio to the stated error.
_MEASURED_IN: Final = "thesis-24"
_MEASURED_OVER: Final = 2.0
_AFFORDABLE: Final = 60.0
_UNDERSTATED: Final = 1.5

#: Number of frequencies, and crank angles, deg, that are compared.
_COUNT: Final = 3
_ANGLES: Final = (180.0, 90.0, 0.0)
#: Relative tolerance of each frequency: `_FLOOR` plus `_REFINED` times the change by finer settings, at most `_MOST` ...
_FLOOR: Final = np.array([0.005, 0.015, 0.04])
_REFINED: Final = 3.0
_MOST: Final = 0.6
#: ... or this, if the engine makes no claim or states an error of 30 %: one cubic is 12 to 16 % too high in the first, two modes that are
#: right in the first are 20 to 60 % off in the next. For a smaller stated error it is in proportion.
_UNCLAIMED: Final = np.array([0.3, 0.6, 0.9])
_RETURN: Final = "return an ascending array of at most `count` finite, positive frequencies"


def ladder(bench: Bench) -> Iterator[Check]:
    """All checks of the ladder."""
    accuracy = sorted((_COARSE, bench.engine.default_accuracy))
    fine, coarse = (bench.engine.settings_for(each, bench.scene) for each in accuracy)
    default = bench.settings(bench.scene)
    yield check_by("ladder: ends", _ends, bench, coarse)
    yield check_by("ladder: gets finer", _gets_finer, bench, coarse, default, fine)
    for words, settings in {"coarse settings": coarse, "default settings": default}.items():
        if words == "default settings" or settings != default:
            yield check_by(f"estimates hold, {words}", _estimates, bench, settings)
    if isinstance(bench.engine, SimpleEngine):
        yield check_by("ladder: stated errors", stated_errors, bench.engine)


def _ends(bench: Bench, settings: Settings) -> str:
    seen = [settings]
    while len(seen) < _MOST_RUNGS:
        finer = bench.finer(bench.scene, seen[-1])
        if finer is None:
            return f"after {len(seen)} rungs"
        if finer in seen:
            raise Fault(f"`finer` gives back earlier settings: {finer}", "return finer settings, or None at the end of the ladder")
        seen.append(finer)
    raise Fault(f"`finer` has gone on for {_MOST_RUNGS} rungs, to {seen[-1]}", "return None where a finer rung is not affordable")


def _truth(bench: Bench) -> Truth:
    """The solution of the scene; for an engine whose discretization is its model, the solution of its own equations."""
    if bench.engine.estimates != "integration":
        return truth(bench.mild)
    settings = bench.settings(bench.scene)
    for _ in range(_RUN):
        settings = bench.finer(bench.scene, settings) or settings
    return Truth(bench.run(bench.mild, settings).columns, {})


def _error(bench: Bench, settings: Settings) -> float:
    """Relative error of the tip deflection."""
    right = _truth(bench).columns["tip_deflection"]
    return rms(bench.run(bench.mild, settings)["tip_deflection"] - right) / (rms(right) or 1.0)


def _better(errors: list[float]) -> bool:
    """Whether the finest rung is better than the coarsest, or that is too good to be improved."""
    return errors[-1] <= _BETTER * errors[0] or errors[0] <= _NOISE


def climb(bench: Bench, settings: Settings, most: int = _AT_MOST) -> tuple[list[float], bool]:
    """Errors of the tip deflection from rung to rung, and whether a rung that takes long ended them."""
    errors = [_error(bench, settings)]
    while len(errors) < _RUN or (len(errors) < most and not _better(errors)):
        finer = bench.finer(bench.scene, settings)
        if finer is None:
            break
        if bench.run(bench.mild, settings).solve_seconds > _SLOW:
            return errors, True
        settings = finer
        errors.append(_error(bench, settings))
    return errors, False


def _gets_finer(bench: Bench, coarse: Settings, default: Settings, fine: Settings) -> str:
    """Check that errors fall from the coarse settings on and above the default ones, and that a smaller accuracy gives finer settings."""
    (errors, slow), (above, _), picked = climb(bench, coarse), climb(bench, default, _RUN), _error(bench, fine)
    told = f"errors of the tip deflection from rung to rung are {_listed(errors)}, above the default {_listed(above)}"
    if any(
        after > max(_WORSE * before, 0.3 * errors[0], _NOISE) for rungs in (errors, above) for before, after in itertools.pairwise(rungs)
    ):
        raise Fault(f"`finer` makes it coarser: {told}", "return settings with a smaller error; look at the direction of steps and sizes")
    if picked > max(_WORSE * errors[0], _NOISE):
        cause = f"`settings_for` gives coarser settings for a smaller accuracy: errors {picked:.2g}, {errors[0]:.2g}"
        raise Fault(cause, "look at the direction of the table behind settings_for")
    if len(errors) > 1 and _better(errors):
        return told
    if len(errors) == 1 or slow or "tip_deflection" in examined(bench, bench.mild).wrong:
        raise Unjudged(f"{told}; there is no other rung, it takes long, or the tip deflection is wrong already", MEND_FIRST)
    raise Fault(f"finer rungs are no better: {told}", "the error is not that of the resolution; compare a fine run with reference")


def _listed(errors: list[float]) -> str:
    return ", ".join(f"{error:.2g}" for error in errors)


def _estimates(bench: Bench, settings: Settings) -> str:
    of, mild = bench.engine.estimates, examined(bench, bench.mild)
    if of == "unverified":
        raise Unjudged("the engine states that its estimates are not verified")
    estimates = bench.estimates(bench.mild, settings)
    if estimates is None:
        raise Unjudged(f"no estimate can be made of {settings}", "let `comparisons` name a run that is not the same and completes")
    right, run = _truth(bench), bench.run(bench.mild, settings)
    if of == "integration" and _error(bench, settings) < _NOISE:
        return "the integration's error is too small to be measured"
    missed = dict[str, float]()
    for name in ESTIMATED:
        size, error = rms(right.columns[name]), rms(run[name] - right.columns[name])
        if (
            name not in mild.wrong
            and error > _MISSED[of] * estimates[name] + 3.0 * right.uncertainty.get(name, 0.0)
            and error > _NOISE * size
        ):
            missed[name] = error / max(estimates[name], 1e-300)
    pairs = bench.engine.comparisons(settings, bench.scene, OUTPUT_STEP)
    told = "; ".join(f"factor {pair.factor:.3g}, errors are in a ratio of {_ratio(bench, pair.run, pair.other):.3g}" for pair in pairs)
    ratio = math.log(_ratio(bench, pairs[0].run, pairs[0].other)) if len(pairs) == 1 and _error(bench, settings) > _NOISE else 0.0
    upside_down = abs(ratio) > _CLEARLY and ratio * math.log(pairs[0].factor) < 0.0
    if missed and mild.motion:
        raise Unjudged("the motion is wrong already", MEND_FIRST)
    if missed or upside_down:
        worst = max(missed, key=lambda name: missed[name], default="")
        cause = f"{worst} is off by {missed[worst]:.3g} times its estimate" if missed else "the factor is on the wrong side of 1"
        cause += f" ({told})"
        raise Fault(cause, "state the factor that runs show: error of `other` over that of `run`, on the safe side")
    size = rms(right.columns["tip_deflection"]) or 1.0
    return f"error {_error(bench, settings):.2g}, estimate {estimates['tip_deflection'] / size:.2g}"


def _ratio(bench: Bench, run: Settings, other: Settings) -> float:
    """Error of the tip deflection with other settings over that with some settings."""
    return _error(bench, other) / max(_error(bench, run), 1e-300)


def stated_errors(engine: SimpleEngine) -> str:
    """Check the stated error of the coarsest resolution, in run 24 over two seconds as `SimpleEngine.errors` are defined."""
    resolution, stated = min(engine.errors.items())
    scene = load_case(_MEASURED_IN).mechanism
    engine.check(scene)
    settings = SimpleSettings(resolution=resolution, tolerance=engine.settings_for(stated, scene).tolerance)
    motion, began = Motion(scene, _MEASURED_OVER), time.monotonic()
    replace(motion, duration=0.05 * _MEASURED_OVER).by(engine, settings)
    if 20.0 * (time.monotonic() - began) > _AFFORDABLE:
        raise Unjudged(f"to measure one takes more than {_AFFORDABLE:g} s", "measure them as docs/engine.md does")
    measured = relative_error(motion.by(engine, settings)["tip_deflection"], solution(motion)["tip_deflection"])
    if measured > _UNDERSTATED * stated:
        cause = f"`errors` states {stated:.2g} for resolution {resolution}, measured in {_MEASURED_IN} it is {measured:.2g}"
        raise Fault(cause, "measure `errors` as docs/engine.md does, all of them")
    return f"resolution {resolution}: {stated:.2g} is stated, {measured:.2g} measured"


def frequencies(bench: Bench) -> Iterator[Check]:
    """The check of natural frequencies."""
    yield check_by("frequencies", _frequencies, bench)


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


def _frequencies(bench: Bench) -> str:
    """Check the frequencies against those of the model by `reference`; gravity and damping do not change them."""
    worst, finer = 0.0, bench.settings(bench.scene)
    scene, _ = with_everything(bench, bench.scene, ({"mechanism.gravity": (0.0, 30.0)}, {"follower.damping": 30.0}))
    for _ in range(_RUN):  # the next rungs may be finer in time alone
        finer = bench.engine.finer(finer, {}, OUTPUT_STEP) or finer
    for degrees in _ANGLES:
        given, one = _given(bench, scene, degrees), _given(bench, scene, degrees, 1)
        if given.ndim != 1 or len(given) > _COUNT or len(one) > 1 or not (np.diff(given, prepend=0.0) >= 0.0).all() or not given[0] > 0.0:
            raise Fault(f"when {_COUNT} or 1 are asked for, they are {given} and {one}", _RETURN)
        count = len(given)
        ratio = given / frozen_crank_modes(bench.scene, math.radians(degrees), count).frequencies
        allowed: Array = _UNCLAIMED[:count]
        if bench.claims:
            better = _given(bench, bench.scene, degrees, settings=finer)[:count]
            shown = np.abs(better / given - 1.0) if len(better) == count else np.zeros(count)
            stated = min(bench.engine.default_accuracy / float(_UNCLAIMED[0]), 1.0) * allowed
            allowed = np.maximum(np.minimum(_FLOOR[:count] + _REFINED * shown, _MOST), stated)
        if not (np.abs(ratio - 1.0) <= allowed).all():
            told = ", ".join(f"{each:.4g}" for each in ratio)
            advice = "they are in Hz, of the straight follower at rest, undamped, without gravity, the crank held at `crank_angle`, in rad"
            raise Fault(f"with the crank at {degrees:g} deg they are {told} times those of reference", advice)
        worst = max(worst, float(np.abs(ratio - 1.0).max()))
    return f"up to {share_of(worst)} off"
