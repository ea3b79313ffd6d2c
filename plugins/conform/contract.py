"""Tries whether an adapter does what it says: an engine on mild scenes, against `reference`, closed forms and its own claims.

A coarse engine conforms, too: its own error estimate is the tolerance of each column. Without an estimate a check fails only if the
difference has one plain explanation. An engine that models a follower alone, and no mechanism, is tried as a rod.

An engine's answer depends on the scene and nothing else: no earlier scene, process or second call. Answers are compared from separate
processes with one thread each: sums in a different order of threads differ in the last digits, which is not a mistake.
"""

import math
import os
import pickle
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.running.display import answers
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.job import Executor, Job, ThisProcess
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.registry import UnknownEngine
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Trajectory, rms
from quickreturn.plugins.conform.bench import Bench, Check, Conformance, Fault, Motion, check_by, compared_columns, ended, engine_from, some
from quickreturn.plugins.conform.columns import motion
from quickreturn.plugins.conform.promises import frequencies, ladder
from quickreturn.plugins.conform.quantities import alone, quantities
from quickreturn.plugins.conform.rods import rods
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.scene_values import changed

#: Changes of the mild scene, SI: a slack follower whose bent end the slider reaches at the farthest place.
_PUSHED_OFF: Final = {"crank.length": 0.1795, "crank.initial_angle": 0.5, "follower.bending_stiffness": 10.0, "tip.mass": 0.1}
#: Allowed relative error of the time at which the slider leaves; largest plausible deflection over the follower's length.
_TIME_ERROR: Final = 0.3
_BENT: Final = 0.4
#: Words in the cause of a failure that the engine did not report itself.
_UNSAID: Final = ("the engine raised", "the engine returned", "no longer a finite number")


def failures(bench: Bench) -> Iterator[Check]:
    """Checks of motions that cannot be, and of one in which a fixed step for a soft follower is unstable."""
    length = bench.scene.follower.length
    out_of_reach = changed(bench.scene, {"crank.length": length - bench.scene.pivot_distance - 1e-3})
    x = np.linspace(0.0, length, 65)
    bent = Start(math.pi, standard_start(out_of_reach).crank_speed, CubicSpline(x, 0.45 * length * (x / length) ** 2))
    leaving, stiff = changed(bench.scene, _PUSHED_OFF), changed(bench.scene, {"follower.bending_stiffness": 2e4})
    yield check_by("failures: the slider leaves the follower", _reported, bench, Motion(leaving, 0.4))
    yield check_by("failures: a start that cannot be", _reported, bench, Motion(out_of_reach, 0.01, start=bent))
    yield check_by("failures: a step that explodes", _reported, bench, Motion(stiff, 0.1))


def _attempt(bench: Bench, motion: Motion) -> Trajectory | EngineFailure:
    """The engine's trajectory, or the failure that it reports. Fault: it fails without a report."""
    try:
        return motion.by(bench.engine, bench.settings(bench.scene))  # those for the mild scene, like a fixed step
    except EngineFailure as failure:
        if any(words in failure.cause for words in _UNSAID):
            raise Fault(f"the engine does not say that the run cannot go on: {failure.cause}") from failure
        return failure


def _reported(bench: Bench, motion: Motion) -> None:
    """Check that the engine reports a failure where `reference` does, and otherwise computes a plausible motion or reports one."""
    length, right, run = motion.scene.follower.length, _attempt(Bench(ReferenceEngine()), motion), _attempt(bench, motion)
    if isinstance(run, EngineFailure):
        if isinstance(right, EngineFailure) and bench.claims and abs(run.time - right.time) > _TIME_ERROR * right.time:
            raise Fault(f"the failure is at {run.time:.4g} s, in reference at {right.time:.4g} s")
        return
    place, deflection = float(run["slider_position"].max()), float(np.abs(run["tip_deflection"]).max())
    if place > 1.001 * length or deflection > _BENT * length or (isinstance(right, EngineFailure) and bench.claims):
        raise Fault(f"the run goes on in silence: slider up to {place:.4g} m of {length:.4g} m, deflection {deflection:.3g} m")


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
#: Scenes that one process computes one after the other, and those that have a process each; names that are no part's are the mild scene.
IN_TURN: Final = ("first", "the second time", *PARTS, "behind other scenes")
ALONE: Final = ("in another process", *PARTS)

#: Scene -> its columns.
Results = Mapping[str, Mapping[str, Array]]


def columns_of(engine: AnyEngine | str, names: tuple[str, ...]) -> Results:
    """Columns of scenes, one after the other in this process: with one of `PARTS` changed, or of the mild scene for any other name."""
    tested = engine_from(engine)
    bench, found = Bench(tested), dict[str, dict[str, Array]]()
    for name in names:
        run = Motion(changed(bench.scene, PARTS.get(name, {})), _DURATION).by(tested, bench.settings(bench.scene))
        found[name] = {column: run[column] for column in compared_columns(run)}
    return found


def elsewhere(engine: AnyEngine | str) -> tuple[Results, Results] | str:
    """Results of the engine in one process for all scenes and in a process for each; or why there are none."""
    try:
        pickle.dumps(engine)
    except Exception as error:  # of whatever kind pickle makes it
        return f"pickle raised {type(error).__name__}: {error}"
    if engine_from(engine).compiles:  # compiled and loaded code may differ in the last digits: all processes shall load it
        answers(LocalProcesses(1), [Job("compiling", columns_of, (engine, IN_TURN[:1]))], "other processes")
    jobs = [Job("scenes in turn", columns_of, (engine, IN_TURN)), *(Job(name, columns_of, (engine, (name,))) for name in ALONE)]
    outcomes = answers(LocalProcesses(2), jobs, "other processes")
    in_turn, *alone = (outcome.value or {} for outcome in outcomes)
    for outcome in outcomes:
        if outcome.value is None:
            return outcome.explanation
    return in_turn, {name: columns for of_process in alone for name, columns in of_process.items()}


