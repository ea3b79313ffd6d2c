"""What the thesis prints of the experiment, and recordings of it: what of them counts, and what changes no conclusion."""

import dataclasses
import re
from pathlib import Path

import pytest

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.plugins.thesis.axes import AxisComparison, fits_worse, measured_alone, misfit
from quickreturn.plugins.thesis.experiment import FOLDER_VARIABLE, axis_labels, channel_is_usable, experiment_tables, measured_crank_speed
from quickreturn.plugins.thesis.page_data import statement_values
from quickreturn.reports.page.content import MeasuredHalf, measured_halves
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


def test_the_example_of_the_readme_has_the_form_that_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    readme = (Path(__file__).parents[1] / "experiment" / "curves" / "README.md").read_text()
    example = re.search(r"```\n(# case.*?)\.\.\.\n(.*?)```", readme, re.DOTALL)
    assert example is not None
    (tmp_path / "curve.csv").write_text(example[1] + example[2])
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    (table,) = experiment_tables()
    assert (table.declared["case"], table.declared["origin"]) == ("thesis-24", "digitised")
    assert table.columns["tip_acceleration"][-1] == pytest.approx(-820.0 * 0.0254, rel=1e-15)


def test_axis_labels_are_in_si_and_strain_is_percent() -> None:
    run_17 = {labels.channel: labels for labels in axis_labels(17)}
    assert run_17["strain"].largest == pytest.approx(4e-5, rel=1e-15)  # the axis reads -0.004
    assert run_17["strain"].range == pytest.approx((-4e-5, 2e-5), rel=1e-15)
    assert run_17["tip_acceleration"].largest == pytest.approx(101.6, rel=1e-15)  # 4000 in/s^2
    in_appendix = [labels for labels in axis_labels() if labels.figure.startswith("A.")]
    assert sorted({labels.run for labels in in_appendix}) == list(range(1, 25))
    assert sum(labels.channel == "strain" for labels in in_appendix) == 23  # all but run 4
    assert sum(labels.channel == "tip_acceleration" for labels in in_appendix) == 23  # all but run 5
    assert [labels.run for labels in in_appendix if not labels.has_experiment] == [1, 1]


def test_crank_speeds_and_valid_channels_are_those_of_the_thesis() -> None:
    assert measured_crank_speed(1) is None
    assert measured_crank_speed(24) == 16.617773
    assert [run for run in range(1, 25) if channel_is_usable(run, "tip_acceleration")] == list(range(9, 25))
    assert [run for run in range(1, 25) if channel_is_usable(run, "strain_2")] == list(range(2, 25))


def test_recordings_of_the_experiment_say_what_they_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    (tmp_path / "b.csv").write_text("# case = thesis-24\n# origin = digitised\ntime,tip_x\n0,1")
    (table,) = experiment_tables()
    assert table.of_experiment
    assert table.declared == {"case": "thesis-24", "origin": "digitised"}
    (tmp_path / "a.csv").write_text("# case = thesis-24\ntime,tip_x\n0,1")
    with pytest.raises(CaseError, match="origin: this declaration is missing"):
        experiment_tables()
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "none"))
    with pytest.raises(CaseError, match="is no folder"):
        experiment_tables()
