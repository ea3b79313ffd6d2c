"""What is stored of one engine on one scene: its steady cycle and the measures taken on it."""

import dataclasses
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cases.fingerprint import SIMULATION, code_fingerprint
from cases.measures import CHANNELS, measure_cycle, time_scale
from cases.steady_run import INACCURATE, SETTLED, SteadyRun, Task, steady_run
from cases.store import key_of
from engines.registry import MAIN, engine

#: What the measures depend on besides what the simulation does.
PARTS: Final = (*SIMULATION, "cases.measures", "cases.steady_run", "cases.engine_run")


def task_key(task: Task) -> str:
    """Key under which the result of a task is stored: scene, engine, settings, versions and code.

    Raises:
        TypeError: the task holds a start that cannot be told apart from another by its content.
    """
    chosen = engine(task.engine)
    foreign = None if task.engine in MAIN or chosen.unavailable() else chosen
    available = "" if chosen.unavailable() else chosen.version()
    return key_of({"kind": "steady run", "task": task, "version": available, "code": code_fingerprint(PARTS, foreign)})


def engine_run(task: Task) -> SteadyRun:
    """`steady_run` with the measures of the last cycle in the document, under "measures" and "consensus"."""
    run = steady_run(task)
    measured: dict[str, Any] = {"measures": [], "consensus": []}
    if run.document["status"] in (SETTLED, INACCURATE):
        channels = {name: run.cycle[name] for name in CHANNELS}
        found = measure_cycle(time_scale(task.mechanism), run.cycle["time"], run.cycle["crank_angle"], channels)
        measured["measures"] = [dataclasses.asdict(measure) for measure in found.measures]
        measured["consensus"] = [dataclasses.asdict(consensus) for consensus in found.consensus]
    return SteadyRun({**run.document, **measured}, run.cycle)


@dataclass(frozen=True)
class EngineRun:
    """One engine on one case, as read back from the store or just computed; see `steady_run` and `engine_run` for the document."""

    document: dict[str, Any]
    cycle: dict[str, NDArray[np.float64]]

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
