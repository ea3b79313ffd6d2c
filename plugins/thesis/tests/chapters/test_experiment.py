"""The experiment: how far simulated peaks are from what is left of it."""

from tests.reports.pages import finding_of, one_run, text_of
from tests.reports.plotted_results import with_table
from tests.reports.reported_results import reported_result


def test_the_heading_is_about_the_runs_of_the_page() -> None:
    assert finding_of(one_run(), "experiment").startswith("No measured waveform survives; simulated strain peaks are ")
    recorded = with_table(reported_result("thesis-24"), "curve.csv", ["strain_2"], {"origin": "digitised"}, of_experiment=True)
    assert finding_of(one_run(recorded), "experiment").startswith("There are recordings; ")


def test_a_page_can_be_made_without_the_converged_model_in_the_run_whose_measured_curves_stand_alone() -> None:
    told = text_of(one_run(reported_result("thesis-06"), reported_result("thesis-24", {"reference": "not settled"})))
    assert "The converged model fits worse" in told
    assert "says the same" not in told
