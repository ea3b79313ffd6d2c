"""Tables of the map of methods over classes of machines: the winners, the failures of each method, and every cell."""

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

#: Strength of the winner's colour in a cell, %: for a runner-up that is as fast, and for one that takes ten times as long or more.
_PALE, _FULL = 8, 34
_SPEED: Final = "crank speed over the lowest bending frequency"


def class_map(classes: Map, level: float, by: str) -> Table:
    """The winner in each scene, the runner-up and how many times as long it takes; a row for each machine, a column for each speed."""
    speeds = sorted({scene.groups.speed for scene in classes.scenes})
    columns = [Column("machine"), *(Column(f"speed {speed:g}", f"{speed:g}", group=_SPEED) for speed in speeds)]
    suffix = f"_{list(TIMES).index(by) + 1}_{level:g}"
    table = Table("classes_map", columns, suffix, by=by, level=percent(level, "g"))
    lines: dict[str, dict[str, Cell]] = {}
    for scene in classes.scenes:
        lines.setdefault(_machine(scene), {})[f"speed {scene.groups.speed:g}"] = _cell(classes, scene, level, by)
    for machine, cells in lines.items():
        table.add(machine=machine, **cells)
    return table


def _machine(scene: ClassScene) -> str:
    """The text that distinguishes a row of the map from the others."""
    _, _, others = name_of(replace(scene.groups, speed=CENTRE.speed)).partition(", ")
    return (others or f"tip {CENTRE.tip:g}").replace("inf", "rigid")


def _cell(classes: Map, scene: ClassScene, level: float, by: str) -> Cell:
    """The winner and the runner-up; the remark lists all engines. The winner's colour is stronger the larger its lead."""
    reaches, ranked = classes.at(scene, level), classes.ranked(scene, level, by)
    without_time = [_why_no_time(reach) for reach in reaches if reach.engine not in ranked]
    note = "; ".join([*(f"{name} {duration(seconds)}" for name, seconds in ranked.items()), *without_time]) or scene.failure
    if not ranked:
        return Cell("nobody" if reaches else "no solution", note=note, mark="open")
    (winner, first), (other, second) = [*ranked.items(), ("", math.inf)][:2]
    text, look = (f"{winner}\n{number(second / first, '.2g')}× {other}" if other else winner), looks([winner])[winner]
    share = _PALE + (_FULL - _PALE) * min(1.0, math.log10(second / first))
    tint = f"color-mix(in srgb, light-dark({look.light}, {look.dark}) {share:.0f}%, transparent)"
    return Cell(winner, text, note, tint=tint)


def _why_no_time(reach: Reach) -> str:
    """The reason why an engine has no time."""
    if reach.status != REACHED:
        return f"{reach.engine} {reach.status}" + (f" ({size(reach.error)} left)" if reach.error is not None else "")
    return f"{reach.engine} reaches it, but its own estimate does not show it ({reach.remark})"


def failing(classes: Map) -> Table:
    """The number of scenes in which each method reaches each error, and the reasons why not in the others."""
    heads = [Column(status.replace(" ", "_"), status, form="d") for status in STATUSES]
    unknown = Column("unclaimed", "reached, not known", form="d")
    table = Table("classes_failing", (Column("method"), Column("level", "error", "%", "g"), *heads, unknown))
    for engine in dict.fromkeys(reach.engine for reach in classes.reaches):
        for level in LEVELS:
            here = [reach for reach in classes.reaches if (reach.engine, reach.level) == (engine, level)]
            cells = {status.replace(" ", "_"): _count([reach for reach in here if reach.status == status]) for status in STATUSES}
            silent = [reach for reach in here if reach.status == REACHED and reach.waited_seconds is None]
            table.add(method=engine, level=level, unclaimed=_count(silent), **cells)
    return table


def _count(reaches: Sequence[Reach]) -> Cell:
    """A number of scenes; its remark names them and the first reason."""
    reason = next((f": {reach.remark}" for reach in reaches if reach.remark), "")
    return Cell(len(reaches), note="; ".join(reach.scene for reach in reaches) + reason)


def cells(classes: Map) -> Table:
    """Every method in every scene at every error, with the scene's groups."""
    groups = [Column(name, form="g") for name in vars(CENTRE)]
    seconds = [Column(time, unit="s", form=".3g") for time in TIMES.values()]
    columns: list[Column | str] = ["scene", *groups, Column("difference", "sharp to", "1", ".1e"), "engine"]
    columns += [Column("level", "error", "%", "g"), "status", *seconds, Column("error", "delivered", "%", ".2g"), "remark"]
    table = Table("classes", columns, in_page=False, scenes=counted(len(classes.scenes), "scene"))
    for scene in classes.scenes:
        shared: dict[str, Any] = {**vars(scene.groups), "difference": scene.difference}
        for level in LEVELS:
            for reach in classes.at(scene, level):
                table.add(reach, **shared)
    return table
