"""The study: every point in runs whose first mode the thesis' own model resolves, beside that model as published, read in both ways.

Two engines also compute the likeliest machines, so that the finding is none of one formulation.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from quickreturn.cases.comparison.campaign import carry_out
from quickreturn.cases.comparison.engines import REFERENCE, compare
from quickreturn.cases.library.thesis import run_case
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.orbit import Orbit, orbits
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.running.job import MISSING, Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import MODEL
from quickreturn.plugins.thesis.experiment import axis_labels
from quickreturn.plugins.thesis.inference.response import Half, Request, Response, respond
from quickreturn.plugins.thesis.inference.unknowns import changes_of_machine, points, scene_of

#: Runs of the study: seven of the thirteen that the single cubic resolves, over all cranks, tip bodies and slider forces.
RUNS: Final = (4, 8, 10, 14, 16, 18, 24)
#: The run whose vibrations section 3.4 describes.
EXAMPLE: Final = 24
#: Number that stands for the thesis' own model as published among the numbers of `points`.
CUBIC: Final = -1


#: Units of recorded ratios, and least amplitude of a visible vibration in a printed figure, as a part of the axis' range.
FREQUENCY_UNIT: Final = 1e-3
AMPLITUDE_UNIT: Final = 0.1
VISIBLE: Final = 0.01
#: Least frequency of a ring, Hz: slower vibrations at the return are the second mode, which lies below 64 Hz.
LEAST_RING: Final = 70.0


@dataclass(frozen=True, kw_only=True)
class Row:
    """A machine in the place of the experiment, in each of `RUNS`; None: not resolvable, or failed."""

    machine: int  # number in `points`
    # frequency of the thesis' own model over the machine's, less 1, in units of 0.1 %, before and after the return: by fits
    pre: tuple[int | None, ...]
    post: tuple[int | None, ...]
    pre_counted: tuple[int | None, ...]  # likewise by counted extremes
    post_counted: tuple[int | None, ...]
    pre_amplitude: tuple[int | None, ...]  # ratio of the first mode's amplitudes in units of 0.1, median over the channels
    post_amplitude: tuple[int | None, ...]
    ring: tuple[float, ...]  # at the return of run 24: strongest frequency, Hz, RMS, m/s^2, correlation of strain 1 with 2 and with 3
    peaks: tuple[float, ...]  # in run 24: of tip acceleration, m/s^2, and the largest of the strains, 1e-6
    slower: float  # largest relative loss of crank speed against the printed machine
    failed: int = 0  # number of runs without a steady cycle

    def logarithms(self, name: str) -> list[float]:
        """Logarithms of the ratios in the field `name` by run, NaN where there is none."""
        unit, start = (AMPLITUDE_UNIT, 0.0) if name.endswith("amplitude") else (FREQUENCY_UNIT, 1.0)
        return [math.nan if value is None else math.log(max(start + unit * value, 0.5 * unit)) for value in getattr(self, name)]

    @property
    def rings(self) -> bool:
        """Whether a fast vibration would be seen at the return in the printed figure of run 24."""
        printed = next(axis.range for axis in axis_labels(EXAMPLE) if axis.channel == "tip_acceleration")
        return self.ring[0] >= LEAST_RING and math.sqrt(2.0) * self.ring[1] >= VISIBLE * (printed[1] - printed[0])


def study(workshop: Workshop) -> list[Row]:
    """The rows of all machines whose results are in the workshop; none without those of the thesis' own model and the printed machine.

    KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    begin = dict(zip(RUNS, orbits([run_case(run).mechanism for run in RUNS], workshop), strict=True))
    wanted = {machine: job(machine, RUNS, begin) for machine in (CUBIC, *range(len(points())))}
    outcomes = workshop.outcomes(list(wanted.values()), "what made the thesis find what it found")
    broken = (Response(reason="its process failed"),) * len(RUNS)
    found = {
        machine: dict(zip(RUNS, outcome.value or broken, strict=True))
        for machine, outcome in zip(wanted, outcomes, strict=True)
        if not outcome.missing
    }
    if not {CUBIC, 0} <= found.keys():
        return []
    cubic, printed = found.pop(CUBIC), found[0]
    return [_row(machine, of_runs, cubic, printed) for machine, of_runs in sorted(found.items()) if of_runs[EXAMPLE].ring]


