"""The map of classes: who is first where, by what, and where a machine lies on it."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

from cases.classes.groups import Groups
from cases.classes.measurement import FAILED, LEVELS, NOT_REACHED, REACHED, REFUSED, TOO_SLOW, Reach
from cases.classes.study import Scene
from cases.library.thesis import run_case
from reference_model.mechanism import Mechanism
from reference_model.scene_values import NAMED, values_of

#: What times are compared by -> the field of `Reach` with the time.
TIMES: Final[Mapping[str, str]] = MappingProxyType({"solving alone": "solve_seconds", "all that one waits for": "waited_seconds"})
SOLVING, WAITING = TIMES
#: What a method can come to, as `Reach.status` has it.
STATUSES: Final = (REACHED, NOT_REACHED, TOO_SLOW, FAILED, REFUSED)
#: What makes up one step between machines, in the logarithm or in the square root of a group: about a row or a column of the map.
_STEPS: Final = {"speed": math.log(2.0), "tip": 0.7, "crank": math.log(1.5), "damping": 0.1, "joint": math.log(10.0)}
#: A joint stiffness over EI/L^3 from which a joint is as good as rigid: at ten times the stiffest one of the map.
_STIFF: Final = 1e4

#: Quantities of a case file that the groups stand for.
_GROUPED: Final = frozenset(
    {"crank.torque", "crank.prescribed_speed", "base.damping", "follower.damping", "follower.material_damping", "slider.joint_stiffness"}
)
#: Part by which a ratio of lengths may differ from the map's and still be called the same.
_SIMILAR: Final = 0.05


@dataclass(frozen=True)
class Place:
    """The engines that get to an error in a scene, fastest first, each with its time (s)."""

    scene: Scene
    ranked: Sequence[tuple[str, float]]

    @property
    def winner(self) -> str:
        """The fastest engine, "" where none gets there."""
        return self.ranked[0][0] if self.ranked else ""

    @property
    def factor(self) -> float:
        """Time of the runner-up over that of the winner; infinite without one."""
        return self.ranked[1][1] / self.ranked[0][1] if len(self.ranked) > 1 else math.inf


@dataclass(frozen=True)
class Map:
    """Scenes, and what each method reached on each of them; both may be empty."""

    scenes: tuple[Scene, ...] = ()
    reaches: tuple[Reach, ...] = ()
    _by_scene: dict[tuple[str, float], list[Reach]] = field(init=False, default_factory=dict, compare=False, repr=False)

    def __post_init__(self) -> None:
        for reach in self.reaches:
            self._by_scene.setdefault((reach.scene, reach.level), []).append(reach)

    def at(self, scene: Scene, level: float) -> list[Reach]:
        """What is known of each method on a scene, in the engines' order."""
        return self._by_scene.get((scene.name, level), [])

    def place(self, scene: Scene, level: float, by: str) -> Place:
        """Who gets to an error on a scene, by one of `TIMES`."""
        times = [(reach.engine, seconds) for reach in self.at(scene, level) if (seconds := getattr(reach, TIMES[by])) is not None]
        return Place(scene, sorted(times, key=lambda found: found[1]))

    def places(self, level: float, by: str) -> list[Place]:
        """The same of all scenes."""
        return [self.place(scene, level, by) for scene in self.scenes]

    def wins(self, level: float, by: str) -> dict[str, int]:
        """Engine -> in how many scenes it is the fastest, the most frequent winner first."""
        return dict(Counter(place.winner for place in self.places(level, by) if place.ranked).most_common())

    def nearest(self, groups: Groups) -> Scene:
        """The scene whose groups are the least steps away. ValueError: the map is empty."""
        return min(self.scenes, key=lambda scene: distance(scene.groups, groups))

    def outside(self, groups: Groups) -> dict[str, tuple[float, float]]:
        """The groups in which a machine lies outside of all scenes, each with its range on the map."""
        ranges = {name: [getattr(scene.groups, name) for scene in self.scenes] for name in vars(groups)}
        found = {name: (min(values), max(values)) for name, values in ranges.items()}
        return {name: (low, high) for name, (low, high) in found.items() if not 0.999 * low <= getattr(groups, name) <= 1.001 * high}


def distance(one: Groups, other: Groups) -> float:
    """How far two machines are from each other, in steps of the map."""
    return math.hypot(*((_scaled(name, one) - _scaled(name, other)) / step for name, step in _STEPS.items()))


def _scaled(name: str, groups: Groups) -> float:
    value = getattr(groups, name)
    if name in ("tip", "damping"):  # which may be zero
        return math.sqrt(value)
    return math.log(min(value, _STIFF) if name == "joint" else value)


def level_for(accuracy: float) -> float | None:
    """The loosest of `LEVELS` that is as tight as an accuracy; None where none is."""
    return max((level for level in LEVELS if level <= accuracy), default=None)


def off_the_map(mechanism: Mechanism) -> list[str]:
    """Sentences on what a machine has and no scene of the map: nothing is known of what that does to the methods."""
    found = []
    for section, values in values_of(mechanism).items():
        for key, value in values.items():
            name = f"{section}.{key}"
            if name in NAMED and name not in _GROUPED and value != NAMED[name].default:
                found.append(f"{name} is given, and no scene of the map has it")
    if (mechanism.slider.is_linear, mechanism.slider.is_rigid) == (False, False):
        found.append("the slider's joint is not one linear spring, as all soft joints of the map are")
    reach, usual = (each.follower.length / each.pivot_distance for each in (mechanism, run_case(24).mechanism))
    if abs(reach / usual - 1.0) > _SIMILAR:
        found.append(f"follower.length over mechanism.pivot_distance is {reach:.3g}, on the map it is {usual:.3g}")
    return found
