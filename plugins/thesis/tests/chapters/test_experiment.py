"""The experiment: how far simulated peaks are from what is left of it."""

import pytest

from quickreturn.plugins.thesis.chapters.experiment import _worse, finding
from tests.reports.pages import finding_of, one_run, text_of
from tests.reports.plotted_results import with_table
from tests.reports.reported_results import reported_result

STRAIN = {"thesis": [1.0, 2.0], "reference": [1.5, 3.0], "exudyn": [1.5, 3.0]}
RANGES = "1.00 to 2.00 (thesis), 1.50 to 3.00 (reference and exudyn)"


def test_the_heading_says_what_survives_and_how_strains_compare() -> None:
    assert all(each in finding(False, STRAIN, True) for each in ("No measured waveform", RANGES, "worse than the stiff cubic"))
    assert "worse" not in finding(True, STRAIN, False)
    assert finding(False, {}, False) == "No measured waveform survives"


def test_the_heading_is_about_the_runs_of_the_page() -> None:
    assert finding_of(one_run(), "experiment").startswith("No measured waveform survives; simulated strain peaks are ")
    recorded = with_table(reported_result("thesis-24"), "curve.csv", ["strain_2"], {"origin": "digitised"}, of_experiment=True)
    assert finding_of(one_run(recorded), "experiment").startswith("There are recordings; ")


@pytest.mark.parametrize(("cubic", "converged", "worse"), [(1.0, 2.0, True), (2.0, 1.0, False)])
def test_a_peak_further_above_the_label_is_worse(cubic: float, converged: float, worse: bool) -> None:
    assert _worse({"thesis": cubic, "reference": converged}) is worse
    assert not _worse({"thesis": cubic})


def test_a_page_can_be_made_without_the_converged_model_in_the_run_whose_measured_curves_stand_alone() -> None:
    told = text_of(one_run(reported_result("thesis-06"), reported_result("thesis-24", {"reference": "not settled"})))
    assert "The converged model fits worse" in told
    assert "says the same" not in told
