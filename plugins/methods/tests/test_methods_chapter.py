"""The chapter on methods: who is first, by how much, which factor buys what, and what carries over to other scenes."""

from dataclasses import replace

import pytest

from quickreturn.plugins.methods.chapters import methods as tables
from quickreturn.plugins.methods.chapters.methods import fastest_figure, finding
from quickreturn.plugins.methods.entrants import entrant, pairs
from quickreturn.plugins.methods.fronts import DEFLECTION, WORST
from quickreturn.plugins.methods.row import TIP, Row
from quickreturn.plugins.methods.studies import CHOSEN
from quickreturn.plugins.methods.tests.made_up_races import made_up_fronts, made_up_race
from quickreturn.plugins.methods.tests.pages import finding_of, one_run, plain, read, text_of


def test_the_heading_has_the_first_and_how_long_the_next_takes() -> None:
    # 1 %: reference 0.1 n^-4 at 10^(1/4) < 2 unknowns, which its first run has, 2 ms; multiplier n^-3 at 100^(1/3) unknowns
    told = plain(finding([made_up_race()]))
    assert told.startswith("reference, this project’s own code compiled for this one mechanism, solves fastest in 3 of 3 contests")
    assert f"the next takes {1e-2 * 100 ** (1 / 3) / 2e-3:.0f} times as long to 1 % (multiplier)" in told
    others = plain(finding([made_up_race(engines=("exudyn",))]))
    assert others == "exudyn solves fastest in 1 of 3 contests; 2 nobody wins"
    assert "no method" in finding([made_up_race(engines=("thesis",))]).lower()
    assert finding_of(one_run(fronts=made_up_fronts()), "methods") == told


def test_a_level_that_an_acceleration_misses_is_missed_by_the_worst_of_four() -> None:
    found = made_up_race(acceleration=10.0)
    first, worst = (tables.fastest([found], by).rows for by in (DEFLECTION, WORST))
    assert float(str(worst[0]["level_seconds"].value)) > float(str(first[0]["level_seconds"].value))
    assert [(row["method"].value, row["method"].mark) for row in worst[:2]] == [("reference", "good"), ("multiplier", "")]
    assert worst[0]["level_calls"].value == pytest.approx(1e6 * worst[0]["level_seconds"].value)
    assert "thesis" not in {row["method"].value for row in worst}


def test_a_pair_of_methods_differs_in_one_factor() -> None:
    rows = [Row(scene="s", engine="reference"), Row(scene="s", engine="fixed-shapes", variant="explicit")]
    rows += [Row(scene="s", engine=name) for name in ("fixed-shapes", "multiplier", "stiff-spring", "exudyn")]
    rows.append(Row(scene="s", engine="multiplier", variant="hermite"))
    assert list(pairs(rows)) == [
        ("shapes", "reference", "fixed-shapes, explicit"),
        ("integrator", "fixed-shapes, explicit", "fixed-shapes"),
        ("constraint", "fixed-shapes", "multiplier"),
        ("constraint", "fixed-shapes", "stiff-spring"),
        ("constraint", "multiplier", "stiff-spring"),
        ("shapes", "multiplier", "multiplier, hermite"),
    ]
    implicit = Row(scene="s", engine="reference", variant="implicit")
    assert (entrant(implicit).integrator, entrant(implicit).order) == ("Radau IIA", 5)
    assert list(pairs([rows[0], implicit])) == [("integrator", "reference", "reference, implicit")]
    assert entrant(Row(scene="s", engine="exudyn")).order == 2
    assert "our chain, multiplier and time loop on MuJoCo" in entrant(Row(scene="s", engine="mujoco")).note


def test_what_a_factor_buys_is_the_ratio_of_times_and_of_calls() -> None:
    (row,) = (row for row in tables.factors([made_up_race()]).rows if row["level"].value == 1e-2)
    assert (row["factor"].value, row["method"].value, row["instead_of"].value) == ("shapes", "multiplier", "multiplier, hermite")
    unknowns = [100.0 ** (1.0 / 3.0), 3000.0 ** (1.0 / 4.0)]
    assert row["calls"].value == pytest.approx(unknowns[1] / unknowns[0])
    assert row["times"].value == pytest.approx(2.0 * unknowns[1] / unknowns[0])


def test_the_broad_front_of_all_falls_and_who_completed_nothing_is_not_drawn() -> None:
    whole, *others = tables.errors_over_time(made_up_race(), WORST).series
    places = list(zip(whole.x, whole.y, strict=True))
    assert places == sorted(places)
    assert list(whole.y) == sorted(whole.y, reverse=True)  # type: ignore[type-var]
    assert [(each.name, each.of, each.hollow) for each in others][1:3] == [
        ("multiplier", "multiplier", False),
        ("multiplier, hermite", "multiplier", True),
    ]
    assert "nodal-load" not in {each.name for each in others}


def test_settings_that_were_chosen_in_one_scene_show_what_they_are_worth_in_another() -> None:
    first, other = made_up_race(), made_up_race("thesis-17")
    carried = replace(other.given[1], signed=CHOSEN.format("thesis-24"), errors={TIP: 4e-4}, solve_seconds=8e-3)
    failed = replace(carried, engine="exudyn", status="failed", errors={}, solve_seconds=None)
    _, _, *rows = tables.chosen([first, replace(other, rows=(*other.rows, carried, failed))]).rows  # exudyn's signed line in both
    # its front has 0.1 4^-4 = 3.9e-4 at 4 ms, in place of its 8 ms at 4e-4
    assert rows[0]["over"].value == pytest.approx(2.0, rel=0.02)
    assert (rows[1]["error"].text, rows[1]["over"].value) == ("failed", None)


@pytest.mark.verify
def test_a_doubtful_solution_is_a_warning_and_without_a_race_there_is_no_chapter() -> None:
    warning = "smaller errors say nothing here"
    assert warning not in text_of(one_run(fronts=made_up_fronts()))
    assert warning in text_of(one_run(fronts=made_up_fronts(made_up_race(confirmed=False))))
    missing = replace(made_up_race(), confirmation=Row(scene="thesis-24", engine="mujoco", status="no such library"))
    assert warning in text_of(one_run(fronts=made_up_fronts(missing)))
    assert "Not measured yet: thesis-17" in text_of(one_run(fronts=made_up_fronts()))
    assert "methods" not in read(one_run()).anchors


def test_the_first_screen_has_a_figure_on_the_fastest_and_the_next_engine() -> None:
    number, meaning = map(plain, fastest_figure(one_run(fronts=made_up_fronts())) or ("", ""))
    assert number == "3.2 ms"  # 0.1 n^-4 = 0.1 % at 10^(1/2) unknowns
    assert meaning.startswith("to solve run 24 to 0.1 % of the tip deflection: reference, made for this mechanism; multiplier takes")
    assert fastest_figure(one_run()) is None
