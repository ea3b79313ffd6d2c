"""The matrix of verdicts by `make verify`: short on two scenes, in full on all, every claim checked against a converged solution."""

from collections.abc import Callable, Generator
from dataclasses import replace
from pathlib import Path

import pytest

from quickreturn.cases.files.case_file import load_case, with_times
from quickreturn.cases.library import catalogue
from quickreturn.cases.library.hard import TAG
from quickreturn.cases.running.job import Limits
from quickreturn.cases.running.processes import LocalProcesses
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import MAIN
from quickreturn.plugins.methods.judging.matrix import Matrix, judge_scenes
from quickreturn.plugins.methods.judging.verdicts import ACCURATE, DIVERGED, ENDED, REFUSED

SHORT = ("hard-speed-x3", "hard-slider-inertia")
ENGINES = ("reference", "mujoco")


@pytest.fixture(scope="module")
def workshop(tmp_path_factory: pytest.TempPathFactory) -> Workshop:
    return Workshop(Store(tmp_path_factory.mktemp("matrix")), LocalProcesses(2))


@pytest.fixture(scope="module")
def short(workshop: Workshop) -> Matrix:
    return judge_scenes([with_times(load_case(name), duration=0.3) for name in SHORT], workshop, ENGINES)


@pytest.mark.verify
def test_engines_agree_when_the_slider_leaves_the_follower(short: Matrix) -> None:
    for name in ENGINES:
        verdict = short.cells["hard-speed-x3", name].verdict
        assert verdict.kind == ENDED, verdict
        # 7 to 11 modes of the reference agree on 0.2524 to 0.2526 s
        assert verdict.time == pytest.approx(0.2525, abs=2e-3)
        assert short.cells["hard-speed-x3", name].holds


@pytest.mark.verify
def test_a_feature_that_an_engine_lacks_is_refused_and_the_other_is_judged(short: Matrix) -> None:
    assert short.cells["hard-slider-inertia", "mujoco"].verdict.kind == REFUSED
    assert "slider.inertia" in short.cells["hard-slider-inertia", "mujoco"].verdict.reason
    cell = short.cells["hard-slider-inertia", "reference"]
    assert cell.verdict.kind == ACCURATE
    assert cell.holds
    assert cell.true_error is not None
    assert short.silently_wrong == ()


@pytest.mark.verify
def test_what_is_stored_is_not_computed_again(short: Matrix, workshop: Workshop, monkeypatch: pytest.MonkeyPatch) -> None:
    def computed(_: object, jobs: list[object], *__: object) -> Generator[object, None, None]:
        assert jobs == []
        yield from jobs

    monkeypatch.setattr(LocalProcesses, "run", computed)
    again = judge_scenes(short.cases, workshop, ENGINES)
    assert again == replace(short, cases=again.cases)
    elsewhere = judge_scenes([replace(case, duration=0.2) for case in short.cases], workshop.as_it_is, ENGINES)
    assert elsewhere.cells == {}
    assert elsewhere.silently_wrong == ()


def test_a_process_that_dies_is_a_verdict_and_not_a_gap(tmp_path: Path) -> None:
    workshop = Workshop(Store(tmp_path), LocalProcesses(2, Limits(seconds=0.01)))
    matrix = judge_scenes([with_times(load_case("hard-no-tip"), duration=0.1)], workshop, ("mujoco",))
    verdict = matrix.cells["hard-no-tip", "mujoco"].verdict
    assert verdict.kind == DIVERGED
    assert "stopped at the time limit of 0.01 s" in verdict.reason
    assert all(conditioned.converged is None for conditioned in matrix.conditionings.values())
    assert not any(tmp_path.glob("*.result"))  # on a less busy machine it may go better


@pytest.mark.verify
def test_no_claim_of_the_whole_matrix_is_too_small(record_property: Callable[[str, object], None]) -> None:
    """Stored where the report finds it; what was computed before is taken from there."""
    scenes = [load_case(entry.name) for entry in catalogue(TAG)]
    matrix = judge_scenes(scenes, Workshop(Store()))
    assert set(matrix.cells) == {(case.name, name) for case in scenes for name in MAIN}
    checked = [cell for cell in matrix.cells.values() if cell.holds is not None]
    record_property("claims checked", len(checked))
    record_property("claims that do not hold", len(matrix.silently_wrong))
    assert not matrix.silently_wrong
    assert checked
