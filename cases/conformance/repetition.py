"""Checks that an engine's answer depends on the scene and nothing else.

The answers come from separate processes with one thread each: sums in a different order of threads differ in the last digits, which is not
a mistake.
"""

import dataclasses
import pickle
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

import numpy as np

from quickreturn.cases.conformance.bench import DECISIVE, Bench, Motion, compared_columns, engine_from, solution
from quickreturn.cases.conformance.checks import LEFT_OUT, NOT_QUICK, Array, Check, Fault, Unjudged, check_by
from quickreturn.cases.jobs.display import answers
from quickreturn.cases.jobs.isolation import STOPPED
from quickreturn.cases.jobs.job import Job
from quickreturn.cases.jobs.processes import LocalProcesses
from quickreturn.cases.mistakes.explanation import Hypothesis, explain
from quickreturn.engines.base import AnyEngine, EngineFailure
from quickreturn.engines.relative import rms
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import changed

_DURATION: Final = 0.1  # s
#: Relative difference that is allowed in a column.
_SAME: Final = 1e-6
#: Allowed difference as a part of the engine's own error, by what its estimate covers. With different last digits a step size control takes
#: other steps, so that the integration's error has another value of the same size, which is a small part of the total error.
_OF_ERROR: Final = {"total": 0.02, "integration": 1.0, "unverified": 0.02}
#: Part of a scene -> its change, which reveals a kept state.
PARTS: Final[Mapping[str, Mapping[str, Any]]] = {
    "crank": {"crank.length": 0.09, "crank.inertia": 4e-3},
    "tip": {"tip.mass": 0.1},
    "follower": {"follower.bending_stiffness": 9.0, "follower.mass_per_length": 0.5},
}
_FIRST: Final = "the mild scene"
#: Scenes that one process computes one after the other, and those that have a process each; names that are no part's are the mild scene.
IN_TURN: Final = (_FIRST, "the second time", *PARTS, "behind other scenes")
ALONE: Final = (_FIRST, "in another process", *PARTS)
_KEEP: Final = "keep nothing between runs: no class attribute, module variable, random number or clock"

#: Scene -> its columns in a process.
Results = Mapping[str, Mapping[str, Array]]


@dataclasses.dataclass(frozen=True)
class OtherProcesses:
    """Results of an engine in other processes."""

    # each scene after the others, in one process; the mild scene again, and once more at the end
    in_turn: Results = dataclasses.field(default_factory=dict)
    alone: Results = dataclasses.field(default_factory=dict)  # each scene in a process of its own, the mild one twice
    reason: str = ""  # why there are no results; "" if there are


NOT_TRIED: Final = OtherProcesses(reason="not tried")


def columns_of(engine: AnyEngine | str, names: tuple[str, ...]) -> dict[str, dict[str, Array]]:
    """Columns of scenes, one after the other in this process: with one of `PARTS` changed, or of the mild scene for any other name."""
    tested = engine_from(engine)
    bench = Bench(tested)
    settings, found = bench.settings(bench.scene), dict[str, dict[str, Array]]()
    for name in names:
        run = Motion(_scene(bench, name), _DURATION).by(tested, settings)
        found[name] = {column: run[column] for column in compared_columns(run)}
    return found


def elsewhere(engine: AnyEngine | str) -> OtherProcesses:
    """Results of the engine in separate processes."""
    try:
        pickle.dumps(engine)
    except Exception as error:  # of whatever kind pickle makes it
        return OtherProcesses(reason=f"pickle raised {type(error).__name__}: {error}")
    if engine_from(engine).compiles:  # compiled and loaded code may differ in the last digits: all processes shall load it
        answers(LocalProcesses(1), [Job("compiling", columns_of, (engine, (_FIRST,)))], "other processes")
    jobs = [Job("scenes in turn", columns_of, (engine, IN_TURN)), *(Job(name, columns_of, (engine, (name,))) for name in ALONE)]
    outcomes = answers(LocalProcesses(2), jobs, "other processes")
    for outcome in outcomes:
        if outcome.failure.startswith(STOPPED):
            return OtherProcesses(reason=f"{LEFT_OUT}: it was {outcome.failure}")
        if outcome.value is None:
            return OtherProcesses(reason=outcome.explanation)
    in_turn, *alone = (outcome.value or {} for outcome in outcomes)
    return OtherProcesses(in_turn, {name: columns for of_process in alone for name, columns in of_process.items()})


