"""Studies that the report shows beside the 24 runs: accuracy against a confirmed solution, convergence, and what the thesis leaves open."""

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from cases.case import Case
from cases.case_file import load_case
from cases.comparison import HALVES
from cases.engine_run import EngineRun
from cases.fingerprint import SIMULATION, code_fingerprint
from cases.marching import Columns, channels_of
from cases.measures import CHANNELS, on_common_grid, relative_change
from cases.runner import Named, run_tasks
from cases.steady_run import Task
from cases.store import Store, key_of
from cases.stored_jobs import Result, stored
from cases.workers import PRELOAD, Job, Limits, Outcome
from engines.accurate import ESTIMATED, run_once, simulate
from engines.base import EngineFailure
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


def run_studies(store: Store, jobs: int | None = None, limits: Limits | None = None) -> Studies:
    """All studies, from the store where they are there; `limits` are those of each simulation, None: `default_limits`.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    case = load_case(ACCURACY_CASE)
    work: dict[tuple[str, ...], tuple[Callable[..., Any], tuple[Any, ...]]] = {
        ("converged",): (_trajectory, (case, *CONVERGED)),
        **{("confirming", name): (_trajectory, (case, name, settings)) for name, settings in CONFIRMING.items()},
        ("convergence",): (_convergence, (case,)),
        **{("default", name): (_trajectory, (case, name, None)) for name in MAIN},
    }
    found, failures = _stored(work, store, jobs, limits)
    accuracy, confirmation = _accuracy_tables(found, failures)
    rows = found[("convergence",)][0]["rows"] if ("convergence",) in found else []
    from_orbit = run_tasks(_from_orbit(case), store, jobs, "from the periodic orbit", limits)
    tasks = [*_straight(case, from_orbit), *_open_tasks()]  # together: one that marches straight takes as long as all the others
    results = run_tasks(tasks, store, jobs, "what the thesis leaves open, and another start", limits)
    sensitivity = _sensitivity(results, failures)
    both_ways = _both_ways({**from_orbit, **results}, failures)
    return Studies(accuracy, confirmation, pd.DataFrame(rows), sensitivity, both_ways, tuple(failures))


Found = dict[tuple[str, ...], Result]


def _stored(
    work: Mapping[tuple[str, ...], tuple[Callable[..., Any], tuple[Any, ...]]], store: Store, jobs: int | None, limits: Limits | None
) -> tuple[Found, list[str]]:
    """Results of the jobs by name, computed where they are not stored, and a sentence for each that failed."""
    code = code_fingerprint((*SIMULATION, "cases.studies"))
    versions = {name: "" if engine(name).unavailable() else engine(name).version() for name in MAIN}
    names: dict[str, tuple[str, ...]] = {}
    for name, (_, arguments) in work.items():
        scene = [item.mechanism if isinstance(item, Case) else item for item in arguments]
        times = [(item.duration, item.output_step) for item in arguments if isinstance(item, Case)]
        names[key_of({"kind": "study", "name": name, "scene": scene, "times": times, "versions": versions, "code": code})] = name
    pending = [Job(key, *work[name]) for key, name in names.items()]
    entries, others = stored(pending, store, "studies", at_once=jobs, limits=limits, preload=(*PRELOAD, "cases.studies"))
    failures = [f"study {' '.join(names[key])}: {_clause(outcome)}" for key, outcome in others.items()]
    return {names[key]: (entry.document, entry.arrays) for key, entry in entries.items()}, failures


def _clause(outcome: Outcome) -> str:
    return str(outcome.error) if isinstance(outcome.error, EngineFailure) else outcome.explanation


def _trajectory(case: Case, name: str, settings: Mapping[str, str] | None) -> tuple[dict[str, Any], dict[str, NDArray[np.float64]]]:
    """A trajectory from the standard start: to the engine's default accuracy, or once with given settings."""
    chosen, start = engine(name), standard_start(case.mechanism)
    if settings is None:
        result = simulate(chosen, case.mechanism, start, case.duration, case.output_step)
        document = {
            "settings": result.settings.as_dict(),
            "error_estimate": result.error_estimate,
            "solve_seconds": result.solve_seconds,
            "setup_seconds": result.setup_seconds,
            "compile_seconds": result.compile_seconds,
            "degrees_of_freedom": result.description.degrees_of_freedom,
            "remark": result.remark,
        }
        trajectory = result.trajectory
    else:
        used = chosen.settings_for(chosen.default_accuracy, case.mechanism).with_texts(dict(settings))
        trajectory, setup_seconds = run_once(chosen, case.mechanism, start, case.duration, case.output_step, used)
        document = {"settings": used.as_dict(), "solve_seconds": trajectory.solve_seconds, "setup_seconds": setup_seconds}
    return {"engine": name, **document}, dict(trajectory.columns)


