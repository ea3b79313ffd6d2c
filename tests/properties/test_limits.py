"""What a scene lacks is the limit of having little of it: every parameter that may be zero, and both that may be infinite.

The change that little of a part makes is proportional to it: half as much of the part, half the change, at every instant and in every
column. A straight line through both runs then meets the run without the part.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume

from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.rivals import multiplier, stiff_spring
from quickreturn.plugins.methods.rivals.multiplier import MultiplierSettings
from quickreturn.plugins.methods.rivals.stiff_spring import StiffSpringSettings
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Base, Mechanism, TorqueDrive
from quickreturn.reference_model.tip import Tip
from tests.properties.law import for_all
from tests.properties.runs import EXUDYN, MUJOCO, REFERENCE, STEPS_ADD_UP, TOLERANCE, Method, sizes
from tests.strategies import Scene, scenes

Part = Callable[[Mechanism, float], Mechanism]

#: How much of a part: of the beam's mass or inertia, of what damps or accelerates within a turn. Little beside the inertia of the finest
#: piece of a follower cut in eight, which is a five hundredth of the whole.
LITTLE = 1e-5
#: How far half of a part may be from half the change of all of it: far above the next order in most scenes, but little inertia at the base
#: of an undamped follower without any meets the straight line at 1e-5 only.
NEXT_ORDER = 0.1
TIGHT = replace(REFERENCE, settings=REFERENCE.settings.replaced(tolerance=1e-2 * TOLERANCE))


def beam_mass(m: Mechanism) -> float:
    return m.follower.mass_per_length * m.follower.length


def beam_inertia(m: Mechanism) -> float:
    return beam_mass(m) * m.follower.length**2 / 3.0


def speed(m: Mechanism) -> float:
    return abs(m.crank.drive.initial_speed)


def tip(m: Mechanism, mass: float, inertia: float = 0.0, offset: float = 0.0) -> Mechanism:
    """A body at the tip by its shares of the beam's mass and inertia and of the length; none without mass."""
    body = Tip(mass=mass * beam_mass(m), inertia=inertia * beam_inertia(m), center_of_mass=offset * m.follower.length)
    return replace(m, tip=body if mass > 0.0 else None)


def slider(m: Mechanism, mass: float = 0.0, inertia: float = 0.0) -> Mechanism:
    return replace(m, slider=replace(m.slider, mass=mass * beam_mass(m), inertia=inertia * beam_inertia(m)))


def crank_damping(m: Mechanism, share: float) -> Mechanism:
    drive = m.crank.drive
    assert isinstance(drive, TorqueDrive)
    return replace(m, crank=replace(m.crank, drive=replace(drive, damping=share * beam_inertia(m) * speed(m))))


def weight(m: Mechanism, share: float) -> Mechanism:
    size = share * m.crank.length * speed(m) ** 2
    return replace(m, gravity=(0.6 * size, -0.8 * size))


def base(m: Mechanism, inertia: float = 0.0, damping: float = 0.0, friction: float = 0.0) -> Mechanism:
    rate = speed(m)
    parts = {"inertia": inertia, "damping": damping * rate, "friction_torque": friction * rate**2}
    return replace(m, base=Base(**{name: value * beam_inertia(m) for name, value in parts.items()}))


def rubbing(m: Mechanism, friction: float = 0.0, drag: float = 0.0) -> Mechanism:
    sliding = m.crank.length * speed(m)
    own = {"friction": friction, "friction_force": drag * beam_mass(m) * sliding * speed(m), "friction_speed": sliding}
    return replace(m, slider=replace(m.slider, **own))


def material_damping(m: Mechanism, share: float) -> Mechanism:
    return replace(m, follower=replace(m.follower, material_damping=share / speed(m)))


def beam_damping(m: Mechanism, share: float) -> Mechanism:
    return replace(m, follower=replace(m.follower, damping=share * m.follower.mass_per_length * speed(m)))


