"""The study: every effect at every strength in all 24 runs, compared with the runs as published."""

import math
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from quickreturn.cases.library.thesis.runs import RUNS, run_case
from quickreturn.cases.motion.consensus import consensus
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.orbit import Orbit, orbits
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.error_parts import counted
from quickreturn.plugins.thesis.finding.effects import PUBLISHED, Effect, effects
from quickreturn.plugins.thesis.finding.response import Request, Response, respond

#: The strength at which errors are estimated and a second formulation computes, and the runs for both.
MIDDLE: Final = 1
SAMPLE: Final = (4, 10, 16, 24)
CONFIRMED_RUNS: Final = (10, 24)
#: The second formulation, and the effects that it also computes: those of the joint.
SECOND: Final = "mujoco"
JOINT_EFFECTS: Final = ("linear", "post-side", "pre-side", "preload", "post-side-alloy", "clearance", "friction", "drag", "pivot")
#: The run whose fast vibration the thesis describes.
EXAMPLE: Final = 24
#: How a run is computed: "" by `Effect.engine`, "finer" by it with finer settings, or the name of another engine.
Way = str
#: Effect, run and way -> response at each computed strength.
Responses = Mapping[tuple[str, int, Way], tuple[Response, ...]]


@dataclass(frozen=True, kw_only=True)
class Row:
    """An effect of one strength; changes are relative to the run as published. None: not resolvable, not computed, or failed."""

    effect: str  # `Effect.id`
    strength: str  # its words
    engine: str  # engine that computed it
    # change of the first mode's consensus frequency, in units of 0.01 %, in each run from 1 on; by `SECOND` in each of `CONFIRMED_RUNS`
    pre_frequency: tuple[int | None, ...]
    post_frequency: tuple[int | None, ...]  # likewise
    pre_amplitude: tuple[int | None, ...]  # change of its amplitude, %, median over the channels
    post_amplitude: tuple[int | None, ...]  # likewise
    acceleration: int | None  # change of the peak tip acceleration, %, median over the runs
    strain: int | None  # likewise of the peak strain, the largest of three
    band: float | None  # RMS from 90 to 180 Hz in the tip acceleration at the return, m/s^2, likewise
    # of run 24 the first mode's frequency before and after the return, Hz (0: not resolvable); at the return the RMS of the band, m/s^2,
    # the strongest frequency from 60 to 200 Hz, and there the correlation of strain 1 with 2, and with 3
    example: tuple[float, ...]
    measured: float  # uncertainty of a measured frequency, %, median over runs and halves, including the cycles' scatter
    # estimated errors, the greatest of the sample: of the changes of frequency, amplitude, peak acceleration and peak strain, in %, and
    # of the band, m/s^2; empty where none was estimated
    claim: tuple[float, ...]
    runs: int  # number of computed runs; `failed` of them failed
    failed: int

    def changes(self, name: str) -> dict[int, float]:
        """Run -> relative change in the field `name`, if it is known."""
        unit, runs = 1e-4 if name.endswith("frequency") else 1e-2, CONFIRMED_RUNS if self.engine == SECOND else tuple(RUNS)
        return {run: unit * value for run, value in zip(runs, getattr(self, name), strict=True) if value is not None}

    @property
    def apart(self) -> float | None:
        """Relative change of the frequency after the return minus that before it, median over the runs."""
        before, after = self.changes("pre_frequency"), self.changes("post_frequency")
        changes = [(1.0 + after[run]) / (1.0 + before[run]) - 1.0 for run in before if run in after]
        return statistics.median(changes) if changes else None

    @property
    def tells_halves_apart(self) -> bool:
        """Whether the halves differ by more than the uncertainty of a difference of two frequencies."""
        return self.apart is not None and abs(self.apart) > 0.01 * math.sqrt(2.0) * self.measured


