"""Tables of the map of classes: who is first where, where each method fails, and every cell."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from quickreturn.cases.classes.grid import CENTRE, name_of
from quickreturn.cases.classes.map import STATUSES, TIMES, Map
from quickreturn.cases.classes.measurement import LEVELS, REACHED, Reach
from quickreturn.cases.classes.study import ClassScene
from quickreturn.reports.looks import looks
from quickreturn.reports.tables.table import Cell, Column, Table
from quickreturn.reports.words import counted, duration, number, percent, size

#: The part of the winner's colour in a cell: of a runner-up that is as fast, and of one that takes ten times as long or more.
_PALE, _FULL = 8, 34
_SPEED: Final = "crank speed over the lowest bending frequency"


def class_map(known: Map, level: float, by: str) -> Table:
    """The winner in each scene, how many times as long the runner-up takes, and who that is; a row for each machine, a column a speed."""
    speeds = sorted({scene.groups.speed for scene in known.scenes})
    columns = [Column("machine"), *(Column(f"speed {speed:g}", f"{speed:g}", group=_SPEED) for speed in speeds)]
    of = f"_{list(TIMES).index(by) + 1}_{level:g}"
    table = Table("classes_map", columns, of, by=by, level=percent(level, "g"))
    lines: dict[str, dict[str, Cell]] = {}
    for scene in known.scenes:
        lines.setdefault(_machine(scene), {})[f"speed {scene.groups.speed:g}"] = _cell(known, scene, level, by)
    for machine, cells in lines.items():
        table.add(machine=machine, **cells)
    return table


def _machine(scene: ClassScene) -> str:
    """What tells a row of the map from the others."""
    _, _, others = name_of(replace(scene.groups, speed=CENTRE.speed)).partition(", ")
    return (others or f"tip {CENTRE.tip:g}").replace("inf", "rigid")


def _cell(known: Map, scene: ClassScene, level: float, by: str) -> Cell:
    """The winner and the runner-up; the remark has everybody. The winner's colour is the stronger the farther the runner-up is behind."""
    reaches, ranked = known.at(scene, level), known.ranked(scene, level, by)
    lost = [_lost(reach) for reach in reaches if reach.engine not in ranked]
    note = "; ".join([*(f"{name} {duration(seconds)}" for name, seconds in ranked.items()), *lost]) or scene.failure
    if not ranked:
        return Cell("nobody" if reaches else "no solution", note=note, mark="open")
    (winner, first), (other, second) = [*ranked.items(), ("", math.inf)][:2]
    told, look = (f"{winner}\n{number(second / first, '.2g')}× {other}" if other else winner), looks([winner])[winner]
    share = _PALE + (_FULL - _PALE) * min(1.0, math.log10(second / first))
    tint = f"color-mix(in srgb, light-dark({look.light}, {look.dark}) {share:.0f}%, transparent)"
    return Cell(winner, told, note, tint=tint)


def _lost(reach: Reach) -> str:
    """What kept an engine from a time."""
    if reach.status != REACHED:
        return f"{reach.engine} {reach.status}" + (f" ({size(reach.error)} left)" if reach.error is not None else "")
    return f"{reach.engine} gets there and does not know it ({reach.remark})"


def failing(known: Map) -> Table:
    """In how many scenes each method gets to each error, and what keeps it from it in the others."""
    heads = [Column(status.replace(" ", "_"), status, form="d") for status in STATUSES]
    unknown = Column("unclaimed", "reached, not known", form="d")
    table = Table("classes_failing", (Column("method"), Column("level", "error", "%", "g"), *heads, unknown))
    for engine in dict.fromkeys(reach.engine for reach in known.reaches):
        for level in LEVELS:
            here = [reach for reach in known.reaches if (reach.engine, reach.level) == (engine, level)]
            cells = {status.replace(" ", "_"): _count([each for each in here if each.status == status]) for status in STATUSES}
            silent = [each for each in here if each.status == REACHED and each.waited_seconds is None]
            table.add(method=engine, level=level, unclaimed=_count(silent), **cells)
    return table


def _count(reaches: Sequence[Reach]) -> Cell:
    """A number of scenes; its remark tells which, and the first reason that there is."""
    reason = next((f": {each.remark}" for each in reaches if each.remark), "")
    return Cell(len(reaches), note="; ".join(each.scene for each in reaches) + reason)


def cells(known: Map) -> Table:
    """Every method in every scene at every error, with the scene's groups."""
    groups = [Column(name, form="g") for name in vars(CENTRE)]
    seconds = [Column(time, unit="s", form=".3g") for time in TIMES.values()]
    columns: list[Column | str] = ["scene", *groups, Column("difference", "sharp to", "1", ".1e"), "engine"]
    columns += [Column("level", "error", "%", "g"), "status", *seconds, Column("error", "delivered", "%", ".2g"), "remark"]
    table = Table("classes", columns, in_page=False, scenes=counted(len(known.scenes), "scene"))
    for scene in known.scenes:
        shared: dict[str, Any] = {**vars(scene.groups), "difference": scene.difference}
        for level in LEVELS:
            for reach in known.at(scene, level):
                table.add(reach, **shared)
    return table