def repetition(bench: Bench, other: tuple[Results, Results] | str) -> Iterator[Check]:
    """Checks of the same scene again, after other scenes, and in another process; `other`: as `elsewhere` gives it."""
    # a class that exists in this process alone: its last digits may depend on threads, which its own error covers
    in_turn, alone = other if not isinstance(other, str) else (columns_of(bench.engine, IN_TURN), {})
    for name in (IN_TURN[1], IN_TURN[-1]):
        yield check_by(f"the same {name}", _same, bench, in_turn[IN_TURN[0]], in_turn[name])
    if isinstance(other, str):
        yield Check("the same in other processes", "not judged", other, "announce the engine's class as an entry point")
        return
    yield check_by("the same in another process", _same, bench, in_turn[IN_TURN[0]], alone[ALONE[0]])
    for part in PARTS:
        yield check_by(f"nothing kept of an earlier {part}", _same, bench, alone[part], in_turn[part])


def _same(bench: Bench, first: Mapping[str, Array], second: Mapping[str, Array]) -> None:
    """Fault if a column differs by more than rounding, and by more than a small part of the engine's own error."""
    off = {name: rms(values - second[name]) for name, values in first.items()}
    differ = [name for name, values in first.items() if off[name] > _SAME * (rms(values) + 1e-12)]
    errors = bench.estimates(Motion(bench.scene, _DURATION)) or {} if differ else {}  # only if needed, because that takes time
    differ = [name for name in differ if off[name] > _OF_ERROR[bench.engine.estimates] * errors.get(name, 0.0)]
    if differ:
        raise Fault(f"another result in {some(differ)}")


__all__ = ["GROUPS", "Check", "Conformance", "conform", "job"]


def _follower_alone(bench: Bench, *_: Any) -> Iterator[Check]:
    """The follower alone; of an engine that models nothing else, as a clamped rod first."""
    if bench.scene.crank is None:
        yield from rods(bench)
    yield from alone(bench)


#: Groups of checks by name, in the order of the output. Each gets the bench, and the engine's results in other processes.
GROUPS: Final[Mapping[str, Callable[..., Iterator[Check]]]] = {
    "motion": lambda bench, _: motion(bench),
    "quantities": lambda bench, _: quantities(bench),
    "resolution": lambda bench, _: ladder(bench),
    "frequencies": lambda bench, _: frequencies(bench),
    "failures": lambda bench, _: failures(bench),
    "follower alone": _follower_alone,
    "repetition": repetition,
}
#: Groups of a quick trial.
QUICK: Final = ("motion", "frequencies", "failures")


def conform(
    engine: AnyEngine | str | os.PathLike[str],
    executor: Executor | None = None,
    groups: tuple[str, ...] = tuple(GROUPS),
    *,
    quick: bool = False,
    quiet: bool = False,
) -> Conformance:
    """Try an engine.

    Args:
        engine: an instance, the name of one that is installed, or the path of a file that declares one.
        executor: computes each group separately, so that a crash loses only that group; None: this process.
        groups: names of groups of checks, see `GROUPS`; of an engine without mechanism all are those of the follower alone.
        quick: whether only the groups `QUICK` are tried.
        quiet: in this process, whether progress on standard error is left out.

    Raises:
        UnknownEngine: there is no engine of this name.
        Refusal: it cannot be used here.
    """
    engine = os.fspath(engine) if isinstance(engine, os.PathLike) else engine
    tested = engine_from(engine)
    groups = ("follower alone",) if _models_no_mechanism(tested) else QUICK if quick else groups
    # here, because the process of a job may not start processes
    other = elsewhere(engine) if "repetition" in groups else ""
    jobs = [Job(group, trial, (group, engine, other)) for group in groups]
    checks = list[Check]()
    for outcome in answers(executor or ThisProcess(quiet), jobs, f"engine {tested.name}"):
        if isinstance(outcome.error, (Refusal, UnknownEngine)):
            raise outcome.error
        checks += outcome.value or [ended(outcome.job.name, Fault(f"the engine's process ends: {outcome.explanation}"))]
    statuses = {check.status for check in checks}
    return Conformance(tested.name, False if "failed" in statuses else True if "passed" in statuses else None, tuple(checks))


def _models_no_mechanism(engine: AnyEngine) -> bool:
    """Whether it models a follower alone."""
    try:
        return Bench(engine).scene.crank is None
    except Exception:  # of whatever kind: each group says so
        return False


def trial(group: str, engine: AnyEngine | str, other: Any) -> list[Check]:
    """The checks of one group; an exception that no engine may raise ends them. `other`: its results in other processes."""
    checks = list[Check]()
    try:
        checks.extend(GROUPS[group](Bench(engine_from(engine)), other))
    except Exception as error:  # an author's engine may raise anything
        checks.append(ended(group, error))
    return checks


def job(engine: str) -> Job[Conformance]:
    """The stored form of `conform` for an installed engine: for this version and code of the engine."""
    return Job(f"conformance of {engine}", conform, (engine,), "conformance", (engine,))
