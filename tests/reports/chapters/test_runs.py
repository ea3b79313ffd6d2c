"""Every run on every engine: how many settled, and what could be measured."""

from quickreturn.reports.chapters.runs import finding, resolvable
from tests.reports.pages import finding_of, one_run, text_of
from tests.reports.reported_results import reported_result

HALVES = "half turns in which the first mode rings enough to be measured"


def test_the_heading_counts_what_is_not_settled_and_what_is_resolved() -> None:
    assert finding(0, {"a": (3, 4), "b": (4, 4)}) == f"All settled; {HALVES}: a 3 of 4, b 4 of 4"
    assert finding(1, {"a": (0, 2)}) == "1 of the simulations is not simply settled; the first mode rings too little to be measured"
    assert finding(2, {"a": (2, 2), "b": (0, 0)}) == f"2 of the simulations are not simply settled; {HALVES}: a 2 of 2"
    assert finding(3, {"a": (0, 0)}) == "3 of the simulations are not simply settled"
    assert finding(0, {}) == "All settled"


def test_half_cycles_of_usable_runs_alone_are_counted() -> None:
    results = [reported_result("thesis-24"), reported_result("thesis-06", {"exudyn": "failed", "mujoco": "inaccurate"})]
    assert {name: resolvable(results, name) for name in results[0].runs} == {
        "thesis": (4, 4),
        "reference": (4, 4),
        "exudyn": (2, 2),
        "mujoco": (2, 4),  # made-up runs of this status have no frequencies
    }
    told = finding_of(one_run(*results), "runs")
    assert told.startswith("2 of the simulations are not simply settled; ")
    assert told.endswith("exudyn 2 of 2, mujoco 2 of 4")


def test_what_is_not_simply_settled_is_named() -> None:
    told = text_of(one_run(reported_result("thesis-06", {"exudyn": "failed", "mujoco": "inaccurate"})))
    assert "Not simply settled: exudyn on run 6 (failed); mujoco on run 6 (inaccurate). Provenance gives" in told
    assert "Not simply settled" not in text_of(one_run())
