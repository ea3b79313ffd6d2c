"""Checks of what an engine says of itself: its ladder, its estimates, its natural frequencies with the crank held."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from quickreturn.cases.library import load_case
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.settings import Settings
from quickreturn.engines.simple import SimpleEngine, SimpleSettings
from quickreturn.engines.trajectory import relative_error, rms
from quickreturn.plugins.conform.bench import Bench, Check, Fault, Motion, Unjudged, check_by, solution, uncertainty
from quickreturn.plugins.conform.columns import examined
from quickreturn.plugins.conform.quantities import with_everything
from quickreturn.plugins.conform.scenes import OUTPUT_STEP
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes

#: Largest number of rungs of a ladder.
_MOST_RUNGS: Final = 200
#: Accuracy of coarse settings, or the engine's default if that is coarser.
_COARSE: Final = 0.05
#: Number of rungs that are run at most while none is better, because neighbours may be equally good by chance; and solve time, s, after
#: which no finer rung is run.
_AT_MOST: Final = 5
_SLOW: Final = 5.0
#: Largest ratio of an error to its estimate, by what the estimate covers: errors of an integration with adaptive steps scatter.
_MISSED: Final = {"total": 1.5, "integration": 2.5}
#: Logarithm of a ratio of errors from which it shows which of two runs is finer.
_CLEARLY: Final = math.log(2.5)
#: Ratios of the errors of a finer and a coarser run: it is better; it is worse, for settings of a smaller accuracy; any rung is worse.
_BETTER: Final = 0.9
_WORSE: Final = 1.1
_COARSER: Final = 2.0
#: Smaller relative errors of the tip deflection are not compared: they are errors of the integration.
_NOISE: Final = 5e-5
#: Case and duration, s, for which the errors of a `SimpleEngine` are stated; largest ratio to the stated error.
_MEASURED_IN: Final = "thesis-24"
_MEASURED_OVER: Final = 2.0
_UNDERSTATED: Final = 1.5

#: Crank angles, deg, at which frequencies are compared.
_ANGLES: Final = (180.0, 90.0, 0.0)
#: Relative tolerance of each frequency: `_FLOOR`, and `_REFINED` times the change by finer settings, at most `_MOST` ...
_FLOOR: Final = np.array([0.005, 0.015, 0.04])
_REFINED: Final = 3.0
_MOST: Final = 0.6
#: ... or this, if the engine makes no claim or states an error of 30 %: one cubic is 12 to 16 % too high in the first, two modes that are
#: right in the first are 20 to 60 % off in the next. For a smaller stated error it is in proportion.
_UNCLAIMED: Final = np.array([0.3, 0.6, 0.9])


def ladder(bench: Bench) -> Iterator[Check]:
    """All checks of the ladder."""
    fine, coarse = (bench.engine.settings_for(each, bench.scene) for each in sorted((_COARSE, bench.engine.default_accuracy)))
    tried = {bench.settings(bench.scene): "default settings", coarse: "coarse settings"}  # which may be the same
    yield check_by("ladder: ends", _ends, bench, coarse)
    yield check_by("ladder: gets finer", _gets_finer, bench, list(tried), fine)
    for settings, words in tried.items():
        yield check_by(f"estimates hold, {words}", _estimates, bench, settings)
    if isinstance(bench.engine, SimpleEngine):
        yield check_by("ladder: stated errors", stated_errors, bench.engine)


def _ends(bench: Bench, rung: Settings | None) -> None:
    seen = list[Settings]()
    while rung is not None:
        if rung in seen or len(seen) == _MOST_RUNGS:
            raise Fault(f"`finer` comes to no end within {_MOST_RUNGS} rungs or gives back earlier settings: {rung}")
        seen.append(rung)
        rung = bench.finer(bench.scene, rung)


def _right(bench: Bench) -> Mapping[str, Array]:
    """Columns of the mild motion; for an engine whose discretization is its model, by its own equations."""
    if bench.engine.estimates != "integration":
        return solution(bench.mild)
    settings = bench.settings(bench.scene)
    for _ in range(3):
        settings = bench.finer(bench.scene, settings) or settings
    return bench.run(bench.mild, settings).columns


def _error(bench: Bench, settings: Settings) -> float:
    """Relative error of the tip deflection."""
    right = _right(bench)["tip_deflection"]
    return rms(bench.run(bench.mild, settings)["tip_deflection"] - right) / (rms(right) or 1.0)


def climb(bench: Bench, settings: Settings) -> list[float]:
    """Errors of the tip deflection from rung to rung, until one is clearly better or takes long."""
    errors, rung = [_error(bench, settings)], bench.finer(bench.scene, settings)
    while rung is not None and len(errors) < _AT_MOST and not min(errors) <= max(_BETTER * errors[0], _NOISE):
        if bench.run(bench.mild, settings).solve_seconds > _SLOW:
            break
        settings, rung = rung, bench.finer(bench.scene, rung)
        errors.append(_error(bench, settings))
    return errors


def _gets_finer(bench: Bench, begin: list[Settings], fine: Settings) -> None:
    """Check that errors fall from the default and the coarse settings on, and that a smaller accuracy gives finer settings."""
    climbed, picked = [climb(bench, each) for each in reversed(begin)], _error(bench, fine)
    words = " and ".join(", ".join(f"{error:.2g}" for error in errors) for errors in climbed)
    if picked > max(_WORSE * climbed[0][0], _NOISE):
        raise Fault(f"`settings_for` gives coarser settings for a smaller accuracy: errors {picked:.2g}, {climbed[0][0]:.2g}")
    if any(max(errors) > max(_COARSER * errors[0], _NOISE) for errors in climbed):
        raise Fault(f"`finer` makes it coarser: errors of the tip deflection from rung to rung are {words}")
    if not any(min(errors) <= max(_BETTER * errors[0], _NOISE) for errors in climbed):
        kind = Unjudged if len(climbed[0]) < _AT_MOST or "tip_deflection" in examined(bench, bench.mild).wrong else Fault
        raise kind(f"no finer rung that was run is better: errors of the tip deflection from rung to rung are {words}")


def _estimates(bench: Bench, settings: Settings) -> None:
    of, mild, estimates = bench.engine.estimates, examined(bench, bench.mild), bench.estimates(bench.mild, settings)
    if of == "unverified" or mild.motion:
        raise Unjudged("the motion is wrong already, or the engine states that its estimates are not verified")
    if estimates is None:
        raise Unjudged(f"no estimate can be made of {settings}: `comparisons` names no other run that completes")
    right, run, error = _right(bench), bench.run(bench.mild, settings), _error(bench, settings)
    unsure = uncertainty(bench.mild) if of == "total" else {}
    for name in ESTIMATED:
        size, off = rms(right[name]), rms(run[name] - right[name])
        if off > max(_MISSED[of] * estimates[name] + 3.0 * unsure.get(name, 0.0), _NOISE * size) and name not in mild.wrong:
            raise Fault(f"{name} is off by {off / max(estimates[name], 1e-300):.3g} times its estimate")
    for pair in bench.engine.comparisons(settings, bench.scene, OUTPUT_STEP):
        ratio = _error(bench, pair.other) / max(_error(bench, pair.run), 1e-300)
        if error > _NOISE and abs(math.log(ratio)) > _CLEARLY and math.log(ratio) * math.log(pair.factor) < 0.0:
            raise Fault(f"`factor` is {pair.factor:.3g}, the errors are in a ratio of {ratio:.3g}")


def stated_errors(engine: SimpleEngine) -> None:
    """Check the stated error of the coarsest resolution, in run 24 over two seconds as `SimpleEngine.errors` are defined."""
    resolution, stated = min(engine.errors.items())
    scene = load_case(_MEASURED_IN).mechanism
    engine.check(scene)
    settings = SimpleSettings(resolution=resolution, tolerance=engine.settings_for(stated, scene).tolerance)
    motion = Motion(scene, _MEASURED_OVER)
    measured = relative_error(motion.by(engine, settings)["tip_deflection"], solution(motion)["tip_deflection"])
    if measured > _UNDERSTATED * stated:
        raise Fault(f"`errors` states {stated:.2g} for resolution {resolution}, measured in {_MEASURED_IN} it is {measured:.2g}")


def frequencies(bench: Bench) -> Iterator[Check]:
    """The check of natural frequencies."""
    yield check_by("frequencies", _frequencies, bench)


def _given(bench: Bench, scene: Mechanism, degrees: float, count: int, settings: Settings) -> Array:
    """The engine's frequencies, at most `count`."""
    given: Any = bench.engine.natural_frequencies(scene, math.radians(degrees), count, settings)
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise Fault(f"they are not numbers: {str(given)[:60]}") from None
    if not values.size:
        raise Unjudged("the engine gives none")
    if values.ndim != 1 or len(values) > count or not (np.diff(values, prepend=0.0) >= 0.0).all() or not values[0] > 0.0:
        raise Fault(f"of at most {count} frequencies they are {values}")
    return values


