"""`quickreturn resonance` and `qr.resonance`: tables, pictures, and answers to mistakes."""

import io
import json
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import quickreturn as qr
from quickreturn.cases.jobs.key import key_of
from quickreturn.cases.jobs.pieces import Pieces
from quickreturn.cases.jobs.records import encoded
from quickreturn.cases.resonance_curve.curve import MULTIPLIER_TOLERANCE
from quickreturn.cases.resonance_curve.range import range_of
from quickreturn.cases.resonance_curve.search import checked_scenes, job, job_around
from quickreturn.reference_model.cycles.cycle_family import CycleFamily
from quickreturn.reference_model.cycles.fixed_points import Array, Image
from quickreturn.reports.drawing.style import picture
from quickreturn.reports.results.around import Around
from tests.quickreturn.conftest import Call

RPM = math.pi / 30.0
#: About the fold of run 24's machine in one mode, which `accuracy=0.05` makes of it.
ASKED = {"range": "237.5 rpm .. 241 rpm", "accuracy": 0.05, "quiet": True}


@pytest.fixture(scope="module")
def found() -> qr.Resonance:
    return qr.resonance("thesis-24", **ASKED)


def test_a_table_in_si_with_claims(found: qr.Resonance) -> None:
    frame = found.frame
    assert frame.attrs["units"]["crank.prescribed_speed"] == "rad/s"
    assert frame["crank.prescribed_speed"].iloc[0] == pytest.approx(237.5 * RPM)
    assert frame["crank.prescribed_speed"].between(237.5 * RPM, 241.0 * RPM).all()
    assert (np.diff(frame["arclength"]) > 0.0).all()
    np.testing.assert_allclose(np.hypot(frame["multiplier.real"], frame["multiplier.imag"]), frame["multiplier"], rtol=1e-12)
    assert ((frame["multiplier"] < 1.0 - MULTIPLIER_TOLERANCE) == (frame["stability"] == "stable")).all()
    assert ((frame["multiplier"] > 1.0 + MULTIPLIER_TOLERANCE) == frame["stability"].str.startswith("unstable")).all()
    assert (frame["stability"][frame["special"] == "fold"] == "neutral").all()
    (fold,) = found.special.itertuples()
    assert fold.kind == "fold"
    assert (frame["special"] == "fold").sum() == 1
    assert fold.value == frame["crank.prescribed_speed"].max()
    assert "prescribed in place of its drive" in repr(found)


@pytest.mark.verify
def test_the_claims_hold_against_a_model_with_more_modes(found: qr.Resonance) -> None:
    """One mode is off by percents. The fold of four modes lies within what the curve of one claims of its own."""
    finer = qr.resonance("thesis-24", range="237.5 rpm .. 240 rpm", accuracy=1e-3, claims=False, quiet=True)
    (coarse,), (fine,) = found.special.itertuples(), finer.special.itertuples()
    assert abs(coarse.value - fine.value) <= coarse.error
    assert abs(coarse.value - fine.value) > 0.2 * coarse.error  # no empty claim


class _Interrupted(Exception):
    pass


