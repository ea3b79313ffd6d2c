"""The chapter that answers the thesis' question says what the numbers say, with their limits."""

import dataclasses

import pytest

from quickreturn.plugins.methods.benchmark import Compiling
from quickreturn.plugins.methods.chapters import methods_tables as tables
from quickreturn.plugins.methods.chapters.methods import contest_words, finding, level_words, mark_words, waiting_words
from quickreturn.plugins.methods.fastest import Fastest, fastest_figure
from quickreturn.plugins.methods.tests.made_up_benchmark import made_up_benchmark
from quickreturn.plugins.methods.tests.pages import chapter_of, one_run, plain, read, text_of
from quickreturn.plugins.methods.trials.trial import Trial

EXAMPLE = Fastest("thesis-24", 1e-3, [("a", 4e-3), ("b", 160e-3), ("mujoco", 1.0)])


def test_the_heading_counts_contests_and_names_the_fastest() -> None:
    in_one = "to 0.1 % in run 24 a solves in 4.0 ms (b in 160 ms)"
    told = plain(finding(6, {"a": 4, "b": 1}, {"b": 4, "a": 2}, True, EXAMPLE, "10 ms for set-up"))
    own = (
        "a, this project’s own code compiled for this one mechanism, solves fastest in 4 of 6 contests (by waiting time, 2); 1 nobody wins"
    )
    assert told == f"{own}; {in_one} and takes 10 ms for set-up besides"
    assert plain(finding(6, {"a": 6}, {}, False, EXAMPLE, "")) == f"a solves fastest in 6 of 6 contests; {in_one}"
    assert (
        plain(finding(6, {"a": 6}, {"b": 6}, False, EXAMPLE, "")) == f"a solves fastest in 6 of 6 contests (by waiting time, 0); {in_one}"
    )


def test_the_heading_without_a_winner_or_without_a_second_method() -> None:
    nobody = dataclasses.replace(EXAMPLE, solve_times=[])
    assert finding(3, {}, {}, False, nobody, "") == "No method wins any of 3 contests"
    assert finding(3, {"a": 1}, {}, False, nobody, "") == "a solves fastest in 1 of 3 contests; 2 nobody wins"
    alone = dataclasses.replace(EXAMPLE, solve_times=EXAMPLE.solve_times[:1])
    assert plain(finding(3, {"a": 3}, {}, False, alone, "")).endswith("contests; to 0.1 % in run 24 a solves in 4.0 ms")


def test_what_one_waits_for_besides_is_listed() -> None:
    timed = made_up_benchmark(timed=True).trials[0]
    compiled, untimed = Compiling("reference", 40.0, 0.5), dataclasses.replace(timed, estimate_seconds=None)
    setup, estimate, once = "10 ms for set-up", "18 ms for the estimate of its error", "once 40 s for compilation"
    assert plain(waiting_words(timed, compiled)) == f"{setup}, {estimate} and {once}"
    assert plain(waiting_words(timed, None)) == f"{setup}, {estimate}"
    assert plain(waiting_words(untimed, compiled)) == f"{setup}, and {once}"
    assert plain(waiting_words(untimed, None)) == setup


def test_an_error_that_no_method_reaches_is_told() -> None:
    begin = "To 0.1 % of run 24’s tip deflection"
    times = "a 4.0 ms, b 160 ms (40 times as long), mujoco 1.0 s (250 times as long)"
    assert plain(level_words(EXAMPLE)) == f"{begin}: {times}."
    assert plain(level_words(dataclasses.replace(EXAMPLE, solve_times=[]))) == f"{begin}: no method reaches it with these ladders."


def test_winners_of_all_contests_are_counted_by_both_times() -> None:
    solved, waited = "The fastest solver in 6 contests: a in 5", "By waiting time (set-up, solution and error estimate): b in 4, a in 2."
    assert plain(contest_words(6, {"a": 5}, {"b": 4, "a": 2})) == f"{solved}; in 1 no method reaches the error. {waited}"
    unmeasured = "The time of the error estimates was not measured here."
    assert plain(contest_words(6, {"a": 5, "b": 1}, {})) == f"{solved}, b in 1; each has a winner. {unmeasured}"


def test_the_fastest_the_next_and_the_packages_are_named_at_each_error() -> None:
    told = text_of(one_run(benchmarks=[made_up_benchmark()]))
    # reference: 0.1 / 2^4 < 1 % with 2 degrees of freedom, 2 ms; multiplier: 1 / 8^3 with 8, 80 ms; exudyn: 2 / 16^2 with 16, 1.6 s
    wanted = "To 1 % of run 24’s tip deflection: reference 2.0 ms, multiplier 80 ms (40 times as long), exudyn 1.6 s (800 times as long)."
    assert wanted in told


def test_a_model_that_does_not_converge_is_said_to() -> None:
    others = made_up_benchmark("hard-prescribed-speed")
    moving = [dataclasses.replace(trial, engine="moving-boundaries") for trial in others.trials[-5:-1]]
    told = text_of(one_run(benchmarks=[made_up_benchmark(), dataclasses.replace(others, trials=(*others.trials, *moving))]))
    for name, left in (("thesis", "run 24, 80 % in hard-prescribed-speed"), ("moving-boundaries", "hard-prescribed-speed")):
        assert f"Finer settings do not help {name}: 80 % are left in {left}. This is the error of the model." in told


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
    told = text_of(one_run(benchmarks=[made_up_benchmark()]))
    assert "reference, this project’s own code compiled for this one mechanism, solves fastest in 3 of 3 contests" in told
    assert "nobody wins" not in told
    table = made_up_benchmark()
    others = dataclasses.replace(table, trials=tuple(trial for trial in table.trials if trial.method == "exudyn"))
    told = text_of(one_run(benchmarks=[others]))
    assert "exudyn solves fastest in 1 of 3 contests; 2 nobody wins" in told
    assert "own code compiled" not in told


def test_what_one_waits_for_stands_beside_the_solve_time() -> None:
    compiled = [Compiling("reference", 40.0, 0.5)]
    told = text_of(one_run(benchmarks=[made_up_benchmark(timed=True)], compiling=compiled))
    # 4 modes solve in 4 ms and reach 0.1 / 4^4 < 0.1 %; the estimate takes nine times as long
    assert "to 0.1 % in run 24 reference solves in 4.0 ms (multiplier in 160 ms)" in told
    assert "takes 10 ms for set-up, 36 ms for the estimate of its error and once 40 s for compilation besides" in told
    assert "waiting time (set-up, solution and error estimate): reference in 3." in told
    without = text_of(one_run(benchmarks=[made_up_benchmark()]))
    assert "takes 10 ms for set-up besides" in without
    assert "was not measured here" in without


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
    assert "error estimate): multiplier in 2, reference in 1." in text_of(one_run(benchmarks=[table]))


def test_the_marks_of_a_chart_are_explained() -> None:
    assert mark_words(True).startswith(
        "Waiting time was measured for each method’s fastest settings to each error. Hollow marks are variants"
    )
    assert mark_words(False).startswith("Hollow marks are variants of a method; ")


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
