"""What is stored of one engine on one scene: its steady cycle and the measures taken on it."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from cases.cycle_estimates import MeasuredCycle, with_estimates
from cases.fingerprint import SIMULATION, code_fingerprint
from cases.marching import Columns
from cases.measures import CHANNELS, measure_cycle, time_scale
from cases.steady_run import INACCURATE, SETTLED, SteadyRun, Task, steady_run
from cases.store import key_of
from engines.registry import MAIN, engine

#: What the measures depend on besides what the simulation does.
PARTS: Final = (
    *SIMULATION,
    *(f"cases.{module}" for module in ("measures", "orbit", "marching", "steady_run", "cycle_estimates", "engine_run")),
)


def task_key(task: Task) -> str:
    """Key under which the result of a task is stored: scene, engine, settings, versions and code.

    Raises:
        TypeError: the task begins in a state that cannot be told apart from another by its content.
    """
    chosen = engine(task.engine)
    foreign = None if task.engine in MAIN or chosen.unavailable() else chosen
    available = "" if chosen.unavailable() else chosen.version()
    return key_of({"kind": "steady run", "task": task, "version": available, "code": code_fingerprint(PARTS, foreign)})


def engine_run(task: Task) -> SteadyRun:
    """`steady_run` with the measures of the last cycle in the document, under "measures" and "consensus", and their estimates.

    "unestimated" says why there are no estimates, "" if there are.
    """
    run = steady_run(task)
    measured: dict[str, Any] = {"measures": [], "consensus": [], "unestimated": run.unestimated}
    if run.document["status"] in (SETTLED, INACCURATE):
        scale, known = time_scale(task.mechanism), dict[int, MeasuredCycle]()

        def measured_cycle(cycle: Columns) -> MeasuredCycle:
            if id(cycle) not in known:  # a run may be compared with several
                channels = {name: cycle[name] for name in CHANNELS}
                known[id(cycle)] = MeasuredCycle.of(cycle, measure_cycle(scale, cycle["time"], cycle["crank_angle"], channels))
            return known[id(cycle)]

        others = [runs.made_of(measured_cycle) for runs in run.compared]
        measured |= with_estimates(measured_cycle(run.cycle).measures, others)
    return SteadyRun({**run.document, **measured}, run.cycle)


@dataclass(frozen=True)
class EngineRun:
    """One engine on one case, as read back from the store or just computed; see `steady_run` and `engine_run` for the document."""

    document: dict[str, Any]
    cycle: Columns

    @property
    def engine(self) -> str:
        """Name of the engine."""
        return str(self.document["engine"])

    @property
    def status(self) -> str:
        """One of the statuses of `cases.steady_run`."""
        return str(self.document["status"])

    @property
    def usable(self) -> bool:
        """Whether there is a settled cycle with measures."""
        return self.status in (SETTLED, INACCURATE)

    @property
    def start(self) -> str | None:
        """Where it began: one of the starts of `cases.steady_run`; None if it did not begin."""
        found = self.document["start"]
        return None if found is None else str(found)

    @property
    def estimate_of(self) -> str:
        """What its estimates are estimates of: see `engines.base.Engine.estimates`."""
        return str(self.document["estimate_of"])

    @property
    def unestimated(self) -> str:
        """Why there are no estimates of its measures (a clause), "" if there are."""
        return str(self.document["unestimated"])

    def has_frequency(self, half: str, channel: str) -> bool:
        """Whether it resolves a channel's first mode in a half, and has an estimate of the frequency's error."""
        measure = self.measure(half, channel)
        return measure is not None and measure["first_mode_frequency_estimate"] is not None

    def measure(self, half: str, channel: str) -> dict[str, Any] | None:
        """The measure of a half and channel, or None if there is none."""
        for measure in self.document["measures"]:
            if measure["half"] == half and measure["channel"] == channel:
                return dict(measure)
        return None

    def consensus_frequency(self, half: str) -> float | None:
        """Consensus of the first-mode frequency in a half, Hz, or None where not resolvable."""
        for consensus in self.document["consensus"]:
            if consensus["half"] == half and consensus["first_mode_frequency"] is not None:
                return float(consensus["first_mode_frequency"])
        return None

    def peak(self, channel: str) -> float:
        """Largest modulus of a channel over the cycle."""
        return float(np.max(np.abs(self.cycle[channel])))
