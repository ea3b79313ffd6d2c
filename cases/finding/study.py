"""The study: every effect at every strength in all 24 runs, held against the runs as published."""

import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from cases.finding.effects import EFFECTS, Effect, Strength
from cases.finding.response import Half, Request, Response, respond
from cases.jobs.job import Job
from cases.jobs.workshop import Workshop
from cases.library.thesis import RUNS, run_case
from cases.measures import CHANNELS
from cases.measures.consensus import consensus
from cases.measures.cycle import HALVES
from cases.runs.orbit import Orbit, orbits
from cases.runs.request import CODE

#: Effect ("" for the run as published) and run, negative for the finer one; and the engine where there are two.
Name = tuple[Any, ...]
#: Runs in which the error of the numbers is estimated, by a run with finer settings at the middle strength.
SAMPLE: Final = (4, 10, 16, 24)
#: Error with the finer settings of `reference` over that with the usual ones: four modes and seven (`engines.own.reference.COMPARED`).
FINER: Final = 0.2
#: The run whose fast vibration the thesis describes.
EXAMPLE: Final = 24
#: Effects that a second formulation computes, at the middle strength, and in which runs.
CONFIRMED: Final = ("linear", "post-side", "pre-side", "preload", "clearance", "friction", "drag", "pivot")
CONFIRMED_RUNS: Final = (10, 24)
SECOND: Final = "mujoco"


@dataclass(frozen=True, kw_only=True)
class Row:
    """An effect of one strength. Changes are in % of the run as published; None: not resolvable, or the run broke down.

    Attributes:
        effect: `Effect.id`.
        strength: `Strength.words`.
        pre_frequency: change of the first mode's consensus frequency, of each run from 1 on.
        post_frequency: likewise.
        pre_amplitude: change of its amplitude, median over the channels.
        post_amplitude: likewise.
        acceleration: change of the peak tip acceleration: least, median and greatest over the runs.
        strain: likewise of the peak strain, the largest of three.
        band: RMS from 90 to 180 Hz in the tip acceleration at the return, m/s^2, likewise.
        ring: in run 24 there: frequency (Hz), and correlation of strain 1 with 2, and with 3, from 60 to 200 Hz.
        measured: what the measurement leaves open of a frequency, %, median over runs and halves, the cycles' scatter included.
        claim: estimated errors of the numbers, the greatest of the sample: of the changes of frequency, amplitude, peak acceleration and
            peak strain, in %, and of the band, m/s^2; empty at strengths where none was estimated.
        failed: number of runs that broke down.
    """

    effect: str
    strength: str
    pre_frequency: tuple[float | None, ...]
    post_frequency: tuple[float | None, ...]
    pre_amplitude: tuple[int | None, ...]
    post_amplitude: tuple[int | None, ...]
    acceleration: tuple[int, int, int]
    strain: tuple[int, int, int]
    band: tuple[float, float, float]
    ring: tuple[float, ...]
    measured: float
    claim: tuple[float, ...]
    failed: int


@dataclass(frozen=True, kw_only=True)
class Confirmation:
    """An effect in one run by `reference` and by a second formulation: changes of the frequencies, %; None: not resolvable."""

    effect: str
    strength: str
    run: int
    pre: float | None
    post: float | None
    second_pre: float | None
    second_post: float | None
    reason: str = ""  # why the second formulation has no numbers


