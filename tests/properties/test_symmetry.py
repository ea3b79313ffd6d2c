"""The mechanism's symmetries: mirror image and whole turns."""

import math
from dataclasses import replace

import pytest
from hypothesis import strategies as st

from quickreturn.engines.base import EngineFailure
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import PrescribedSpeed
from tests.properties.law import for_all
from tests.properties.runs import COMPLIANT, EXPLICIT, EXUDYN, MUJOCO, REFERENCE, STEPS_ADD_UP, TOLERANCE, Method, apart, assert_close, both
from tests.strategies import Scene, scenes

#: How closely an engine does the same thing again in other numbers. The integrators of the explicit models may take other steps for the
#: sake of a rounding; Exudyn leaves Newton's iteration at a residual of 1e-6; MuJoCo's steps are fixed, roundings alone are left.
REPEATED = {**dict.fromkeys(("reference", "thesis", "fixed-shapes"), STEPS_ADD_UP * TOLERANCE), "exudyn": 1e-6, "mujoco": 1e-9}
#: What the image in the line through O and P does to each column: keeps it or turns its sign. The follower's angle is counted from
#: the direction of P to O.
MIRRORED = {
    "crank_angle": -1.0,
    "crank_speed": -1.0,
    "follower_angle": -1.0,
    "slider_position": 1.0,
    "tip_x": 1.0,
    "tip_y": -1.0,
    "tip_deflection": -1.0,
    "tip_acceleration": -1.0,
    "strain_1": -1.0,
    "strain_2": -1.0,
    "strain_3": -1.0,
    "slider_force": -1.0,
    "crank_torque": -1.0,
    "kinetic_energy": 1.0,
    "strain_energy": 1.0,
    "gravity_energy": 1.0,
    "dissipated_energy": 1.0,
    "drive_work": 1.0,
}


def mirrored(scene: Scene) -> Scene:
    """The scene's image in the line through O and P."""
    crank, drive, (g1, g2) = scene.mechanism.crank, scene.mechanism.crank.drive, scene.mechanism.gravity
    if isinstance(drive, PrescribedSpeed):
        drive = PrescribedSpeed(speed=-drive.speed)
    else:
        drive = replace(drive, torque=-drive.torque, initial_speed=-drive.initial_speed)
    tip = scene.mechanism.tip
    if tip and (table := tip.force_table):
        angles, first, second = (each[::-1] for each in (table.points, *table.values))
        other_table = replace(table, points=tuple(-angle for angle in angles), values=(first, tuple(-each for each in second)))
        tip = replace(tip, force_table=other_table)
    elif tip:
        tip = replace(tip, force=(tip.force[0], -tip.force[1]), force_from=-tip.force_to, force_to=-tip.force_from)
    spring = scene.mechanism.spring
    if spring:
        spring = replace(spring, anchor=(spring.anchor[0], -spring.anchor[1]))
    slider = scene.mechanism.slider
    slider = replace(slider, joint_stiffness_plus=slider.joint_stiffness_minus, joint_stiffness_minus=slider.joint_stiffness_plus)
    turned = replace(crank, drive=drive, initial_angle=-crank.initial_angle)
    other = scene.with_part(crank=turned, gravity=(g1, -g2), tip=tip, slider=slider, spring=spring)
    return replace(other, bend=-scene.bend, bend_rate=-scene.bend_rate)


def image(columns: dict[str, Array]) -> dict[str, Array]:
    """The columns of the mirrored motion."""
    seen = {name: sign * columns[name] for name, sign in MIRRORED.items() if name in columns}
    # mirrored about the direction of P to O, which lies at half a turn
    return seen | {"follower_angle": 2.0 * math.pi - columns["follower_angle"]}


def check_image(method: Method, scene: Scene) -> None:
    if runs := both(lambda: method.run(scene), lambda: method.run(mirrored(scene))):
        assert_close(image(runs[1].columns), runs[0], scene, method, REPEATED[method.engine.name])


@pytest.mark.parametrize("method", [*EXPLICIT, pytest.param(EXUDYN, marks=pytest.mark.verify), MUJOCO], ids=str)
@for_all(few=3, many=25, scene=scenes())
def test_the_mirror_image_moves_like_the_mirror_image(method: Method, scene: Scene) -> None:
    check_image(method, scene)


@pytest.mark.parametrize("method", [REFERENCE, pytest.param(EXUDYN, marks=pytest.mark.verify), MUJOCO], ids=str)
@for_all(few=3, many=25, scene=scenes(tool=True))
def test_the_mirror_image_with_a_tool_and_a_spring(method: Method, scene: Scene) -> None:
    check_image(method, scene)


@for_all(few=3, many=25, scene=scenes(compliant=True))
def test_the_mirror_image_with_a_soft_joint(scene: Scene) -> None:
    assert_close(image(COMPLIANT.run(mirrored(scene)).columns), COMPLIANT.run(scene), scene, COMPLIANT, REPEATED["reference"])


@for_all(few=3, many=40, scene=scenes(rollers=True))
def test_the_mirror_image_with_rollers_exchanged(scene: Scene) -> None:
    """Blows make roundings grow, and the error of the integration alike; a hundredth of the tolerance leaves less than that error."""
    tight = replace(COMPLIANT, settings=COMPLIANT.settings.replaced(tolerance=1e-2 * TOLERANCE))
    run = tight.run(scene)
    error = max(apart(COMPLIANT.run(scene).columns, run, scene, COMPLIANT).values())
    assert error < 1e-3  # exchanged sides, a turned sign: 1e-3 to 1e-1 where the sides differ much
    assert_close(image(tight.run(mirrored(scene)).columns), run, scene, tight, REPEATED["reference"] + error)


@pytest.mark.parametrize("method", [*EXPLICIT, EXUDYN, MUJOCO], ids=str)
@for_all(few=3, many=25, scene=scenes(), turns=st.sampled_from([1, -1, 3]))
def test_whole_turns_of_the_crank_change_nothing(method: Method, scene: Scene, turns: int) -> None:
    """A step that is too large for a scene is so after whole turns, at the same instant."""
    crank = scene.mechanism.crank
    turned = scene.with_part(crank=replace(crank, initial_angle=crank.initial_angle + turns * 2.0 * math.pi))
    try:
        expected = method.run(scene)
    except EngineFailure as failure:
        failed_at = failure.time
    else:
        found = method.run(turned).columns
        found |= {"crank_angle": found["crank_angle"] - turns * 2.0 * math.pi}
        assert_close(found, expected, scene, method, REPEATED[method.engine.name])
        return
    with pytest.raises(EngineFailure) as again:
        method.run(turned)
    assert again.value.time == pytest.approx(failed_at, rel=1e-3)
