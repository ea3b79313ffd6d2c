"""Two cells of every recorded study, drawn by the slice's number, come out again: a record that no longer holds is red.

Every slice of the long tests computes them anew, without the store. `make verify` notes the commit in `about.csv`. A study whose cells do
not come out alike is to be recorded anew (`python -m quickreturn.record NAME`).
"""

import json
import random
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import pytest

from quickreturn.cases.library import load_case
from quickreturn.cases.library.thesis import RUNS, run_case
from quickreturn.cases.motion.orbit import orbits
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.one_run import CompletedRun
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import as_texts
from quickreturn.plugins.conform.contract import conform
from quickreturn.plugins.conform.records import ConformanceRow
from quickreturn.plugins.methods import studies as of_methods
from quickreturn.plugins.methods.asked import asked
from quickreturn.plugins.methods.groups import case_of
from quickreturn.plugins.methods.row import TOO_SLOW, Row, errors_of
from quickreturn.plugins.methods.truth import run_of, truth_of
from quickreturn.plugins.thesis.inference import study as finding
from quickreturn.plugins.thesis.sharpness import SIZES, Planted, planted
from quickreturn.plugins.thesis.starts import Start, starts
from quickreturn.record import confirm
from quickreturn.reports import long_studies
from quickreturn.reports.long_studies import studies, table
from tests.slices import slice_of

#: Cells of a study.
CELLS: Final = 2
#: Solve time (s) of the slowest cell that is computed anew.
SLOWEST: Final = 2.0
#: Duration (s) of the longest hard scene that is computed anew.
LONGEST: Final = 10.0
#: Relative difference of an error that is computed anew: four digits are recorded, and rounding of another machine changes adaptive steps.
SAME: Final = 1e-2
#: The same of a stiff spring, whose steps follow rounding: 5.6e-3, 5.9e-3 and 7.3e-3 with three instruction sets of one processor.
OF_SPRING: Final = 0.5
#: The same of a number of right-hand sides: 6,780 to 6,978 of a stiff spring with these sets, and 1.3 % between machines with fixed shapes.
OF_CALLS: Final = 5e-2
#: Factor within which the ratio of two solve times is the recorded one, and repetitions of both, in turn, of which the least counts.
PACE: Final = 2.0
REPETITIONS: Final = 5
#: Measurements of a ratio of which one must agree: other work of the machine disturbs some of them.
TRIALS: Final = 3

Draw = Callable[[Sequence[Any]], list[Any]]


def benchmark(draw: Draw, workshop: Workshop) -> None:
    """The error and the right-hand sides of a row, and its solve time over that of the first row of its scene."""
    races = of_methods.recorded("benchmark")
    cells = [(found, row) for found in races for row in found.given if row.completed and row.seconds < SLOWEST]
    for found, recorded in draw(cells):
        run, cell = runner(recorded), (recorded.scene, recorded.method, recorded.settings)
        fixed = next(row for row in found.given if row.completed)
        other, right = runner(fixed), truth_of(load_case(found.case))
        trajectory = run().trajectory
        error = errors_of(trajectory, right.trajectory)["tip_deflection"]
        assert error == pytest.approx(recorded.error, rel=same(recorded.engine), abs=right.uncertainty), cell
        if "right_hand_side_calls" in trajectory.statistics:
            assert trajectory.statistics["right_hand_side_calls"] == pytest.approx(recorded.calls, rel=OF_CALLS), cell
        other()  # what is compiled is compiled now
        ratio = recorded.seconds / fixed.seconds
        assert any(1.0 / PACE < pace(run, other) / ratio < PACE for _ in range(TRIALS)), cell


def same(engine: str) -> float:
    """Relative difference of an engine's error that counts as the same."""
    return OF_SPRING if engine == "stiff-spring" else SAME


def pace(run: Callable[[], CompletedRun], other: Callable[[], CompletedRun]) -> float:
    """Solve time of one run over that of another, from the least of a few repetitions in turn."""
    pairs = [(run().trajectory.solve_seconds, other().trajectory.solve_seconds) for _ in range(REPETITIONS)]
    return min(first for first, _ in pairs) / min(second for _, second in pairs)


def runner(row: Row) -> Callable[[], CompletedRun]:
    """Runs a row with given settings."""
    case, chosen = load_case(row.scene), engine(row.engine)
    settings = chosen.settings_type().with_texts(as_texts(row.settings))
    return lambda: run_of(chosen, case, settings)


def hard_scenes(draw: Draw, workshop: Workshop) -> None:
    """What comes of an engine that is asked for an error in a scene."""
    for found in draw([each for each in of_methods.recorded("hard_scenes") if each.duration < LONGEST]):
        case = load_case(found.case)
        truth = truth_of(case)
        for recorded in (row for row in found.rows if row.status != TOO_SLOW):  # for this machine is another thing
            again = asked(engine(recorded.engine), case, of_methods.REQUESTED, truth)
            assert again.status in (recorded.status, TOO_SLOW), recorded
            if again.status != TOO_SLOW and recorded.claim is not None:
                assert again.claim == pytest.approx(recorded.claim, rel=0.5), recorded


