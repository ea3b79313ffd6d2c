"""The scenes on which methods are compared, and their results in the store."""

import dataclasses
from collections.abc import Sequence
from typing import Final

from cases.benchmark.measurement import LONG, REPETITIONS, Benchmark, pinned
from cases.case import Case
from cases.fingerprint import SIMULATION, code_fingerprint
from cases.store import Store, key_of
from cases.workers import Job, run_jobs
from engines.base import EngineFailure
from engines.registry import MAIN, RIVALS, engine

#: Run 24, the run with the least strain, and two hard scenes: a soft follower, and a slider that gets to 96 % of the follower.
SCENES: Final = ("thesis-24", "thesis-17", "hard-ei-x0.1", "hard-crank-6in")

ENGINES: Final = (*MAIN, *RIVALS)
PARTS: Final = (*SIMULATION, "cases.benchmark")


def stored(case: Case, store: Store, names: Sequence[str] = ENGINES) -> Benchmark | None:
    """The result that was measured last with this code and these libraries, or None."""
    entry = store.get(_key(case, names))
    return None if entry is None else Benchmark(**entry.document)


def measure(case: Case, store: Store, names: Sequence[str] = ENGINES, repetitions: int = REPETITIONS, longest: float = LONG) -> Benchmark:
    """Measure anew, in a process of its own, and store the result; see `cases.benchmark.measurement.benchmark`.

    Raises:
        EngineFailure, Refusal: the solution to measure against cannot be computed, or the process ended without an answer.
        StoreError: the result cannot be written.
        KeyboardInterrupt: Ctrl-C.
    """
    (outcome,) = run_jobs([Job(case.name, pinned, (case, tuple(names), repetitions, longest))], preload=())
    if outcome.error is not None:
        raise outcome.error
    if not outcome.completed:
        raise EngineFailure(0.0, f"the process of the benchmark was {outcome.failure}", "try fewer engines at once")
    result: Benchmark = outcome.value
    store.put(_key(case, names), dataclasses.asdict(result))
    return result


def _key(case: Case, names: Sequence[str]) -> str:
    versions = {name: "" if engine(name).unavailable() else engine(name).version() for name in names}
    scene = {"mechanism": case.mechanism, "duration": case.duration, "output_step": case.output_step}
    return key_of({"kind": "benchmark", "scene": scene, "versions": versions, "code": code_fingerprint(PARTS)})
