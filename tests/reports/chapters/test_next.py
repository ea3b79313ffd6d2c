"""What to do next: what failed, where engines disagree, and commands for the case."""

from quickreturn.reports.chapters.next import finding

from tests.reports.pages import finding_of, one_run, plain, text_of
from tests.reports.reported_results import agreeing, reported_result


def test_the_heading_names_what_failed_first_and_then_what_departs() -> None:
    assert plain(finding(1, ["a"])) == "1 simulation did not deliver"
    assert plain(finding(2, [])) == "2 simulations did not deliver"
    assert finding(0, ["a"]) == "Engines disagree in a"
    assert finding(0, ["a", "b", "c"]) == "Engines disagree in a, b and c"
    assert finding(0, []) == "Change a value, measure the cost, take the data"


def test_the_heading_is_about_the_cases_of_the_page() -> None:
    failed = one_run(reported_result("example", {"exudyn": "failed", "mujoco": "not settled"}))
    assert finding_of(failed, "next") == "2 simulations did not deliver"
    assert finding_of(one_run(reported_result("example")), "next") == "Engines disagree in example"  # made up: mujoco departs
    assert finding_of(one_run(agreeing(reported_result("example"))), "next").startswith("Change a value")


def test_commands_are_for_the_case_and_with_a_value_that_it_can_have() -> None:
    told = text_of(one_run(reported_result("example", {"exudyn": "failed"})))
    assert "example, exudyn: failed at t = 0.25 s: the beam <snapped>; try another beam" in told
    assert 'quickreturn run example --set crank.length="90 mm" makes the crank a tenth shorter' in told
