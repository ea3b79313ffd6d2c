"""Whether claims hold: scenes that no table of settings was made for, several engines, several accuracies, every column with a claim.

    python -m tests.verification.accuracy_campaign --library --machines 40 --combined 25 --output table.csv

An engine claims an error for each of `engines.error_parts.ESTIMATED`; the claim holds where the error is no larger. The truth of a scene is
`reference` with 13 modes, or fewer of a stiff follower, at a tolerance of 1e-9. Its own error is not known but bounded by how far two
modes fewer are away, which have several times its error where modes converge: a claim is judged only where the truth is known three times
as well. A formulation that shares nothing with it confirms it, MuJoCo's chain with as many links as can be afforded, or exudyn's cable
where the follower is too stiff for that: where the two are more than a percent apart nothing is judged. Nor is it on a violent scene:
where a change of the bending stiffness by one part in a thousand moves the tip by five percent (`LARGEST_CONDITION`), models that differ
by as little as an axial stretch differ visibly. What is not judged is listed (`left_out`).

An engine climbs no further than `MOST_RUNGS` from where it begins: what it claims there is judged as well.
"""

import argparse
import copy
import dataclasses
import itertools
import math
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from quickreturn.cases.library import case_names, load_case
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.accurate import Result as Accurate
from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceSettings
from quickreturn.engines.registry import engine, engine_names
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.row import errors_of
from quickreturn.plugins.methods.truth import run_of
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from tests.verification.random_machines import braked_machines, combined_machines, sensible_machines
from tests.verification.random_scenes import LARGEST_CONDITION, OUTPUT_STEP, Scene, condition_of, random_scenes

SEED: Final = 1999
ENGINES: Final = ("reference", "exudyn", "mujoco")
#: None: the engine's default.
ACCURACIES: Final = (None, 1e-2, 1e-3)
#: Modes of the truth: the most whose steps are affordable, which is 13 but for stiff followers, that need fewer.
MODES: Final = (13, 11, 9, 7)
MOST_STEPS: Final = 6e4  # half a minute; a thesis' run takes 1.3e4 with 13 modes
TRUTH_TOLERANCE: Final = 1e-9
#: Runs that confirm the truth: links of a chain, the first whose steps times links are affordable, else a cable.
CHAINS: Final = (40, 27, 18)
CABLE: Final = ExudynSettings(elements=32, step=1.25e-4, newton_tolerance=1e-6)
AFFORDABLE: Final = 4e6  # some ten seconds
LONGEST: Final = 2.0  # s
#: Rungs that an engine climbs from where it begins. On a machine whose first bending frequency is 3800 times the crank's exudyn took all of
#: its ladder, from 24 elements to 96 in seven rungs of five runs of 10 to 30 s, while its estimate stayed at 4e-3 from the third on.
MOST_RUNGS: Final = 2
#: s, time limit of an answer, as a user may give it: a run that could take longer is not begun, and the answer says so.
ANSWER: Final = 60.0

#: AnyEngine, and accuracy asked for.
Request = tuple[str, float | None]


@dataclass(frozen=True, kw_only=True)
class Row:
    """One claim."""

    scene: str
    condition: float  # of the scene (`tests.verification.random_scenes.Scene`)
    engine: str
    asked: str  # accuracy as text, "default" if none was asked for
    column: str  # that the claim is about
    claim: float | None = None  # the engine's own estimate; None where there is none
    error: float | None = None  # against the truth; None where there is none
    reached: bool = False  # as the engine says
    settings: str = ""  # of the delivered run, as text
    solve_seconds: float | None = None  # of the delivered run
    total_seconds: float | None = None  # with all runs for the estimate and the rungs climbed
    truth_error: float | None  # difference of the truth from two modes fewer, in this column
    confirmation: float | None  # difference of the truth from the confirming run; None where there is none
    confirmed_by: str  # that run
    remark: str = ""  # why not reached, or why there is no claim or no run


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


def scene_rows(scene: Scene, requests: Sequence[Request], confirm: bool = True) -> list[Row]:
    """One row per request and column; none where there is no truth."""
    modes = _modes(scene)
    truth, less = (_run("reference", scene, ReferenceSettings(modes=count, tolerance=TRUTH_TOLERANCE)) for count in (modes, modes - 2))
    if truth is None or less is None:
        return []
    other, by = _confirming(scene) if confirm else (None, "")
    uncertain, confirmed = errors_of(less, truth), errors_of(other, truth) if other else {}
    answers = [(name, accuracy, *_answer(name, scene, accuracy)) for name, accuracy in requests]
    return [
        Row(
            scene=scene.name,
            condition=scene.condition,
            engine=name,
            asked="default" if accuracy is None else f"{accuracy:g}",
            column=column,
            claim=None if result is None else result.error_estimates[column],
            error=errors.get(column),
            truth_error=uncertain[column],
            confirmation=confirmed.get(column),
            confirmed_by=by,
            **known,
        )
        for name, accuracy, result, known in answers
        for errors in [errors_of(result.trajectory, truth) if result is not None else {}]
        for column in ESTIMATED
    ]


