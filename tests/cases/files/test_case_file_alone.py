"""Case files of the follower alone, and of a crank that is held."""

import pytest

from quickreturn.cases.files.case import parse_case
from quickreturn.cases.files.errors import CaseError
from quickreturn.reference_model.mechanism import PrescribedSpeed
from tests.cases.files.scene_texts import SCENE, message

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