def test_an_interrupted_curve_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped several times, it evaluates each time at most one piece of cycles anew; the curve has the same bits."""
    monkeypatch.setattr("quickreturn.cases.resonance_curve.search.PIECE", 3)
    asked = job(qr.case("thesis-24"), range_of("crank.prescribed_speed", "150 rpm .. 165 rpm", "range"), accuracy=0.05, claims=False)
    plain, cycles, left = CycleFamily.image, [0], [math.inf]

    def image(family: CycleFamily, point: Array, value: float) -> Image:
        cycles[0] += 1
        left[0] -= 1
        if left[0] < 0:
            raise _Interrupted
        return plain(family, point, value)

    monkeypatch.setattr(CycleFamily, "image", image)
    whole = asked.function(*asked.arguments)
    alone, cycles[0], stops = cycles[0], 0, 0
    while True:
        left[0] = max(60, alone // 4)
        try:
            resumed = asked.function(*asked.arguments, Pieces(str(tmp_path), key_of(asked)))
            break
        except _Interrupted:
            stops += 1
    assert stops >= 2
    assert cycles[0] <= alone + stops * 60
    assert encoded(resumed).document == encoded(whole).document
    for name, values in encoded(whole).arrays.items():
        assert np.array_equal(values, encoded(resumed).arrays[name], equal_nan=True)


def test_files_of_every_kind(found: qr.Resonance, tmp_path: Path) -> None:
    table = pd.read_csv(io.BytesIO(found.written(".csv")))
    assert list(table.columns[:2]) == ["crank.prescribed_speed [rad/s]", "crank.prescribed_speed.error [rad/s]"]
    np.testing.assert_allclose(table["peak.tip_acceleration [m/s^2]"], found.frame["peak.tip_acceleration"], rtol=1e-12)
    assert len(pd.read_parquet(io.BytesIO(found.written(".parquet")))) == len(table)
    (tmp_path / "curve.nc").write_bytes(found.written(".nc"))
    dataset = xr.open_dataset(tmp_path / "curve.nc", engine="h5netcdf")
    assert dataset["peak.tip_acceleration"].attrs["units"] == "m/s^2"
    assert set(dataset["stability"].values) == {"stable", "neutral", "unstable: fold"}


def test_a_picture_tells_stable_from_unstable(found: qr.Resonance) -> None:
    (axes,) = found.plot(mark=240.0 * RPM).axes
    styles = {line.get_linestyle() for line in axes.lines if len(line.get_xdata()) > 2}
    assert styles == {"-", "--"}
    marks = [line for line in axes.lines if line.get_label() == "fold"]
    assert marks[0].get_xdata() == pytest.approx(found.special["value"] / RPM)
    assert picture(found.plot(), ".png").startswith(b"\x89PNG")


def test_the_command_writes_what_python_gives(call: Call, tmp_path: Path) -> None:
    table, picture = tmp_path / "curve.csv", tmp_path / "curve.svg"
    asked = ("resonance", "thesis-24", "--speed", "150 rpm .. 151 rpm", "--accuracy", "0.05", "--no-claims", "--json")
    answer = call(*asked, "--output", str(table), "--plot", str(picture))
    assert answer.code == 0
    document = json.loads(answer.output)
    rows = pd.read_csv(table)
    assert document["points"]["crank.prescribed_speed"] == pytest.approx(rows["crank.prescribed_speed [rad/s]"].tolist())
    assert document["special"] == []
    assert picture.read_text().startswith("<?xml")


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        ((), ("--speed", "60 rpm .. 300 rpm")),
        (("--speed", "60 rpm"), ("--speed", "60 rpm", "is no range")),
        (("--speed", "300 rpm .. 60 rpm"), ("300 rpm .. 60 rpm", "smaller and a larger")),
        (("--speed", "-60 rpm .. 60 rpm"), ("one sign",)),
        (("--speed", "1 Hz .. 2 Hz"), ("1 Hz", "an angular speed is needed")),
        (("--vary", "tip.mas=0 g .. 100 g"), ("tip.mas", "tip.mass")),
        (("--vary", "crank.initial_angle=0 deg .. 10 deg"), ("crank.initial_angle", "changes no periodic motion")),
        (("--vary", "crank.length=4 in .. 9 in"), ("crank.length", "slider leaves the follower")),
        (("--vary", "slider.joint_stiffness=1e4 N/m .. 2e4 N/m", "--speed", "100 rpm"), ("rigid and frictionless",)),
        (("--vary", "tip.mass=0 g .. 100 g", "--speed", "0 rpm"), ("--speed", "0 rpm", "does not turn")),
        (("--speed", "60 rpm .. 90 rpm", "--measure", "peak.tip"), ("--measure", "peak.tip")),
        (("--vary", "tip.mass=-20 g .. -10 g", "--speed", "60 rpm"), ("--vary", "tip.mass", '"-20 g" is negative')),
        (("--vary", "crank.length=0 in .. 4 in"), ("--vary", "crank.length", '"0 in" is not positive')),
        (("--speed", "60 rpm .. 90 rpm", "--output", "curve.xlsx"), ("curve.xlsx", ".csv")),
    ],
    ids=str,
)
def test_answers_to_mistakes(call: Call, typed: tuple[str, ...], words: tuple[str, ...]) -> None:
    answer = call("resonance", "thesis-24", *typed)
    assert answer.code == 2
    assert answer.output == ""
    for word in words:
        assert word in answer.errors.replace('\\"', '"')


def test_other_values_replace_what_excludes_them() -> None:
    held = checked_scenes(qr.case("thesis-24"), range_of("tip.mass", "0 g .. 25 g", "range"), 10.0, ())(0.02)
    assert not held.crank_is_free
    assert held.crank.drive.initial_speed == 10.0
    assert held.tip_body.mass == 0.02
    assert range_of("tip.mass", "0 g .. 25 g", "range").high == pytest.approx(0.025)


def test_the_curve_around_a_crank_that_turns_clockwise_is_over_negative_speeds() -> None:
    case = qr.case("thesis-24", {"crank.prescribed_speed": "-100 rpm"})
    varied = job_around(case).arguments[1]
    assert (varied.low / RPM, varied.high / RPM) == pytest.approx((-115.0, -85.0))
    assert Around(case, None).pace / RPM == pytest.approx(-100.0)


def test_what_is_told_of_a_machine_between_fold_and_limit(found: qr.Resonance) -> None:
    fold = found.special["value"].item()
    pace = 0.998 * fold
    lines = Around(qr.case("thesis-24", {"crank.prescribed_speed": f"{pace / RPM!r} rpm"}), found.curve).lines
    assert lines[0].startswith(f"the machine runs at {pace / RPM:.5g} rpm, its mean speed")
    assert {line.rpartition(", ")[2] for line in lines[1:3]} == {"stable", "unstable: fold"}
    assert lines[3].startswith("no peak between 237.5 and 241 rpm")
    assert lines[4] == f"nearest change of stability: fold, at {fold / RPM:.5g} rpm, 0.2 % faster"


def test_a_rigid_machine_has_no_curve(call: Call) -> None:
    answer = call("show", "rigid", "--resonance")
    assert answer.code == 2
    assert "bending_stiffness" in answer.errors
