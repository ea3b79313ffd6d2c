"""Changes of a case from outside its file."""

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
    ("overrides", "expected"),
    [
        ({"crank.lenght": "4 in"}, 'overrides: crank.lenght: "4 in" belongs to an unknown key; the nearest known one is crank.length'),
        (
            {"pivot_distance": "4 in"},
            'overrides: pivot_distance: "4 in" belongs to an unknown key; the nearest known one is mechanism.pivot_distance',
        ),
        ({"slider.damping": "2 N*s/m"}, "the nearest known one is"),
        ({"name": "x"}, 'overrides: name: "x" cannot be set; only quantities can, such as crank.torque'),
        ({"crank.length": "4 kg"}, 'overrides: crank.length: "4 kg" is a mass (kg), but a length is needed'),
        (
            {"follower.length": "21 in"},
            'overrides: follower.length: "21 in" cannot be: the slider leaves the follower: pivot_distance + crank.length = 0.5588 m'
            " must not exceed follower.length = 0.5334 m",
        ),
        (
            {"follower.length": "15 in"},
            'overrides: follower.length: "15 in" does not fit: follower.strain_gauges leaves the strain gauge at 0.47625 m outside the'
            " follower; its length is 0.381 m",
        ),
        (
            {"follower.notch_places": ["0 mm"]},
            'follower.notch_places: ["0 mm"] does not fit: follower.notch_factors has 0 values, and follower.notch_places 1; give one',
        ),
        (
            {"simulation.output_step": "0.3 s"},
            'overrides: simulation.output_step: "0.3 s" gives 6.66667 output steps (duration 2 s, output step 0.3 s); ',
        ),
        (
            {"mechanism.gravity": "9.81 m/s^2"},
            'overrides: mechanism.gravity: "9.81 m/s^2" is not a list of 2 strings (gravity: along n1 and n2, on every body); write one'
            ' such as ["2 in/s^2", "2 in/s^2"]',  # as the file has it
        ),
        (
            {"follower.notch_factors": "1.8"},
            'overrides: follower.notch_factors: "1.8" is not a list of strings (notch factors: fatigue notch factor at each of them, on the'
            ' stress amplitude); write one such as ["1.5", "1.5"]',
        ),
        (
            {"follower.notch_factors": '["180 percent"]'},
            'overrides: follower.notch_factors: "180 percent" is not a pure number; write one plain number without a unit, such as "1.5"',
        ),
        (
            {"crank.wanted_fluctuation": "2 %"},
            '"2 %" is not a pure number; write one plain number without a unit',
        ),
        ({"follower.wall_thickness": "2 mm"}, "belongs to an unknown key; the nearest known one is follower.wall"),
        (
            {"crank.prescribed_speed": "9 rad/s", "crank.damping": "0 N*m*s"},
            'overrides: crank.prescribed_speed: "9 rad/s" conflicts with crank.damping; give either',
        ),
    ],
    ids=str,
)
def test_a_mistaken_override_is_told_like_one_in_a_file(overrides: dict[str, str], expected: str) -> None:
    with pytest.raises(CaseError) as refused:
        parse_case(SCENE, "scene.toml", overrides)
    assert expected in str(refused.value)


def test_the_example_in_a_message_has_the_units_of_the_file() -> None:
    metric = SCENE.replace(' in"', ' mm"')
    for text, unit, others in ((SCENE, "in", "mm, m"), (metric, "mm", "in, m")):
        with pytest.raises(CaseError, match=f'has no unit; .* such as "2 {unit}" \\(other units: {others}\\)'):
            parse_case(text, "scene.toml", {"follower.width": "12"})