def _scene(bench: Bench, name: str) -> Mechanism:
    return changed(bench.scene, PARTS.get(name, {}))


def repetition(bench: Bench, other: OtherProcesses) -> Iterator[Check]:
    """Checks of the same scene again, after other scenes, and in another process."""
    if other.reason.startswith(LEFT_OUT):
        yield Check("twice the same", "not judged", other.reason, NOT_QUICK)
        return
    if other.reason:
        # a class that exists in this process alone: its last digits may depend on threads, which its own error covers
        try:
            in_turn: Results = columns_of(bench.engine, IN_TURN)
        except EngineFailure as failure:
            yield Check("twice the same", "not judged", failure.cause, failure.advice)
            return
    else:
        in_turn = other.in_turn
    yield check_by("twice the same", _same, bench, in_turn[_FIRST], in_turn["the second time"], "the second time")
    yield check_by("the same behind another scene", _same, bench, in_turn[_FIRST], in_turn["behind other scenes"], "behind other scenes")
    yield check_by("the same from another process", _same_there, bench, other)
    for part in PARTS:
        if other.reason:
            yield Check(f"nothing kept of an earlier {part}", "not judged", "it takes other processes")
        else:
            yield check_by(f"nothing kept of an earlier {part}", _nothing_kept, bench, part, in_turn[part], other.alone[part])


def _same(bench: Bench, first: Mapping[str, Array], second: Mapping[str, Array], when: str) -> None:
    """Fault if a column differs."""
    if name := _differing(bench, first, second):
        raise Fault(f"{name} comes out another way {when}", _KEEP)


def _differing(bench: Bench, first: Mapping[str, Array], second: Mapping[str, Array]) -> str:
    """The first column that differs by more than rounding, and by more than a small part of the engine's own error; "" if none does."""

    def among(names: Iterable[str], allowed: Mapping[str, float]) -> list[str]:
        same_length = {name: len(first[name]) == len(second[name]) for name in names}
        return [name for name, same in same_length.items() if not same or rms(first[name] - second[name]) > allowed.get(name, 0.0)]

    names = among(first, {name: _SAME * (rms(values) + 1e-12) for name, values in first.items()})
    if names:  # its own error is computed only if needed, because that takes time
        part, errors = _OF_ERROR[bench.engine.estimates], bench.estimates(Motion(bench.scene, _DURATION)) or {}
        names = among(names, {name: part * error for name, error in errors.items()})
    return names[0] if names else ""


def _same_there(bench: Bench, other: OtherProcesses) -> None:
    """Fault if two processes differ, or if there is none; Unjudged if the class does not exist there."""
    if other.reason:
        words = other.reason.lower()
        if "raised" in words and (("error" in words and "import" in words) or "attribute" in words or "pickle" in words):
            advice = "give it a module of its own and announce it as an entry point"
            raise Unjudged(f"the engine's class cannot be had in another process ({other.reason})", advice)
        raise Fault(f"another process ends: {other.reason}", "see what it says there")
    _same(bench, other.alone[_FIRST], other.alone["in another process"], "in another process")


def _nothing_kept(bench: Bench, part: str, behind: Mapping[str, Array], fresh: Mapping[str, Array]) -> None:
    """Fault if a scene gives other results after other scenes than in a new process; it names the kept part, if it is a single one."""
    if not (name := _differing(bench, fresh, behind)):
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