def job(machine: int, runs: tuple[int, ...], begin: Mapping[int, Orbit]) -> Job[tuple[Response, ...]]:
    """The job that computes a machine in some runs, each from the periodic state of the run as published."""
    engine = MODEL if machine == CUBIC else "reference"
    scenes = {run: run_case(run).mechanism if machine == CUBIC else scene_of(points()[machine], run) for run in runs}
    requests = tuple(Request(scenes[run], start, engine) for run in runs if (start := begin[run].begin) is not None)
    return Job(f"machine {machine}, runs {runs}", respond, (requests,), kind="inference", engines=(engine,))


def _row(number: int, machine: Mapping[int, Response], cubic: Mapping[int, Response], printed: Mapping[int, Response]) -> Row:
    def ratios(half: str, reading: str) -> tuple[int | None, ...]:
        pairs = [[getattr(each[run].halves.get(half, Half()), reading) for each in (cubic, machine)] for run in RUNS]
        return tuple(None if None in pair else round((pair[0] / pair[1] - 1.0) / FREQUENCY_UNIT) for pair in pairs)

    def amplitudes(half: str) -> tuple[int | None, ...]:
        pairs = [[each[run].halves.get(half, Half()).amplitudes for each in (cubic, machine)] for run in RUNS]
        shares = [[pair[0][name] / pair[1][name] for name in pair[0] if name in pair[1]] for pair in pairs]
        return tuple(round(float(np.median(of_channels)) / AMPLITUDE_UNIT) if of_channels else None for of_channels in shares)

    example = machine[EXAMPLE]
    assert example.ring is not None
    return Row(
        machine=number,
        pre=ratios("pre", "fitted"),
        post=ratios("post", "fitted"),
        pre_counted=ratios("pre", "counted"),
        post_counted=ratios("post", "counted"),
        pre_amplitude=amplitudes("pre"),
        post_amplitude=amplitudes("post"),
        ring=(round(example.ring.frequency, 1), round(example.ring.rms, 1), *(round(sign, 1) for sign in example.ring.signs)),
        peaks=(round(example.peaks["tip_acceleration"]), round(1e6 * max(example.peaks[f"strain_{gauge}"] for gauge in (1, 2, 3)))),
        slower=round(max(1.0 - machine[run].speed / printed[run].speed for run in RUNS if not machine[run].reason), 4),
        failed=sum(bool(machine[run].reason) for run in RUNS),
    )


#: The two formulations, and the runs in which both compute.
ENGINES: Final = (REFERENCE, "mujoco")
CONFIRMED_IN: Final = (4, 10, 16, 18, 24)


@dataclass(frozen=True, kw_only=True)
class Confirmation:
    """A machine in a run by two engines, compared as in every cross-check."""

    machine: tuple[float, ...]  # in the order of `unknowns.NAMES`, three digits
    run: int
    pre: tuple[float | None, ...]  # first-mode frequency before the return by each engine, Hz; None: not resolvable, or failed
    post: tuple[float | None, ...]
    compared: int  # numbers that both engines give with their claims
    missed: int  # those that differ by more than the claims


def confirmed(machines: Sequence[Sequence[float]], workshop: Workshop) -> list[Confirmation]:
    """Every machine in every run of `CONFIRMED_IN` that is in the workshop. KeyboardInterrupt: Ctrl-C; finished runs are stored."""
    pairs = [(tuple(float(f"{number:.3g}") for number in machine), run) for machine in machines for run in CONFIRMED_IN]
    requests = {}
    for (machine, run), name in product(pairs, ENGINES):
        case = run_case(run)
        scene = case.mechanism_with(changes_of_machine(np.array(machine), run))
        requests[json.dumps(machine), str(run), name] = RunRequest(mechanism=scene, duration=case.duration, engine=name)
    runs, rows = carry_out(requests, workshop, "two engines on the likeliest machines"), list[Confirmation]()
    for machine, run in pairs:
        engines = {name: runs[json.dumps(machine), str(run), name] for name in ENGINES}
        if any(each.cause == MISSING for each in engines.values()):
            continue
        pre, post = (tuple(each.consensus_frequency(half) if each.usable else None for each in engines.values()) for half in HALVES)
        agreement = compare(run_case(run), engines).agreement
        agree, disagree = agreement["agree"], agreement["disagree"]
        rows.append(Confirmation(machine=machine, run=run, pre=pre, post=post, compared=agree + disagree, missed=disagree))
    return rows
