"""The race on a short stretch of run 24: rows with errors, counts and times; who dies loses its own rows alone."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from quickreturn.cases.files.case import Case
from quickreturn.cases.library import catalogue, load_case
from quickreturn.cases.library.hard import TAG
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.registry import MAIN, UnknownEngine, engine
from quickreturn.plugins.methods import race as module
from quickreturn.plugins.methods import truth
from quickreturn.plugins.methods.compiling import compiling
from quickreturn.plugins.methods.fronts import DEFLECTION, standings
from quickreturn.plugins.methods.race import Contest, Race, race, tried
from quickreturn.plugins.methods.row import LEVELS, REACHED, WRONG, Row, errors_of
from quickreturn.plugins.methods.signed import Line
from quickreturn.plugins.methods.studies import CHOSEN, chosen_in, hard_scenes, recorded_rows
from quickreturn.plugins.methods.truth import Truth
from tests.engines.fake_engine import FakeEngine, FakeSettings


def short(name: str = "thesis-24") -> Case:
    return replace(load_case(name), duration=0.05)


#: A line that somebody signs, beside the search.
LINE = Line("reference", "a. n. other", {"modes": 3, "tolerance": 1e-8})


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> tuple[Race, Workshop]:
    workshop = Workshop(Store(tmp_path_factory.mktemp("race")), LocalProcesses(1))
    made = race(short(), Contest(("reference", "thesis"), runs=8, lines=(LINE,)), workshop)
    assert made is not None
    return made, workshop


def test_every_row_has_its_errors_counts_and_times(found: tuple[Race, Workshop]) -> None:
    made, _ = found
    assert {row.method for row in made.given} == {"reference", "reference, implicit", "thesis", "thesis, exact"}
    for row in made.given:
        assert row.status == "completed", row.settings
        assert set(row.errors) == set(ESTIMATED)
        assert row.calls is not None
        assert row.call_seconds is not None
        assert row.rows_seconds is not None
        assert row.seconds == pytest.approx(row.calls * row.call_seconds + row.rows_seconds)
    for method in ("reference", "thesis"):
        assert len([row for row in made.given if row.method == method and not row.signed]) == 8
    (signed,) = (row for row in made.given if row.signed)
    assert (signed.signed, signed.settings["modes"], signed.settings["tolerance"]) == ("a. n. other", 3, 1e-8)


def test_errors_are_against_a_solution_that_another_engine_confirms(found: tuple[Race, Workshop]) -> None:
    made, _ = found
    assert made.until == pytest.approx(0.05)
    assert made.confirmation.engine == "mujoco"
    assert 0.0 < (made.confirmation.error or 0.0) < 1e-4
    assert standings(made.given, 1e-3, DEFLECTION)["reference"].row.error < 1e-3  # type: ignore[operator]
    assert all((row.error or 0.0) > 0.05 for row in made.given if row.settings.get("elements") == 1)  # one cubic


def test_engines_also_answer_as_a_user_asks(found: tuple[Race, Workshop]) -> None:
    answers = [row for row in found[0].rows if row.level is not None and row.engine == "reference"]
    assert [row.level for row in answers] == list(LEVELS)  # the default accuracy is one of them
    for row in answers:
        assert row.status == REACHED
        assert (row.error or 1.0) <= (row.claim or 0.0) + (found[0].confirmation.error or 0.0)
        assert (row.answer_seconds or 0.0) > (row.solve_seconds or 0.0) > 0.0


def test_what_is_stored_is_not_computed_again(found: tuple[Race, Workshop]) -> None:
    made, workshop = found
    affinity = os.sched_getaffinity(0)
    same = Contest(("reference", "thesis"), runs=8, lines=(LINE,))
    assert race(short(), same, workshop.as_it_is) == made
    for case, other in ((replace(short(), duration=0.06), same), (short(), replace(same, lines=()))):
        with pytest.raises(LookupError):
            race(case, other, workshop.as_it_is)
    assert os.sched_getaffinity(0) == affinity  # only the workers are pinned


def test_what_is_chosen_in_a_scene_is_tried_in_another(found: tuple[Race, Workshop]) -> None:
    lines = chosen_in(found[0])
    assert {line.signed_by for line in lines} == {CHOSEN.format("thesis-24")}
    settings = [at.row.settings for level in LEVELS for at in standings(found[0].given, level).values()]
    assert [line.settings for line in lines] == [each for number, each in enumerate(settings) if each not in settings[:number]]


def test_fronts_signed_rows_and_answers_are_recorded(found: tuple[Race, Workshop]) -> None:
    made = found[0]
    for kept in (recorded_rows(made.rows, whole) for whole in (True, False)):
        assert len(kept) < len(made.rows)
        again = replace(made, rows=tuple(kept))
        for level in LEVELS:
            both = ({name: (at.seconds, at.calls) for name, at in standings(each.given, level).items()} for each in (again, made))
            assert next(both) == next(both)
        others = ([row.settings for row in rows if row.signed or row.level is not None] for rows in (made.rows, kept))
        assert next(others) == next(others)


def test_a_failure_and_a_run_that_would_be_too_long_are_rows() -> None:
    case = replace(short(), duration=0.2)
    solution = Truth(truth.run_of(engine("thesis"), case, engine("thesis").settings_type()).trajectory, Row(scene="s", engine="none"))

    def of(behaviour: str, limit: float = 10.0) -> Row:
        return tried(FakeEngine(), case, solution, FakeSettings(step=0.1, behaviour=behaviour), limit)

    assert of("fails").status == "failed at t = 0.002 s: the beam snapped; try another beam"
    assert of("good").completed  # the fake engine claims 0.125 s for any run, so a fiftieth foretells 6.25 s
    assert (of("good", 1.0).status, of("good", 1.0).solve_seconds) == (module.SLOW, None)


@pytest.mark.verify
def test_a_solution_that_cannot_be_had_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "truth_of", _broken)
    with pytest.raises(EngineFailure, match="the loop cannot close"):
        race(short(), Contest(("thesis",)), Workshop(Store(tmp_path)))
    with pytest.raises(UnknownEngine):
        race(short(), Contest(("nobody",)), Workshop(Store(tmp_path)))


def _broken(case: Case, alone: bool) -> Truth:
    raise EngineFailure(0.1, "the loop cannot close any more", "check the scene")


@pytest.mark.verify
def test_two_packages_confirm_the_solution_of_run_24() -> None:
    case = load_case("thesis-24")
    solution = truth.truth_of(case)
    assert solution.until == case.duration
    cable = truth.settings_of("exudyn", {"elements": "32", "step": "5e-5", "newton_tolerance": "1e-6"}, case)
    errors = errors_of(truth.run_of(engine("exudyn"), case, cable).trajectory, solution.trajectory)
    for error in (solution.confirmation.error, errors["tip_deflection"]):  # measured: 3e-5 and 6e-5
        assert 0.0 < (error or 1.0) <= truth.CONFIRMED


@pytest.mark.verify
def test_compiling_takes_longer_than_loading_what_was_compiled(tmp_path: Any) -> None:
    workshop = Workshop(Store(tmp_path))
    assert compiling(workshop.as_it_is, ("thesis", "exudyn")) == []
    (made,) = compiling(workshop, ("thesis", "exudyn"))  # exudyn compiles nothing
    assert made.engine == "thesis"
    assert 0.0 < 3.0 * made.load_seconds < made.compile_seconds
    assert compiling(workshop.as_it_is, ("thesis",)) == [made]


@pytest.mark.verify
def test_no_claim_in_a_hard_scene_is_wrong() -> None:
    """Stored where the report finds it; what was computed before is taken from there."""
    races = list(hard_scenes(Workshop(Store())))
    assert {found.case for found in races} == {entry.name for entry in catalogue(TAG)}
    rows = [row for found in races for row in found.rows]
    assert len(rows) == len(races) * len(MAIN)
    assert [(row.scene, row.engine) for row in rows if row.status == WRONG] == []
    assert [row for row in rows if row.status == REACHED]