def _frequencies(bench: Bench) -> None:
    """Check the frequencies against those of the model by `reference`; gravity and damping do not change them."""
    scene, _ = with_everything(bench, bench.scene, ({"mechanism.gravity": (0.0, 30.0)}, {"follower.damping": 30.0}))
    settings = finer = bench.settings(bench.scene)
    for _ in range(3):  # the next rungs may be finer in time alone
        finer = bench.engine.finer(finer, {}, OUTPUT_STEP) or finer
    for degrees in _ANGLES:
        _given(bench, scene, degrees, 1, settings)
        given = _given(bench, scene, degrees, len(_FLOOR), settings)
        n, allowed = len(given), _UNCLAIMED
        if bench.claims:
            better = _given(bench, bench.scene, degrees, n, finer)
            change = np.abs(better / given - 1.0) if len(better) == n else np.zeros(n)
            stated = min(bench.engine.default_accuracy / 0.3, 1.0) * _UNCLAIMED
            allowed = np.maximum(np.minimum(_FLOOR[:n] + _REFINED * change, _MOST), stated[:n])
        ratios = given / frozen_crank_modes(bench.scene, math.radians(degrees), n).frequencies
        if (np.abs(ratios - 1.0) > allowed[:n]).any():
            listed = ", ".join(f"{ratio:.4g}" for ratio in ratios)
            raise Fault(f"with the crank at {degrees:g} deg they are {listed} times those of reference")
