"""Studies that the report shows beside the 24 runs: accuracy against a confirmed solution, convergence, and what the thesis leaves open."""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from cases.case_file import load_case
from cases.jobs.job import Job
from cases.jobs.workshop import Workshop
from cases.measures import CHANNELS, on_common_grid, relative_change
from cases.runs.campaign import Work, carry_out
from cases.runs.comparison import HALVES
from cases.runs.marching import Columns, channels_of
from cases.runs.request import Run, RunRequest
from engines.accurate import ESTIMATED, run_once, simulate
from engines.convergence import convergence_table
from engines.own.reference import ReferenceEngine, ReferenceSettings
from engines.registry import MAIN, engine
from engines.settings import as_texts
from engines.start import standard_start
from reference_model.mechanism import Mechanism

#: The case on which accuracy is shown, and the settings whose three solutions confirm each other.
ACCURACY_CASE: Final = "thesis-24"
CONVERGED: Final = ("reference", {"modes": "9", "tolerance": "1e-9"})
CONFIRMING: Final = {"exudyn": {"elements": "32", "step": "1e-4"}, "mujoco": {"links": "60", "armature": "0"}}
#: Modes and tolerances of the convergence table of the reference; the last of each is the solution it is measured against.
MODES: Final = (1, 2, 3, 4, 5, 6, 7, 9, 11)
TOLERANCES: Final = (1e-5, 1e-7, 1e-9)
#: Runs on which the influence of what the thesis leaves open is shown.
OPEN_RUNS: Final = ("thesis-10", "thesis-24")

INCH: Final = 0.0254  # m


@dataclass(frozen=True)
class Studies:
    """Tables of all studies.

    Attributes:
        accuracy: one row per engine at its default accuracy: engine, settings, error of each column of `ESTIMATED` against the
            converged solution, error_estimate (of the tip deflection, the engine's own), solve_seconds, setup_seconds, remark.
        confirmation: one row per confirming engine: engine and settings of both solutions, and their difference for each column of
            `ESTIMATED`.
        convergence: see `engines.convergence.convergence_table`, for the engine `reference`.
        sensitivity: one row per run, change, half and quantity: run, change, half, quantity, channel, nominal, value, relative_change;
            value and relative_change are NaN where not resolvable.
        both_ways: one row per package that marches: engine, cycles and settling error from the orbit of the reference and from the standard
            start, and the difference of the two last cycles (RMS over the channels, relative to theirs).
        failures: sentences on what could not be computed.
    """

    accuracy: pd.DataFrame
    confirmation: pd.DataFrame
    convergence: pd.DataFrame
    sensitivity: pd.DataFrame
    both_ways: pd.DataFrame
    failures: tuple[str, ...]


def work() -> Work:
    """All that the studies need, to be computed with other runs; `run_studies` then finds it in the store."""
    return Work({**_from_orbit(), **_straight(), **_open_requests()}, [job for _, job in _solutions()])


def run_studies(workshop: Workshop) -> Studies:
    """All studies, from the store where they are there.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    failures: list[str] = []
    names, jobs = zip(*_solutions(), strict=True)
    solutions = dict(zip(names, workshop.outcomes(jobs, "studies"), strict=True))
    failures += [f"study {outcome.job.name}: {outcome.explanation}" for outcome in solutions.values() if not outcome.completed]
    convergence = solutions.pop(_CONVERGENCE).value
    accuracy, confirmation = _accuracy_tables({name: outcome.value for name, outcome in solutions.items() if outcome.value is not None})
    results = carry_out({**_from_orbit(), **_straight(), **_open_requests()}, workshop, "what the thesis leaves open, and another start")
    sensitivity = _sensitivity(results, failures)
    both_ways = _both_ways(results, failures)
    return Studies(accuracy, confirmation, pd.DataFrame(convergence or []), sensitivity, both_ways, tuple(failures))


_CODE: Final = ("cases.studies",)

Name = tuple[str, ...]
Runs = Mapping[Name, Run]
_CONVERGENCE: Final = ("convergence", "reference")


def _solutions() -> list[tuple[Name, Job[Any]]]:
    """Trajectories of one case, and the convergence of the reference there."""
    case = load_case(ACCURACY_CASE)
    scene = (case.mechanism, case.duration, case.output_step)
    wanted: list[tuple[str, str, Mapping[str, str] | None]] = [("confirming", *other) for other in CONFIRMING.items()]
    wanted += [("converged", *CONVERGED), *(("default", name, None) for name in MAIN)]
    jobs: list[tuple[Name, Job[Any]]] = [
        ((what, name), Job(f"{what} {name}", _trajectory, (*scene, name, settings), "study", (name,), _CODE))
        for what, name, settings in wanted
    ]
    return [*jobs, (_CONVERGENCE, Job("convergence", _convergence, scene, "study", ("reference",), _CODE))]


@dataclass(frozen=True)
class StudiedTrajectory:
    """A trajectory from the standard start, and what it took; estimate and what follows it belong to one to an accuracy."""

    engine: str
    settings: dict[str, Any]
    solve_seconds: float
    setup_seconds: float
    columns: Columns
    error_estimate: float | None = None
    degrees_of_freedom: int | None = None
    remark: str = ""


def _trajectory(
    mechanism: Mechanism, duration: float, output_step: float, name: str, settings: Mapping[str, str] | None
) -> StudiedTrajectory:
    """To the engine's default accuracy, or once with given settings."""
    chosen, start = engine(name), standard_start(mechanism)
    if settings is not None:
        used = chosen.settings_for(chosen.default_accuracy, mechanism).with_texts(dict(settings))
        trajectory, setup_seconds = run_once(chosen, mechanism, start, duration, output_step, used)
        return StudiedTrajectory(name, used.as_dict(), trajectory.solve_seconds, setup_seconds, dict(trajectory.columns))
    result = simulate(chosen, mechanism, start, duration, output_step)
    return StudiedTrajectory(
        engine=name,
        settings=result.settings.as_dict(),
        solve_seconds=result.solve_seconds,
        setup_seconds=result.setup_seconds,
        columns=dict(result.trajectory.columns),
        error_estimate=result.error_estimate,
        degrees_of_freedom=result.description.degrees_of_freedom,
        remark=result.remark,
    )


