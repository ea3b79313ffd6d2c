"""The experiment: how far simulated peaks are from what is left of it."""

import pytest

from quickreturn.plugins.thesis.axes import AxisComparison
from quickreturn.plugins.thesis.chapters.experiment import (
    alone_words,
    below_words,
    drawn_alone_words,
    finding,
    label_words,
    ranges,
    varying_words,
    worse_words,
)
from quickreturn.plugins.thesis.tests.made_up_finding import BAND
from tests.reports.pages import finding_of, one_run, plain, text_of
from tests.reports.plotted_results import with_table
from tests.reports.reported_results import reported_result

STRAIN = {"thesis": [1.0, 2.0], "reference": [1.5, 3.0], "exudyn": [1.5, 3.0]}
RANGES = "1.00 to 2.00 (thesis), 1.50 to 3.00 (reference and exudyn)"
WORSE = ": the converged model fits this one contact with the measurement worse than the stiff cubic"


def test_the_heading_says_what_survives_and_how_strains_compare() -> None:
    told = f"simulated strain peaks are {RANGES} times the largest printed axis label"
    assert finding(False, STRAIN, True) == f"No measured waveform survives; {told}{WORSE}"
    assert finding(True, STRAIN, False) == f"There are recordings; {told}"
    assert finding(False, {}, False) == "No measured waveform survives"


def test_the_heading_is_about_the_runs_of_the_page() -> None:
    assert finding_of(one_run(), "experiment").startswith("No measured waveform survives; simulated strain peaks are ")
    recorded = with_table(reported_result("thesis-24"), "curve.csv", ["strain_2"], {"origin": "digitised"}, of_experiment=True)
    assert finding_of(one_run(recorded), "experiment").startswith("There are recordings; ")


def test_a_page_can_be_made_without_the_converged_model_in_the_run_whose_measured_curves_stand_alone() -> None:
    other, without = reported_result("thesis-06"), reported_result("thesis-24", {"reference": "not settled"})
    told = text_of(one_run(other, without))
    assert "The converged model fits worse" in told
    assert "shows the measured strains of run" not in told


def test_engines_with_the_same_range_stand_together() -> None:
    assert ranges(STRAIN) == RANGES
    assert ranges({"a": [1.0, 2.0]}) == "1.00 to 2.00 (a)"


def test_peaks_are_held_against_labels_channel_by_channel() -> None:
    told = plain(label_words("tip_acceleration", {"thesis": [0.5, 0.25], "mujoco": [2.0]}))
    first = "Simulated peak over the largest label, tip acceleration: 0.25 to 0.50 (thesis), 2.00 to 2.00 (mujoco), in 2 runs."
    assert told == f"{first} In the median the peak is off the label by a factor of 2.83 (thesis), 2.00 (mujoco)."
    assert " in 1 run. " in plain(label_words("strain", {"thesis": [0.5]}))


def test_the_runs_far_below_the_label_of_acceleration_are_counted() -> None:
    ratios = {"thesis": [0.4, 0.6], "reference": [0.3, 0.4], "exudyn": [0.1]}
    told = plain(below_words("tip_acceleration", ratios))
    counted = "thesis reaches less than half of the label in 1 run. reference reaches less than half of the label in 2 runs."
    assert told.startswith(f"{counted} The plotted curves")
    assert below_words("tip_acceleration", {"thesis": [0.6]}).startswith("The plotted curves")
    assert below_words("strain", ratios) == below_words("tip_acceleration", {"exudyn": [0.1]}) == ""


@pytest.mark.parametrize(("cubic", "converged", "same"), [(1.0, 2.0, True), (2.0, 1.0, False)])
def test_the_figure_of_measured_curves_alone_may_say_the_same(cubic: float, converged: float, same: bool) -> None:
    axis = AxisComparison("3.8", 24, "strain", 1e-4, {"thesis": cubic, "reference": converged})
    ratios = f"{cubic:.2f} (thesis), {converged:.2f} (reference)"
    figure = "Figure 3.8 shows the measured strains of run 24 alone."
    assert alone_words(axis) == f"{figure} The simulated peak is {ratios} times its largest label."
    told = " But figure 3.8, which shows measured curves alone, says the same."
    assert drawn_alone_words(axis) == (told if same else "")
    lacking = AxisComparison("3.8", 24, "strain", 1e-4, {"thesis": cubic})
    assert alone_words(lacking) == drawn_alone_words(lacking) == ""


def test_the_excess_of_the_converged_model_is_counted() -> None:
    assert plain(worse_words([0.5, 1.5, 2.5])) == "reference exceeds it in 2 of 3 runs, and is more than twice as large in 1."
    assert plain(worse_words([1.5])) == "reference exceeds it in 1 of 1 run, and is more than twice as large in 0."


def test_the_largest_variation_of_a_strain_is_told() -> None:
    assert varying_words([BAND]).endswith("a run’s peak strain varies up to 2.9-fold")  # 8.4 / 2.9
    assert varying_words([]) == ""
