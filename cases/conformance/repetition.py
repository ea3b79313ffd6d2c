"""An engine's answer depends on the scene and nothing else.

What is compared are answers of processes of their own, all with one thread: sums that threads make in another order differ in the last
digits, and that is no mistake.
"""

import dataclasses
import pickle
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from quickreturn.cases.conformance.bench import DECISIVE, Bench, Motion, columns_of, found_engine, solution
from quickreturn.cases.conformance.checks import LEFT_OUT, Array, Check, Fault, Unjudged, looked_at
from quickreturn.cases.explanation import Hypothesis, explain
from quickreturn.cases.jobs.display import answers
from quickreturn.cases.jobs.isolation import STOPPED
from quickreturn.cases.jobs.job import Job, Limits, default_limits
from quickreturn.cases.jobs.processes import LocalProcesses
from quickreturn.engines.base import AnyEngine, EngineFailure
from quickreturn.engines.relative import rms
from quickreturn.reference_model.mechanism import Mechanism, changed

_DURATION: Final = 0.1  # s
#: Part of a column by which it may differ.
_SAME: Final = 1e-6
#: Part of its own error that an engine may differ by, by what its estimate is of. Other last digits lead a step size control to other
#: steps, and the integration's error to another value of the same size; of the whole error that is a small part.
_OF_ERROR: Final = {"total": 0.02, "integration": 1.0, "unverified": 0.02}
#: Part of a scene -> what is changed in it, so that a state kept of it shows.
PARTS: Final[Mapping[str, Mapping[str, Any]]] = {
    "crank": {"crank.length": 0.09, "crank.inertia": 4e-3},
    "tip": {"tip.mass": 0.1},
    "follower": {"follower.bending_stiffness": 9.0, "follower.mass_per_length": 0.5},
}
_FIRST: Final = "the mild scene"
_KEEP: Final = "keep nothing between runs: no class attribute, module variable, random number or clock"

#: What was found of each scene in a process: columns, or why there are none.
Found = Mapping[str, Mapping[str, Array]]


@dataclasses.dataclass(frozen=True)
class Elsewhere:
    """What came of an engine in other processes."""

    # each scene behind the others, in one process; the mild scene again, and at the end once more
    in_turn: Found = dataclasses.field(default_factory=dict)
    alone: Found = dataclasses.field(default_factory=dict)  # each scene in a process of its own, the mild one twice
    reason: str = ""  # why there is nothing; "" where there is


NOT_TRIED: Final = Elsewhere(reason="not tried")


def scenes_in_turn(engine: AnyEngine | str) -> dict[str, dict[str, Array]]:
    """Columns of the mild scene, of the same again, of each of `PARTS` changed, and of the mild scene behind them."""
    found = found_engine(engine)
    return {name: _columns(found, name) for name in (_FIRST, "the second time", *PARTS, "behind other scenes")}


def one_scene(engine: AnyEngine | str, name: str) -> dict[str, Array]:
    """Columns of one of these scenes."""
    return _columns(found_engine(engine), name)


def elsewhere(engine: AnyEngine | str, seconds: float | None = None) -> Elsewhere:
    """What comes of the engine in processes of their own; `seconds`: wall time that each may take, None: as long as it takes."""
    try:
        pickle.dumps(engine)
    except Exception as error:  # of whatever kind pickle makes it
        return Elsewhere(reason=f"pickle raised {type(error).__name__}: {error}")
    limits = None if seconds is None else Limits(seconds, default_limits().memory)
    if found_engine(engine).compiles:  # what a process compiles and what it loads may differ in the last digits: all shall load it
        answers(LocalProcesses(1, limits), [Job("compiling", one_scene, (engine, _FIRST))], "other processes")
    names = (_FIRST, "in another process", *PARTS)
    jobs: list[Job[Any]] = [Job("scenes in turn", scenes_in_turn, (engine,)), *(Job(name, one_scene, (engine, name)) for name in names)]
    first, *others = answers(LocalProcesses(2, limits), jobs, "other processes")
    for outcome in (first, *others):
        if outcome.failure.startswith(STOPPED):
            return Elsewhere(reason=f"{LEFT_OUT}: it was {outcome.failure}")
        if outcome.value is None:
            return Elsewhere(reason=outcome.explanation)
    return Elsewhere(first.value or {}, {name: outcome.value or {} for name, outcome in zip(names, others, strict=True)})


