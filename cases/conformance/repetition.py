"""An engine's answer depends on the scene and nothing else."""

from collections.abc import Iterator
from typing import Final

from cases.conformance.bench import COMPARED, Bench, found_engine
from cases.conformance.checks import Array, Check, Fault, Unjudged, looked_at
from cases.conformance.scenes import OUTPUT_STEP
from cases.jobs.display import answers
from cases.jobs.job import Job
from cases.jobs.processes import LocalProcesses
from engines.accurate import run_once
from engines.base import AnyEngine, EngineFailure
from engines.relative import rms
from engines.start import standard_start
from engines.trajectory import Trajectory
from reference_model.mechanism import changed

_DURATION: Final = 0.1  # s
#: Threads may add in another order, and a step size control makes more of it.
_SAME: Final = 1e-6


def fingerprint(engine: AnyEngine | str) -> dict[str, Array]:
    """The columns of a short run, for another process to compare with."""
    return {name: values for name, values in _run(Bench(found_engine(engine))).columns.items() if name in COMPARED}


def elsewhere(engine: AnyEngine | str) -> dict[str, Array] | str:
    """The same from a process of its own; a clause where there is none."""
    (outcome,) = answers(LocalProcesses(1), [Job("another process", fingerprint, (engine,))], "another process")
    return outcome.explanation if outcome.value is None else outcome.value


def _run(bench: Bench) -> Trajectory:
    settings = bench.settings(bench.scene)
    return run_once(bench.engine, bench.scene, standard_start(bench.scene), _DURATION, OUTPUT_STEP, settings)[0]


def repetition(bench: Bench, other: dict[str, Array] | str) -> Iterator[Check]:
    """The same scene again, behind another scene, and in another process (`other`, from `elsewhere`)."""
    try:
        first, again = _run(bench), _run(bench)
        bench.run(changed(bench.scene, {"follower.bending_stiffness": 9.0, "tip.mass": 0.1}), duration=_DURATION)
        behind = _run(bench)
    except EngineFailure as failure:
        yield Check("twice the same", "not judged", failure.cause, failure.advice)
        return
    yield looked_at("twice the same", _same, first, again.columns, "the second time")
    yield looked_at("the same behind another scene", _same, first, behind.columns, "the second time")
    yield looked_at("the same from another process", _same, first, other, "in another process")


def _same(first: Trajectory, second: dict[str, Array] | str, when: str) -> None:
    """Fault if a column differs, or if there is no second run but a clause why; Unjudged if only the class is not to be had there."""
    if isinstance(second, str):
        words = second.lower()
        if "raised" in words and (("error" in words and "import" in words) or "attribute" in words or "pickle" in words):
            advice = "give it a module of its own and announce it as an entry point"
            raise Unjudged(f"the engine's class cannot be had in another process ({second})", advice)
        raise Fault(f"another process ends: {second}", "see what it says there")
    for name, values in second.items():
        if name in COMPARED and (len(values) != len(first) or rms(first[name] - values) > _SAME * (rms(first[name]) + 1e-12)):
            keep = "keep nothing between runs: no class attribute, module variable, random number or clock"
            raise Fault(f"{name} comes out another way {when}", keep)