def conformance(draw: Draw, workshop: Workshop) -> None:
    """The verdict on an engine."""
    for recorded in draw(table("conformance", ConformanceRow)):
        chosen = engine(recorded.engine)
        if not chosen.unavailable():
            judged = conform(recorded.engine, workshop.executor, quiet=True)
            again = ConformanceRow.of(judged, str(chosen.version()))
            assert (again.verdict, again.failed) == (recorded.verdict, recorded.failed), [
                check for check in judged.checks if check.status == "failed"
            ]


def classes(draw: Draw, workshop: Workshop) -> None:
    """The error of the first run below a level in a class; a record without settings is read alone."""
    known = of_methods.class_map()
    scenes = {scene.name: scene for scene in known.scenes}
    for recorded in draw([each for each in known.trials if each.solve_seconds is not None and each.settings] or known.trials):
        if recorded.settings:
            case, chosen = case_of(scenes[recorded.scene].groups), engine(recorded.engine)
            settings = chosen.settings_type().with_texts(as_texts(recorded.settings))
            error = errors_of(run_of(chosen, case, settings).trajectory, truth_of(case).trajectory)["tip_deflection"]
            apart = scenes[recorded.scene].difference or 0.0
            assert error == pytest.approx(recorded.error, rel=same(recorded.engine), abs=apart), recorded


def finding_of_the_thesis(draw: Draw, workshop: Workshop) -> None:
    """The ratio of the thesis' frequency to a machine's after the return, in a run."""
    known = {row.machine: dict(zip(finding.RUNS, row.post, strict=True)) for row in table("finding", finding.Row)}
    for machine, run in draw([(machine, run) for machine, of_runs in known.items() for run in of_runs if of_runs[run] is not None]):
        (orbit,) = orbits([run_case(run).mechanism], workshop)
        assert orbit.begin is not None
        outcomes = workshop.outcomes([finding.job(each, (run,), {run: orbit}) for each in (finding.CUBIC, machine)], "machines")
        cubic, again = (outcome.value[0].halves["post"].fitted for outcome in outcomes if outcome.value is not None)
        ratio = 1.0 + finding.FREQUENCY_UNIT * (known[machine][run] or 0)
        # impacts amplify rounding: 0.3 % is the floor of the measure
        assert cubic / again == pytest.approx(ratio, abs=0.5 * finding.FREQUENCY_UNIT + 0.003), (machine, run)


def planted_errors(draw: Draw, workshop: Workshop) -> None:
    """The sizes from which on errors in a run are found; another machine's rounding may move one by a step."""
    known = {(row.engine, row.error): dict(zip(row.runs, row.found, strict=True)) for row in table("planted", Planted)}
    for run in draw(sorted(RUNS)):
        for row in planted(workshop, [run]):
            recorded = known[row.engine, row.error][run]
            near = [SIZES.index(size) if size else len(SIZES) for size in (row.found[0], recorded)]
            assert abs(near[0] - near[1]) <= 1, row


def other_starts(draw: Draw, workshop: Workshop) -> None:
    """The cycles of a run from other starts lie within the claims where the recorded ones do."""
    known = {(row.engine, row.start): row for row in table("starts", Start)}
    for run in draw(sorted(RUNS)):
        for row in starts(workshop, [run]):
            recorded = known[row.engine, row.start]
            place = recorded.runs.index(run)
            assert row.within == (recorded.difference[place] <= recorded.claimed[place]), row


AGAIN: Final[dict[str, Callable[[Draw, Workshop], None]]] = {
    "benchmark": benchmark,
    "hard scenes": hard_scenes,
    "conformance": conformance,
    "classes": classes,
    "finding": finding_of_the_thesis,
    "planted": planted_errors,
    "starts": other_starts,
}


def test_cells_of_every_study_are_computed_anew() -> None:
    assert set(AGAIN) == set(studies())


@pytest.mark.verify
@pytest.mark.every_slice
@pytest.mark.parametrize("study", AGAIN)
def test_two_recorded_cells_come_out_again(study: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    if (known := long_studies.about(study)) is None:
        pytest.skip("not recorded")
    chosen = slice_of(request.config)
    generator = random.Random(json.dumps([study, known.confirmed or known.commit, chosen.number if chosen else 0]))
    AGAIN[study](lambda cells: generator.sample(list(cells), min(CELLS, len(cells))), Workshop(Store(tmp_path), LocalProcesses()))
    if request.config.getoption("--keep-outcome") and chosen is None:
        confirm(study)
