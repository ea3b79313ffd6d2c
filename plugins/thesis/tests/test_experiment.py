"""What the thesis prints of the experiment; and that the place for recordings of it says what is read."""

import math
import re
from pathlib import Path

import pytest

from quickreturn.cases.files.errors import CaseError
from quickreturn.plugins.thesis.experiment import (
    FOLDER_VARIABLE,
    axis_labels,
    channel_is_usable,
    experiment_tables,
    measured_crank_speed,
    statements,
)


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


def test_statements_are_ranges_that_a_share_of_the_runs_shows() -> None:
    by_id = {statement.id: statement for statement in statements()}
    assert len(by_id) == len(statements())
    post, pre = by_id["post-frequency"], by_id["pre-frequency"]
    assert (post.runs, post.share, post.low, post.high) == (tuple(range(1, 25)), 1.0, 1.0, math.inf)  # "always"
    assert (pre.low, pre.high, pre.share) == (0.97, 1.05, 0.9)  # "close to it or slightly above", "virtually all"
    assert by_id["pre-amplitude-long-crank"].runs == tuple(range(1, 9))
    assert by_id["second-mode"].low == by_id["second-mode"].high == 132.0
    assert by_id["joint-cause"].kind == "cause"


def test_there_is_no_recording_of_the_experiment_and_none_is_invented() -> None:
    assert experiment_tables() == []


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
