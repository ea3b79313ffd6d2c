"""Which method, where: the fastest method in each class of machines, and where each method fails."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from quickreturn.plugins.methods.chapters.methods import is_own
from quickreturn.plugins.methods.groups import CENTRE, MEANINGS, TURNS, grid, name_of
from quickreturn.plugins.methods.map import LEVELS, STATUSES, TIMES, ClassScene, Map
from quickreturn.plugins.methods.row import REACHED, Row
from quickreturn.plugins.methods.studies import map_of
from quickreturn.reports.line_styles import looks
from quickreturn.reports.long_studies import about
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import Cell, Column, Table
from quickreturn.reports.words import duration, number, percent, size, times, won

#: Strength of the winner's colour in a cell, %: for a runner-up that is as fast, and for one that takes ten times as long or more.
_PALE, _FULL = 8, 34
#: What the engine of that name is.
CHAIN: Final = " (mujoco is this project’s chain and time loop on MuJoCo)"
#: What an opponent would say of the race.
CHOSEN: Final = "; all settings are this project’s choice"
_SPEED: Final = "crank speed over the lowest bending frequency"


def classes(content: Content) -> Chapter | None:
    """The chapter; None if no map was recorded."""
    class_map = content.of(map_of)
    if not class_map.scenes:
        return None
    own = [name for name in dict.fromkeys(trial.engine for trial in class_map.trials) if is_own(name)]
    facts = {
        "of_record": about("classes"),
        "turns": TURNS,
        "winners": [winners(class_map, level, by) for level in LEVELS for by in TIMES],
        "own": own,
        "meanings": MEANINGS,
        "blunt": blunt(class_map),
        "maps": [(f"{by}, to {percent(level, 'g')}", map_table(class_map, level, by)) for by in TIMES for level in LEVELS],
        "failing": failing(class_map),
    }
    return Chapter("classes", "Which method, where", finding(class_map, own), facts)


def finding(class_map: Map, own: Sequence[str]) -> str:
    """The most frequent winner by solve time to the larger error and its lead, and the winners by waiting time; `own`: see `is_own`."""
    scenes, level = len(class_map.scenes), LEVELS[0]
    by_solving, waited = (class_map.factors(level, by) for by in TIMES)
    of_classes = f"of {scenes} classes of machines"
    text = f"No engine reaches {percent(level, 'g')} in any {of_classes}"
    if by_solving:
        name, factors = next(iter(by_solving.items()))
        code = ", this project’s own code," if name in own else ""
        text = f"{name}{code} solves fastest to {percent(level, 'g')} in {len(factors)} {of_classes} ({_lead(factors)})"
    missing = len(list(grid())) - scenes
    unrecorded = f"; {missing} more classes of the map are not recorded" if missing else ""
    return f"{text}; by waiting time, {_won(waited)}{CHAIN if 'mujoco' in waited else ''}{unrecorded}{CHOSEN if own else ''}"


def _won(factors: Mapping[str, Sequence[float]]) -> str:
    return won({name: len(of_name) for name, of_name in factors.items()}) or "no engine in any class"


def _lead(factors: Sequence[float]) -> str:
    """How much longer the runner-up takes, where another engine reaches the error."""
    known = [factor for factor in factors if factor < math.inf]
    if not known:
        return "no other reaches it"
    least = f"{number(min(known), '.2g')} to " if len(known) > 1 else ""
    return f"the next takes {least}{times(max(known))} as long"


def winners(class_map: Map, level: float, by: str) -> str:
    """The winners to an error by one of `TIMES`, each with the number of its classes."""
    factors = class_map.factors(level, by)
    unwon = len(class_map.scenes) - sum(map(len, factors.values()))
    return f"{by}, to {percent(level, 'g')}: {_won(factors)}{f'; {unwon} nobody wins' if unwon else ''}."


def blunt(class_map: Map) -> list[str]:
    """Scenes whose solution no second formulation confirms to a tenth of the smaller error."""
    return [scene.name for scene in class_map.scenes if scene.difference is None or scene.difference > 0.1 * LEVELS[-1]]


def map_table(class_map: Map, level: float, by: str) -> Table:
    """The winner in each scene, the runner-up and how many times as long it takes; a row for each machine, a column for each speed."""
    speeds = sorted({scene.groups.speed for scene in class_map.scenes})
    columns = [Column("machine"), *(Column(f"speed {speed:g}", f"{speed:g}", group=_SPEED) for speed in speeds)]
    table = Table(
        f"classes_map_{list(TIMES).index(by) + 1}_{level:g}",
        f"""The fastest method by {by}, to an error of {percent(level, "g")}; below it the runner-up, and how many times as long it takes.
        The colour is the winner's; the larger the lead, the stronger the colour. A click on a cell shows the times of all methods, or the
        reason why a method has none.""",
        columns,
    )
    lines: dict[str, dict[str, Cell]] = {}
    for scene in class_map.scenes:
        lines.setdefault(_machine(scene), {})[f"speed {scene.groups.speed:g}"] = _cell(class_map, scene, level, by)
    for machine, of_speeds in lines.items():
        table.add(machine=machine, **of_speeds)
    return table


def _machine(scene: ClassScene) -> str:
    """The text that distinguishes a row of the map from the others."""
    _, _, others = name_of(replace(scene.groups, speed=CENTRE.speed)).partition(", ")
    return (others or f"tip {CENTRE.tip:g}").replace("inf", "rigid")


def _cell(class_map: Map, scene: ClassScene, level: float, by: str) -> Cell:
    """The winner and the runner-up; the remark lists all engines. The winner's colour is stronger the larger its lead."""
    trials, ranked = class_map.at(scene, level), class_map.ranked(scene, level, by)
    without_time = [_why_no_time(trial) for trial in trials if trial.engine not in ranked]
    note = "; ".join([*(f"{name} {duration(seconds)}" for name, seconds in ranked.items()), *without_time]) or scene.failure
    if not ranked:
        return Cell("nobody" if trials else "no solution", note=note, mark="open")
    (winner, first), (other, second) = [*ranked.items(), ("", math.inf)][:2]
    text, look = (f"{winner}\n{number(second / first, '.2g')}× {other}" if other else winner), looks([winner])[winner]
    share = _PALE + (_FULL - _PALE) * min(1.0, math.log10(second / first))
    tint = f"color-mix(in srgb, light-dark({look.light}, {look.dark}) {share:.0f}%, transparent)"
    return Cell(winner, text, note, tint=tint)


