"""Recordings of the experiment, and the axes of the figures: what of them counts, and what changes no conclusion."""

import dataclasses

import pytest

from quickreturn.cases.comparison.engines import CaseResult, compare
from quickreturn.cases.motion.number import Consensus
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.plugins.thesis.axes import AxisComparison, axis_comparisons, fits_worse, measured_alone, misfit
from quickreturn.plugins.thesis.page_data import statement_values
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import MeasuredHalf, measured_halves
from quickreturn.reports.page.first_screen import answer_of
from tests.changed_run import changed_run
from tests.reports.pages import content_of
from tests.reports.plotted_results import with_table
from tests.reports.reported_results import reported_result


@pytest.fixture(scope="module")
def run_24() -> CaseResult:
    return reported_result("thesis-24")


def measured(run_24: CaseResult, origin: str, of_experiment: bool = True) -> list[MeasuredHalf]:
    """Before the return, with numbers in place of what a made-up signal leaves unresolved."""
    found = measured_halves([with_table(run_24, "curve.csv", ["strain_2"], {"origin": origin}, of_experiment)])
    (half,) = (item for item in found if item.measure.half == "pre")
    measure = dataclasses.replace(half.measure, first_mode_frequency=16.0, first_mode_frequency_uncertainty=0.1, first_mode_amplitude=2e-4)
    of_model = {"thesis": dataclasses.replace(measure, first_mode_frequency=18.0, first_mode_amplitude=1e-4)}
    return [dataclasses.replace(half, measure=measure, engines=of_model)]


def test_recordings_of_the_experiment_alone_have_weight_in_a_verdict(run_24: CaseResult) -> None:
    values = statement_values(measured(run_24, "digitised"), "thesis")
    assert values["pre_frequency"] == {24: pytest.approx(18.0 / 16.0)}
    assert values["pre_amplitude"] == {24: pytest.approx(0.5)}
    assert statement_values(measured(run_24, "synthetic"), "thesis") == {}
    assert statement_values(measured(run_24, "measured", of_experiment=False), "thesis") == {}


def test_what_is_not_ours_changes_no_statement(run_24: CaseResult) -> None:
    """Neither an engine of another package nor a recorded table, however far off, though both are compared."""
    wrong = changed_run(run_24.runs["mujoco"], engine="foreign", consensus=(Consensus("pre", 99.0, 0.1, 0.1),))
    others = with_table(compare(run_24.case, {**run_24.runs, "foreign": wrong}), "tool.csv", ["strain_2", "tip_acceleration"], factor=3.0)
    before, after = content_of(results=[run_24]), content_of(results=[others])
    values = [statement_values(each.comparisons, "thesis") for each in (before, after)]
    assert values == [{}, {}]
    axes = axis_comparisons(after.results)
    assert axes
    assert not any("tool.csv" in axis.ratios for axis in axes)
    told_before, told_after = ({each.id: each.finding for each in chapters_of(content)} for content in (before, after))
    assert told_after["experiment"] == told_before["experiment"]
    assert told_after["recorded"].startswith("tool.csv: ")
    assert answer_of(after).cubic == answer_of(before).cubic
    assert "foreign" in answer_of(after).engines


def test_a_label_of_half_the_peak_is_missed_by_as_much_as_one_of_twice_the_peak() -> None:
    assert misfit([0.5]) == pytest.approx(misfit([2.0])) == pytest.approx(2.0)
    assert misfit([1.0, 1.0, 4.0]) == 1.0


@pytest.mark.parametrize(("cubic", "converged", "worse"), [(1.0, 2.0, True), (2.0, 1.0, False), (0.4, 2.0, False), (0.6, 2.0, True)])
def test_what_is_further_from_the_labels_fits_worse(cubic: float, converged: float, worse: bool) -> None:
    axes = [AxisComparison("A.1", 1, "strain", 1e-4, {"thesis": cubic, "reference": converged})]
    assert fits_worse(axes) is worse
    assert not fits_worse([dataclasses.replace(axes[0], ratios={"reference": converged})])


def test_figures_with_measured_curves_alone_are_told_apart(run_24: CaseResult) -> None:
    assert [(axis.figure, axis.channel) for axis in measured_alone([run_24])] == [
        ("3.7", "tip_acceleration"),
        ("3.8", "strain"),
        ("3.9", "strain"),
    ]
    (strain,) = (axis for axis in measured_alone([run_24]) if axis.figure == "3.8")
    peak = max(run_24.runs["thesis"].peak(name) for name in CHANNELS[1:])
    assert strain.ratios["thesis"] == pytest.approx(peak / 1.5e-4)  # the axis reads 0.015 percent
