"""Settled cycles of the 24 runs from three starts: whether an engine finds its own cycle, or keeps some of `reference`'s.

In a report `exudyn` and `mujoco` begin in the periodic orbit of `reference`. Here they also march from the standard start, and from a start
with the crank 100 degrees further on, with the same settings.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from quickreturn.cases.comparison.campaign import carry_out
from quickreturn.cases.library import load_case
from quickreturn.cases.library.thesis import RUNS, run_name
from quickreturn.cases.motion.marching import channels_of
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.motion.settling import on_common_grid, relative_change
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.settings import as_texts
from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.scene_values import value_at

#: Engines that march.
ENGINES: Final = ("exudyn", "mujoco")
ANGLE: Final = "crank.initial_angle"
#: Start -> how much further on the crank begins than in the standard start, rad.
STARTS: Final = {"standard": 0.0, "crank 100° on": np.radians(100.0)}


@dataclass(frozen=True, kw_only=True)
class Start:
    """Settled cycles from another start, beside those from the orbit."""

    engine: str
    start: str  # one of `STARTS`
    runs: tuple[int, ...]  # numbers of the runs that settle
    cycles: tuple[int, ...]  # until settled
    difference: tuple[float, ...]  # RMS over the channels of the difference of the two cycles, each over the channel's RMS
    claimed: tuple[float, ...]  # what is left to the steady state by both runs' claims, likewise

    @property
    def within(self) -> int:
        """Number of cycles that are the same within the claims."""
        return sum(difference <= claim for difference, claim in zip(self.difference, self.claimed, strict=True))


def starts(workshop: Workshop, runs: Sequence[int] = tuple(RUNS)) -> list[Start]:
    """Every engine from every start in the runs that settle. KeyboardInterrupt: Ctrl-C."""
    cases = {str(run): load_case(run_name(run)) for run in runs}
    requests = {
        (run, name): RunRequest(mechanism=case.mechanism, duration=case.duration, engine=name)
        for run, case in cases.items()
        for name in ENGINES
    }
    begun = {place: run for place, run in carry_out(requests, workshop, "from the orbit").items() if run.usable}
    again = {}
    for (run, name), orbit in begun.items():
        scene = cases[run].mechanism
        settings = as_texts(dict(orbit.computation.settings or {}))
        for start, further in STARTS.items():
            moved = cases[run].mechanism_with({ANGLE: value_at(scene, ANGLE) + further})
            again[run, name, start] = replace(requests[run, name], mechanism=moved, settings=settings, straight=True, estimated=False)
    found = {place: run for place, run in carry_out(again, workshop, "from other starts").items() if run.approach.settled}
    rows = []
    for name in ENGINES:
        for start in STARTS:
            settled = {run: cycle for (run, engine, begun_in), cycle in found.items() if (engine, begun_in) == (name, start)}
            pairs = [(straight, begun[run, name]) for run, straight in settled.items()]
            rows.append(
                Start(
                    engine=name,
                    start=start,
                    runs=tuple(map(int, settled)),
                    cycles=tuple(straight.approach.cycles for straight, _ in pairs),
                    difference=tuple(cycle_difference(straight.cycle, orbit.cycle) for straight, orbit in pairs),
                    claimed=tuple(sum(each.approach.settling_error or 0.0 for each in pair) for pair in pairs),
                )
            )
    return rows


def cycle_difference(one: Columns, other: Columns) -> float:
    """RMS over the channels of the difference between two cycles, each channel relative to its RMS in the other cycle."""
    return relative_change(on_common_grid(channels_of(other)), on_common_grid(channels_of(one)))
