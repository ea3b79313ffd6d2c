"""The map of classes: what each engine needs in each scene, the winners by each time, and the place of a machine on the map."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Final

from quickreturn.plugins.methods.fronts import DEFLECTION, standings
from quickreturn.plugins.methods.groups import Groups
from quickreturn.plugins.methods.race import SLOW, Race
from quickreturn.plugins.methods.row import FAILED, NOT_REACHED, REACHED, REFUSED, TIP, TOO_SLOW, Row

#: Errors of the tip deflection at which the map compares engines.
LEVELS: Final = (1e-2, 1e-3)
#: Name of a compared time -> the attribute of a row with it.
TIMES: Final[Mapping[str, str]] = {"solve time": "solve_seconds", "waiting time": "answer_seconds"}
#: Group -> place of a value on an axis whose unit is about a row or a column of the map. Tip and damping may be zero; a joint that is ten
#: times as stiff as the stiffest of the map counts as rigid.
_AXES: Final[Mapping[str, Callable[[float], float]]] = {
    "speed": math.log2,
    "tip": lambda value: math.sqrt(value) / 0.7,
    "crank": lambda value: math.log(value) / math.log(1.5),
    "damping": lambda value: math.sqrt(value) / 0.1,
    "joint": lambda value: math.log10(min(value, 1e4)),
}


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
        """The nearest scene, and its distance in steps of the map. ValueError: the map is empty."""

        def steps(scene: ClassScene) -> float:
            return math.hypot(*(place(getattr(scene.groups, name)) - place(getattr(groups, name)) for name, place in _AXES.items()))

        return (nearest := min(self.scenes, key=steps)), steps(nearest)


def condensed(found: Race) -> Iterator[Row]:
    """For each engine and level of the map a row: the time of its fastest combination at the level, and that of its own answer."""
    for name, level in product(dict.fromkeys(row.engine for row in found.rows), LEVELS):
        given = [row for row in found.given if row.engine == name]
        row = Row(scene=found.case, engine=name, level=level)
        answer = next((each for each in found.rows if (each.engine, each.level) == (name, level)), row)
        waited = answer.answer_seconds if answer.status == REACHED else None
        row = replace(row, claim=answer.claim, answer_seconds=waited)
        if at := next(iter(standings(given, level, DEFLECTION).values()), None):
            why = answer.remark or answer.status if waited is None else ""
            row = replace(row, status=REACHED, remark=why, solve_seconds=at.seconds, errors={TIP: at.row.error}, calls=at.calls)
            yield replace(row, variant=at.row.variant, settings=at.row.settings)
        elif answer.status == REFUSED or not given:
            yield replace(row, status=answer.status, remark=answer.remark)
        else:
            least = min((error for each in given if (error := each.error) is not None), default=None)
            slow = any(each.status == SLOW for each in given)
            status = TOO_SLOW if slow else FAILED if least is None else NOT_REACHED
            yield replace(row, status=status, remark=answer.remark, errors={} if least is None else {TIP: least})
