"""Whether asking for an accuracy delivers it: scenes that no table of settings was made for, several engines, several accuracies.

    python -m cases.accuracy_campaign --random 50 --engine reference --engine exudyn --accuracy 1e-3 --output table.csv

The truth of a scene is `reference` with 13 modes at a tolerance of 1e-9. Its own error is not known but bounded by how far 11 modes
are away, which have several times its error where modes converge, and it is confirmed by a formulation that shares nothing with it:
MuJoCo's chain of 40 links, whose own error is some 1e-4. An accuracy is judged on a scene only if the truth is known three times as
well, and not at all on a violent one: where a change of the bending stiffness by one part in a thousand moves the tip by five percent
(`LARGEST_CONDITION`), models that differ by as little as an axial stretch differ visibly.
"""

import argparse
import itertools
import math
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from cases.case_file import load_case
from cases.library import case_names
from cases.random_scenes import LARGEST_CONDITION, OUTPUT_STEP, Scene, condition_of, random_scenes
from cases.store import Store, StoreError
from cases.stored_jobs import Campaign, Result, Work, results
from cases.units import plain_number
from engines.accurate import run_once, simulate
from engines.base import EngineFailure, Refusal
from engines.mujoco.settings import ChainSettings
from engines.pseudo_coordinate.reference import ReferenceSettings
from engines.registry import UnknownEngine, engine, usable_engine
from engines.settings import Settings
from engines.start import standard_start
from engines.trajectory import Trajectory
from reference_model.mechanism import Mechanism

SEED: Final = 1999
ENGINES: Final = ("reference", "exudyn")
ACCURACIES: Final = (1e-2, 1e-3, 1e-4)
TRUTH: Final = ReferenceSettings(modes=13, tolerance=1e-9)
LESS: Final = ReferenceSettings(modes=11, tolerance=1e-9)
CONFIRMING: Final = ChainSettings(links=40)
#: The truth must be known this many times better than what is judged by it.
MARGIN: Final = 3.0
LONGEST: Final = 2.0  # s

_CAMPAIGN: Final = Campaign("accuracy scene", ("cases.accuracy_campaign", "cases.random_scenes"))


@dataclass(frozen=True, kw_only=True)
class Row:
    """What became of one request.

    Attributes:
        scene, engine: names.
        condition: of the scene (`cases.random_scenes.Scene`).
        asked: accuracy.
        settings: of the delivered run, as text.
        estimate, achieved: error of the tip deflection, the engine's own estimate and against the truth; None where there is none.
        reached: as the estimate says, verified or not: here it is put to the test.
        solve_seconds: of the delivered run.
        total_seconds: with all runs for the estimate and the rungs climbed.
        truth_error: difference of the truth from two modes fewer.
        confirmation: difference of the truth from the confirming engine; None where that cannot model the scene or failed.
        remark: why not reached, or why there is no run.
    """

    scene: str
    condition: float
    engine: str
    asked: float
    settings: str = ""
    estimate: float | None = None
    achieved: float | None = None
    reached: bool = False
    solve_seconds: float | None = None
    total_seconds: float | None = None
    truth_error: float
    confirmation: float | None
    remark: str = ""


def library_scenes() -> Iterator[Scene]:
    """The library's cases with a crank, a flexible follower and a rigid slider joint, over their own durations or two seconds.

    A compliant joint is another model of `reference`, whose truth would need other settings.
    """
    for name in case_names():
        case = load_case(name)
        scene = case.scene
        if not isinstance(scene, Mechanism) or scene.follower.is_rigid or math.isfinite(scene.slider.joint_stiffness):
            continue
        try:
            duration = min(case.duration, LONGEST)
            condition, motion = condition_of(scene, duration)
        except EngineFailure:
            continue  # a scene that cannot go on has no accuracy
        largest = float(np.abs(motion["tip_deflection"]).max())
        yield Scene(name, scene, duration, condition, largest)


def scene_rows(scene: Scene, requests: Sequence[tuple[str, float]], confirm: bool = True) -> list[Row]:
    """One row per request (engine, accuracy) on a scene."""
    truth, less = (_run("reference", scene, settings) for settings in (TRUTH, LESS))
    if truth is None or less is None:
        return []
    chain = _run("mujoco", scene, CONFIRMING) if confirm else None
    known: dict[str, Any] = {
        "scene": scene.name,
        "condition": scene.condition,
        "truth_error": _difference(less, truth),
        "confirmation": None if chain is None else _difference(chain, truth),
    }
    return [Row(engine=name, asked=accuracy, **known, **_answer(name, scene, accuracy, truth)) for name, accuracy in requests]


def _answer(name: str, scene: Scene, accuracy: float, truth: Trajectory) -> dict[str, Any]:
    try:
        start = standard_start(scene.mechanism)
        result = simulate(engine(name), scene.mechanism, start, scene.duration, OUTPUT_STEP, accuracy=accuracy)
    except (EngineFailure, Refusal) as failure:
        return {"remark": str(failure)}
    return {
        "settings": ", ".join(f"{key} = {value:.4g}" for key, value in result.settings.as_dict().items() if isinstance(value, float | int)),
        "estimate": result.error_estimate,
        "achieved": _difference(result.trajectory, truth),
        "reached": result.error_estimate is not None and result.error_estimate <= accuracy,
        "solve_seconds": result.solve_seconds,
        "total_seconds": result.solve_seconds + result.setup_seconds + result.estimate_seconds,
        "remark": result.remark,
    }


def _run(name: str, scene: Scene, settings: Settings) -> Trajectory | None:
    try:
        return run_once(engine(name), scene.mechanism, standard_start(scene.mechanism), scene.duration, OUTPUT_STEP, settings)[0]
    except (EngineFailure, Refusal):
        return None