def _modes(scene: Scene) -> int:
    """Modes of the truth; an explicit integrator takes steps of about five over the highest angular frequency."""
    highest = 2.0 * np.pi * frozen_crank_modes(scene.mechanism, np.pi, MODES[0]).frequencies
    return next((modes for modes in MODES if scene.duration * highest[modes - 1] / 5.0 <= MOST_STEPS), MODES[-1])


def _answer(name: str, scene: Scene, accuracy: float | None) -> tuple[Accurate | None, dict[str, Any]]:
    try:
        start, chosen = standard_start(scene.mechanism), _climbing_little(engine(name))
        result = simulate(chosen, scene.mechanism, start, scene.duration, OUTPUT_STEP, accuracy=accuracy, time_limit=ANSWER)
    except (EngineFailure, Refusal) as failure:
        return None, {"remark": str(failure)}
    return result, {
        "settings": ", ".join(f"{key} = {value:.4g}" for key, value in result.settings.items() if isinstance(value, float | int)),
        "reached": result.reached,
        "solve_seconds": result.solve_seconds,
        "total_seconds": result.solve_seconds + result.setup_seconds + result.estimate_seconds,
        "remark": result.remark,
    }


def _climbing_little(chosen: AnyEngine) -> AnyEngine:
    """The engine with a ladder of `MOST_RUNGS` rungs from where a run begins."""
    kind, rungs = type(chosen), itertools.count(1)

    class ClimbingLittle(kind):  # type: ignore[misc, valid-type]
        def finer(self, settings: Settings, excess: Mapping[str, float], output_step: float) -> Settings | None:
            found: Settings | None = super().finer(settings, excess, output_step)
            return found if next(rungs) <= MOST_RUNGS else None

    limited = copy.copy(chosen)  # an engine may be made from data
    limited.__class__ = ClimbingLittle
    return limited


def _confirming(scene: Scene) -> tuple[Trajectory | None, str]:
    """The run of another formulation, and what it is."""
    for links in CHAINS:
        settings = ChainSettings(links=links)
        first = _run("mujoco", dataclasses.replace(scene, duration=OUTPUT_STEP), settings)
        if first is not None and first.statistics["steps"] * scene.duration / OUTPUT_STEP * links <= AFFORDABLE:
            return _run("mujoco", scene, settings), f"mujoco, {links} links"
    return _run("exudyn", scene, CABLE), f"exudyn, {CABLE.elements} elements"


def _run(name: str, scene: Scene, settings: Settings) -> Trajectory | None:
    try:
        return run_of(engine(name), scene.case, settings).trajectory
    except (EngineFailure, Refusal):
        return None


def campaign(scenes: Iterable[tuple[Scene, Sequence[Request]]], workshop: Workshop, confirm: bool = True) -> tuple[pd.DataFrame, list[str]]:
    """All rows (`Row`), and a clause for each scene that has none: its process broke down, or there is no truth.

    Each scene has a process of its own and is taken from the store where it is there. Without `confirm` nothing is judged.
    """
    jobs = []
    for scene, requests in scenes:
        names = tuple(sorted({"reference", *(name for name, _ in requests), *(("mujoco", "exudyn") if confirm else ())}))
        jobs.append(Job(scene.name, scene_rows, (scene, tuple(requests), confirm), "accuracy scene", names))
    outcomes = workshop.outcomes(jobs, "accuracy scenes")
    broken = [f"{outcome.job.name}: {outcome.explanation}" for outcome in outcomes if not outcome.completed]
    rows = [asdict(row) for outcome in outcomes for row in outcome.value or ()]
    table = pd.DataFrame(rows, columns=[field.name for field in fields(Row)])
    broken += [f"{outcome.job.name}: no truth" for outcome in outcomes if outcome.value == []]
    return table.sort_values(["engine", "asked", "scene"], kind="stable", ignore_index=True), broken


#: The confirming run's own error may be so much: 40 links leave up to 4e-3 in the acceleration of a thesis' run.
CONFIRMED: Final = 1e-2
#: The truth must be known this many times better than what is judged by it.
MARGIN: Final = 3.0


