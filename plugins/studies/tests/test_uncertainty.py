"""`quickreturn uncertainty` and `qr.uncertainty` from outside: against a closed form, after a kill, and what is told of mistakes."""

import json
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import quickreturn as qr
from tests.quickreturn.conftest import Call
from tests.quickreturn.input.answers import refused

RPM = math.pi / 30.0
#: A rigid machine of which only the base dissipates: the work of a turn is b w K, with K the integral of (d phi / d theta)^2 over a turn.
WORK = """
case = "machines/rigid.toml"
measures = ["turn.drive_work"]
samples = 8

[uncertain]
base.damping = "uniform 1e-4 N*m*s/rad .. 3e-4 N*m*s/rad"
"""
SPEED = 'crank.prescribed_speed = "uniform 80 rpm .. 120 rpm"\n'


def rigid() -> qr.Case:
    return qr.case("rigid", {"follower.damping": "0 N*s/m^2", "crank.prescribed_speed": "100 rpm"})


def turn_of_the_base(case: qr.Case) -> float:
    """K: phi is the direction from P to the crank's end, and d phi / d theta = (r^2 - r d cos theta) / (r^2 + d^2 - 2 r d cos theta)."""
    r, d = case.mechanism.crank.length, case.mechanism.pivot_distance
    theta = np.linspace(0.0, 2.0 * np.pi, 20_001)[:-1]
    rate = (r * r - r * d * np.cos(theta)) / (r * r + d * d - 2.0 * r * d * np.cos(theta))
    return float(np.mean(rate**2) * 2.0 * np.pi)


@pytest.fixture
def place(call: Call) -> Call:
    """The study of the work in the folder where the program is called, its case in another one."""
    Path("machines").mkdir()
    Path("machines/rigid.toml").write_text(rigid().to_toml())
    Path("work.toml").write_text(WORK)
    return call


@pytest.mark.verify
def test_quantiles_of_the_work_are_those_of_its_closed_form(place: Call) -> None:
    answer = place("uncertainty", "work.toml", "--json", "--output", "points.csv")
    assert answer.code == 0, answer.errors
    document = json.loads(answer.output)
    (found,) = document["measures"]
    work = 2e-4 * 100.0 * RPM * turn_of_the_base(rigid())  # of the middle damping
    for each in found["quantiles"]:
        exact = work * (0.5 + each["probability"])
        assert abs(each["value"] - exact) <= each["sampling_error"] + each["simulation_error"]
        assert each["sampling_error"] + each["simulation_error"] < 2e-3 * work
    assert found["mean"]["value"] == pytest.approx(work, rel=1e-6)
    assert found["deviation"]["value"] == pytest.approx(work / math.sqrt(12.0), rel=1e-6)
    assert found["band"][0] == pytest.approx(0.55 * work, rel=5e-3)
    assert [share["key"] for share in found["shares"]] == ["base.damping"]
    table = pd.read_csv("points.csv")
    heads = ["base.damping [N*m*s/rad]", "turn.drive_work [J]", "turn.drive_work.error [J]", "status", "sentence"]
    assert list(table.columns) == heads
    np.testing.assert_allclose(table[heads[1]] / table[heads[0]], work / 2e-4, rtol=1e-5)


@pytest.mark.verify
def test_shares_of_the_work_are_those_of_a_product(place: Call) -> None:
    """Of the product of two independent quantities with the relative variances u and v the shares are u, v and u v over their sum."""
    Path("work.toml").write_text(WORK.replace("samples = 8", "samples = 16") + SPEED)
    (found,) = json.loads(place("uncertainty", "work.toml", "--json").output)["measures"]
    u, v = 1.0 / 12.0, 0.4**2 / 12.0
    whole = u + v + u * v
    for share, alone, total in zip(found["shares"], (u, v), (u + u * v, v + u * v), strict=True):
        assert abs(share["first"] - alone / whole) <= max(share["first_error"], 1e-4)
        assert abs(share["total"] - total / whole) <= max(share["total_error"], 1e-4)
        assert share["first_error"] < 0.01


def results(folder: Path) -> dict[str, int]:
    return {file.name: file.stat().st_mtime_ns for file in (folder / ".quickreturn").glob("*.result")}


def test_a_study_whose_machines_cannot_be_gives_no_band(call: Call) -> None:
    Path("long.toml").write_text(
        'case = "rigid"\nmeasures = ["turn.drive_work"]\nsamples = 8\nuncertain."crank.length" = "uniform 4 in .. 17 in"\n'
    )
    answer = call("uncertainty", "long.toml", "--no-claims")
    assert answer.code == 3
    settled = int(answer.output.partition(" settled")[0].rpartition(" ")[2])
    assert 0 < settled < 8
    assert f"no band: {settled} of 8 points settled" in answer.output
    assert "±" not in answer.output
    assert f"rigid: no band of turn.drive_work: {settled} of 8 points settled; {8 - settled} " in answer.errors
    assert "such as at crank.length = " in answer.errors


