"""`quickreturn resonance` and `qr.resonance`: tables, pictures, answers to mistakes, and curves that were interrupted or lost."""

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import quickreturn as qr
from quickreturn.cases.files.shown import Unit
from quickreturn.cases.running.key import key_of
from quickreturn.cases.running.store import Pieces, encoded
from quickreturn.plugins.studies.around import Around
from quickreturn.plugins.studies.resonance_curve.curve import MULTIPLIER_TOLERANCE, Range, SpecialPoint, range_of
from quickreturn.plugins.studies.resonance_curve.search import _followed, job
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.cycles.cycle_family import CycleFamily
from quickreturn.reference_model.cycles.fixed_points import Image
from quickreturn.reference_model.cycles.poincare import CycleBroken
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reports.drawing.style import picture
from tests.quickreturn.conftest import Call
from tests.quickreturn.input.answers import refused

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
def test_the_curve_of_the_largest_stress_is_that_of_settled_machines() -> None:
    """Against `run`, which samples the turn and its places otherwise; above the strain of the gauge times the modulus."""
    names = ["peak.stress", "peak.strain_2"]
    frame = qr.resonance("thesis-24", range="150 rpm .. 151 rpm", measures=names, accuracy=0.05, claims=False, quiet=True).frame
    at = int(frame["crank.prescribed_speed"].argmin())
    case = qr.case("thesis-24", {"crank.prescribed_speed": "150 rpm"})
    loads = qr.run(case, "reference", accuracy=0.05, quiet=True).loads.set_index("quantity")
    assert frame["peak.stress"][at] == pytest.approx(loads.loc["stress", "value"], rel=2e-3)
    assert (frame["peak.stress"] >= case.mechanism.follower.elastic_modulus * frame["peak.strain_2"]).all()


@pytest.mark.verify
def test_the_claims_hold_against_a_model_with_more_modes(found: qr.Resonance) -> None:
    """One mode is off by percents. The fold of four modes lies within what the curve of one claims of its own."""
    finer = qr.resonance("thesis-24", range="237.5 rpm .. 240 rpm", accuracy=1e-3, claims=False, quiet=True)
    (coarse,), (fine,) = found.special.itertuples(), finer.special.itertuples()
    assert abs(coarse.value - fine.value) <= coarse.error
    assert abs(coarse.value - fine.value) > 0.2 * coarse.error  # no empty claim


def test_a_picture_tells_stable_from_unstable(found: qr.Resonance) -> None:
    (axes,) = found.plot().axes
    styles = {line.get_linestyle() for line in axes.lines if len(line.get_xdata()) > 2}
    assert styles == {"-", "--"}
    marks = [line for line in axes.lines if line.get_label() == "fold"]
    assert marks[0].get_xdata() == pytest.approx(found.special["value"] / RPM)
    assert picture(found.plot(), ".png").startswith(b"\x89PNG")


def test_the_command_writes_what_python_gives(call: Call, tmp_path: Path) -> None:
    table, drawn = tmp_path / "curve.csv", tmp_path / "curve.svg"
    asked = ("resonance", "thesis-24", "--speed", "150 rpm .. 150.2 rpm", "--accuracy", "0.05", "--no-claims", "--json")
    answer = call(*asked, "--output", str(table))
    assert answer.code == 0
    document = json.loads(answer.output)
    rows = pd.read_csv(table)
    assert document["points"]["crank.prescribed_speed"] == pytest.approx(rows["crank.prescribed_speed [rad/s]"].tolist())
    assert document["special"] == []
    assert call(*asked, "--output", str(drawn)).code == 0
    assert drawn.read_text().startswith("<?xml")


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        ((), ("--speed", "60 rpm .. 300 rpm")),
        (("--speed", "60 rpm"), ("--speed", "60 rpm", "is no range")),
        (("--speed", "-60 rpm .. 60 rpm"), ("one sign",)),
        (("--vary", "tip.mas=0 g .. 100 g"), ("tip.mas", "tip.mass")),
        (("--vary", "crank.initial_angle=0 deg .. 10 deg"), ("crank.initial_angle", "changes no periodic motion")),
        (("--vary", "slider.joint_stiffness=1e4 N/m .. 2e4 N/m", "--speed", "100 rpm"), ("rigid and frictionless",)),
        (("--vary", "tip.mass=0 g .. 100 g", "--speed", "0 rpm"), ("--speed", "0 rpm", "does not turn")),
        (("--speed", "60 rpm .. 90 rpm", "--measure", "peak.tip"), ("--measure", "peak.tip")),
        (("--speed", "60 rpm .. 90 rpm", "--measure", "factor.yielding"), ("has no resonance curve", "peak.tip_acceleration", "`sweep`")),
        (("--speed", "60 rpm .. 90 rpm", "--output", "curve.xlsx"), ("curve.xlsx", ".csv")),
    ],
    ids=str,
)
def test_answers_to_mistakes(call: Call, typed: tuple[str, ...], words: tuple[str, ...]) -> None:
    refused(call("resonance", "thesis-24", *typed), *words)