def study(workshop: Workshop) -> list[Row]:
    """All rows, those of the second formulation last, from the runs in the workshop; none unless all runs of the sample are there.

    KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    others = tuple(run for run in RUNS if run not in SAMPLE)
    begin = dict(zip(RUNS, orbits([run_case(run).mechanism for run in RUNS], workshop), strict=True))
    jobs = dict[tuple[str, int, Way], Job[tuple[Response, ...]]]()
    # the sample first, so that an interrupted study has the same runs for all effects
    for way, runs in (("", SAMPLE), (SECOND, CONFIRMED_RUNS), ("finer", SAMPLE), ("", others)):
        for run in (run for run in runs if begin[run].begin is not None):
            computed = [effect for effect in (PUBLISHED, *effects()) if way != SECOND or effect.id in (PUBLISHED.id, *JOINT_EFFECTS)]
            jobs |= {(effect.id, run, way): _job(effect, run, way, begin[run]) for effect in computed}
    outcomes = workshop.outcomes(list(jobs.values()), "what the thesis' finding comes from")
    broken = (Response(reason="its process failed"),) * 3
    responses = {name: outcome.value or broken for name, outcome in zip(jobs, outcomes, strict=True) if not outcome.missing}
    if any((effect.id, run, "") not in responses for effect in (PUBLISHED, *effects()) for run in SAMPLE):
        return []
    rows = [_row(effect, place, "", responses) for effect in (PUBLISHED, *effects()) for place in range(len(effect.strengths))]
    return rows + [_row(effect, MIDDLE, SECOND, responses) for effect in effects() if effect.id in JOINT_EFFECTS]


def _job(effect: Effect, run: int, way: Way, begin: Orbit) -> Job[tuple[Response, ...]]:
    """All strengths of an effect in a run, or the middle one."""
    assert begin.begin is not None
    assert begin.multiplier is not None
    strengths = [MIDDLE] if way and effect is not PUBLISHED else range(len(effect.strengths))
    engine = way if way == SECOND else effect.engine
    requests = tuple(
        Request(
            scene=effect.scene(run, strength),
            start=begin.begin,
            multiplier=begin.multiplier,
            speed=2.0 * math.pi / begin.period,
            engine=engine,
            settings=effect.settings(strength) if effect.set else {},
            finer=way == "finer",
        )
        for strength in strengths
    )
    return Job(" ".join((effect.id, str(run), way)).strip(), respond, (requests,), kind="finding", engines=(engine,))


def _row(effect: Effect, place: int, way: Way, responses: Responses) -> Row:
    pairs = {run: _pair(effect, place, run, way, responses) for run in (CONFIRMED_RUNS if way == SECOND else RUNS)}
    good = [pair for pair in pairs.values() if pair and not pair[1].reason]
    frequencies = {half: [_frequency(pair, half) for pair in pairs.values()] for half in HALVES}
    errors = [error for half in HALVES for _, error in frequencies[half] if error is not None]
    amplitudes = {half: [_amplitude(pair, half) for pair in pairs.values()] for half in HALVES}
    example = pairs[EXAMPLE]
    return Row(
        effect=effect.id,
        strength=effect.words[place],
        engine=way or effect.engine,
        pre_frequency=tuple(_rounded(change, 100.0) for change, _ in frequencies["pre"]),
        post_frequency=tuple(_rounded(change, 100.0) for change, _ in frequencies["post"]),
        pre_amplitude=tuple(_rounded(each) for each in amplitudes["pre"]),
        post_amplitude=tuple(_rounded(each) for each in amplitudes["post"]),
        acceleration=round(statistics.median(_peak(pair, CHANNELS[:1]) for pair in good)) if good else None,
        strain=round(statistics.median(_peak(pair, CHANNELS[1:]) for pair in good)) if good else None,
        band=round(statistics.median(pair[1].ring.rms for pair in good if pair[1].ring), 2) if good else None,
        example=_example(example[1]) if example else (),
        measured=round(statistics.median(errors), 2) if errors else 0.0,
        claim=_claim(effect, responses) if not way and place == MIDDLE else (),
        runs=sum(pair is not None for pair in pairs.values()),
        failed=sum(bool(pair and pair[1].reason) for pair in pairs.values()),
    )


Pair = tuple[Response, Response] | None


def _pair(effect: Effect, place: int, run: int, way: Way, responses: Responses) -> Pair:
    """Responses of a run as published and with an effect, computed in the same way; None if they were not computed."""
    if (effect.id, run, way) not in responses:
        return None
    changed = responses[effect.id, run, way]
    return responses[PUBLISHED.id, run, way][0], changed[min(place, len(changed) - 1)]


def _frequency(pair: Pair, half: str) -> tuple[float | None, float | None]:
    """Change of the first mode's consensus frequency over the channels that both resolve, %, and its uncertainty, %."""
    before, after = (response.halves.get(half) for response in pair) if pair else (None, None)
    channels = [name for name in CHANNELS if before and after and name in before.frequencies and name in after.frequencies]
    if before is None or after is None or not channels:
        return None, None
    means = [
        consensus(half, [each.frequencies[name] for name in channels], [each.uncertainties[name] for name in channels])
        for each in (before, after)
    ]
    (old, _), (new, error) = ((mean.first_mode_frequency or 0.0, mean.uncertainty or 0.0) for mean in means)
    return 100.0 * (new / old - 1.0), 100.0 * math.hypot(error / new, after.scatter)


