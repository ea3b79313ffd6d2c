"""An engine's answer depends on the scene and nothing else."""

import pickle
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from cases.conformance.bench import COMPARED, Bench, columns_of, found_engine
from cases.conformance.checks import Array, Check, Fault, Unjudged, looked_at
from cases.jobs.display import answers
from cases.jobs.job import Job
from cases.jobs.processes import LocalProcesses
from engines.base import AnyEngine, EngineFailure
from engines.relative import rms
from engines.trajectory import Trajectory
from reference_model.mechanism import changed

_DURATION: Final = 0.1  # s
#: Part of a column by which it may differ.
_SAME: Final = 1e-6
#: Part of its own error that an engine may differ by in another process, where as many threads add in another order: a step size control
#: makes 1e-5 of a column of that at a tolerance of 1e-5.
_OF_ERROR: Final = 0.02


def fingerprint(engine: AnyEngine | str) -> dict[str, Array]:
    """The columns of a short run, for another process to compare with."""
    run = _run(Bench(found_engine(engine)))
    return {name: run[name] for name in columns_of(run)}


def elsewhere(engine: AnyEngine | str) -> dict[str, Array] | str:
    """The same from a process of its own; a clause where there is none."""
    try:
        pickle.dumps(engine)
    except Exception as error:  # of whatever kind pickle makes it
        return f"pickle raised {type(error).__name__}: {error}"
    (outcome,) = answers(LocalProcesses(1), [Job("another process", fingerprint, (engine,))], "another process")
    return outcome.explanation if outcome.value is None else outcome.value


def _run(bench: Bench) -> Trajectory:
    return replace(bench.mild, duration=_DURATION).by(bench.engine, bench.settings(bench.scene))


def repetition(bench: Bench) -> Iterator[Check]:
    """The same scene again, behind another scene, and in another process."""
    try:
        first, again = _run(bench), _run(bench)
        bench.run(replace(bench.mild, scene=changed(bench.scene, {"follower.bending_stiffness": 9.0, "tip.mass": 0.1}), duration=_DURATION))
        behind = _run(bench)
    except EngineFailure as failure:
        yield Check("twice the same", "not judged", failure.cause, failure.advice)
        return
    yield looked_at("twice the same", _same, first.columns, again.columns, "the second time")
    yield looked_at("the same behind another scene", _same, first.columns, behind.columns, "the second time")
    yield looked_at("the same from another process", _same_there, bench, first)


def _same(first: Mapping[str, Array], second: Mapping[str, Array], when: str, errors: Mapping[str, float] | None = None) -> None:
    """Fault if a column differs; `errors`: of the columns by the engine's own estimate, in their units."""
    for name, values in first.items():
        allowed = max(_SAME * (rms(values) + 1e-12), _OF_ERROR * (errors or {}).get(name, 0.0))
        if name in COMPARED and (len(values) != len(second[name]) or rms(values - second[name]) > allowed):
            keep = "keep nothing between runs: no class attribute, module variable, random number or clock"
            raise Fault(f"{name} comes out another way {when}", keep)


def _same_there(bench: Bench, first: Trajectory) -> None:
    """Fault if a column differs, or if there is no run but a clause why; Unjudged if only the class is not to be had there."""
    other = bench.elsewhere
    if isinstance(other, str):
        words = other.lower()
        if "raised" in words and (("error" in words and "import" in words) or "attribute" in words or "pickle" in words):
            advice = "give it a module of its own and announce it as an entry point"
            raise Unjudged(f"the engine's class cannot be had in another process ({other})", advice)
        raise Fault(f"another process ends: {other}", "see what it says there")
    here, when = {name: first[name] for name in other}, "in another process"
    try:
        _same(here, other, when)
    except Fault:  # estimates take time: they are made where something depends on them
        _same(here, other, when, bench.estimates(replace(bench.mild, duration=_DURATION)))