@pytest.mark.verify
def test_tolerances_of_a_case_file_scatter_here_and_nowhere_else(call: Call) -> None:
    text = rigid().to_toml()
    Path("exact.toml").write_text(text)
    tolerant = text.replace('"4 in"', '"4 in +- 0.1 in"').replace('"18 in"', '"18 in +- 1 %"')
    assert tolerant != text
    Path("tolerant.toml").write_text(tolerant)
    case = qr.case("tolerant.toml")
    assert case.tolerances == {"mechanism.pivot_distance": "18 in +- 1 %", "crank.length": "4 in +- 0.1 in"}
    assert case.scene == qr.case("exact.toml").scene
    assert qr.case("tolerant.toml", {"crank.length": "4 in"}).tolerances.keys() == {"mechanism.pivot_distance"}
    assert qr.case("tolerant.toml").with_(name="copy").tolerances == case.tolerances, "values stay as they were written"
    answer = call("uncertainty", "tolerant.toml", "--measure", "period", "--measure", "peak.follower_angle", "--samples", "8", "--json")
    assert answer.code == 0, answer.errors
    document = json.loads(answer.output)
    assert document["uncertain"] == {
        "mechanism.pivot_distance": "uniform within 18 in +- 1 %",
        "crank.length": "uniform within 4 in +- 0.1 in",
    }
    angle = document["measures"][1]  # pi + asin(r / d) to first order in both tolerances
    r, d = 4.0, 18.0
    slope = 1.0 / math.sqrt(1.0 - (r / d) ** 2)
    scatter = slope * math.hypot(0.1 / d, 0.01 * r / d) / math.sqrt(3.0)
    assert angle["mean"]["value"] == pytest.approx(math.pi + math.asin(r / d), abs=2e-4)
    assert angle["deviation"]["value"] == pytest.approx(scatter, rel=0.02)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("case = 3", ("case", "3 is not accepted", '"thesis-24"')),
        ('measure = ["period"]', ('measure: ["period"] belongs to an unknown key', "measures")),
        ('measures = ["peroid"]', ("measures", '"peroid" is unknown', "period")),
        ("samples = 100", ("samples: 100 is no power of two", "from 8 to 65536")),
        ('engine = "mujco"', ("engine", '"mujco" is unknown', "mujoco")),
        ("accuracy = 0.5", ("accuracy: 0.5 cannot be asked for", "from 0.0001 to 0.05")),
        ('case = "machines/rigit.toml"', ("case", "machines/rigit.toml", "there is no such file", "rigid.toml")),
        ('uncertain.base.dampin = "uniform 0 N*m*s/rad .. 1 N*m*s/rad"', ("base.dampin", "base.damping")),
        ('uncertain.base.damping = "1 N*m*s/rad +- 2 N*m*s/rad"', ("base.damping", "beyond which it is negative")),
        ('uncertain.crank.initial_angle = "180 deg +- 1 deg"', ("crank.initial_angle", "changes no steady motion")),
        ("uncertain = {}", ("uncertain", "names no parameter")),
    ],
    ids=str,
)
def test_a_bad_study_file_gets_one_sentence(place: Call, text: str, words: tuple[str, ...]) -> None:
    key = text.split(" ")[0].split(".")[0]
    kept = [line for line in WORK.splitlines() if line and not line.startswith((key, "[", "base") if key == "uncertain" else (key,))]
    top = [line for line in kept if not line.startswith(("[", "base"))]
    Path("work.toml").write_text("\n".join([text, *top, *(line for line in kept if line not in top)]))
    refused(place("uncertainty", "work.toml"), "work.toml: ", *words)
    assert not results(Path())


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (("rigid",), ("--measure", "none is given")),
        (("rigid", "--measure", "period"), ("rigid: has no tolerances", "6 mm +- 0.1 mm", "[uncertain]")),
        (("work.toml", "--samples", "24"), ("--samples", "24 is no power of two")),
        (("work.toml", "--set", "engine.elements=4"), ("--set engine.elements", "engine.modes")),
        (("work.toml", "--engine", "fixed-shapes", "--set", "slider.friction=0.1"), ("fixed-shapes", "slider.friction")),
        (("work.toml", "--output", "points.nc"), ("points.nc", ".csv")),
        (("nowhere.toml",), ("nowhere.toml", "there is no such file")),
    ],
    ids=str,
)
def test_answers_to_mistakes_on_the_command_line(place: Call, typed: tuple[str, ...], words: tuple[str, ...]) -> None:
    refused(place("uncertainty", *typed), *words)


def test_too_many_quantities_for_the_points_are_told_before_anything_is_computed(place: Call) -> None:
    keys = ("slider.mass", "tip.mass", "crank.mass", "base.inertia")
    more = "".join(
        f'{key} = "uniform 1 {"kg*m^2" if key == "base.inertia" else "kg"} .. 2 {"kg*m^2" if key == "base.inertia" else "kg"}"\n'
        for key in keys
    )
    Path("work.toml").write_text(WORK + more)
    refused(place("uncertainty", "work.toml"), "work.toml", "samples", "8", "5 uncertain", "16")
    assert not results(Path())


@pytest.mark.verify
def test_in_python(place: Call) -> None:
    found = qr.uncertainty(None, "work.toml", claims=False, quiet=True)
    again = qr.uncertainty(
        "machines/rigid.toml", {"base.damping": "2e-4 N*m*s/rad +- 50 %"}, "turn.drive_work", 8, claims=False, quiet=True
    )
    np.testing.assert_allclose(again.inputs, found.inputs, rtol=1e-12)
    np.testing.assert_allclose(again.values, found.values, rtol=1e-9)
