"""Engines that are wrong on purpose must never be called accurate: by their own evidence, or by comparison with the others."""

import os
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

from quickreturn.cases.files.case_file import load_case
from quickreturn.engines.base import Engine
from quickreturn.engines.registry import engine
from quickreturn.engines.relative import relative_error
from quickreturn.engines.trajectory import Columns
from quickreturn.plugins.methods.judging.evidence import TrialScene, gather
from quickreturn.plugins.methods.judging.matrix import REQUESTED
from quickreturn.plugins.methods.judging.verdicts import ACCURATE, CONTRADICTED, DIVERGED, NOT_CONVERGED, Evidence, contradicted, judge
from quickreturn.reference_model.motion import loop
from tests.engines.wrong_engines import Disguised, Restarting, Stiffer, TooLargeStep
from tests.package_copy import copied_package

MECHANISM = load_case("thesis-24").mechanism
SHORT = TrialScene(mechanism=MECHANISM, duration=0.4, output_step=1e-3, horizon=0.4)
#: Exudyn divides a row evenly, so that its steps are at most a row.
COARSE_ROWS = TrialScene(mechanism=MECHANISM, duration=0.4, output_step=0.02, horizon=0.4)


def run_of(chosen: Engine, scene: TrialScene = SHORT) -> Evidence:
    return gather(chosen.name, scene, REQUESTED, lambda _: chosen, asked=(1.0,))


@pytest.fixture(scope="module")
def sound() -> dict[str, Evidence]:
    """Two engines that are right, each by a method of its own."""
    return {name: run_of(engine(name)) for name in ("reference", "exudyn")}


def verdicts_with(odd: Columns, evidence: Evidence, sound: dict[str, Evidence]) -> dict[str, str]:
    """Kinds of the verdicts after the comparison."""
    columns = {name: run.columns for name, run in sound.items()} | {"odd": odd}
    own = {name: judge(run) for name, run in sound.items()} | {"odd": judge(evidence)}
    differences = {
        (first, second): relative_error(columns[first]["tip_deflection"], columns[second]["tip_deflection"])
        for first in columns
        for second in columns
        if first != second
    }
    return {name: verdict.kind for name, verdict in contradicted(own, differences).items()}


def test_sound_engines_are_accurate_disguised_or_not(sound: dict[str, Evidence]) -> None:
    disguised = run_of(Disguised(engine("reference")))
    assert verdicts_with(disguised.columns, disguised, sound) == {"reference": ACCURATE, "exudyn": ACCURATE, "odd": ACCURATE}


@pytest.mark.verify
def test_a_step_twenty_times_too_large_is_found_by_the_estimate() -> None:
    assert judge(run_of(engine("exudyn"), COARSE_ROWS)).kind == ACCURATE  # on this grid, too
    assert judge(run_of(TooLargeStep(engine("exudyn")), COARSE_ROWS)).kind in (NOT_CONVERGED, DIVERGED)


def test_a_reset_to_the_start_is_found_by_the_run_itself() -> None:
    verdict = judge(run_of(Restarting(engine("reference"))))
    assert verdict.kind == NOT_CONVERGED


def test_a_stiffness_3_percent_off_is_found_by_comparison(sound: dict[str, Evidence]) -> None:
    odd = run_of(Stiffer(engine("reference")))
    assert judge(odd).kind == ACCURATE  # it converges, to another scene
    assert verdicts_with(odd.columns, odd, sound) == {"reference": ACCURATE, "exudyn": ACCURATE, "odd": CONTRADICTED}


#: What is left out: twice the sliding speed times the turning of the follower, in the acceleration of its point at the slider.
CORIOLIS = "2.0 * w.turn[slider_point] + "
PROGRAM = """
import pickle, sys
from quickreturn import reference_model
from quickreturn.cases.files.case_file import load_case
from quickreturn.plugins.methods.judging.evidence import TrialScene, gather
assert reference_model.__file__.startswith(sys.argv[1]), reference_model.__file__
scene = TrialScene(mechanism=load_case("thesis-24").mechanism, duration=0.4, output_step=1e-3, horizon=0.4)
run = gather("fixed-shapes", scene, float(sys.argv[2]), asked=(1.0,))
with open(sys.argv[3], "wb") as file:
    pickle.dump(run, file)
"""


def test_the_term_to_drop_is_in_the_source_once() -> None:
    assert Path(loop.__file__).read_text("utf-8").count(CORIOLIS) == 1


@pytest.mark.verify
@pytest.mark.parametrize("dropped", [False, True])
def test_a_dropped_coriolis_term_is_found(dropped: bool, sound: dict[str, Evidence], tmp_path: Path) -> None:
    """A copy of the code with the term cut out of the source, and a whole copy to see that copying does no harm."""
    package = copied_package(tmp_path, "reference_model", "engines")
    if dropped:
        file = package / "reference_model/motion/loop.py"
        file.write_text(file.read_text("utf-8").replace(CORIOLIS, ""), "utf-8")
    result = tmp_path / "run.pickle"
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(tmp_path), str(REQUESTED), str(result)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *filter(None, sys.path)])},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=1500,
    )
    assert done.returncode == 0, done.stderr
    odd: Evidence = pickle.loads(result.read_bytes())
    kind = verdicts_with(odd.columns, odd, sound)["odd"]
    assert (kind == ACCURATE) == (not dropped), judge(odd)