def _difference(found: Trajectory, truth: Trajectory) -> float:
    a, b = found["tip_deflection"], truth["tip_deflection"]
    return float(np.sqrt(np.mean((a - b) ** 2) / np.mean(b**2)))


def campaign(
    scenes: Iterable[tuple[Scene, Sequence[tuple[str, float]]]], store: Store, confirm: bool = True, jobs: int | None = None
) -> tuple[pd.DataFrame, list[str]]:
    """All rows (`Row`), and a clause for each scene whose process broke down.

    Each scene has a process of its own and is taken from the store where it is there.

    Args:
        scenes: with the requests (engine, accuracy) to make of each.
        store: what is computed is kept here, scene by scene.
        confirm: whether to run the confirming engine.
        jobs: processes at a time; None: one per core.

    Raises:
        StoreError: see `cases.store`.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    work = []
    for scene, requests in scenes:
        names = tuple(sorted({"reference", *(name for name, _ in requests), *(("mujoco",) if confirm else ())}))
        work.append(Work(("scene", scene.name), names, _stored_rows, (scene, tuple(requests), confirm)))
    found = {name[1]: document for name, (document, _) in results(work, _CAMPAIGN, store, jobs).items()}
    broken = [f"{name}: {document['failure']}" for name, document in found.items() if "failure" in document]
    rows = [row for document in found.values() for row in document.get("rows", ())]
    table = pd.DataFrame(rows, columns=[field.name for field in fields(Row)])
    return table.sort_values(["engine", "asked", "scene"], ascending=[True, False, True], ignore_index=True), broken


def _stored_rows(scene: Scene, requests: Sequence[tuple[str, float]], confirm: bool) -> Result:
    return {"rows": [asdict(row) for row in scene_rows(scene, requests, confirm)]}, {}


def judged(table: pd.DataFrame) -> pd.DataFrame:
    """The rows with a run whose truth is known well enough, with the column `ratio` = achieved / asked; violent scenes left out."""
    known = (MARGIN * table["truth_error"] <= table["asked"]) & (table["condition"] < LARGEST_CONDITION)
    found = table[table["achieved"].notna() & known]
    return found.assign(ratio=found["achieved"].astype(float) / found["asked"])


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """One row per engine and accuracy: how many runs are judged, say that they reached it, did so, and how far the worst one is off."""
    rows = []
    for (name, asked), group in judged(table).groupby(["engine", "asked"], sort=False):
        reached = group[group["reached"]]
        estimated = group[group["estimate"].notna()]
        rows.append(
            {
                "engine": name,
                "asked": asked,
                "judged": len(group),
                "say so": len(reached),
                "within": int((reached["ratio"] <= 1.0).sum()),
                "median achieved / asked": float(reached["ratio"].median()),
                "worst achieved / asked": float(reached["ratio"].max()),
                "median estimate / achieved": float((estimated["estimate"] / estimated["achieved"]).median()),
                "least estimate / achieved": float((estimated["estimate"] / estimated["achieved"]).min()),
                "median total [s]": float(group["total_seconds"].median()),
            }
        )
    return pd.DataFrame(rows)


def chapter(table: pd.DataFrame, title: str, text: str) -> dict[str, Any]:
    """A table as a chapter of the verification's outcome (`reports.verification`)."""
    rows = [[_plain(value) for value in row] for row in table.itertuples(index=False)]
    return {"title": title, "text": text, "columns": [str(name).replace("_", " ") for name in table.columns], "rows": rows}


def _plain(value: Any) -> str | float | int | None:
    if value is None or (isinstance(value, float) and not np.isfinite(value)):
        return None
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return float(f"{float(value):.3g}")
    return int(value) if isinstance(value, np.integer) else value


def _accuracy(text: str) -> float:
    value = plain_number(text)
    if value is None or not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f'"{text}": give a plain number between 0 and 1, e.g. 1e-3')
    return value


def _engine(text: str) -> str:
    try:
        return usable_engine(text).name
    except (UnknownEngine, Refusal) as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f'"{text}": give a whole number from 1')
    return int(text)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line, see the top of this file; 1 if a scene's process broke down."""
    parser = argparse.ArgumentParser(prog="python -m cases.accuracy_campaign", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--random", type=_count, default=0, metavar="N", help="number of random scenes")
    parser.add_argument("--library", action="store_true", help="the scenes of the library too")
    parser.add_argument("--engine", action="append", type=_engine, help="default: reference and exudyn")
    parser.add_argument("--accuracy", action="append", type=_accuracy, help="default: 1e-2, 1e-3 and 1e-4")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--jobs", type=_count, default=None)
    parser.add_argument("--no-confirmation", action="store_true")
    parser.add_argument("--output", type=Path, help="CSV file of all rows")
    given = parser.parse_args(arguments)
    if not (given.random or given.library):
        parser.error("no scenes; give --random N, --library or both")
    try:
        store = Store()
    except StoreError as error:
        parser.error(str(error))
    requests = tuple(itertools.product(given.engine or ENGINES, given.accuracy or ACCURACIES))
    scenes = [*(library_scenes() if given.library else ()), *itertools.islice(random_scenes(given.seed), given.random)]
    table, broken = campaign([(scene, requests) for scene in scenes], store, not given.no_confirmation, given.jobs)
    if given.output:
        table.to_csv(given.output, index=False)
    with pd.option_context("display.width", 250, "display.max_columns", None):
        print(summary(table).to_string(index=False, float_format=lambda value: f"{value:.3g}"))
    for clause in broken:
        print(clause, file=sys.stderr)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
