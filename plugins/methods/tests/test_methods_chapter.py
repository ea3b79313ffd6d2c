"""The chapter that answers the thesis' question says what the numbers say, with their limits."""

import dataclasses

import pytest

from quickreturn.plugins.methods.benchmark import Compiling
from quickreturn.plugins.methods.chapters import methods_tables as tables
from quickreturn.plugins.methods.chapters.methods import finding, waiting_words
from quickreturn.plugins.methods.fastest import Fastest, fastest_figure
from quickreturn.plugins.methods.tests.made_up_benchmark import made_up_benchmark
from quickreturn.plugins.methods.tests.pages import chapter_of, finding_of, one_run, plain, read, text_of
from quickreturn.plugins.methods.trials.trial import Trial

EXAMPLE = Fastest("thesis-24", 1e-3, [("a", 4e-3), ("b", 160e-3), ("mujoco", 1.0)])


@pytest.mark.parametrize(
    ("firsts", "soonest", "own", "words"),
    [
        ({"a": 4, "b": 1}, {"b": 4, "a": 2}, True, ["own code compiled", "4 of 6 contests (by waiting time, 2); 1 nobody wins"]),
        ({"a": 6}, {}, False, ["6 of 6 contests; to 0.1 % in run 24 a solves in 4.0 ms (b in 160 ms) and takes 10 ms besides"]),
        ({}, {}, False, ["No method wins any of 6 contests"]),
    ],
)
def test_the_heading_counts_contests(firsts: dict[str, int], soonest: dict[str, int], own: bool, words: list[str]) -> None:
    told = plain(finding(6, firsts, soonest, own, EXAMPLE, "10 ms"))
    assert all(each in told for each in words), told
    assert "solves in" not in finding(6, firsts, soonest, own, dataclasses.replace(EXAMPLE, solve_times=[]), "")


def test_what_one_waits_for_besides_is_listed() -> None:
    timed = made_up_benchmark(timed=True).trials[0]
    told = plain(waiting_words(timed, Compiling("reference", 40.0, 0.5)))
    assert all(each in told for each in ("10 ms for set-up", "18 ms for the estimate", "40 s for compilation"))
    assert plain(waiting_words(dataclasses.replace(timed, estimate_seconds=None), None)) == "10 ms for set-up"


def test_observed_orders_are_those_of_the_power_laws() -> None:
    rows = {row["method"].value: row["thesis-24"].value for row in tables.orders([made_up_benchmark()]).rows}
    assert round(float(str(rows["multiplier"])), 6) == 3.0
    assert round(float(str(rows["exudyn"])), 6) == 2.0
    assert rows["nodal-load"] is None


def test_points_that_failed_are_listed() -> None:
    (row,) = tables.failures([made_up_benchmark()]).rows
    assert row["method"].value == "nodal-load"
    assert "the beam snapped" in str(row["status"].value)
    everything = tables.trials([made_up_benchmark()])
    assert len(everything.rows) == len(made_up_benchmark().trials)


def test_an_unconfirmed_truth_is_a_warning() -> None:
    assert "smaller errors say nothing here" not in text_of(one_run(benchmarks=[made_up_benchmark()]))
    assert "smaller errors say nothing here" in text_of(one_run(benchmarks=[made_up_benchmark(confirmed=False)]))
    missing = dataclasses.replace(made_up_benchmark(), confirmation=Trial(scene="thesis-24", engine="mujoco", status="no such library"))
    assert "smaller errors say nothing here" in text_of(one_run(benchmarks=[missing]))


def test_scenes_that_were_not_measured_are_named_and_without_any_there_is_no_chapter() -> None:
    assert "quickreturn benchmark" in text_of(one_run(benchmarks=[made_up_benchmark()]))
    assert "methods" not in read(one_run()).anchors


def test_contests_that_nobody_wins_are_counted() -> None:
    # the least error of reference is 0.1 / 16^4 = 1.5e-6: it gets everywhere; without it 0.01 % is out of reach of all others
    assert "solves fastest in 3 of 3 contests" in finding_of(one_run(benchmarks=[made_up_benchmark()]), "methods")
    table = made_up_benchmark()
    others = dataclasses.replace(table, trials=tuple(trial for trial in table.trials if trial.method == "exudyn"))
    told = finding_of(one_run(benchmarks=[others]), "methods")
    assert told.startswith("exudyn solves fastest in 1 of 3 contests; 2 nobody wins")


def test_who_solves_fastest_need_not_be_who_is_done_first() -> None:
    table = made_up_benchmark(timed=True)
    slow = [dataclasses.replace(each, estimate_seconds=100.0) if each.engine == "reference" else each for each in table.trials]
    table = dataclasses.replace(table, trials=tuple(slow))
    rows = [row for row in tables.waiting([table]).rows if row["level"].value == 1e-2]
    assert [row["method"].value for row in rows] == ["multiplier", "multiplier, elements", "exudyn", "reference"]
    # 8 degrees of freedom at 10 ms, its estimate as much, and 10 ms of setting up
    assert rows[0]["waited_seconds"].value == pytest.approx(0.17)
    told = "solves fastest in 3 of 3 contests (by waiting time, 1)"
    assert told in text_of(one_run(benchmarks=[table]))


def test_the_chart_offers_what_one_waits_for_where_that_was_measured() -> None:
    choices = [chapter_of(one_run(benchmarks=[made_up_benchmark(timed=timed)]), "methods").facts["plots"][0][1] for timed in (False, True)]
    assert [list(each) for each in choices] == [["solve time"], ["solve time", "waiting time"]]
    series = {each.name: each for each in choices[1]["waiting time"].series}
    assert "Pareto front" not in series
    assert list(series["reference"].x) == pytest.approx([0.01 + 10.0 * 1e-3 * free for free in (2, 4, 8, 16)])


def test_the_first_screen_has_a_figure_on_the_fastest_and_the_next_engine() -> None:
    number, meaning = map(plain, fastest_figure(one_run(benchmarks=[made_up_benchmark()])) or ("", ""))
    assert number == "4.0 ms"  # 0.1 / 4^4, 1 / 16^3 < 0.1 % with 4 and 16 degrees of freedom
    assert meaning.startswith("to solve run 24 to 0.1 %, after a set-up of")
    assert meaning.endswith("reference, made for this mechanism; multiplier takes 40 times as long")
    assert fastest_figure(one_run()) is None