def _why_no_time(trial: Row) -> str:
    """The reason why an engine has no time."""
    if trial.status != REACHED:
        return f"{trial.engine} {trial.status}" + (f" ({size(trial.error)} left)" if trial.error is not None else "")
    return f"{trial.engine} reaches it, but its own estimate does not show it ({trial.remark})"


def failing(class_map: Map) -> Table:
    """The number of scenes in which each method reaches each error, and the reasons why not in the others."""
    heads = [Column(status.replace(" ", "_"), status, form="d") for status in STATUSES]
    unknown = Column("unclaimed", "reached, not known", form="d")
    table = Table(
        "classes_failing",
        """Where each method fails: the number of classes in which it reaches an error, and the reasons in the other classes. Reached,
        not known: some settings keep within the error, but the method's own estimate does not show it. A click on a number shows the
        classes.""",
        (Column("method"), Column("level", "error", "%", "g"), *heads, unknown),
    )
    for engine in dict.fromkeys(trial.engine for trial in class_map.trials):
        for level in LEVELS:
            here = [trial for trial in class_map.trials if (trial.engine, trial.level) == (engine, level)]
            counts = {status.replace(" ", "_"): _count([trial for trial in here if trial.status == status]) for status in STATUSES}
            silent = [trial for trial in here if trial.status == REACHED and trial.answer_seconds is None]
            table.add(method=engine, level=level, unclaimed=_count(silent), **counts)
    return table


def _count(trials: Sequence[Row]) -> Cell:
    """A number of scenes; its remark names them and the first reason."""
    reason = next((f": {trial.remark}" for trial in trials if trial.remark), "")
    return Cell(len(trials), note="; ".join(trial.scene for trial in trials) + reason)
