"""The studies of methods: which contests in which scenes, their records, and what the page gets of them.

A scene's own results are shown where the store has them, and the recorded ones (`reports.long_studies`) otherwise.
"""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.library import catalogue, load_case
from quickreturn.cases.library.hard import TAG
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.registry import MAIN
from quickreturn.plugins.methods import map as of_classes
from quickreturn.plugins.methods.compiling import Compiling, compiling
from quickreturn.plugins.methods.fronts import CRITERIA, around_levels, front, standings
from quickreturn.plugins.methods.groups import Groups, case_of, grid, name_of
from quickreturn.plugins.methods.map import ClassScene, Map
from quickreturn.plugins.methods.race import Contest, Race, race
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.plugins.methods.row import LEVELS, Row, essential
from quickreturn.plugins.methods.signed import Line, read_lines
from quickreturn.reports.long_studies import About, about, table
from quickreturn.reports.page.content import Content

#: The scene on which settings are chosen; the run with the least strain; two hard scenes, one with a soft follower and one in which the
#: slider reaches 96 % of the follower; and the first one at a prescribed crank speed, because one method requires this.
SCENES: Final = ("thesis-24", "thesis-17", "hard-ei-x0.1", "hard-crank-6in", "hard-prescribed-speed")
ENGINES: Final = (*MAIN, *RIVALS)
#: Error that is asked for in hard scenes.
REQUESTED: Final = 1e-2
#: Processor time (s) for an answer in a hard scene.
PATIENCE_OF_HARD: Final = 60.0
#: Largest error of a row on a front that is recorded.
LARGEST_RECORDED: Final = 0.1
#: Who signs settings that the search found on the first scene.
CHOSEN: Final = "chosen on {}"
#: Runs of a combination in the scenes after the first, where settings found in that are tried, too.
RUNS_OF_OTHERS: Final = 20
#: Runs of each engine with its usual choices, and processor time (s) for an answer, in each of the many scenes of the map.
RUNS_OF_CLASSES, PATIENCE_OF_CLASSES = 16, 5.0


@dataclass(frozen=True)
class Fronts:
    """Races in some scenes, each with its fronts."""

    races: Sequence[Race] = ()
    record: About | None = None  # if one of them is the recorded one


def contest(lines: Iterable[Line] = (), chosen: Race | None = None, engines: Sequence[str] = ENGINES) -> Contest:
    """The contest of fronts, with signed lines and, at the end, what was chosen in a scene."""
    return Contest(tuple(engines), lines=(*read_lines(), *lines, *(chosen_in(chosen) if chosen else ())))


def chosen_in(found: Race) -> list[Line]:
    """The first settings below each level on each front of a scene, as lines."""
    lines = dict[str, Line]()
    for level in LEVELS:
        for at in standings(found.given, level).values():
            line = Line(at.row.engine, CHOSEN.format(found.case), at.row.settings)
            lines[repr(line)] = line
    return list(lines.values())


def raced_in(cases: Iterable[Case], wanted: Contest, workshop: Workshop) -> list[Race]:
    """The races in those of some scenes that have a solution and that the workshop has or computes."""
    races = list[Race]()
    for case in cases:
        with suppress(EngineFailure, Refusal):
            races += [found] if (found := race(case, wanted, workshop)) else []
    return races


def fronts(workshop: Workshop) -> list[Race]:
    """The races in `SCENES`; what is missing in the workshop is left out."""
    found = list[Race]()
    for name in SCENES:
        chosen = next((each for each in found if each.case == SCENES[0]), None)
        wanted = contest(chosen=chosen)
        found += raced_in([load_case(name)], replace(wanted, runs=RUNS_OF_OTHERS) if chosen else wanted, workshop)
    return found


def hard_scenes(workshop: Workshop) -> list[Race]:
    """Every main engine asked for `REQUESTED` in every hard scene; what is missing in the workshop is left out."""
    asked = Contest(MAIN, (REQUESTED,), runs=0, patience=PATIENCE_OF_HARD)
    return raced_in([load_case(entry.name) for entry in catalogue(TAG)], asked, workshop)