def _convergence(case: Case) -> tuple[dict[str, Any], dict[str, NDArray[np.float64]]]:
    ladder = [ReferenceSettings(modes=modes, tolerance=tolerance) for modes in MODES for tolerance in TOLERANCES]
    table = convergence_table(ReferenceEngine(), case.mechanism, ladder, case.duration, case.output_step)
    plain = [{str(k): (v.item() if hasattr(v, "item") else v) for k, v in row.items()} for row in table.to_dict("records")]
    return {"rows": plain}, {}


def relative_error(values: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
    """RMS of the difference over the RMS of the truth, both of shape (n,)."""
    return float(np.sqrt(np.mean((values - truth) ** 2) / np.mean(truth**2)))


def _accuracy_tables(found: Found, failures: list[str]) -> tuple[pd.DataFrame, pd.DataFrame]:
    if ("converged",) not in found:
        return pd.DataFrame(), pd.DataFrame()
    document, truth = found["converged",]
    rows = []
    for name in MAIN:
        if ("default", name) not in found:
            continue
        about, columns = found["default", name]
        errors = {column: relative_error(columns[column], truth[column]) for column in ESTIMATED}
        rows.append(about | {"settings": _settings_text(about["settings"])} | errors)
    confirmation = []
    for name in CONFIRMING:
        if ("confirming", name) not in found:
            continue
        about, columns = found["confirming", name]
        row: dict[str, Any] = {column: relative_error(columns[column], truth[column]) for column in ESTIMATED}
        texts = {"engine": document["engine"], "settings": _settings_text(document["settings"])}
        texts |= {"confirmed_by": about["engine"], "with_settings": _settings_text(about["settings"])}
        confirmation.append(texts | row)
    return pd.DataFrame(rows), pd.DataFrame(confirmation)


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


Runs = Mapping[tuple[str, ...], EngineRun]


def _open_tasks() -> list[Named]:
    tasks = []
    for name in OPEN_RUNS:
        case = load_case(name)
        scenes = {"": case.mechanism, **open_changes(case.mechanism)}
        tasks += [
            Named((name, change), Task(mechanism=scene, duration=case.duration, engine="reference")) for change, scene in scenes.items()
        ]
        for law in ("both components", "transverse"):
            task = Task(
                mechanism=case.mechanism,
                duration=case.duration,
                engine="fixed-shapes",
                accuracy=DAMPING_LAW_ACCURACY,
                settings={"damping_law": law},
                estimated=False,
            )
            tasks.append(Named((name, law), task))
    return tasks


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
                failures.append(f"study {name} {change}: {run.document['remark'] or nominal.document['remark']}")
    return pd.DataFrame(rows)


#: Packages that march from the standard start, too, on one run: that they get to the same cycle is seen, not assumed.
PACKAGES: Final = ("exudyn", "mujoco")


def _from_orbit(case: Case) -> list[Named]:
    return [Named((name, "orbit"), Task(mechanism=case.mechanism, duration=case.duration, engine=name)) for name in PACKAGES]


def _straight(case: Case, from_orbit: Runs) -> list[Named]:
    """With the settings of the runs from the orbit, so that nothing differs but the start."""
    return [
        Named(
            (name, "straight"),
            Task(
                mechanism=case.mechanism,
                duration=case.duration,
                engine=name,
                settings=as_texts(from_orbit[name, "orbit"].document.get("settings") or {}),
                straight=True,
                estimated=False,
            ),
        )
        for name in PACKAGES
    ]


def _both_ways(results: Runs, failures: list[str]) -> pd.DataFrame:
    rows: list[dict[str, Any]] = []
    for name in PACKAGES:
        orbit, straight = results[name, "orbit"], results[name, "straight"]
        if not (orbit.usable and straight.usable):
            failures.append(f"study of {name} from both starts: {straight.document['remark'] or orbit.document['remark']}")
            continue
        found: dict[str, Any] = {"engine": name, "difference": cycle_difference(straight.cycle, orbit.cycle)}
        for way, run in (("orbit", orbit), ("straight", straight)):
            found |= {f"{way}_{key}": run.document[key] for key in ("start", "cycles", "settling_error")}
        rows.append(found)
    return pd.DataFrame(rows)


def cycle_difference(one: Columns, other: Columns) -> float:
    """RMS over the channels of their difference in two cycles, each relative to its RMS in the first."""
    return relative_change(on_common_grid(channels_of(other)), on_common_grid(channels_of(one)))


def _changes(name: str, change: str, run: EngineRun, nominal: EngineRun) -> list[dict[str, Any]]:
    rows = []
    for half in HALVES:
        pairs: list[tuple[str, str, float | None, float | None]] = [
            ("first_mode_frequency", "consensus", nominal.consensus_frequency(half), run.consensus_frequency(half))
        ]
        for channel in CHANNELS:
            before, after = nominal.measure(half, channel), run.measure(half, channel)
            if before and after:
                pairs.append(("first_mode_amplitude", channel, before["first_mode_amplitude"], after["first_mode_amplitude"]))
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
