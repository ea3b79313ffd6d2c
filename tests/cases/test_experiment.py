"""All curves in here are synthetic; no measured one exists."""

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cases.errors import CaseError
from cases.experiment import axis_labels, channel_is_usable, load_curves, measured_crank_speed, statements

Floats = NDArray[np.float64]

HEADER = {
    "run": "24",
    "channel": "tip_acceleration",
    "unit": "in/s^2",
    "sign": "+1",
    "axis": "phase",
    "origin": "synthetic",
    "source": "made up for a test: 1000 sin(2 pi 8 phase)",
}
PHASE = np.linspace(0.0, 1.0, 401)


def write(path: Path, places: Floats = PHASE, values: Floats | None = None, **header: str | None) -> Path:
    """A synthetic curve file; a header value of None leaves its line out."""
    declared = {key: value for key, value in (HEADER | header).items() if value is not None}
    if values is None:
        values = 1000.0 * np.sin(16.0 * np.pi * PHASE)
    rows = [f"{place:.9f}, {value:.9f}" for place, value in zip(places, values, strict=True)]
    path.write_text("\n".join([*(f"# {key} = {value}" for key, value in declared.items()), *rows]) + "\n")
    return path


def test_there_is_no_measured_curve_and_none_is_invented() -> None:
    assert load_curves() == []


def test_a_curve_is_read_as_it_declares_itself_and_not_touched_otherwise(tmp_path: Path) -> None:
    write(tmp_path / "a24.csv")
    (curve,) = load_curves(tmp_path)
    assert (curve.run, curve.case_name, curve.channel, curve.origin) == (24, "thesis-24", "tip_acceleration", "synthetic")
    assert curve.source == HEADER["source"]
    # 1e-8: the file gives 9 decimals of values up to 1000
    np.testing.assert_allclose(curve.values, 25.4 * np.sin(8.0 * (curve.crank_angle - np.pi)), atol=25.4e-8)
    np.testing.assert_allclose(curve.crank_angle[[0, 200, 400]], [np.pi, 2.0 * np.pi, 3.0 * np.pi], rtol=1e-15)
    np.testing.assert_allclose(curve.time[-1], 2.0 * math.pi / 16.617773, rtol=1e-15)


@pytest.mark.parametrize(
    ("channel", "unit", "sign", "factor"),
    [
        ("tip_acceleration", "m/s^2", "+1", 1.0),
        ("tip_acceleration", "in/s^2", "-1", -0.0254),
        ("tip_acceleration", "g", "+1", 9.80665),
        ("strain_1", "strain", "+1", 1.0),
        ("strain_2", "percent", "-1", -0.01),
        ("strain_3", "microstrain", "+1", 1e-6),
    ],
)
def test_units_and_sign_are_applied(tmp_path: Path, channel: str, unit: str, sign: str, factor: float) -> None:
    write(tmp_path / "curve.csv", values=np.full(401, 2.0), channel=channel, unit=unit, sign=sign)
    (curve,) = load_curves(tmp_path)
    assert set(curve.values) == {2.0 * factor}


def test_time_phase_and_crank_angle_say_the_same(tmp_path: Path) -> None:
    period = 2.0 * math.pi / 16.617773  # mean speed of run 24, table 3.1
    for axis, places, channel in (
        ("phase", PHASE, "strain_1"),
        ("time", PHASE * period, "strain_2"),
        ("crank_angle", 180.0 + 360.0 * PHASE, "strain_3"),
    ):
        write(tmp_path / f"{axis}.csv", places, axis=axis, channel=channel, unit="percent")
    by_phase, by_time, by_angle = load_curves(tmp_path)
    # the files give 9 decimals: 1e-9 of a cycle is 6e-9 rad, 1e-9 s at 16.6 rad/s is 1.7e-8 rad
    np.testing.assert_allclose(by_time.crank_angle, by_phase.crank_angle, atol=2e-8)
    np.testing.assert_allclose(by_angle.crank_angle, by_phase.crank_angle, atol=1e-8)


def test_another_folder_can_be_named_by_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("QUICKRETURN_CURVES", str(tmp_path))
    write(tmp_path / "b.csv", run="9", channel="strain_1", unit="percent")
    write(tmp_path / "a.csv", run="10", channel="strain_1", unit="percent")
    assert [curve.run for curve in load_curves()] == [9, 10]
    monkeypatch.setenv("QUICKRETURN_CURVES", str(tmp_path / "none"))
    with pytest.raises(CaseError, match="is no folder"):
        load_curves()


def test_a_channel_that_the_thesis_calls_unusable_is_marked(tmp_path: Path) -> None:
    write(tmp_path / "a.csv", run="8")
    write(tmp_path / "b.csv", run="8", channel="strain_1", unit="percent")
    assert [curve.usable for curve in load_curves(tmp_path)] == [True, False]


