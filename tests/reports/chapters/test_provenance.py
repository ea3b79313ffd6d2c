"""Provenance: engines, statuses, and whether there is a long verification."""

from quickreturn.cases.runs.endings import Ending
from quickreturn.reports.chapters.provenance import engines, finding, settings
from quickreturn.reports.verification import Verification
from tests.reports.pages import finding_of, one_run, plain, text_of
from tests.reports.reported_results import reported_result

VERIFIED, ABSENT = Verification(date="2026-01-02"), Verification(absent="It has not been run with this store.")


def test_the_heading_counts_engines_and_runs_that_are_not_simply_settled() -> None:
    assert plain(finding(1, 0, ABSENT)) == "1 engine, versions, machine, settings; no long verification"
    assert plain(finding(4, 0, VERIFIED)) == "4 engines, versions, machine, settings; verified on 2026-01-02"
    assert plain(finding(4, 1, ABSENT)) == "4 engines, versions, machine, settings; 1 run not simply settled; no long verification"
    assert plain(finding(4, 2, VERIFIED)) == "4 engines, versions, machine, settings; 2 runs not simply settled; verified on 2026-01-02"


def test_the_heading_is_about_the_runs_of_the_page() -> None:
    content = one_run(reported_result("thesis-24", {"exudyn": "failed", "mujoco": "inaccurate"}), verification=ABSENT)
    assert finding_of(content, "provenance") == "4 engines, versions, machine, settings; 2 runs not simply settled; no long verification"
    assert "failed: " in text_of(content)  # what the status means
    assert "Every engine" not in text_of(content)
    assert f"Every engine {Ending.SETTLED.sentence}, on every case." in text_of(one_run(verification=ABSENT))


def test_tables_of_engines_and_settings_have_what_the_runs_have() -> None:
    """With the numbers of `reported_result`."""
    result = reported_result("thesis-24", {"exudyn": "failed"})
    for row in engines(one_run(result)).rows:
        assert (row["method"].value, row["accuracy"].value, row["runs"].value) == ("made up", 1e-3, 1)
    for row in settings([result]).rows:
        keys = ("accuracy", "error_estimate", "cycles", "settling_error")
        assert tuple(row[key].value for key in keys) == (1e-3, 8e-4, 12, 5e-4)