def test_what_is_told_of_a_machine_between_fold_and_limit(found: qr.Resonance) -> None:
    fold = found.special["value"].item()
    pace = 0.998 * fold
    own = Around(qr.case("thesis-24", {"crank.prescribed_speed": f"{pace / RPM!r} rpm"}), found.curve, Unit("rpm", RPM))
    _, motions, nearest = own.lines
    assert motions.startswith("There it has two periodic motions, one of them stable, ")
    assert f"fold at {fold / RPM:.5g} rpm, {(fold - pace) / RPM:.3g} rpm or 0.2 % faster" in nearest
    document = own.document
    assert [motion["stability"] for motion in document["motions"]].count("stable") == 1
    assert document["nearest_change"]["distance"] == pytest.approx(fold - pace)


def test_a_machine_beyond_its_curve_has_no_motion_on_it(found: qr.Resonance) -> None:
    """Run 24 turns at 158.68 rpm: its torque over its damping is 158.69 rpm, and the pivot takes a part."""
    assert found.around.lines[0].startswith("Your machine runs at 158.68 rpm, the mean speed of its rigid mechanism")
    assert found.around.lines[1] == "The curve does not reach there, and says nothing of it."
    assert found.document()["own"]["motions"] == []


def test_what_was_not_followed_is_not_said_to_be_without_peaks(found: qr.Resonance) -> None:
    """Of a curve that is lost at its first point the part that was followed is told, and the machine beyond it gets no answer."""
    reason = SpecialPoint("lost", float(found.curve.values[0]), 1e-3, None, 0, "the corrections ended")
    curve = dataclasses.replace(found.curve, special=(*found.curve.special, reason))
    high = curve.reach[1]
    assert high == pytest.approx(found.special["value"].item())
    nearest = Around(qr.case("thesis-24"), curve, unit=Unit("rpm", RPM)).lines[2]
    assert nearest.startswith(f"No peak between 237.5 rpm and {high / RPM:.5g} rpm; fold at ")


#: Changes of run 24, a range of speeds, and how many motions it then has at its own speed, and how many stable ones.
OWN = {
    "stable": ("226 rpm", "224 rpm .. 229 rpm", 1, 1),
    "between the folds": ("236 rpm", "231 rpm .. 240 rpm", 3, 2),
    "period doubling": ("370 rpm", "363 rpm .. 375 rpm", 1, 0),
}