def _convergence(mechanism: Mechanism, duration: float, output_step: float) -> list[dict[str, Any]]:
    ladder = [ReferenceSettings(modes=modes, tolerance=tolerance) for modes in MODES for tolerance in TOLERANCES]
    table = convergence_table(ReferenceEngine(), mechanism, ladder, duration, output_step)
    return [{str(key): value for key, value in row.items()} for row in table.to_dict("records")]


def relative_error(values: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
    """RMS of the difference over the RMS of the truth, both of shape (n,)."""
    return float(np.sqrt(np.mean((values - truth) ** 2) / np.mean(truth**2)))


def _accuracy_tables(found: Mapping[Name, StudiedTrajectory]) -> tuple[pd.DataFrame, pd.DataFrame]:
    name, _ = CONVERGED
    if ("converged", name) not in found:
        return pd.DataFrame(), pd.DataFrame()
    truth = found["converged", name]
    accuracy, confirmation = [], []
    for (what, _), run in found.items():
        errors = {column: relative_error(run.columns[column], truth.columns[column]) for column in ESTIMATED}
        about = {field.name: getattr(run, field.name) for field in dataclasses.fields(run) if field.name != "columns"}
        if what == "default":
            accuracy.append(about | {"settings": _settings_text(run.settings)} | errors)
        elif what == "confirming":
            texts = {"engine": truth.engine, "settings": _settings_text(truth.settings)}
            texts |= {"confirmed_by": run.engine, "with_settings": _settings_text(run.settings)}
            confirmation.append(texts | errors)
    return pd.DataFrame(accuracy), pd.DataFrame(confirmation)


def _settings_text(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in settings.items())


def open_changes(mechanism: Mechanism) -> dict[str, Mechanism]:
    """What the thesis leaves open, as changed scenes, by a text that names the change."""
    follower, slider = mechanism.follower, mechanism.slider
    tip = mechanism.tip_body

    def stiffness(factor: float) -> Mechanism:
        return dataclasses.replace(mechanism, follower=dataclasses.replace(follower, bending_stiffness=factor * follower.bending_stiffness))

    def damping(factor: float) -> Mechanism:
        return dataclasses.replace(mechanism, follower=dataclasses.replace(follower, damping=factor * follower.damping))

    return {
        "tip centre of mass 0.5 in beyond the end": dataclasses.replace(mechanism, tip=dataclasses.replace(tip, center_of_mass=0.5 * INCH)),
        "slider mass 0.1 kg": dataclasses.replace(mechanism, slider=dataclasses.replace(slider, mass=0.1)),
        "slider inertia 2e-5 kg m²": dataclasses.replace(mechanism, slider=dataclasses.replace(slider, inertia=2e-5)),
        "EI + 5 %": stiffness(1.05),
        "EI - 5 %": stiffness(0.95),
        "beam damping doubled": damping(2.0),
        "beam damping halved": damping(0.5),
    }


#: The damping law is a setting of the model with fixed shapes: nominal and changed law are both taken from it, at this accuracy.
DAMPING_LAW: Final = "beam damping on the transverse velocity alone"
DAMPING_LAW_ACCURACY: Final = 3e-3


def _open_requests() -> dict[Name, RunRequest]:
    requests = dict[Name, RunRequest]()
    for name in OPEN_RUNS:
        case = load_case(name)
        scenes = {"": case.mechanism, **open_changes(case.mechanism)}
        for change, scene in scenes.items():
            requests[name, change] = RunRequest(mechanism=scene, duration=case.duration, engine="reference")
        for law in ("both components", "transverse"):
            requests[name, law] = RunRequest(
                mechanism=case.mechanism,
                duration=case.duration,
                engine="fixed-shapes",
                accuracy=DAMPING_LAW_ACCURACY,
                settings={"damping_law": law},
                estimated=False,
            )
    return requests


def _sensitivity(results: Runs, failures: list[str]) -> pd.DataFrame:
    rows: list[dict[str, Any]] = []
    for name in OPEN_RUNS:
        changes = list(open_changes(load_case(name).mechanism))
        pairs = [(change, results[name, change], results[name, ""]) for change in changes]
        pairs.append((DAMPING_LAW, results[name, "transverse"], results[name, "both components"]))
        for change, run, nominal in pairs:
            if run.usable and nominal.usable:
                rows += _changes(name, change, run, nominal)
            else:
                failures.append(f"study {name} {change}: {run.remark or nominal.remark}")
    return pd.DataFrame(rows)


#: Packages that march from the standard start, too, on one run: that they get to the same cycle is seen, not assumed.
PACKAGES: Final = ("exudyn", "mujoco")


def _from_orbit() -> dict[Name, RunRequest]:
    case = load_case(ACCURACY_CASE)
    return {(name, "orbit"): RunRequest(mechanism=case.mechanism, duration=case.duration, engine=name) for name in PACKAGES}


def _straight() -> dict[Name, RunRequest]:
    """With the settings that the runs from the orbit begin with; where those needed finer ones the two are no pair."""
    case, requests = load_case(ACCURACY_CASE), dict[Name, RunRequest]()
    for name in PACKAGES:
        chosen = engine(name)
        settings = as_texts(chosen.settings_for(chosen.default_accuracy, case.mechanism).as_dict())
        requests[name, "straight"] = RunRequest(
            mechanism=case.mechanism, duration=case.duration, engine=name, settings=settings, straight=True, estimated=False
        )
    return requests


def _both_ways(results: Runs, failures: list[str]) -> pd.DataFrame:
    rows: list[dict[str, Any]] = []
    for name in PACKAGES:
        orbit, straight = results[name, "orbit"], results[name, "straight"]
        if not (orbit.usable and straight.usable) or orbit.settings != straight.settings:
            reason = straight.remark or orbit.remark or "the run from the orbit needed finer settings than the other was given"
            failures.append(f"study of {name} from both starts: {reason}")
            continue
        found: dict[str, Any] = {"engine": name, "difference": cycle_difference(straight.cycle, orbit.cycle)}
        for way, run in (("orbit", orbit), ("straight", straight)):
            found |= {f"{way}_start": run.start, f"{way}_cycles": run.cycles, f"{way}_settling_error": run.settling_error}
        rows.append(found)
    return pd.DataFrame(rows)


def cycle_difference(one: Columns, other: Columns) -> float:
    """RMS over the channels of their difference in two cycles, each relative to its RMS in the first."""
    return relative_change(on_common_grid(channels_of(other)), on_common_grid(channels_of(one)))


def _changes(name: str, change: str, run: Run, nominal: Run) -> list[dict[str, Any]]:
    rows = []
    for half in HALVES:
        pairs: list[tuple[str, str, float | None, float | None]] = [
            ("first_mode_frequency", "consensus", nominal.consensus_frequency(half), run.consensus_frequency(half))
        ]
        for channel in CHANNELS:
            before, after = nominal.measure(half, channel), run.measure(half, channel)
            if before and after:
                pairs.append(("first_mode_amplitude", channel, before.first_mode_amplitude, after.first_mode_amplitude))
        for quantity, channel, old, new in pairs:
            known = old is not None and new is not None
            rows.append(
                {
                    "run": name,
                    "change": change,
                    "half": half,
                    "quantity": quantity,
                    "channel": channel,
                    "nominal": math.nan if old is None else old,
                    "value": math.nan if new is None else new,
                    "relative_change": new / old - 1.0 if known and old else math.nan,  # type: ignore[operator]
                }
            )
    return rows
