"""The map of classes: what each engine needs in each scene, the winners by each time, and the place of a machine on the map."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

from quickreturn.cases.library import library_case
from quickreturn.plugins.methods.fronts import DEFLECTION, standings
from quickreturn.plugins.methods.groups import Groups
from quickreturn.plugins.methods.race import SLOW, Race
from quickreturn.plugins.methods.row import FAILED, NOT_REACHED, REACHED, REFUSED, TIP, TOO_SLOW, Row, essential
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import NAMED, values_of

#: Errors of the tip deflection at which the map compares engines.
LEVELS: Final = (1e-2, 1e-3)
#: Name of a compared time -> the attribute of a row with it.
TIMES: Final[Mapping[str, str]] = MappingProxyType({"solve time": "solve_seconds", "waiting time": "answer_seconds"})
#: Values of a row's status.
STATUSES: Final = (REACHED, NOT_REACHED, TOO_SLOW, FAILED, REFUSED)
#: Group -> place of a value on an axis whose unit is about a row or a column of the map. Tip and damping may be zero; a joint that is ten
#: times as stiff as the stiffest of the map counts as rigid.
_AXES: Final[Mapping[str, Callable[[float], float]]] = MappingProxyType(
    {
        "speed": math.log2,
        "tip": lambda value: math.sqrt(value) / 0.7,
        "crank": lambda value: math.log(value) / math.log(1.5),
        "damping": lambda value: math.sqrt(value) / 0.1,
        "joint": lambda value: math.log10(min(value, 1e4)),
    }
)
#: Quantities of a case file that the groups contain.
_GROUPED: Final = frozenset(
    {"crank.torque", "crank.prescribed_speed", "base.damping", "follower.damping", "follower.material_damping", "slider.joint_stiffness"}
)
#: Relative difference up to which a ratio of lengths counts as that of the map.
_SIMILAR: Final = 0.05


@dataclass(frozen=True)
class ClassScene:
    """A scene of the map."""

    name: str  # see `groups.name_of`
    groups: Groups
    # difference of the confirming solution's tip deflection from the one that defines errors; None if there is none
    difference: float | None = None
    failure: str = ""  # why there is no solution; "" if there is one


@dataclass(frozen=True)
class Map:
    """Scenes, and the result of each engine on each of them; both may be empty."""

    scenes: tuple[ClassScene, ...] = ()
    trials: tuple[Row, ...] = ()

    def at(self, scene: ClassScene, level: float) -> list[Row]:
        """The results of all methods on a scene, in the engines' order."""
        return [trial for trial in self.trials if (trial.scene, trial.level) == (scene.name, level)]

    def ranked(self, scene: ClassScene, level: float, by: str) -> dict[str, float]:
        """The engines that reach an error on a scene, each with its time (s) by one of `TIMES`, fastest first."""
        times = {trial.engine: seconds for trial in self.at(scene, level) if (seconds := getattr(trial, TIMES[by])) is not None}
        return dict(sorted(times.items(), key=lambda item: item[1]))

    def factors(self, level: float, by: str) -> dict[str, list[float]]:
        """Winner -> the runner-up's time over its own in each scene that it wins (infinite without one), the most frequent winner first."""
        factors: dict[str, list[float]] = {}
        for ranked in (self.ranked(scene, level, by) for scene in self.scenes):
            if ranked:
                first, second, *_ = *ranked.values(), math.inf
                factors.setdefault(next(iter(ranked)), []).append(second / first)
        return dict(sorted(factors.items(), key=lambda item: -len(item[1])))

    def nearest(self, groups: Groups) -> tuple[ClassScene, float]:
        """The nearest scene, and its distance in steps. ValueError: the map is empty."""
        return min(((scene, distance(scene.groups, groups)) for scene in self.scenes), key=lambda pair: pair[1])

    def outside(self, groups: Groups) -> dict[str, tuple[float, float]]:
        """The groups in which a machine lies outside all scenes, each with its range on the map."""
        values = {name: [getattr(scene.groups, name) for scene in self.scenes] for name in vars(groups)}
        ranges = {name: (min(of_scenes), max(of_scenes)) for name, of_scenes in values.items()}
        return {name: (low, high) for name, (low, high) in ranges.items() if not 0.999 * low <= getattr(groups, name) <= 1.001 * high}


def distance(one: Groups, other: Groups) -> float:
    """The distance of two machines, in steps of the map."""
    return math.hypot(*(place(getattr(one, name)) - place(getattr(other, name)) for name, place in _AXES.items()))


def off_the_map(mechanism: Mechanism) -> list[str]:
    """Sentences on features of a machine that no scene of the map has: their effect on the methods is unknown."""
    given = {f"{section}.{key}": value for section, values in values_of(mechanism).items() for key, value in values.items()}
    others = [name for name, value in given.items() if name in NAMED and name not in _GROUPED and value != NAMED[name].default]
    sentences = [f"{name} is given, but no scene of the map has it" for name in others]
    reach, usual = (each.follower.length / each.pivot_distance for each in (mechanism, library_case("thesis-24").mechanism))
    if abs(reach / usual - 1.0) > _SIMILAR:
        sentences.append(f"follower.length over mechanism.pivot_distance is {reach:.3g}, on the map it is {usual:.3g}")
    return sentences


def condensed(found: Race) -> list[Row]:
    """For each engine and level of the map a row: the time of its fastest combination at the level, and that of its own answer."""
    engines = dict.fromkeys(row.engine for row in found.rows)
    rows = {name: [row for row in found.rows if row.engine == name] for name in engines}
    return [essential(_condensed(found.case, rows[name], level)) for name in engines for level in LEVELS]


def _condensed(scene: str, rows: Sequence[Row], level: float) -> Row:
    """The row of an engine at a level, from its rows in a scene."""
    given = [row for row in rows if row.level is None]
    answer = next((row for row in rows if row.level == level), Row(scene=scene, engine=rows[0].engine))
    waited = answer.answer_seconds if answer.status == REACHED else None
    row = Row(scene=scene, engine=answer.engine, level=level, claim=answer.claim, answer_seconds=waited)
    for first in standings(given, level, DEFLECTION).values():
        why = answer.remark or answer.status if waited is None else ""
        row = replace(row, status=REACHED, remark=why, solve_seconds=first.seconds, errors={TIP: first.row.error}, calls=first.calls)
        return replace(row, variant=first.row.variant, settings=first.row.settings)
    if answer.status == REFUSED or not given:
        return replace(row, status=answer.status, remark=answer.remark)
    least = min((error for each in given if (error := each.error) is not None), default=None)
    slow = any(each.status == SLOW for each in given)
    status = TOO_SLOW if slow else FAILED if least is None else NOT_REACHED
    return replace(row, status=status, remark=answer.remark, errors={} if least is None else {TIP: least})
