"""The studies of methods: which contests in which scenes, their records, and what the page gets of them.

A scene's own results are shown where the store has them, and the recorded ones (`reports.long_studies`) otherwise.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache
from typing import Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.library import catalogue, load_case
from quickreturn.cases.library.hard import TAG
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.registry import MAIN, engine
from quickreturn.plugins.methods import map as of_classes
from quickreturn.plugins.methods.compiling import Compiling, compiling
from quickreturn.plugins.methods.fronts import CRITERIA, front, standings
from quickreturn.plugins.methods.groups import Groups, case_of, grid, name_of
from quickreturn.plugins.methods.map import ClassScene, Map
from quickreturn.plugins.methods.race import Contest, Race, race
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.plugins.methods.row import LEVELS, TIP, Row, by_method
from quickreturn.plugins.methods.signed import Line, read_lines
from quickreturn.reports.long_studies import About, about, table
from quickreturn.reports.page.content import Content

#: The scene on which settings are chosen; the run with the least strain; two hard scenes, one with a soft follower and one in which the
#: slider reaches 96 % of the follower; and the first one at a prescribed crank speed, because one method requires this.
SCENES: Final = ("thesis-24", "thesis-17", "hard-ei-x0.1", "hard-crank-6in", "hard-prescribed-speed")
ENGINES: Final = (*MAIN, *RIVALS)
#: Error that is asked for in hard scenes.
REQUESTED: Final = 1e-2
#: Every main engine asked for it; and each engine with its usual choices in the many scenes of the map.
OF_HARD: Final = Contest(MAIN, (REQUESTED,), runs=0, patience=60.0)
OF_CLASSES: Final = Contest(ENGINES, of_classes.LEVELS, runs=16, usual=True, patience=5.0)
#: Largest error of a row on a front that is recorded.
LARGEST_RECORDED: Final = 0.1
#: Who signs settings that the search found on the first scene.
CHOSEN: Final = "chosen on {}"


def fronts(workshop: Workshop, wanted: Contest, cases: Iterable[Case], carries: bool) -> Iterator[tuple[Case, Race | EngineFailure]]:
    """The race in each case, or why its solution fails; what is missing in the workshop is left out. Raises Refusal: it is refused.

    `carries`: whether settings that are chosen in the first one are tried in the others, too, whose searches have half as many runs.
    """
    wanted = replace(wanted, lines=(*read_lines(), *wanted.lines))
    for case in cases:
        with suppress(LookupError):
            try:
                found = race(case, wanted, workshop)
            except EngineFailure as failure:
                yield case, failure
                continue
            yield case, found
            if carries:
                wanted, carries = replace(wanted, runs=wanted.runs // 2, lines=(*wanted.lines, *chosen_in(found))), False


def chosen_in(found: Race) -> list[Line]:
    """The first settings below each level on each front of a scene, as lines."""
    rows = [at.row for level in LEVELS for at in standings(found.given, level).values()]
    lines = [Line(row.engine, CHOSEN.format(found.case), row.settings) for row in rows]
    return list({repr(line): line for line in lines}.values())


def usual_fronts(workshop: Workshop) -> list[Race]:
    """The races in `SCENES`; what is missing in the workshop is left out."""
    found = fronts(workshop, Contest(ENGINES), map(load_case, SCENES), carries=True)
    return [each for _, each in found if isinstance(each, Race)]


def hard_scenes(workshop: Workshop) -> list[Race]:
    """The race in every hard scene; what is missing in the workshop is left out."""
    found = list[Race]()
    for entry in catalogue(TAG):
        with suppress(EngineFailure, Refusal, LookupError):
            found.append(race(load_case(entry.name), OF_HARD, workshop))
    return found


def classes(workshop: Workshop, among: Iterable[Groups] | None = None) -> Map:
    """The map of some classes, None: of all; what is missing in the workshop is left out."""
    scenes, rows = list[ClassScene](), list[Row]()
    for groups in grid() if among is None else among:
        with suppress(LookupError):
            try:
                found = race(case_of(groups), OF_CLASSES, workshop)
            except (EngineFailure, Refusal) as failure:
                scenes.append(ClassScene(name_of(groups), groups, failure=str(failure)))
                continue
            scenes.append(ClassScene(found.case, groups, found.confirmation.error))
            rows += map(essential, of_classes.condensed(found))
    return Map(tuple(scenes), tuple(rows))


def essential(row: Row) -> Row:
    """The row as it is recorded: settings that differ from the engine's defaults, errors that are compared, the remark's first clause."""
    usual = engine(row.engine).settings_type().as_dict()
    errors = {name: error for name, error in row.errors.items() if name == TIP or error == row.worst}
    settings = {name: value for name, value in row.settings.items() if value != usual.get(name)}
    return replace(row, settings=settings, errors=errors, remark=row.remark.partition("; ")[0])


def recorded_rows(rows: Sequence[Row], whole: bool = True) -> list[Row]:
    """The rows of a scene that are recorded: the signed ones, the answers, and those on a front with an error up to `LARGEST_RECORDED`.

    Unless the `whole` front is recorded, only the rows that give the time at a level, and the most accurate one; without parts of times.
    """
    kept = {id(row) for row in rows if row.signed or row.level is not None}
    for of_method in by_method(row for row in rows if row.level is None).values():
        for by in CRITERIA:
            on_front = front(of_method, by)
            at_levels = [at for level in LEVELS for at in standings(of_method, level, by).values()]
            around = [*on_front[-1:], *(row for at in at_levels for row in (at.before, at.row))]
            kept |= {id(row) for row in (on_front if whole else around) if not whole or (row.worst or 0.0) <= LARGEST_RECORDED}
    without: dict[str, Any] = {} if whole else {"call_seconds": None, "rows_seconds": None, "setup_seconds": None}
    return [replace(row, **without) for row in rows if id(row) in kept]


def front_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Tables of the record "benchmark"."""
    return _tables("benchmark", usual_fronts(workshop)) | {"compiling": compiling(workshop, ENGINES) or table("compiling", Compiling)}


def hard_scene_rows(workshop: Workshop) -> dict[str, Sequence[Any]]:
    """Tables of the record "hard scenes"."""
    return _tables("hard_scenes", hard_scenes(workshop))


def _tables(name: str, races: Sequence[Race]) -> dict[str, Sequence[Any]]:
    """Rows and scenes; of the first scene, where settings are chosen, with whole fronts, and with the machine."""
    rows = [essential(row) for found in races for row in recorded_rows(found.rows, found is races[0])]
    return {name: rows, f"{name}_scenes": [replace(each, rows=(), machine=each.machine if each is races[0] else {}) for each in races]}


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


def fronts_of(content: Content) -> tuple[Sequence[Race], About | None]:
    """The races of a report on the thesis, and the record if they are the recorded ones."""
    return _own_or_recorded(content, usual_fronts, "benchmark")


def hard_scenes_of(content: Content) -> tuple[Sequence[Race], About | None]:
    """The same of the hard scenes."""
    return _own_or_recorded(content, hard_scenes, "hard scenes")


def _own_or_recorded(content: Content, find: Callable[[Workshop], list[Race]], study: str) -> tuple[Sequence[Race], About | None]:
    if content.workshop is None or not content.has(SCENES[0]):
        return (), None
    own = find(content.workshop.as_it_is)
    return (own, None) if own else (recorded(study.replace(" ", "_")), about(study))


def map_of(content: Content) -> Map:
    """The recorded map of classes, in a report on the thesis."""
    return class_map() if content.workshop and content.has(SCENES[0]) else Map()
