"""What stands in a case file, or is changed from outside it, arrives where it belongs, also for the follower alone and a held crank."""

import math
import re

import pytest

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import with_times
from quickreturn.reference_model.mechanism import PrescribedSpeed, TorqueDrive
from tests.cases.files.scene_texts import SCENE, changed, message, numbers, parse_case


def test_every_key_arrives_where_it_belongs() -> None:
    """Numbers converted by hand with 1 in = 0.0254 m and 1 lbf = 4.4482216152605 N; rounded once to a double, after 16 digits."""
    case = parse_case(SCENE, "scene.toml")
    scene = case.mechanism
    assert (case.name, case.title, case.tags, case.source, case.notes) == ("scene", "A scene", ("test",), "scene.toml", ())
    assert (case.duration, case.output_step) == (2.0, 0.001)
    assert len(numbers(case)) == 52  # every quantity of the file: none was dropped or put in another's place
    crank, base, follower, tip, slider = scene.crank, scene.base, scene.follower, scene.tip, scene.slider
    assert isinstance(crank.drive, TorqueDrive)
    assert tip is not None
    for found, expected in (
        ((scene.pivot_distance, *scene.gravity), (0.4572, 0.0, -9.8044)),
        ((crank.length, crank.center_of_mass, crank.inertia), (0.1016, 0.0762, 4.519393161104668e-5)),
        ((crank.mass, crank.initial_angle), (17.512683524647638, math.pi)),
        ((crank.drive.torque, crank.drive.damping), (1.129848290276167, 0.06799035518449393)),
        ((crank.drive.initial_speed, base.inertia, base.damping), (16.617773, 1.6947724354142505e-5, 2.259696580552334e-6)),
        ((follower.length, follower.thickness, follower.width), (0.635, 0.003175, 0.0381)),
        ((follower.mass_per_length, follower.bending_stiffness), (0.32818148397033291, 6.1075969499621217)),
        ((follower.damping, *follower.strain_gauges), (0.1378951458633672, 0.15875, 0.3175, 0.47625)),
        ((tip.mass, tip.inertia, tip.center_of_mass), (0.050786782221478150, 2.21450264894128732e-6, 0.0127)),
        ((*tip.force, tip.force_from), (0.44482216152605, -0.08896443230521, 3.490658503988659)),
        ((tip.force_to, tip.force_ramp), (5.759586531581288, 0.20943951023931956)),
        ((slider.mass, slider.inertia), (1.7512683524647638, 1.129848290276167e-5)),
        ((slider.joint_stiffness, slider.joint_damping), (17512.683524647638, 17.512683524647638)),
    ):
        assert found == pytest.approx(expected, rel=1e-15, abs=0.0)


def test_what_may_be_left_out_has_the_documented_default() -> None:
    text = changed('gravity = ["0 in/s^2", "-386 in/s^2"]\n', "").replace('initial_speed = "16.617773 rad/s"\n', "")
    for section in ("tip", "slider"):
        start = text.index(f"[{section}]")
        text = text[:start] + text[text.index("\n\n", start) + 2 :]
    case = parse_case(text.replace('title = "A scene"\n', "").replace('tags = ["test"]\n', ""), "scene.toml")
    scene = case.mechanism
    assert (case.title, case.tags) == ("scene", ())
    assert scene.tip is None
    assert not scene.has_gravity
    assert (scene.slider.mass, scene.slider.inertia, scene.slider.joint_stiffness, scene.slider.joint_damping) == (0.0, 0.0, math.inf, 0.0)
    assert scene.crank.drive.initial_speed == pytest.approx(10.0 / 0.60176535, rel=1e-15)  # torque / damping; a few roundings


def test_simulation_times_can_be_replaced() -> None:
    case = parse_case(SCENE, "scene.toml")
    assert (with_times(case, 0.5).duration, with_times(case, 0.5).output_step) == (0.5, 0.001)
    assert with_times(case, output_step=0.002).output_step == 0.002
    assert with_times(case) == case
    for duration, step in ((math.nan, None), (-1.0, None), (0.0, None), (math.inf, None), (0.0015, None), (None, 3.0), (1e9, 1e-9)):
        with pytest.raises(CaseError, match=r"^scene: (duration|output_step): "):
            with_times(case, duration, step)


