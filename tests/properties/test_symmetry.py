"""The mechanism's symmetries: mirror image, whole turns, and the independence of physics from the units of measure."""

import math
from dataclasses import replace

import pytest
from hypothesis import strategies as st

from quickreturn.cases.files.keys import dimension_of
from quickreturn.engines.base import EngineFailure
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.scene_values import scene_of, values_of
from tests.properties.law import for_all
from tests.properties.runs import (
    COMPLIANT,
    ENERGIES,
    EXPLICIT,
    EXUDYN,
    MUJOCO,
    REFERENCE,
    STEPS_ADD_UP,
    TOLERANCE,
    Array,
    Method,
    apart,
    assert_close,
    both,
)
from tests.strategies import Scene, numbers, scenes

#: How closely an engine does the same thing again in other numbers. The integrators of the explicit models may take other steps for the
#: sake of a rounding; Exudyn leaves Newton's iteration at a residual of 1e-6; MuJoCo's steps are fixed, roundings alone are left.
REPEATED = {
    **dict.fromkeys(("reference", "thesis", "fixed-shapes"), STEPS_ADD_UP * TOLERANCE),
    "exudyn": 1e-6,
    "mujoco": 1e-9,
}
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


#: Exponents of length, mass and time in each column.
DIMENSIONS = {
    **dict.fromkeys(("crank_angle", "follower_angle", "strain_1", "strain_2", "strain_3"), (0, 0, 0)),
    "crank_speed": (0, 0, -1),
    **dict.fromkeys(("slider_position", "tip_x", "tip_y", "tip_deflection"), (1, 0, 0)),
    "tip_acceleration": (1, 0, -2),
    "slider_force": (1, 1, -2),
    **dict.fromkeys(("crank_torque", *ENERGIES), (2, 1, -2)),
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
        angles, first, second = (each[::-1] for each in (table.angles, table.first, table.second))
        other_table = replace(table, angles=tuple(-angle for angle in angles), first=first, second=tuple(-each for each in second))
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


def factor(exponents: tuple[int, ...], units: tuple[float, float, float]) -> float:
    """By what a number grows that has these exponents of length, mass and time."""
    return math.prod(unit**exponent for unit, exponent in zip(units, exponents[:3], strict=True))


def scaled(scene: Scene, units: tuple[float, float, float]) -> Scene:
    """The scene with all lengths, masses and times multiplied; the dimension of each quantity is the one that case files demand."""
    values = values_of(scene.mechanism)
    for section, keys in values.items():
        for name, value in keys.items():
            by = factor(dimension_of(f"{section}.{name}").exponents, units)
            keys[name] = tuple(by * each for each in value) if isinstance(value, tuple) else by * value
    other = scene_of(values)
    assert isinstance(other, Mechanism)
    return replace(
        scene,
        mechanism=other,
        bend=units[0] * scene.bend,
        bend_rate=units[0] / units[2] * scene.bend_rate,
        duration=units[2] * scene.duration,
    )


def check_image(method: Method, scene: Scene) -> None:
    if runs := both(lambda: method.run(scene), lambda: method.run(mirrored(scene))):
        assert_close(image(runs[1].columns), runs[0], scene, method, REPEATED[method.engine.name])


@pytest.mark.parametrize("method", [*EXPLICIT, pytest.param(EXUDYN, marks=pytest.mark.verify), MUJOCO], ids=str)
@for_all(few=4, many=25, scene=scenes())
def test_the_mirror_image_moves_like_the_mirror_image(method: Method, scene: Scene) -> None:
    check_image(method, scene)


@pytest.mark.parametrize("method", [REFERENCE, pytest.param(EXUDYN, marks=pytest.mark.verify), MUJOCO], ids=str)
@for_all(few=4, many=25, scene=scenes(tool=True))
def test_the_mirror_image_with_a_tool_and_a_spring(method: Method, scene: Scene) -> None:
    check_image(method, scene)


@for_all(few=4, many=25, scene=scenes(compliant=True))
def test_the_mirror_image_with_a_soft_joint(scene: Scene) -> None:
    assert_close(image(COMPLIANT.run(mirrored(scene)).columns), COMPLIANT.run(scene), scene, COMPLIANT, REPEATED["reference"])


@for_all(few=6, many=40, scene=scenes(rollers=True))
def test_the_mirror_image_with_rollers_exchanged(scene: Scene) -> None:
    """Blows make roundings grow, and the error of the integration alike; a hundredth of the tolerance leaves less than that error."""
    tight = replace(COMPLIANT, settings=COMPLIANT.settings.replaced(tolerance=1e-2 * TOLERANCE))
    run = tight.run(scene)
    error = max(apart(COMPLIANT.run(scene).columns, run, scene, COMPLIANT).values())
    assert error < 1e-3  # exchanged sides, a turned sign: 1e-3 to 1e-1 where the sides differ much
    assert_close(image(tight.run(mirrored(scene)).columns), run, scene, tight, REPEATED["reference"] + error)


@pytest.mark.parametrize("method", [*EXPLICIT, EXUDYN, MUJOCO], ids=str)
@for_all(few=4, many=25, scene=scenes(), turns=st.sampled_from([1, -1, 3]))
def test_whole_turns_of_the_crank_change_nothing(method: Method, scene: Scene, turns: int) -> None:
    """A step that is too large for a scene is so after whole turns, at the same instant."""
    crank = scene.mechanism.crank
    turned = scene.with_part(crank=replace(crank, initial_angle=crank.initial_angle + turns * 2.0 * math.pi))
    try:
        expected = method.run(scene)
    except EngineFailure as failure:
        with pytest.raises(EngineFailure, match=f"at t = {failure.time:.3g}"):
            method.run(turned)
        return
    found = method.run(turned).columns
    found |= {"crank_angle": found["crank_angle"] - turns * 2.0 * math.pi}
    assert_close(found, expected, scene, method, REPEATED[method.engine.name])


@pytest.mark.parametrize("method", [*EXPLICIT], ids=str)
@for_all(few=4, many=25, scene=scenes(), powers=st.tuples(*[numbers(-1.0, 1.0)] * 3))
def test_motion_scales_with_the_units_of_length_mass_and_time(method: Method, scene: Scene, powers: tuple[float, float, float]) -> None:
    """Dimensional analysis: lengths, masses and times in other proportions are the same scene in other units."""
    units = (10.0 ** powers[0], 10.0 ** powers[1], 10.0 ** powers[2])
    columns = method.run(scaled(scene, units)).columns
    back = {name: columns[name] / factor(exponents, units) for name, exponents in DIMENSIONS.items()}
    assert_close(back, method.run(scene), scene, method, STEPS_ADD_UP * TOLERANCE)
