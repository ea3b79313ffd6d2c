"""What the command line asks of engines, each question in a process of its own.

A library that crashes, prints or holds on to the interpreter then costs no more than its own answer: Ctrl-C works at once, and
nothing but the command's own words gets to standard output. What an engine computed comes back through a pipe and is written here,
so that a worker which is killed leaves no half file behind.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from cases.workers import Job, Limits, Outcome, default_limits, run_jobs
from reports.output import plain, write_file

if TYPE_CHECKING:
    from cases.case import Case
    from engines.accurate import Result
    from engines.trajectory import Trajectory
    from reference_model.mechanism import Mechanism, Scene


_ADVICE: Final = "see the limits of time and memory, or report this to the author of the engine"


class EngineDied(Exception):
    """The process of an engine ended without an answer, or with an error that no engine should make; one sentence."""

    def __init__(self, sentence: str, outcome: Outcome) -> None:
        super().__init__(sentence)
        self.outcome = outcome


def answer_of(job: Job, limits: Limits | None = None) -> Any:
    """The job's value; `limits` None: `cases.workers.default_limits`.

    Raises:
        Refusal, SettingError, UnknownEngine, EngineFailure: as raised in the job.
        EngineDied: it ended in any other way.
    """
    (outcome,) = run_jobs([job], limits=limits or default_limits(), preload=())
    return value_of(outcome)


def value_of(outcome: Outcome) -> Any:
    """The value of a job that has ended; raises like `answer_of`."""
    if outcome.completed:
        return outcome.value
    from engines.base import EngineFailure, Refusal
    from engines.registry import UnknownEngine
    from engines.settings import SettingError

    if isinstance(outcome.error, (Refusal, SettingError, UnknownEngine, EngineFailure)):
        raise outcome.error
    raise EngineDied(f"engine {outcome.job.name}: {outcome.explanation}", outcome)


def about(name: str) -> dict[str, Any]:
    """Name, version, method, what the error estimate is of, and whether the engine can be used here or why not."""
    from engines.registry import engine

    found = engine(name)
    reason = found.unavailable()
    usable = {"version": found.version() if reason is None else None, "estimate_of": found.estimates if reason is None else None}
    return {"name": name, "method": found.method, **usable, "available": reason is None, "reason": reason}


def settings(name: str) -> dict[str, Any]:
    """`about`, with the accuracy that the engine works to unless asked, and its settings: name, what is accepted, meaning."""
    import dataclasses

    from engines.registry import engine

    def accepted(field: dataclasses.Field[Any]) -> str:
        about = field.metadata
        if about["choices"]:
            return ", ".join(about["choices"])
        return "true or false" if isinstance(field.default, bool) else f"{about['low']:g} to {about['high']:g} {about['unit']}".strip()

    found = engine(name)
    rows = [
        {"name": f"engine.{field.name}", "accepted": accepted(field), "meaning": field.metadata["meaning"]}
        for field in dataclasses.fields(found.settings_type)
    ]
    return about(name) | {"default_accuracy": found.default_accuracy, "settings": rows}


def model(name: str, scene: "Scene") -> dict[str, Any]:
    """What the engine builds for a scene with its default settings. Raises Refusal if it cannot."""
    from engines.registry import usable_engine
    from engines.scene import describe_scene

    built = describe_scene(usable_engine(name), scene)
    return {"bodies": built.bodies, "joints": built.joints, "degrees_of_freedom": built.degrees_of_freedom}


def modes(name: str, mechanism: "Mechanism", crank_angle: float, count: int, texts: Mapping[str, str]) -> dict[str, Any]:
    """Natural frequencies (Hz) with the crank held at `crank_angle` (rad). Raises as `engines.frozen_crank` does."""
    from engines.frozen_crank import natural_frequencies
    from engines.registry import usable_engine

    found = usable_engine(name)
    found.check(mechanism)
    settings = found.settings_for(found.default_accuracy, mechanism).with_texts(dict(texts))
    frequencies = natural_frequencies(found, mechanism, crank_angle, count, settings)
    return plain({"engine": name, "version": found.version(), "settings": settings.as_dict(), "frequencies": frequencies})


def simulate(
    name: str, case: "Case", texts: Mapping[str, str], accuracy: float | None, output: str, limits: Limits | None = None
) -> dict[str, Any]:
    """Simulate a case from its standard start and write the trajectory, as far as it got, to the file `output`.

    Returns:
        What `quickreturn simulate --json` prints: settings, times, error estimate; after a failure "failure" tells of it.

    Raises:
        Refusal, SettingError, UnknownEngine, OutputError.
    """
    document = {"case": case.name, "engine": name, "output": output, "notes": case.notes, "accuracy": accuracy}
    try:
        found, table = answer_of(Job(name, _simulated, (name, case, texts, accuracy)), limits)
    except EngineDied as death:
        return document | _failed(None, death.outcome.explanation, _ADVICE)
    if table is not None:
        write_file(Path(output), table)
    return document | found


def _simulated(name: str, case: "Case", texts: Mapping[str, str], accuracy: float | None) -> tuple[dict[str, Any], bytes | None]:
    """The part of `simulate` that happens in the worker: the document, and the trajectory as CSV as far as there is one."""
    from engines.base import EngineFailure
    from engines.registry import usable_engine
    from engines.scene import simulate_scene

    found = usable_engine(name)
    try:
        result = simulate_scene(found, case.scene, case.duration, case.output_step, texts, accuracy)
    except EngineFailure as failure:
        document, trajectory = _failed(failure.time, failure.cause, failure.advice, failure.partial), failure.partial
    else:
        document, trajectory = _completed(result), result.trajectory
    return plain({"version": found.version(), **document}), None if trajectory is None else _table(trajectory)


def _completed(result: "Result") -> dict[str, Any]:
    return {
        "rows": len(result.trajectory),
        "accuracy": result.accuracy,
        "reached": result.reached,
        "error_estimate": result.error_estimate,
        "error_estimates": result.error_estimates,
        "estimate_of": result.estimate_of,
        "remark": result.remark,
        "settings": result.settings.as_dict(),
        "setup_seconds": result.setup_seconds,
        "compile_seconds": result.compile_seconds,
        "solve_seconds": result.solve_seconds,
        "estimate_seconds": result.estimate_seconds,
        "statistics": result.trajectory.statistics,
        "bodies": result.description.bodies,
        "joints": result.description.joints,
        "degrees_of_freedom": result.description.degrees_of_freedom,
        "failure": None,
    }


def _failed(time: float | None, cause: str, advice: str, partial: "Trajectory | None" = None) -> dict[str, Any]:
    when = "" if time is None else f"failed at t = {time:.6g} s: "
    return {
        "rows": 0 if partial is None else len(partial),
        "reached": False,
        "error_estimate": None,
        "error_estimates": {},
        "estimate_of": None,
        "remark": f"{when}{cause}; {advice}",
        "settings": None,
        "setup_seconds": None,
        "compile_seconds": None,
        "solve_seconds": None if partial is None else partial.solve_seconds,
        "estimate_seconds": None,
        "statistics": {} if partial is None else partial.statistics,
        "failure": {"time": time, "cause": cause, "advice": advice},
    }


def _table(trajectory: "Trajectory") -> bytes:
    # pandas writes floats in full: the shortest text that reads back as the same number
    return trajectory.table().to_csv(index=False, lineterminator="\n").encode("ascii")