@pytest.mark.verify
@pytest.mark.parametrize("where", OWN)
def test_the_machines_own_speed_has_the_motions_that_a_search_of_that_speed_alone_finds(where: str, call: Call) -> None:
    """From sweeps of a few speeds up and down, which search each motion by itself; the fold of the unstable branch is left out there."""
    speed, range_, count, stable = OWN[where]
    drive = ("--set", f"crank.prescribed_speed={speed}")
    answer = call("resonance", "thesis-24", *drive, "--speed", range_, "--no-claims", "--json")
    own = json.loads(answer.output)["own"]
    assert own["value"] / RPM == pytest.approx(float(speed.split()[0]))
    kinds = [motion["stability"] for motion in own["motions"]]
    assert (len(kinds), kinds.count("stable")) == (count, stable)
    assert own["sentences"][0] == f"Your machine runs at {speed}."
    low, high = (float(end.split()[0]) for end in range_.split(" .. "))
    around, settled = [f"{low + 1.0} rpm", speed, f"{high - 1.0} rpm"], set[str]()
    for way in (around, around[::-1]):
        swept = qr.sweep("thesis-24", {"crank.prescribed_speed": way}, claims=False, quiet=True).isel({"crank.prescribed_speed": 1})
        settled |= {f"{float(swept['peak.tip_acceleration']):.3g}"} if swept["status"] == "settled" else set()
    assert settled <= {f"{motion['height']:.3g}" for motion in own["motions"] if motion["stability"] == "stable"}
    assert bool(settled) is (stable > 0)
    if where == "between the folds":
        assert own["nearest_change"]["distance"] / RPM == pytest.approx(2.48, abs=0.05)


@pytest.mark.verify
def test_peaks_are_named_by_the_frequencies_of_the_modes(call: Call) -> None:
    """The multiple of the peak's speed that its name tells is the mean over the turn of the first frequency with the crank held."""
    answer = call("resonance", "thesis-24", "--speed", "105 rpm .. 172 rpm", "--no-claims", "--json", "--output", "curve.csv")
    peaks = json.loads(answer.output)["peaks"]
    angles = np.linspace(0.0, 360.0, 37)[:-1].tolist()
    mean = float(qr.modes("thesis-24", "exudyn", angles, count=1).to_numpy()[:, -1].mean())
    assert [peak["harmonic"] for peak in peaks] == [f"{order} x crank = first mode" for order in (9, 8, 7, 6)]
    for peak in peaks:
        assert peak["order"] * peak["value"] / (2.0 * math.pi) == pytest.approx(mean, rel=0.02)
    named = pd.read_csv("curve.csv")["peak_harmonic"].dropna()
    assert sorted(named) == sorted(peak["harmonic"] for peak in peaks)


def test_a_curve_is_stored_for_the_machines_own_drive() -> None:
    """The speed of one is prescribed in place of its torque, that of the other by itself: the two curves say so."""
    varied = range_of("crank.prescribed_speed", "150 rpm .. 165 rpm", "range")
    of_torque, of_speed = (qr.case("thesis-24", more) for more in ({}, {"crank.prescribed_speed": "150 rpm"}))
    assert key_of(job(of_torque, varied)) != key_of(job(of_speed, varied))


def test_a_rigid_machine_has_no_curve(call: Call) -> None:
    refused(call("resonance", "rigid", "--speed", "60 rpm .. 90 rpm"), "bending_stiffness")


class _Interrupted(Exception):
    pass


@pytest.mark.verify
def test_an_interrupted_curve_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped several times, it evaluates each time at most one piece of cycles anew; the curve has the same bits."""
    monkeypatch.setattr("quickreturn.plugins.studies.resonance_curve.search.PIECE", 3)
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


class Gap(CycleFamily):
    """A family of one motion x = a that has no image between 0.1 and 0.4."""

    def __init__(self) -> None:
        pass

    def scene_at(self, value: float) -> Mechanism:
        return qr.case("rigid").mechanism

    def orbit(self, value: float) -> Array:
        return np.array([value])

    def image(self, point: Array, parameter: float) -> Image:
        if 0.1 < parameter < 0.4:
            raise CycleBroken("it broke")
        return Image(0.5 * (point + parameter), np.ones(1), np.full(1, 1e-16))


def test_a_curve_that_is_lost_is_begun_again_beyond() -> None:
    branch = _followed(Gap(), Range("tip.mass", 0.0, 1.0, "kg", 1.0), lambda kind, compute: compute())
    before, after = branch.endings
    assert after is None
    assert before is not None
    assert "it broke" in before.reason
    assert [round(branch.points[at].parameter, 4) for at in (0, -1)] == [0.4, 1.0]