def _scene(bench: Bench, name: str) -> Mechanism:
    return changed(bench.scene, PARTS.get(name, {}))


def _columns(engine: AnyEngine, name: str) -> dict[str, Array]:
    bench = Bench(engine)
    run = Motion(_scene(bench, name), _DURATION).by(engine, bench.settings(bench.scene))
    return {column: run[column] for column in columns_of(run)}


def repetition(bench: Bench, other: Elsewhere) -> Iterator[Check]:
    """The same scene again, behind other scenes, and in another process."""
    if other.reason.startswith(LEFT_OUT):
        yield Check("twice the same", "not judged", other.reason, "try it without --quick")
        return
    if other.reason:
        # a class that is to be had here alone: its last digits may depend on threads here, which its own error covers
        try:
            in_turn: Found = {name: _columns(bench.engine, name) for name in (_FIRST, "the second time", *PARTS, "behind other scenes")}
        except EngineFailure as failure:
            yield Check("twice the same", "not judged", failure.cause, failure.advice)
            return
    else:
        in_turn = other.in_turn
    yield looked_at("twice the same", _same, bench, in_turn[_FIRST], in_turn["the second time"], "the second time")
    yield looked_at("the same behind another scene", _same, bench, in_turn[_FIRST], in_turn["behind other scenes"], "behind other scenes")
    yield looked_at("the same from another process", _same_there, bench, other)
    for part in PARTS:
        if other.reason:
            yield Check(f"nothing kept of an earlier {part}", "not judged", "it takes other processes")
        else:
            yield looked_at(f"nothing kept of an earlier {part}", _nothing_kept, bench, part, in_turn[part], other.alone[part])


def _same(bench: Bench, first: Mapping[str, Array], second: Mapping[str, Array], when: str) -> None:
    """Fault if a column differs by more than rounding, and by more than a small part of the engine's own error."""
    if _differing(first, second, {}) and (name := _differing(first, second, _errors(bench))):
        raise Fault(f"{name} comes out another way {when}", _KEEP)


def _errors(bench: Bench) -> Mapping[str, float]:
    """By how much columns may differ for the engine's own error, in their units. It takes time: it is only made where it matters."""
    part = _OF_ERROR[bench.engine.estimates]
    return {name: part * error for name, error in (bench.estimates(Motion(bench.scene, _DURATION)) or {}).items()}


def _differing(first: Mapping[str, Array], second: Mapping[str, Array], errors: Mapping[str, float]) -> str:
    """The first column that differs; "" where none does."""
    for name, values in first.items():
        allowed = max(_SAME * (rms(values) + 1e-12), errors.get(name, 0.0))
        if len(values) != len(second[name]) or rms(values - second[name]) > allowed:
            return name
    return ""


def _same_there(bench: Bench, other: Elsewhere) -> None:
    """Fault if two processes differ, or if there is none; Unjudged if only the class is not to be had there."""
    if other.reason:
        words = other.reason.lower()
        if "raised" in words and (("error" in words and "import" in words) or "attribute" in words or "pickle" in words):
            advice = "give it a module of its own and announce it as an entry point"
            raise Unjudged(f"the engine's class cannot be had in another process ({other.reason})", advice)
        raise Fault(f"another process ends: {other.reason}", "see what it says there")
    _same(bench, other.alone[_FIRST], other.alone["in another process"], "in another process")


def _nothing_kept(bench: Bench, part: str, behind: Mapping[str, Array], fresh: Mapping[str, Array]) -> None:
    """Fault if a scene comes out another way behind others than in a new process; names the part that is kept, if it is one."""
    if not _differing(fresh, behind, {}) or not (name := _differing(fresh, behind, _errors(bench))):
        return
    scene = _scene(bench, part)
    names = [column for column in DECISIVE if column in fresh and rms(fresh[column]) > 0.0]

    def stacked(columns: Mapping[str, Array]) -> Array:
        return np.concatenate([columns[column] / rms(fresh[column]) for column in names])

    right, kept = (solution(Motion(each, _DURATION)) for each in (scene, bench.scene))
    expected, there = stacked(fresh), stacked(behind)
    stale = Hypothesis(f"the {part} of an earlier scene is kept", "", expected + stacked(kept) - stacked(right))
    explained = explain(there, expected, [stale], coarse=True)
    cause = f"behind other scenes {name} comes out another way than in a new process"
    raise Fault(f"{explained.words}: {cause}" if explained else cause, _KEEP)