STEEL = """\
elastic_modulus = "210 GPa"
density = "7.85 g/cm^3"
"""


@pytest.mark.parametrize(("first", "other"), [("elastic_modulus", "bending_stiffness"), ("density", "mass_per_length")])
def test_material_and_what_follows_from_it_exclude_each_other(first: str, other: str) -> None:
    both = SCENE.replace("[follower]\n", f"[follower]\n{STEEL}")
    both = both if first == "elastic_modulus" else both.replace('elastic_modulus = "210 GPa"\n', "")
    with pytest.raises(CaseError, match=f"follower.{first}.*conflicts with follower.{other}"):
        parse_case(both, "scene.toml")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("3 mm +- 0.1 mm", ""),
        ("3 mm +- 2 %", ""),
        ("3 mm +-0.1 mm", "no tolerance that can be read"),
        ("3 mm +- 0.1", "has no unit"),
        ("3 mm +- -0.1 mm", "tolerance that is not positive"),
        ("3 mm +- 3 mm", "tolerance beyond which it is not positive"),
        ("inf +- 1 mm", "cannot be read"),
    ],
)
def test_a_value_with_a_tolerance_is_the_value(text: str, told: str) -> None:
    if told:
        with pytest.raises(CaseError, match=r"overrides: follower\.thickness: ") as wrong:
            parse_case(SCENE, "scene.toml", {"follower.thickness": text})
        assert told in str(wrong.value)
        assert str(wrong.value).count("\n") == 0
        return
    case, plain = (parse_case(SCENE, "scene.toml", {"follower.thickness": each}) for each in (text, "3 mm"))
    assert case.scene == plain.scene
    assert case.tolerances == {"follower.thickness": text}
    assert parse_case(case.to_toml(), "written").tolerances == case.tolerances
    assert case.mechanism_with({"follower.thickness": 0.004}).follower.thickness == 0.004


def test_a_tolerance_in_a_list_belongs_to_its_place() -> None:
    case = parse_case(SCENE, "scene.toml", {"mechanism.gravity": '["0 m/s^2", "-9.8 m/s^2 +- 0.1 m/s^2"]'})
    assert case.tolerances == {"mechanism.gravity[2]": "-9.8 m/s^2 +- 0.1 m/s^2"}
    assert case.mechanism.gravity == (0.0, -9.8)


ALONE = """\
name = "alone"

[base]
inertia = "0 kg*m^2"
damping = "0 N*m*s/rad"
spin_up_speed = "6 rad/s"
spin_up_time = "15 s"

[follower]
length = "10 m"
mass_per_length = "1.2 kg/m"
bending_stiffness = "14 kN*m^2"
thickness = "77 mm"
width = "5 mm"
damping = "0 N*s/m^2"
strain_gauges = ["2.5 m", "5 m", "7.5 m"]

[simulation]
duration = "1 s"
output_step = "10 ms"
"""
CRANK = SCENE[SCENE.index("[crank]") : SCENE.index("[base]")]


def test_a_follower_alone_is_a_scene_of_its_own() -> None:
    scene = parse_case(ALONE, "alone.toml").scene
    assert (scene.spin_up.speed, scene.spin_up.time, scene.follower.length, scene.tip) == (6.0, 15.0, 10.0, None)
    assert scene.gravity == (0.0, 0.0)
    heavy = parse_case(ALONE.replace("[base]", '[mechanism]\ngravity = ["0 m/s^2", "-9.8 m/s^2"]\n\n[base]'), "alone.toml").scene
    assert heavy.gravity == (0.0, -9.8)