def judged(table: pd.DataFrame) -> pd.DataFrame:
    """The claims whose truth is known well enough and confirmed, with the column `ratio` = error / claim; violent scenes left out."""
    found = table[(table["condition"] < LARGEST_CONDITION) & table["claim"].notna() & table["error"].notna()]
    numbers = found[["claim", "error", "truth_error", "confirmation"]].astype(float)
    larger = numbers[["claim", "error"]].max(axis=1)
    found = found[(MARGIN * numbers["truth_error"] <= larger) & (numbers["confirmation"] <= CONFIRMED)]
    return found.assign(ratio=found["error"].astype(float) / found["claim"].astype(float))


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """One row per engine, accuracy and column: how many claims are judged, the share that holds, and how far off they are."""
    rows = [
        {
            "engine": name,
            "asked": asked,
            "column": column,
            "claims": len(group),
            "hold": float((group["ratio"] <= 1.0).mean()),
            "worst error / claim": float(group["ratio"].max()),
            "median claim / error": float((1.0 / group["ratio"]).median()),
        }
        for (name, asked, column), group in judged(table).groupby(["engine", "asked", "column"], sort=False)
    ]
    return pd.DataFrame(rows)


def deliveries(table: pd.DataFrame) -> pd.DataFrame:
    """One row per engine and accuracy: in how many scenes it ran, claimed an error for every column, reached what was asked; times."""
    sane = table[table["condition"] < LARGEST_CONDITION]
    rows = []
    for (name, asked), group in sane.groupby(["engine", "asked"], sort=False):
        scenes = group.groupby("scene")
        rows.append(
            {
                "engine": name,
                "asked": asked,
                "scenes": len(scenes),
                "ran": int(scenes["error"].count().gt(0).sum()),
                "claimed": float((scenes["claim"].count() == scenes["column"].count()).mean()),
                "reached": float(scenes["reached"].all().mean()),
                "median solve [s]": float(scenes["solve_seconds"].first().median()),
                "median total [s]": float(scenes["total_seconds"].first().median()),
            }
        )
    return pd.DataFrame(rows)


def left_out(table: pd.DataFrame) -> pd.DataFrame:
    """Scenes with columns that cannot be judged: how violent, how well the truth is known, how far the confirming run is from it."""
    once = table.drop_duplicates(["scene", "column"])
    numbers = once[["condition", "truth_error", "confirmation"]].astype(float)
    unknown = (
        (numbers["condition"] >= LARGEST_CONDITION) | (MARGIN * numbers["truth_error"] > 1e-3) | ~(numbers["confirmation"] <= CONFIRMED)
    )
    return once[unknown][["scene", "column", "condition", "truth_error", "confirmation", "confirmed_by"]].reset_index(drop=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line, see the top of this file; 1 if a scene could not be computed."""
    parser = argparse.ArgumentParser(prog="python -m tests.verification.accuracy_campaign", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--library", action="store_true", help="the scenes of the library")
    parser.add_argument("--machines", type=int, default=0, metavar="N", help="number of sensible machines")
    parser.add_argument("--combined", type=int, default=0, metavar="N", help="number of machines on which everything acts at once")
    parser.add_argument("--braked", type=int, default=0, metavar="N", help="number of such machines with a braked, light pivot")
    parser.add_argument("--random", type=int, default=0, metavar="N", help="number of random scenes around the thesis' mechanism")
    parser.add_argument("--engine", action="append", choices=engine_names(), help="default: reference, exudyn and mujoco")
    parser.add_argument("--accuracy", action="append", type=float, help="default: the engine's own, 1e-2 and 1e-3")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--jobs", type=int, default=None)
    parser.add_argument("--no-confirmation", action="store_true", help="without the confirming run, and therefore without a judgement")
    parser.add_argument("--output", type=Path, help="CSV file of all rows")
    given = parser.parse_args(arguments)
    if not (given.random or given.machines or given.combined or given.braked or given.library):
        parser.error("no scenes; give --library, --machines N, --combined N, --braked N or --random N")
    requests = tuple(itertools.product(given.engine or ENGINES, given.accuracy or ACCURACIES))
    kinds = (
        (sensible_machines, given.machines),
        (combined_machines, given.combined),
        (braked_machines, given.braked),
        (random_scenes, given.random),
    )
    drawn = (itertools.islice(drawn_from(given.seed), count) for drawn_from, count in kinds)
    scenes = itertools.chain(library_scenes() if given.library else (), *drawn)
    workshop = Workshop(Store(), LocalProcesses(given.jobs))
    table, broken = campaign([(scene, requests) for scene in scenes], workshop, not given.no_confirmation)
    if given.output:
        table.to_csv(given.output, index=False)
    with pd.option_context("display.width", 250, "display.max_columns", None, "display.max_rows", None):
        for found in (summary(table), deliveries(table), left_out(table)):
            print(found.to_string(index=False, float_format=lambda value: f"{value:.3g}"), end="\n\n")
    for clause in broken:
        print(clause, file=sys.stderr)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