def _amplitude(pair: Pair, half: str) -> float | None:
    """Change of the first mode's amplitude, %, median over the channels."""
    before, after = (response.halves[half].amplitudes if response.halves else {} for response in pair) if pair else ({}, {})
    changes = [100.0 * (after[name] / before[name] - 1.0) for name in before if name in after]
    return statistics.median(changes) if changes else None


def _peak(pair: Pair, channels: Sequence[str]) -> float:
    """Change of the largest magnitude in some channels, %."""
    assert pair is not None
    before, after = (max(response.peaks[name] for name in channels) for response in pair)
    return 100.0 * (after / before - 1.0)


def _example(response: Response) -> tuple[float, ...]:
    if response.ring is None:
        return ()
    halves = response.halves.items()
    agreed = [consensus(name, list(half.frequencies.values()), list(half.uncertainties.values())) for name, half in halves]
    means = (round(each.first_mode_frequency or 0.0, 2) for each in agreed)
    return (*means, round(response.ring.rms, 2), round(response.ring.frequency, 1), *(round(sign, 2) for sign in response.ring.signs))


def _claim(effect: Effect, responses: Responses) -> tuple[float, ...]:
    """Greatest error in the sample of each kind of number: what counts of its difference from finer settings."""
    kinds: Sequence[Callable[[Pair], Iterable[float | None]]] = (
        lambda pair: [_frequency(pair, half)[0] for half in HALVES],
        lambda pair: [_amplitude(pair, half) for half in HALVES],
        lambda pair: [_peak(pair, CHANNELS[:1])],
        lambda pair: [_peak(pair, CHANNELS[1:])],
        lambda pair: [pair[1].ring.rms if pair and pair[1].ring else None],
    )
    pairs = [tuple(_pair(effect, MIDDLE, run, way, responses) for way in ("", "finer")) for run in SAMPLE]
    pairs = [both for both in pairs if all(pair and not pair[1].reason for pair in both)]
    claims = list[float]()
    for kind in kinds if pairs else ():
        values = [(one, two, _counted(finer)) for usual, finer in pairs for one, two in zip(kind(usual), kind(finer), strict=True)]
        errors = [part * abs(one - two) for one, two, part in values if one is not None and two is not None]
        claims.append(round(max(errors, default=0.0), 2))
    return tuple(claims)


def _counted(finer: Pair) -> float:
    """The larger part of the difference that counts as error, in the published and in the changed run (`engines.error_parts.counted`)."""
    assert finer is not None
    return max(counted(response.factor) for response in finer)


def _rounded(value: float | None, times: float = 1.0) -> int | None:
    return None if value is None else round(times * value)