def classes(workshop: Workshop, among: Iterable[Groups] | None = None) -> Map:
    """The map of some classes, None: of all; what is missing in the workshop is left out."""
    scenes, rows = list[ClassScene](), list[Row]()
    wanted = Contest(ENGINES, of_classes.LEVELS, RUNS_OF_CLASSES, usual=True, patience=PATIENCE_OF_CLASSES)
    for groups in grid() if among is None else among:
        try:
            found = race(case_of(groups), wanted, workshop)
        except (EngineFailure, Refusal) as failure:
            scenes.append(ClassScene(name_of(groups), groups, failure=str(failure)))
            continue
        if found:
            scenes.append(ClassScene(found.case, groups, found.confirmation.error))
            rows += of_classes.condensed(found)
    return Map(tuple(scenes), tuple(rows))


def recorded_rows(rows: Sequence[Row], whole: bool = True) -> list[Row]:
    """The rows of a scene that are recorded: the signed ones, the answers, and those on a front with an error up to `LARGEST_RECORDED`.

    Unless the `whole` front is recorded, only the rows that give the time at a level, and the most accurate one; without parts of times.
    """
    kept = {id(row) for row in rows if row.signed or row.level is not None}
    for method in dict.fromkeys(row.method for row in rows):
        given = [row for row in rows if row.method == method and row.level is None]
        for by in CRITERIA:
            on_front = front(given, by)
            chosen = [row for row in on_front if (row.worst or 0.0) <= LARGEST_RECORDED] if whole else around_levels(on_front, by)
            kept |= {id(row) for row in chosen}
    without: dict[str, Any] = {} if whole else {"call_seconds": None, "rows_seconds": None, "setup_seconds": None}
    return [replace(row, **without) for row in rows if id(row) in kept]


def front_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Tables of the record "benchmark"."""
    return _tables("benchmark", fronts(workshop)) | {"compiling": compiling(workshop, ENGINES) or table("compiling", Compiling)}


def hard_scene_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Tables of the record "hard scenes"."""
    return _tables("hard_scenes", hard_scenes(workshop))


def _tables(name: str, races: Sequence[Race]) -> dict[str, Sequence[Any]]:
    """Rows and scenes; of the first scene, where settings are chosen, with whole fronts, and with the machine."""
    rows = [essential(row) for found in races for row in recorded_rows(found.rows, found is races[0])]
    scenes = [replace(found, rows=(), machine=found.machine if found is races[0] else {}) for found in races]
    return {name: rows, f"{name}_scenes": scenes}


def class_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Tables of the record "classes"."""
    found = classes(workshop)
    return {"classes": found.trials, "classes_scenes": found.scenes}


@cache
def recorded(name: str) -> tuple[Race, ...]:
    """The races of a record: "benchmark" or "hard_scenes"."""
    rows = table(name, Row)
    return tuple(replace(found, rows=tuple(row for row in rows if row.scene == found.case)) for found in table(f"{name}_scenes", Race))


def class_map() -> Map:
    """The recorded map of classes; empty if there is none."""
    return Map(tuple(table("classes_scenes", ClassScene)), tuple(table("classes", Row)))


def fronts_of(content: Content) -> Fronts:
    """The races of a report: in `SCENES`, or in its own cases."""
    if content.workshop is None:
        return Fronts()
    if content.has(SCENES[0]):
        own = fronts(content.workshop.as_it_is)
        return Fronts(own) if own else Fronts(recorded("benchmark"), about("benchmark"))
    return Fronts(raced_in([result.case for result in content.results], contest(), content.workshop.as_it_is))


def hard_scenes_of(content: Content) -> Fronts:
    """The hard scenes of a report."""
    if content.workshop is None or not content.has(SCENES[0]):
        return Fronts()
    own = hard_scenes(content.workshop.as_it_is)
    return Fronts(own) if own else Fronts(recorded("hard_scenes"), about("hard scenes"))


def map_of(content: Content) -> Map:
    """The recorded map of classes."""
    return class_map() if content.workshop and content.has(SCENES[0]) else Map()


def compiling_of(content: Content) -> Sequence[Compiling]:
    """Times to compile engines, if they were measured."""
    if content.workshop is None or not content.has(SCENES[0]):
        return []
    return compiling(content.workshop.as_it_is, ENGINES) or table("compiling", Compiling)