PARTS: dict[str, Part] = {
    "slider mass": lambda m, share: slider(m, mass=share),
    "slider inertia": lambda m, share: slider(m, inertia=0.1 * share),
    "tip mass": lambda m, share: tip(m, share),
    "tip": lambda m, share: tip(m, share, 0.01 * share, 0.02),
    "tip inertia": lambda m, share: tip(m, 0.2, 0.1 * share),
    "tip offset": lambda m, share: tip(m, 0.2, 0.001, share),
    "base inertia": lambda m, share: base(m, inertia=share),
    "base damping": lambda m, share: base(m, damping=share),
    "base friction": lambda m, share: base(m, friction=share),
    "beam damping": beam_damping,
    "material damping": material_damping,
    "crank damping": crank_damping,
    "gravity": weight,
}
#: Friction along the follower: with a force that holds the slider, which knows its size, whether it rubs or not.
FRICTIONS: dict[str, Part] = {"friction": lambda m, share: rubbing(m, friction=share), "drag": lambda m, share: rubbing(m, drag=share)}
PLACES = ("crank_angle", "slider_position", "tip_x", "tip_y")
COLUMNS = (*PLACES, "follower_angle", "tip_deflection", "strain_2", "slider_force", "strain_energy")
#: What the joints of Exudyn and MuJoCo cannot carry.
FORCE_JOINT = tuple(name for name in PARTS if name not in ("slider inertia", "base friction", "material damping"))


def with_part(scene: Scene, part: str, share: float) -> Scene:
    return replace(scene, mechanism=(PARTS | FRICTIONS)[part](scene.mechanism, share))


def change(found: Trajectory, limit: Trajectory, unit: dict[str, float]) -> dict[str, Array]:
    """Difference of each column in its size (`tests.properties.runs.sizes`)."""
    return {name: (found[name] - limit[name]) / size for name, size in unit.items()}


def check_first_order_in_the_part(
    method: Method, part: str, scene: Scene, columns: tuple[str, ...], noise: float, whole: float = LITTLE
) -> None:
    """Half of the part, half the change; `noise` is what two runs of the same motion may differ by, in sizes."""
    lacking = with_part(scene, part, 0.0)
    without = method.run(lacking)
    unit = {name: size for name, size in sizes(lacking, without, method.half_waves).items() if name in columns}
    little, half = (change(method.run(with_part(scene, part, each)), without, unit) for each in (whole, 0.5 * whole))
    for name in unit:
        bound = NEXT_ORDER * np.max(np.abs(little[name])) + noise
        assert np.max(np.abs(little[name] - 2.0 * half[name])) <= bound, name


@pytest.mark.parametrize("part", PARTS)
@for_all(few=2, many=20, scene=scenes(drive="torque"))
def test_little_of_a_part_changes_little(part: str, scene: Scene) -> None:
    check_first_order_in_the_part(TIGHT, part, scene, COLUMNS, STEPS_ADD_UP * 1e-2 * TOLERANCE)


@pytest.mark.parametrize("part", FRICTIONS)
@for_all(few=2, many=20, scene=scenes(drive="torque"))
def test_little_friction_changes_little(part: str, scene: Scene) -> None:
    tight = replace(MULTIPLIER, settings=MULTIPLIER.settings.replaced(tolerance=1e-2 * TOLERANCE))
    check_first_order_in_the_part(tight, part, scene, COLUMNS, STEPS_ADD_UP * 1e-2 * TOLERANCE)


