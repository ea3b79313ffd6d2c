"""Two engines on the likeliest machines: whether they agree within their claims, so that the finding is none of one formulation."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from quickreturn.cases.comparison.campaign import carry_out
from quickreturn.cases.comparison.engines import REFERENCE, compare
from quickreturn.cases.library.thesis.runs import run_case
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.running.job import MISSING
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.thesis.inference.unknowns import changes_of_machine

#: The two formulations, and the runs in which both compute.
ENGINES: Final = (REFERENCE, "mujoco")
RUNS: Final = (4, 10, 16, 18, 24)


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
    """Every machine in every run of `RUNS` that is in the workshop. KeyboardInterrupt: Ctrl-C; finished runs are stored."""
    pairs = [(tuple(float(f"{number:.3g}") for number in machine), run) for machine in machines for run in RUNS]
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
