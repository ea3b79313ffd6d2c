"""The scenes of the map: a grid over speed and tip, and the other groups varied at its centre."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

from quickreturn.cases.files.case import Case
from quickreturn.plugins.methods.classes.groups import Groups, scene_of

#: Values of `Groups.speed` and `Groups.tip` on the map.
SPEEDS: Final = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5)
TIPS: Final = (0.0, 0.5, 2.0)
#: Centre of the variations of the other groups; the damping is that of run 24, 0.0031, rounded.
CENTRE: Final = Groups(speed=0.2, tip=0.5, crank=0.25, damping=0.003, joint=math.inf)
#: Group -> its other values, and the speeds at which they are measured: damping matters where the arm rings, a soft joint at lower speeds.
VARIED: Final[Mapping[str, tuple[tuple[float, ...], tuple[float, ...]]]] = MappingProxyType(
    {"crank": ((0.15, 0.38), (0.05, 0.2, 0.5)), "damping": ((0.0, 0.03), (0.2, 0.5)), "joint": ((1000.0, 100.0), (0.05, 0.2))}
)
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
