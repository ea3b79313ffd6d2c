"""Which method, where: the fastest method in each class of machines, and by how much."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from quickreturn.plugins.methods.entrants import entrant
from quickreturn.plugins.methods.groups import CENTRE, MEANINGS, TURNS, name_of
from quickreturn.plugins.methods.map import LEVELS, TIMES, ClassScene, Map
from quickreturn.plugins.methods.row import REACHED, Row
from quickreturn.plugins.methods.studies import map_of
from quickreturn.reports.long_studies import about
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import Cell, Column, Table
from quickreturn.reports.words import duration, number, percent, size, times, won

#: Difference of two solutions of a scene beyond which numbers there are to be used with care.
BLUNT: Final = 0.1 * LEVELS[-1]
#: What the engine of that name is.
CHAIN: Final = " (mujoco is this project’s chain and time loop on MuJoCo)"
#: What an opponent would say of the race.
CHOSEN: Final = "; all settings are this project’s choice"


def classes(content: Content) -> Chapter | None:
    """The chapter; None if no map was recorded."""
    class_map = content.of(map_of)
    if not class_map.scenes:
        return None
    own = list(dict.fromkeys(trial.engine for trial in class_map.trials if entrant(trial).is_own))
    facts = {
        "of_record": about("classes"),
        "turns": TURNS,
        "winners": [winners(class_map, level, by) for level in LEVELS for by in TIMES],
        "own": own,
        "meanings": MEANINGS,
        "blunt": [each.name for each in class_map.scenes if each.difference is None or each.difference > BLUNT],
        "maps": {f"{by}, to {percent(level, 'g')}": map_table(class_map, level, by) for by in TIMES for level in LEVELS},
    }
    return Chapter("classes", "Which method, where", finding(class_map, own), facts)


def finding(class_map: Map, own: Sequence[str]) -> str:
    """The most frequent winner by solve time to the larger error and its lead, and those by waiting time; `own`: code of this project."""
    scenes, level = f"of {len(class_map.scenes)} classes of machines", LEVELS[0]
    by_solving, waited = (class_map.factors(level, by) for by in TIMES)
    text = f"No engine reaches {percent(level, 'g')} in any {scenes}"
    for name, factors in list(by_solving.items())[:1]:
        known = [factor for factor in factors if factor < math.inf]
        least = f"{number(min(known), '.2g')} to " if len(known) > 1 else ""
        lead = f"the next takes {least}{times(max(known))} as long" if known else "no other reaches it"
        code = ", this project’s own code," if name in own else ""
        text = f"{name}{code} solves fastest to {percent(level, 'g')} in {len(factors)} {scenes} ({lead})"
    return f"{text}; by waiting time, {_won(waited)}{CHAIN if 'mujoco' in waited else ''}{CHOSEN if own else ''}"


def _won(factors: Mapping[str, Sequence[float]]) -> str:
    return won({name: len(of_name) for name, of_name in factors.items()}) or "no engine in any class"


def winners(class_map: Map, level: float, by: str) -> str:
    """The winners to an error by one of `TIMES`, each with the number of its classes."""
    factors = class_map.factors(level, by)
    unwon = len(class_map.scenes) - sum(map(len, factors.values()))
    return f"{by}, to {percent(level, 'g')}: {_won(factors)}{f'; {unwon} nobody wins' if unwon else ''}."


def map_table(class_map: Map, level: float, by: str) -> Table:
    """The winner in each scene, the runner-up and how many times as long it takes; a row for each machine, a column for each speed."""
    speeds = sorted({scene.groups.speed for scene in class_map.scenes})
    table = Table(
        f"classes_map_{list(TIMES).index(by) + 1}_{level:g}",
        f"""The fastest method by {by}, to an error of {percent(level, "g")}; below it the runner-up, and how many times as long it takes.
        A click on a cell shows the times of all methods, or the reason why a method has none.""",
        ["machine", *(Column(f"speed {speed:g}", f"{speed:g}", group=MEANINGS["speed"]) for speed in speeds)],
    )
    lines: dict[str, dict[str, Cell]] = {}
    for scene in class_map.scenes:
        _, _, others = name_of(replace(scene.groups, speed=CENTRE.speed)).partition(", ")
        machine = (others or f"tip {CENTRE.tip:g}").replace("inf", "rigid")
        lines.setdefault(machine, {})[f"speed {scene.groups.speed:g}"] = _cell(class_map, scene, level, by)
    for machine, of_speeds in lines.items():
        table.add(machine=machine, **of_speeds)
    return table


def _cell(class_map: Map, scene: ClassScene, level: float, by: str) -> Cell:
    """The winner and the runner-up; the remark lists all engines."""
    trials, ranked = class_map.at(scene, level), class_map.ranked(scene, level, by)
    note = (
        "; ".join([*(f"{name} {duration(seconds)}" for name, seconds in ranked.items()), *_without_time(trials, ranked)]) or scene.failure
    )
    if not ranked:
        return Cell("nobody" if trials else "no solution", note=note, mark="open")
    (winner, first), (other, second) = [*ranked.items(), ("", math.inf)][:2]
    return Cell(winner, f"{winner}\n{number(second / first, '.2g')}× {other}" if other else winner, note)


def _without_time(trials: Sequence[Row], ranked: Mapping[str, float]) -> Iterator[str]:
    """The reason why each other engine has no time."""
    for trial in (each for each in trials if each.engine not in ranked):
        left = f" ({size(trial.error)} left)" if trial.error is not None else ""
        unknown = f"reaches it, but its own estimate does not show it ({trial.remark})"
        yield f"{trial.engine} {unknown if trial.status == REACHED else f'{trial.status}{left}'}"