def test_what_needs_a_crank_says_so() -> None:
    with pytest.raises(CaseError, match=r"^alone: \[crank\]: this case has no crank and no slider, but the command needs them"):
        _ = parse_case(ALONE, "alone.toml").mechanism


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (ALONE + CRANK, ("base.spin_up_speed", "conflicts with [crank]")),
        (SCENE.replace(CRANK, ""), ("[crank]", "missing", "base.spin_up_speed and base.spin_up_time")),
        (ALONE.replace('spin_up_time = "15 s"\n', ""), ("base.spin_up_time", "missing")),
        (ALONE.replace('spin_up_speed = "6 rad/s"\n', ""), ("base.spin_up_speed", "missing")),
        (ALONE.replace('"15 s"', '"0 s"'), ("base.spin_up_time", "not positive")),
        (ALONE + '[slider]\nmass = "1 kg"\n', ("[slider]", "missing [crank]")),
        (ALONE + '[mechanism]\npivot_distance = "1 m"\n', ("mechanism.pivot_distance", "missing [crank]")),
        (ALONE.replace('"14 kN*m^2"', '"inf"'), ("follower.bending_stiffness", "base.spin_up_speed")),
        (SCENE.replace('pivot_distance = "18 in"\n', ""), ("mechanism.pivot_distance", "missing")),
    ],
)
def test_crank_and_spun_up_base_exclude_each_other_in_one_sentence(text: str, words: tuple[str, ...]) -> None:
    said = message(text)
    assert all(word in said for word in words), said
    assert "\n" not in said


def test_a_crank_may_be_held() -> None:
    held = parse_case(
        SCENE.replace('torque = "10 lbf*in"\n', 'prescribed_speed = "0 rad/s"\n')
        .replace('damping = "0.60176535 lbf*in*s/rad"\n', "")
        .replace('initial_speed = "16.617773 rad/s"\n', ""),
        "held.toml",
    )
    assert held.mechanism.crank.drive == PrescribedSpeed(speed=0.0)


def override(**texts: str) -> Case:
    return parse_case(SCENE, "scene.toml", {key.replace("__", "."): text for key, text in texts.items()})


def test_overrides_change_what_they_name_and_nothing_else() -> None:
    plain = parse_case(SCENE, "scene.toml")
    stiffer = override(follower__bending_stiffness="12 N*m^2")
    assert stiffer.mechanism.follower.bending_stiffness == 12.0
    rest = [(a, b) for a, b in zip(numbers(plain), numbers(stiffer), strict=True) if a != b]
    assert len(rest) == 1
    assert override(mechanism__gravity='["0 m/s^2", "-1.62 m/s^2"]').mechanism.gravity == (0.0, -1.62)
    assert override(crank__length='"0.1 m"').mechanism.crank.length == 0.1  # quotes as in the file are understood


def test_an_override_can_exchange_the_crank_drive_as_a_whole() -> None:
    fixed = override(crank__prescribed_speed="10 rad/s")
    assert fixed.mechanism.crank.drive == PrescribedSpeed(speed=10.0)
    text = changed('torque = "10 lbf*in"\ndamping = "0.60176535 lbf*in*s/rad"\n', 'prescribed_speed = "9 rad/s"\n')
    text = text.replace('initial_speed = "16.617773 rad/s"\n', "")
    kept = override(crank__damping="0.1 N*m*s/rad").mechanism.crank.drive
    assert kept == TorqueDrive(torque=1.129848290276167, damping=0.1, initial_speed=16.617773)  # the start is as written
    freed = parse_case(text, "scene.toml", {"crank.torque": "2 N*m", "crank.damping": "0.1 N*m*s/rad"})
    assert freed.mechanism.crank.drive == TorqueDrive(torque=2.0, damping=0.1, initial_speed=20.0)


@pytest.mark.parametrize(
    ("overrides", "key", "word"),
    [
        ({"pivot_distance": "4 in"}, "pivot_distance", "mechanism.pivot_distance"),
        ({"slider.damping": "2 N*s/m"}, "slider.damping", "nearest"),
        ({"name": "x"}, "name", "cannot be set"),
        ({"follower.length": "21 in"}, "follower.length", "pivot_distance + crank.length = 0.5588 m"),
        ({"simulation.output_step": "0.3 s"}, "simulation.output_step", "6.66667 output steps"),
        ({"follower.notch_factors": '["180 percent"]'}, "follower.notch_factors", "not a pure number"),
        ({"crank.prescribed_speed": "9 rad/s", "crank.damping": "0 N*m*s"}, "crank.prescribed_speed", "crank.damping"),
    ],
    ids=str,
)
def test_a_mistaken_override_is_told_like_one_in_a_file(overrides: dict[str, str], key: str, word: str) -> None:
    with pytest.raises(CaseError, match=rf"^overrides: {re.escape(key)}: ") as refused:
        parse_case(SCENE, "scene.toml", overrides)
    assert word in str(refused.value)