def study(workshop: Workshop, *, compute: bool) -> list[Row]:
    """All rows; none unless all is stored, or computed.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    begin = _begin(RUNS, workshop)
    jobs = {("", run): _job("as published", run, [_request(begin[run], run)]) for run in RUNS}
    jobs |= {("", -run): _job("as published, finer", run, [_request(begin[run], run, finer=True)]) for run in SAMPLE}
    for effect in EFFECTS:
        for run in RUNS:
            jobs[effect.id, run] = _job(effect.id, run, [_request(begin[run], run, each) for each in effect.strengths])
        for run in SAMPLE:
            jobs[effect.id, -run] = _job(f"{effect.id}, finer", run, [_request(begin[run], run, _middle(effect), finer=True)])
    found = _responses(jobs, workshop, compute)
    if not found:
        return []
    published = {("published", run): found["", run] for run in RUNS}
    rows = [_row(effect, place, found) for effect in EFFECTS for place in range(len(effect.strengths))]
    return [_row(Effect("published", "as published", (Strength("as published"),)), 0, found | published), *rows]


def confirmation(workshop: Workshop, *, compute: bool) -> list[Confirmation]:
    """Both formulations on some runs; as `study`."""
    begin = _begin(CONFIRMED_RUNS, workshop)
    effects = [effect for effect in EFFECTS if effect.id in CONFIRMED]
    jobs = {}
    for run in CONFIRMED_RUNS:
        for engine in ("reference", SECOND):
            jobs["", engine, run] = _job(f"as published, {engine}", run, [_request(begin[run], run, engine=engine)])
            for effect in effects:
                jobs[effect.id, engine, run] = _job(f"{effect.id}, {engine}", run, [_request(begin[run], run, _middle(effect), engine)])
    found = _responses(jobs, workshop, compute)
    return [_confirmation(effect, run, found) for effect in effects if found for run in CONFIRMED_RUNS]


def _begin(runs: Iterable[int], workshop: Workshop) -> dict[int, Orbit]:
    numbers = tuple(runs)
    return dict(zip(numbers, orbits([run_case(run).mechanism for run in numbers], workshop), strict=True))


def _middle(effect: Effect) -> Strength:
    return effect.strengths[len(effect.strengths) // 2]


def _request(begin: Orbit, run: int, strength: Strength | None = None, engine: str = "", finer: bool = False) -> Request:
    assert begin.begin is not None
    assert begin.multiplier is not None
    mechanism, speed = run_case(run).mechanism, 2.0 * math.pi / begin.period
    scene = strength.scene(mechanism, speed) if strength else mechanism
    name = engine or (strength.engine if strength else "reference")
    return Request(scene, begin.begin, begin.multiplier, speed, name, strength.settings if strength else {}, finer)


def _job(words: str, run: int, requests: Sequence[Request]) -> Job[tuple[Response, ...]]:
    engines = tuple(dict.fromkeys(request.engine for request in requests))
    code = ("cases.finding.response", *CODE)
    return Job(f"{words} {run}", respond, (tuple(requests),), kind="finding", engines=engines, code=code)


def _responses(jobs: Mapping[Name, Job[tuple[Response, ...]]], workshop: Workshop, compute: bool) -> dict[Name, tuple[Response, ...]]:
    if compute:
        outcomes = workshop.outcomes(list(jobs.values()), "what the thesis' finding comes from")
    else:
        stored = [workshop.stored(job) for job in jobs.values()]
        outcomes = [outcome for outcome in stored if outcome is not None]
    if len(outcomes) < len(jobs):
        return {}
    broken = (Response(reason="its process did not end well"),) * len(EFFECTS[0].strengths)
    return {name: outcome.value or broken for name, outcome in zip(jobs, outcomes, strict=True)}


def _confirmation(effect: Effect, run: int, found: Mapping[Name, tuple[Response, ...]]) -> Confirmation:
    def changes(engine: str) -> list[float | None]:
        return [_frequency(found["", engine, run][0], found[effect.id, engine, run][0], half)[0] for half in HALVES]

    (pre, post), (second_pre, second_post) = changes("reference"), changes(SECOND)
    return Confirmation(
        effect=effect.id,
        strength=_middle(effect).words,
        run=run,
        pre=pre,
        post=post,
        second_pre=second_pre,
        second_post=second_post,
        reason=found[effect.id, SECOND, run][0].reason,
    )


def _row(effect: Effect, place: int, found: Mapping[Name, tuple[Response, ...]]) -> Row:
    pairs = {run: (found["", run][0], found[effect.id, run][place]) for run in RUNS}
    known = [pair for pair in pairs.values() if not pair[1].reason]
    frequencies = {half: [_frequency(*pair, half) for pair in pairs.values()] for half in HALVES}
    amplitudes = {half: [_amplitude(*pair, half) for pair in pairs.values()] for half in HALVES}
    example = found[effect.id, EXAMPLE][place].ring
    return Row(
        effect=effect.id,
        strength=effect.strengths[place].words,
        pre_frequency=_rounded(change for change, _ in frequencies["pre"]),
        post_frequency=_rounded(change for change, _ in frequencies["post"]),
        pre_amplitude=_whole(amplitudes["pre"]),
        post_amplitude=_whole(amplitudes["post"]),
        acceleration=_spread([_acceleration(*pair) for pair in known], 0),
        strain=_spread([_strain(*pair) for pair in known], 0),
        band=_spread([pair[1].ring.rms for pair in known if pair[1].ring], 2),
        ring=(round(example.frequency, 1), *(round(sign, 2) for sign in example.signs)) if example else (),
        measured=round(statistics.median([error for half in HALVES for _, error in frequencies[half] if error is not None]), 2),
        claim=_claim(effect, found) if (effect.id, -SAMPLE[0]) in found and effect.strengths[place] == _middle(effect) else (),
        failed=len(pairs) - len(known),
    )


def _frequency(nominal: Response, other: Response, half: str) -> tuple[float | None, float | None]:
    """Change and what its measurement leaves open, %, over the channels that both resolve."""
    if other.reason or nominal.reason:
        return None, None
    before, after = nominal.halves[half], other.halves[half]
    channels = [name for name in CHANNELS if name in before.frequencies and name in after.frequencies]
    if not channels:
        return None, None

    def agreed(of: Half) -> tuple[float, float]:
        mean = consensus(half, [of.frequencies[name] for name in channels], [of.uncertainties[name] for name in channels])
        assert mean.first_mode_frequency is not None
        assert mean.uncertainty is not None
        return mean.first_mode_frequency, mean.uncertainty

    (old, _), (new, error) = agreed(before), agreed(after)
    return 100.0 * (new / old - 1.0), 100.0 * math.hypot(error / new, after.scatter)


def _amplitude(nominal: Response, other: Response, half: str) -> float | None:
    if other.reason or nominal.reason:
        return None
    before, after = nominal.halves[half].amplitudes, other.halves[half].amplitudes
    changes = [100.0 * (after[name] / before[name] - 1.0) for name in before if name in after]
    return statistics.median(changes) if changes else None


def _acceleration(nominal: Response, other: Response) -> float:
    return 100.0 * (other.peaks["tip_acceleration"] / nominal.peaks["tip_acceleration"] - 1.0)


def _strain(nominal: Response, other: Response) -> float:
    before, after = (max(response.peaks[name] for name in CHANNELS[1:]) for response in (nominal, other))
    return 100.0 * (after / before - 1.0)


def _claim(effect: Effect, found: Mapping[Name, tuple[Response, ...]]) -> tuple[float, ...]:
    """Greatest difference that finer settings make to each kind of number, over the part of the error that they take away."""
    place = effect.strengths.index(_middle(effect))
    greatest = [0.0] * 5
    for run in SAMPLE:
        usual, finer = found[effect.id, run][place], found[effect.id, -run][0]
        if usual.reason or finer.reason or usual.ring is None or finer.ring is None:
            continue
        pairs = (found["", run][0], usual), (found["", -run][0], finer)
        kinds: list[Callable[[Response, Response], float | None]] = [
            *(lambda one, two, half=half: _frequency(one, two, half)[0] for half in HALVES),
            *(lambda one, two, half=half: _amplitude(one, two, half) for half in HALVES),
            _acceleration,
            _strain,
            lambda _, two: two.ring.rms if two.ring else None,
        ]
        for kind, place_of in zip(kinds, (0, 0, 1, 1, 2, 3, 4), strict=True):
            one, two = (kind(*pair) for pair in pairs)
            if one is not None and two is not None:
                greatest[place_of] = max(greatest[place_of], abs(one - two) / (1.0 - FINER))
    return tuple(round(each, 2) for each in greatest)


def _rounded(values: Iterable[float | None]) -> tuple[float | None, ...]:
    return tuple(None if value is None else round(value, 2) for value in values)


def _whole(values: Iterable[float | None]) -> tuple[int | None, ...]:
    return tuple(None if value is None else round(value) for value in values)


def _spread(values: Sequence[float], digits: int) -> tuple[Any, Any, Any]:
    """Least, median, greatest."""
    least, median, greatest = (
        round(each, digits) if digits else round(each) for each in (min(values), statistics.median(values), max(values))
    )
    return least, median, greatest