@pytest.mark.parametrize("part", FORCE_JOINT)
@pytest.mark.parametrize("method", [EXUDYN, MUJOCO], ids=str)
@for_all(few=1, many=5, scene=scenes(drive="torque"))
def test_little_of_a_part_changes_little_in_other_engines(method: Method, part: str, scene: Scene) -> None:
    """Their steps do not depend on the motion; Exudyn leaves Newton's iteration at a residual of 1e-6, sooner or later by one.

    MuJoCo's steps are as long as the chain allows: where the part changes their number the error of the steps changes, too. They damp
    nothing, so that the phase of the fastest vibration shows more of the next order.
    """
    noise, whole = (1e-6, LITTLE) if method is EXUDYN else (1e-9, 0.1 * LITTLE)
    if method is MUJOCO:
        assume(len({method.run(with_part(scene, part, share)).statistics["steps"] for share in (0.0, 0.5 * whole, whole)}) == 1)
    check_first_order_in_the_part(method, part, scene, PLACES, noise, whole)


#: Where the rigid limits are looked for. Strain, force and acceleration have none: what is stiffened vibrates the faster about
#: its equilibrium, by as much less, with the same forces.
TIP = ("tip_x", "tip_y")
ONE_MODE = replace(REFERENCE, settings=REFERENCE.settings.replaced(modes=1))
SPRING = Method(stiff_spring.ENGINE, StiffSpringSettings(shapes=4, tolerance=TOLERANCE), 4)
MULTIPLIER = Method(multiplier.ENGINE, MultiplierSettings(shapes=4, tolerance=TOLERANCE), 4)
#: Time constant of the joint's damper over the follower's own time: a tip recovered from equilibrium shows the slider force, which an
#: undamped stiff joint would make vibrate about its limit by as much as that is, however stiff the joint.
JOINT_TIME = 0.01
#: Of these times after which 2e-9 is left of what it begins with.
OVER = 20.0


def with_stiffness(scene: Scene, factor: float) -> Scene:
    follower = scene.mechanism.follower
    return scene.with_part(follower=replace(follower, bending_stiffness=factor * follower.bending_stiffness))


def with_joint(scene: Scene, factor: float) -> Scene:
    follower = scene.mechanism.follower
    stiffness = factor * follower.bending_stiffness / follower.length**3
    damping = joint_time(scene) * stiffness
    return scene.with_part(slider=replace(scene.mechanism.slider, joint_stiffness=stiffness, joint_damping=damping))


def joint_time(scene: Scene) -> float:
    """Time constant of the joint, s."""
    follower = scene.mechanism.follower
    return JOINT_TIME * follower.length**2 * math.sqrt(follower.mass_per_length / follower.bending_stiffness)


def check_first_order(rigid: Trajectory, stiff: Trajectory, stiffer: Trajectory, length: float, since: float = 0.0) -> None:
    """Four times the stiffness, a quarter of the distance, on average over a vibration that is not in phase, from a time (s) on."""
    rows = rigid["time"] >= since
    assert rows.sum() > 1
    for name in TIP:
        far, near = (float(np.sqrt(np.mean((found[name] - rigid[name])[rows] ** 2))) for found in (stiff, stiffer))
        floor = STEPS_ADD_UP * TOLERANCE * 0.1 * length
        assert near <= 0.5 * far + floor, name
        assert near >= 0.125 * far - floor, name


@for_all(few=2, many=20, scene=scenes(bent=False))
def test_a_stiff_follower_is_nearly_the_rigid_one(scene: Scene) -> None:
    rigid = ONE_MODE.run(with_stiffness(scene, math.inf))
    stiff, stiffer = (ONE_MODE.run(with_stiffness(scene, factor)) for factor in (1e3, 4e3))
    check_first_order(rigid, stiff, stiffer, scene.mechanism.follower.length)


@for_all(few=2, many=20, scene=scenes(bent=False))
def test_a_stiff_joint_is_nearly_the_rigid_one(scene: Scene) -> None:
    """A spring begins without the force that a rigid joint has at once, however stiff it is: that is over in its own time."""
    rigid = MULTIPLIER.run(scene)
    stiff, stiffer = (SPRING.run(with_joint(scene, factor)) for factor in (1e5, 4e5))
    check_first_order(rigid, stiff, stiffer, scene.mechanism.follower.length, since=OVER * joint_time(scene))
