"""The study: every point in the runs whose first mode the thesis' own model resolves, read in both ways; and what two engines say of the best."""

import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from quickreturn.cases.library.thesis.runs import run_case
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.orbit import Orbit, orbits
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import MODEL
from quickreturn.plugins.thesis.inference.response import Request, Response, respond
from quickreturn.plugins.thesis.inference.unknowns import points, scene_of

#: Runs of the study, in groups that are computed one after the other; the single cubic resolves 13 runs, these among them.
GROUPS: Final = ((4, 8, 10, 14, 16, 18, 24), (12, 20, 22))
RUNS: Final = tuple(sorted(run for group in GROUPS for run in group))
#: The run whose vibrations section 3.4 describes.
EXAMPLE: Final = 24
#: Number of the row that is the thesis' own model as published; the others are numbers of `points`.
CUBIC: Final = -1


def jobs(begin: dict[int, Orbit]) -> dict[tuple[int, tuple[int, ...]], Job[tuple[Response, ...]]]:
    """Row and group of runs -> the job that computes it, the first group of runs first."""
    machines = points()
    found = dict[tuple[int, tuple[int, ...]], Job[tuple[Response, ...]]]()
    for group in GROUPS:
        for row in (CUBIC, *range(len(machines))):
            engine = MODEL if row == CUBIC else "reference"
            scenes = {run: run_case(run).mechanism if row == CUBIC else scene_of(machines[row], run) for run in group}
            requests = tuple(Request(scenes[run], start, engine) for run in group if (start := begin[run].begin) is not None)
            found[row, group] = Job(f"machine {row}, runs {group}", respond, (requests,), kind="inference", engines=(engine,))
    return found
