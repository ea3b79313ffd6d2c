"""What stands in a case file arrives where it belongs."""

import math
from pathlib import Path

import pytest

from cases.case_file import load_case, parse_case, with_times
from cases.errors import CaseError
from reference_model.mechanism import PrescribedSpeed, TorqueDrive
from tests.cases.scene_texts import IN_SI, SCENE, changed, numbers


def test_a_scene_in_inches_and_in_si_is_the_same() -> None:
    inches, metric = parse_case(SCENE, "scene.toml"), parse_case(IN_SI, "scene.toml")
    assert len(numbers(metric)) == 31  # every quantity of the file: none was dropped or put in another's place
    # 1e-15: both texts are rounded once to a double, the metric one after 16 or more digits
    assert numbers(inches) == pytest.approx(numbers(metric), rel=1e-15, abs=0.0)


def test_every_key_arrives_where_it_belongs() -> None:
    case = parse_case(IN_SI, "scene.toml")
    scene = case.mechanism
    assert (case.name, case.title, case.tags, case.source, case.notes) == ("scene", "A scene", ("test",), "scene.toml", ())
    assert (case.duration, case.output_step) == (2.0, 0.001)
    assert (scene.pivot_distance, scene.gravity) == (0.4572, (0.0, -9.8044))
    assert (scene.crank.length, scene.crank.center_of_mass, scene.crank.inertia) == (0.1016, 0.0762, 4.519393161104668e-5)
    assert scene.crank.initial_angle == math.pi
    assert scene.crank.drive == TorqueDrive(torque=1.129848290276167, damping=0.06799035518449393, initial_speed=16.617773)
    assert (scene.base.inertia, scene.base.damping) == (1.6947724354142505e-5, 2.259696580552334e-6)
    assert (scene.follower.length, scene.follower.thickness, scene.follower.width) == (0.635, 0.003175, 0.0381)
    assert (scene.follower.damping, scene.follower.strain_gauges) == (0.1378951458633672, (0.15875, 0.3175, 0.47625))
    assert scene.tip is not None
    assert (scene.tip.inertia, scene.tip.center_of_mass) == (2.21450264894128732e-6, 0.0127)
    assert (scene.slider.joint_stiffness, scene.slider.joint_damping) == (17512.68352464763779, 17.51268352464763779)


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


def test_the_crank_may_be_driven_by_a_prescribed_speed_alone() -> None:
    text = changed('torque = "10 lbf*in"\n', 'prescribed_speed = "-120 rpm"\n').replace('damping = "0.60176535 lbf*in*s/rad"\n', "")
    case = parse_case(text.replace('initial_speed = "16.617773 rad/s"\n', ""), "scene.toml")
    assert case.mechanism.crank.drive == PrescribedSpeed(speed=-4.0 * math.pi)


def test_a_file_may_have_a_byte_order_mark_and_windows_lines(tmp_path: Path) -> None:
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + SCENE.replace("\n", "\r\n").encode())
    assert load_case(str(path)).mechanism == parse_case(SCENE, "scene.toml").mechanism


def test_simulation_times_can_be_replaced() -> None:
    case = parse_case(SCENE, "scene.toml")
    assert (with_times(case, 0.5).duration, with_times(case, 0.5).output_step) == (0.5, 0.001)
    assert with_times(case, output_step=0.002).output_step == 0.002
    assert with_times(case) == case
    for duration, step in ((math.nan, None), (-1.0, None), (0.0, None), (math.inf, None), (0.0015, None), (None, 3.0), (1e9, 1e-9)):
        with pytest.raises(CaseError, match=r"^command line: --"):
            with_times(case, duration, step)
