"""A mechanism in dimensionless groups, which define classes of machines, and the scenes of the map of classes.

By similarity two machines with the same groups move alike: lengths scale with the follower's, times with the period of its lowest mode.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.library import library_case
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import stiffness_ratio
from quickreturn.reference_model.rigid import crank_pace, mean_crank_speed
from quickreturn.reference_model.scene_values import changed

#: Square of the tip body's radius of gyration over that of the follower's length: the thesis' plates, 0.068 in^2 and 25 in (table 5.1).
GYRATION: Final = 0.068 / 25.0**2


@dataclass(frozen=True)
class Groups:
    """The groups of a machine."""

    speed: float  # crank's frequency over the lowest natural frequency of the follower with the crank held, the least over its angle
    tip: float  # mass of the tip body over that of the arm
    crank: float  # crank's length over the distance of the pivots
    # damping ratio of the lowest mode: from the arm's own damping as if there were no tip body, and from the pivot's as if the arm turned
    # as a whole
    damping: float
    joint: float  # stiffness of the slider's joint over EI / L^3 of the arm; infinite if it is rigid


#: Group -> its definition in words.
MEANINGS: Final[Mapping[str, str]] = {
    "speed": "crank speed over the lowest bending frequency",
    "tip": "tip mass over arm mass",
    "crank": "crank length over pivot distance",
    "damping": "damping ratio of the lowest mode",
    "joint": "joint stiffness over EI/L^3 of the arm",
}


def scene_of(groups: Groups) -> Mechanism:
    """The thesis' arm with a crank, a tip, a damping, a joint and a prescribed speed that give these groups.

    Raises:
        ImpossibleMechanism: the slider would leave the follower, or the crank reach the pivot.
    """
    base = library_case("thesis-24").mechanism
    arm, mass = base.follower, groups.tip * base.follower.mass
    changes = {
        "crank.length": groups.crank * base.pivot_distance,
        "crank.prescribed_speed": 1.0,
        "base.damping": 0.0,
        "tip": None,
        "slider": None,
        "slider.joint_stiffness": groups.joint * arm.bending_stiffness / arm.length**3,
    }
    slow = changed(base, changes | ({"tip.mass": mass, "tip.inertia": mass * GYRATION * arm.length**2} if mass else {}))
    lowest = stiffness_ratio(slow)  # at a speed of 1 rad/s this is the angular frequency of the lowest mode, rad/s
    damping = 2.0 * groups.damping * lowest * arm.mass_per_length
    return changed(slow, {"crank.prescribed_speed": groups.speed * lowest, "follower.damping": damping})


def groups_of(mechanism: Mechanism) -> Groups | None:
    """The groups of a mechanism; None if it has no bending frequency or does not turn."""
    ratio, arm = stiffness_ratio(mechanism), mechanism.follower
    if ratio == 0.0:
        return None
    lowest = ratio * crank_pace(mechanism)
    rates = arm.damping / arm.mass_per_length + mechanism.base.damping / (arm.mass * arm.length**2 / 3.0)
    return Groups(
        speed=abs(mean_crank_speed(mechanism)) / lowest,
        tip=mechanism.tip_body.mass / arm.mass,
        crank=mechanism.crank.length / mechanism.pivot_distance,
        damping=0.5 * (rates / lowest + arm.material_damping * lowest),
        joint=min(mechanism.slider.sides) * arm.length**3 / arm.bending_stiffness,
    )


#: Values of `Groups.speed` and `Groups.tip` on the map.
SPEEDS: Final = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5)
TIPS: Final = (0.0, 0.5, 2.0)
#: Centre of the variations of the other groups; the damping is that of run 24, 0.0031, rounded.
CENTRE: Final = Groups(speed=0.2, tip=0.5, crank=0.25, damping=0.003, joint=math.inf)
#: Group -> its other values, and the speeds at which they are measured: damping matters where the arm rings, a soft joint at lower speeds.
VARIED: Final[Mapping[str, tuple[tuple[float, ...], tuple[float, ...]]]] = {
    "crank": ((0.15, 0.38), (0.05, 0.2, 0.5)),
    "damping": ((0.0, 0.03), (0.2, 0.5)),
    "joint": ((1000.0, 100.0), (0.05, 0.2)),
}
#: Duration of a scene, in turns of the crank, and number of output steps in it.
TURNS: Final = 1
ROWS: Final = 1000


def grid() -> Iterator[Groups]:
    """The groups of all scenes, row by row of the map; a row is one machine at several speeds."""
    for tip in TIPS:
        yield from (replace(CENTRE, tip=tip, speed=speed) for speed in SPEEDS)
    for group, (values, speeds) in VARIED.items():
        for value in values:
            yield from (replace(CENTRE, speed=speed, **{group: value}) for speed in speeds)


def name_of(groups: Groups) -> str:
    """A short name, such as "speed 0.2, tip 2": speed, and the groups that differ from the centre."""
    others = [f"{group} {value:g}" for group, value in vars(groups).items() if group != "speed" and value != getattr(CENTRE, group)]
    return ", ".join([f"speed {groups.speed:g}", *others])


def case_of(groups: Groups) -> Case:
    """The case of a scene: `TURNS` of the crank from the standard start."""
    scene = scene_of(groups)
    duration = TURNS * 2.0 * math.pi / scene.crank.drive.initial_speed
    return Case(name=name_of(groups), title="", tags=(), scene=scene, duration=duration, output_step=duration / ROWS)
