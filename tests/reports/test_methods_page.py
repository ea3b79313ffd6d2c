"""The chapter that answers the thesis' question says what the numbers say, with their limits."""

import dataclasses

from cases.benchmark import Benchmark
from reports.pages.blocks import Points, Text
from reports.pages.content import Content
from reports.pages.methods import headline, methods
from reports.tables import benchmark as tables
from tests.reports.made_up_benchmark import made_up_benchmark
from tests.reports.reported_results import reported_result


def lines(*benchmarks: Benchmark) -> list[str]:
    chapter = methods(Content(results=[reported_result("thesis-24")], benchmarks=benchmarks))
    return [item.replace("\N{NO-BREAK SPACE}", " ") for block in chapter.blocks if isinstance(block, Points) for item in block.items]


def test_the_fastest_the_next_and_the_packages_are_named_at_each_error() -> None:
    told = lines(made_up_benchmark())
    # reference: 0.1 / 2^4 < 1 % with 2 degrees of freedom, 2 ms; multiplier: 1 / 8^3 with 8, 80 ms; exudyn: 2 / 16^2 with 16, 1.6 s
    assert told[0] == (
        "To 1 % of run 24's tip deflection reference (2.0 ms) is fastest; multiplier takes 80 ms, 40 times as long and exudyn takes"
        " 1.6 s, 800 times as long; mujoco is not here."
    )
    assert "exudyn does not get there with the settings of its ladder; mujoco is not here" in told[1]


def test_the_answer_in_one_sentence() -> None:
    content = Content(results=[reported_result("thesis-24")], benchmarks=[made_up_benchmark()])
    told = headline(content).replace("\N{NO-BREAK SPACE}", " ")
    assert "on 1 scene is reference in 3 of 3." in told
    assert told.endswith("To 0.1 % in run 24: reference (4.0 ms) and multiplier (160 ms).")
    assert headline(Content(results=[reported_result("thesis-24")])) == ""


def test_a_model_that_does_not_converge_is_said_to() -> None:
    assert any("do not help thesis (80 %)" in line for line in lines(made_up_benchmark()))


def test_observed_orders_are_those_of_the_power_laws() -> None:
    rows = {row[0].value: row[1].value for row in tables.orders([made_up_benchmark()]).rows}
    assert round(float(str(rows["multiplier"])), 6) == 3.0
    assert round(float(str(rows["exudyn"])), 6) == 2.0
    assert rows["nodal-load"] is None


def test_points_that_failed_are_listed() -> None:
    (row,) = tables.failures([made_up_benchmark()]).rows
    assert row[1].value == "nodal-load"
    assert "the beam snapped" in str(row[3].value)
    everything = tables.points([made_up_benchmark()])
    assert len(everything.rows) == len(made_up_benchmark().points)


def test_an_unconfirmed_truth_is_a_warning() -> None:
    chapter = methods(Content(results=[reported_result("thesis-24")], benchmarks=[made_up_benchmark(confirmed=False)]))
    warnings = [block.text for block in chapter.blocks if isinstance(block, Text) and block.tone == "warning"]
    assert any("agree to 1.0" in text for text in warnings)
    missing = dataclasses.replace(made_up_benchmark(), confirmation={"engine": "mujoco", "settings": {}, "failure": "no such library"})
    chapter = methods(Content(results=[reported_result("thesis-24")], benchmarks=[missing]))
    assert any("could not be compared" in block.text for block in chapter.blocks if isinstance(block, Text))


def test_without_measurements_the_chapter_says_how_to_get_them() -> None:
    chapter = methods(Content(results=[reported_result("thesis-24")]))
    assert not list(chapter.tables)
    assert any("quickreturn benchmark" in block.text for block in chapter.blocks if isinstance(block, Text))
