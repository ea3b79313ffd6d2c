"""The chapter that answers the thesis' question says what the numbers say, with their limits."""

import dataclasses

from cases.benchmark.findings import Confirmation
from reports.page.answer import answer_of
from reports.tables import benchmark as tables
from tests.reports.made_up_benchmark import made_up_benchmark
from tests.reports.pages import one_run, read, text_of


def test_the_fastest_the_next_and_the_packages_are_named_at_each_error() -> None:
    told = text_of(one_run(benchmarks=[made_up_benchmark()]))
    # reference: 0.1 / 2^4 < 1 % with 2 degrees of freedom, 2 ms; multiplier: 1 / 8^3 with 8, 80 ms; exudyn: 2 / 16^2 with 16, 1.6 s
    wanted = "To 1 % of run 24’s tip deflection: reference 2.0 ms, multiplier 80 ms (40 times as long), exudyn 1.6 s (800 times as long)."
    assert wanted in told


def test_the_answer_names_the_fastest_and_the_next_engine() -> None:
    found = answer_of(one_run(benchmarks=[made_up_benchmark()])).fastest
    assert found is not None
    assert found.found[:2] == [("reference", 4e-3), ("multiplier", 160e-3)]  # 0.1 / 4^4, 1 / 16^3 < 0.1 % with 4 and 16 degrees of freedom
    assert answer_of(one_run()).fastest is None


def test_a_model_that_does_not_converge_is_said_to() -> None:
    assert "Finer settings do not help thesis: 80 % are left" in text_of(one_run(benchmarks=[made_up_benchmark()]))


def test_observed_orders_are_those_of_the_power_laws() -> None:
    rows = {row["method"].value: row["thesis-24"].value for row in tables.orders([made_up_benchmark()]).rows}
    assert round(float(str(rows["multiplier"])), 6) == 3.0
    assert round(float(str(rows["exudyn"])), 6) == 2.0
    assert rows["nodal-load"] is None


def test_points_that_failed_are_listed() -> None:
    (row,) = tables.failures([made_up_benchmark()]).rows
    assert row["method"].value == "nodal-load"
    assert "the beam snapped" in str(row["status"].value)
    everything = tables.points([made_up_benchmark()])
    assert len(everything.rows) == len(made_up_benchmark().points)


def test_an_unconfirmed_truth_is_a_warning() -> None:
    assert "smaller errors say nothing here" not in text_of(one_run(benchmarks=[made_up_benchmark()]))
    assert "smaller errors say nothing here" in text_of(one_run(benchmarks=[made_up_benchmark(confirmed=False)]))
    missing = dataclasses.replace(made_up_benchmark(), confirmation=Confirmation("mujoco", {}, failure="no such library"))
    assert "smaller errors say nothing here" in text_of(one_run(benchmarks=[missing]))


def test_scenes_that_were_not_measured_are_named_and_without_any_there_is_no_chapter() -> None:
    assert "quickreturn benchmark" in text_of(one_run(benchmarks=[made_up_benchmark()]))
    assert "methods" not in read(one_run()).anchors
