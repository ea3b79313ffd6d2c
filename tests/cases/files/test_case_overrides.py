"""Changes of a case from outside its file."""

import re

import pytest

from quickreturn.cases.files.case import Case, parse_case
from quickreturn.cases.files.errors import CaseError
from quickreturn.reference_model.mechanism import PrescribedSpeed, TorqueDrive
from tests.cases.files.scene_texts import SCENE, changed, numbers


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
        ({"crank.lenght": "4 in"}, "crank.lenght", "crank.length"),
        ({"pivot_distance": "4 in"}, "pivot_distance", "mechanism.pivot_distance"),
        ({"slider.damping": "2 N*s/m"}, "slider.damping", "nearest"),
        ({"name": "x"}, "name", "cannot be set"),
        ({"crank.length": "4 kg"}, "crank.length", "a length is needed"),
        ({"follower.length": "21 in"}, "follower.length", "pivot_distance + crank.length = 0.5588 m"),
        ({"follower.length": "15 in"}, "follower.length", "the strain gauge at 0.47625 m outside"),
        ({"follower.notch_places": ["0 mm"]}, "follower.notch_places", "follower.notch_factors has 0 values"),
        ({"simulation.output_step": "0.3 s"}, "simulation.output_step", "6.66667 output steps"),
        ({"mechanism.gravity": "9.81 m/s^2"}, "mechanism.gravity", '["2 in/s^2", "2 in/s^2"]'),  # in the unit of the file
        ({"follower.notch_factors": "1.8"}, "follower.notch_factors", "a list of strings"),
        ({"follower.notch_factors": '["180 percent"]'}, "follower.notch_factors", "not a pure number"),
        ({"crank.wanted_fluctuation": "2 %"}, "crank.wanted_fluctuation", "not a pure number"),
        ({"follower.wall_thickness": "2 mm"}, "follower.wall_thickness", "follower.wall"),
        ({"crank.prescribed_speed": "9 rad/s", "crank.damping": "0 N*m*s"}, "crank.prescribed_speed", "crank.damping"),
    ],
    ids=str,
)
def test_a_mistaken_override_is_told_like_one_in_a_file(overrides: dict[str, str], key: str, word: str) -> None:
    with pytest.raises(CaseError, match=rf"^overrides: {re.escape(key)}: ") as refused:
        parse_case(SCENE, "scene.toml", overrides)
    assert word in str(refused.value)


def test_the_example_in_a_message_has_the_units_of_the_file() -> None:
    metric = SCENE.replace(' in"', ' mm"')
    for text, unit, others in ((SCENE, "in", "mm, m"), (metric, "mm", "in, m")):
        with pytest.raises(CaseError, match=f'has no unit; .* such as "2 {unit}" \\(other units: {others}\\)'):
            parse_case(text, "scene.toml", {"follower.width": "12"})