BAD_HEADERS: list[tuple[dict[str, str | None], str]] = [
    ({"origin": None}, 'origin: this declaration is missing; write "# origin = ..." with one of: measured, digitised, synthetic'),
    ({"source": None}, 'source: this declaration is missing; write "# source = ..." with one of: free text'),
    ({"source": ""}, 'source: "" is not accepted; give where the curve is from'),
    ({"unit": None}, "unit: this declaration is missing"),
    ({"origin": "guessed"}, 'origin: "guessed" is not accepted; give one of measured, digitised, synthetic'),
    ({"run": "25"}, 'run: "25" is not accepted; give one of 1, 2, 3'),
    ({"sign": "1"}, 'sign: "1" is not accepted; give one of +1, -1'),
    ({"axis": "seconds"}, 'axis: "seconds" is not accepted; give one of phase, time, crank_angle'),
    ({"channel": "strain_4"}, 'channel: "strain_4" is not accepted; give one of tip_acceleration, strain_1, strain_2, strain_3'),
    ({"unit": "percent"}, 'unit: "percent" does not measure tip_acceleration; accepted are m/s^2, in/s^2, g'),
    ({"unti": "g"}, 'line 8: "unti" is no known key; the nearest one is unit'),
]


@pytest.mark.parametrize(("header", "told"), BAD_HEADERS, ids=str)
def test_a_curve_that_does_not_say_what_it_is_is_refused(tmp_path: Path, header: dict[str, str | None], told: str) -> None:
    path = write(tmp_path / "curve.csv", PHASE, None, **header)
    with pytest.raises(CaseError) as refused:
        load_curves(tmp_path)
    assert str(refused.value).startswith(f"{path}: {told}")


@pytest.mark.parametrize(
    ("places", "told"),
    [
        (np.linspace(0.0, 2.0, 401), "covers 0 to 2 cycles after 180 deg; exactly one cycle is accepted"),
        (np.linspace(0.1, 1.1, 401), "covers 0.1 to 1.1 cycles after 180 deg; exactly one cycle is accepted"),
        (np.linspace(0.0, 0.9, 401), "covers 0 to 0.9 cycles after 180 deg; exactly one cycle is accepted"),
        (np.where(PHASE > 0.5, PHASE, 0.96 * PHASE), "point 202: 0.0225 of a cycle lie before it; at most 0.01 are accepted"),
        (PHASE[::-1], "point 2: the first column does not increase; sort the rows and drop doubles"),
    ],
    ids=str,
)
def test_a_curve_is_exactly_one_cycle_without_gaps(tmp_path: Path, places: Floats, told: str) -> None:
    path = write(tmp_path / "curve.csv", places)
    with pytest.raises(CaseError) as refused:
        load_curves(tmp_path)
    assert str(refused.value).startswith(f"{path}: {told}")


@pytest.mark.parametrize(
    ("row", "told"),
    [
        ("0,5, 1,2", '"0,5, 1,2" is not two numbers (the decimal sign is a point); write a row such as "0.002, -655"'),
        ("phase, value", '"phase, value" is not two numbers; write a row such as "0.002, -655"'),
        ("0.5; 3", '"0.5; 3" is not two numbers; write a row such as "0.002, -655"'),
        ("nan, 3", '"nan, 3" is not two numbers; write a row such as "0.002, -655"'),
        ("# remark", '"# remark" is no header line; write "# key = value"'),
        ("# run = 23", '"run" is declared twice; declare each key once'),
    ],
)
def test_a_row_that_cannot_be_read_is_named_by_its_line(tmp_path: Path, row: str, told: str) -> None:
    path = write(tmp_path / "curve.csv")
    path.write_text(path.read_text() + row + "\n")
    with pytest.raises(CaseError) as refused:
        load_curves(tmp_path)
    assert str(refused.value) == f"{path}: line 409: {told}"


def test_two_files_for_one_channel_are_refused(tmp_path: Path) -> None:
    write(tmp_path / "a.csv")
    path = write(tmp_path / "b.csv")
    with pytest.raises(CaseError) as refused:
        load_curves(tmp_path)
    assert str(refused.value) == f"{path}: tip_acceleration of run 24 is already given by a.csv; keep one of them"


def test_the_example_of_the_readme_has_the_form_that_is_read(tmp_path: Path) -> None:
    readme = (Path(__file__).parents[2] / "cases" / "experiment" / "curves" / "README.md").read_text()
    header = readme.split("```\n")[1].split("0.000,")[0]
    (tmp_path / "curve.csv").write_text(header + "\n".join(f"{phase:.3f}, {-1000 * phase:.0f}" for phase in PHASE))
    (curve,) = load_curves(tmp_path)
    assert curve.origin == "digitised"
    assert curve.values[-1] == pytest.approx(25.4, rel=1e-15)  # -1000 in/s^2 with sign -1


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


def test_statements_can_be_confirmed_and_contradicted() -> None:
    by_id = {statement.id: statement for statement in statements()}
    assert len(by_id) == len(statements())
    post, pre = by_id["post-frequency"], by_id["pre-frequency"]
    assert (post.runs, post.share, post.low) == (tuple(range(1, 25)), 1.0, 1.0)
    assert post.holds(dict.fromkeys(range(1, 25), 1.1)) is True
    assert post.holds(dict.fromkeys(range(1, 24), 1.1) | {24: 0.99}) is False  # "always"
    assert post.holds({24: math.nan}) is None
    assert pre.holds(dict.fromkeys(range(1, 23), 1.02) | {23: 1.2, 24: 1.2}) is True  # 22 of 24: "virtually all"
    assert pre.holds(dict.fromkeys(range(1, 25), 1.13)) is False
    assert pre.share_of({1: 1.0, 2: 1.2}) == 0.5
    assert by_id["pre-amplitude-long-crank"].runs == tuple(range(1, 9))
    assert by_id["second-mode"].holds({24: 124.0}) is False
    assert by_id["first-mode-range"].holds({24: 20.0}) is True
    assert by_id["joint-cause"].holds({24: 1.0}) is None
