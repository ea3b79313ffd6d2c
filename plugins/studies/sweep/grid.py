"""Axes of a study, read from text, and the scenes of their grid."""

import itertools
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.document import in_words
from quickreturn.cases.files.errors import Argument, CaseError, as_written, nearest_or_all
from quickreturn.cases.files.keys import PATHS, Written, si_value, text_of, unit_given
from quickreturn.cases.files.reading import changes_of
from quickreturn.cases.motion.catalogue import measure
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.running.job import Job
from quickreturn.engines.registry import engine, engine_names, is_engine
from quickreturn.plugins.studies.sweep.rows import OPEN, Impossible, MeasureRequest, Row, row
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import Changes, Value, what_moves_nothing

#: Key of an axis whose values are engines.
ENGINE: Final = "engine"
#: Keys that change a trajectory but not the steady motion.
OF_START: Final = ("crank.initial_angle", "crank.initial_speed", "simulation.duration", "simulation.output_step")
#: Largest number of points, on one axis and in all.
MOST: Final = 1_000_000
VARY: Final = Argument("vary")
_SPEC: Final = "such as 'crank.prescribed_speed = 60 rpm .. 300 rpm : 241' or 'tip.mass = 0 g; 25 g; 50 g'"
_RANGE: Final = re.compile(r"(?P<log>log\s+)?(?P<first>.+?)\s*\.\.\s*(?P<last>.+?)\s*:\s*(?P<count>\d{1,9})", re.ASCII)


@dataclass(frozen=True)
class Axis:
    """A key and its values along one dimension of a grid."""

    key: str  # dotted key of a case file, or "engine"
    texts: tuple[str, ...]  # the values as in a case file
    numbers: tuple[Value, ...]  # the values in SI, which remember their texts; empty of engines
    unit: str  # SI; "" of engines, vectors and tables

    @property
    def values(self) -> tuple[Value, ...] | tuple[str, ...]:
        """The values as coordinates: in SI; of engines and vectors the texts."""
        return self.numbers if self.unit else self.texts

    @property
    def given(self) -> tuple[str, float]:
        """The unit in which the numbers were given, and its size in SI."""
        return unit_given(self.key, self.texts)


def axis(text: str) -> Axis:
    """The axis that "KEY = a .. b : n", "KEY = log a .. b : n" or "KEY = a; b; c" describes. CaseError: an invalid text."""
    key, sign, values = (part.strip() for part in text.partition("="))
    if not (key and sign and values):
        raise CaseError(VARY, None, as_written(text), "is no axis", f"write KEY = VALUES, {_SPEC}")
    if key in OF_START:
        raise CaseError(VARY, key, None, "changes no steady motion", "vary another key")
    unit = "" if key == ENGINE else unit_of(key)
    texts = _ranged(key, values) if ".." in values and key != ENGINE else _listed(key, values)
    for name in texts if key == ENGINE else ():
        if not is_engine(name):
            raise CaseError(VARY, ENGINE, as_written(name), "is unknown", nearest_or_all(name, engine_names()))
    numbers = tuple(_number(key, each) for each in texts) if unit else ()
    if len(set(numbers or texts)) < len(texts):
        raise CaseError(VARY, key, None, "has a value twice", "give each once")
    return Axis(key, texts, numbers, "" if unit and not PATHS[key].is_number else unit)


def _number(key: str, text: str) -> Value:
    """The value in SI of a text, or of a list of texts; or the table. CaseError: it is invalid."""
    return Written(si_value(key, text, VARY), text) if PATHS[key].is_number else changes_of({key: text}, VARY)[key]


def unit_of(key: str) -> str:
    """SI unit of a key. CaseError: there is no such key."""
    if key not in PATHS:
        raise CaseError(VARY, key, None, "is an unknown key", nearest_or_all(key, (*PATHS, ENGINE)))
    return PATHS[key].unit


def _listed(key: str, values: str) -> tuple[str, ...]:
    """The values of a list, as written."""
    texts = tuple(text.strip() for text in values.split(";"))
    if not all(texts):
        raise CaseError(VARY, key, as_written(values), "has an empty value", _SPEC)
    return texts


def _ranged(key: str, values: str) -> tuple[str, ...]:
    """The values of a range: in the unit of its ends if both have the same one, otherwise in SI."""

    def wrong(problem: str, accepted: str) -> CaseError:
        return CaseError(VARY, key, as_written(values), problem, accepted)

    match = _RANGE.fullmatch(values)
    if not match or not 2 <= (count := int(match["count"])) <= MOST:
        raise wrong("is no range", f"write FIRST .. LAST : COUNT with 2 to {MOST} values, {_SPEC}")
    ends = match["first"], match["last"]
    low, high = (si_value(key, end, VARY, finite=True) for end in ends)
    (first, _, unit), (last, _, other) = (end.partition(" ") for end in ends)
    if unit == other:
        low, high = float(first), float(last)
    else:
        unit = PATHS[key].unit
    if match["log"] and not min(low, high) > 0.0:
        raise wrong("has an end that is not positive", "a logarithmic range needs positive ends")
    return tuple(f"{number:.12g} {unit}".strip() for number in (np.geomspace if match["log"] else np.linspace)(low, high, count))


@dataclass(frozen=True)
class Grid:
    """A case, and the axes along which it varies, in the order given."""

    case: Case
    axes: tuple[Axis, ...]

    def __post_init__(self) -> None:
        _ = self.case.mechanism  # CaseError for a follower alone, which has no settled motion
        keys = [each.key for each in self.axes]
        if twice := next((key for key in keys if keys.count(key) > 1), None):
            raise CaseError(VARY, twice, None, "varies twice", "give each key once")
        if (points := math.prod(self.shape)) > MOST:
            raise CaseError(VARY, None, None, f"gives {points} points", f"at most {MOST} are accepted")

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis."""
        return tuple(len(each.texts) for each in self.axes)

    @property
    def along(self) -> int | None:
        """The axis along which rows run: the longest one of numbers, preferably of those that leave the follower's shapes unchanged.

        None if engines alone vary: a row has one engine, and then one point.
        """
        numeric = [place for place, each in enumerate(self.axes) if each.unit]
        preferred = [place for place in numeric if keeps_shapes(self.axes[place].key)]
        others = [place for place, each in enumerate(self.axes) if each.key != ENGINE]
        return max(preferred or numeric or others, key=lambda place: self.shape[place], default=None)

    def rows(self) -> Iterator[tuple[int, ...]]:
        """The places of the grid at which rows begin, with 0 on the axis along which they run."""
        yield from itertools.product(*(range(1 if place == self.along else size) for place, size in enumerate(self.shape)))

    def engine_at(self, place: tuple[int, ...], otherwise: str) -> str:
        """The engine at a place of the grid."""
        return next((axis.texts[at] for axis, at in zip(self.axes, place, strict=True) if axis.key == ENGINE), otherwise)

    def changes(self, place: tuple[int, ...]) -> dict[str, Value]:
        """The changes of the case at a place of the grid."""
        return {axis.key: axis.numbers[at] for axis, at in zip(self.axes, place, strict=True) if axis.key != ENGINE}


def keeps_shapes(key: str) -> bool:
    """Whether a key leaves the follower's shapes unchanged, so that a row can share their tables."""
    kept = ("crank.", "base.", "slider.", "spring.", "tip.force", "tip.friction", "mechanism.gravity", "follower.damping")
    return key.startswith(kept) and key != "crank.length"


def scenes_of(case: Case, changes: Iterable[Changes]) -> list[Mechanism | Impossible]:
    """The scenes of a case with changes; for an impossible one the reason."""

    def scene(changed: Changes) -> Mechanism | Impossible:
        try:
            return case.mechanism_with(changed)
        except CaseError as wrong:
            impossible = wrong.__cause__  # why the parts do not fit together
            open_loop = isinstance(impossible, ImpossibleMechanism) and impossible.key == "crank.length"
            return Impossible(OPEN if open_loop else Ending.REFUSED, str(wrong).removeprefix(f"{case.name}: "))

    return [scene(each) for each in changes]


def measured_row(case: Case, changes: tuple[Changes, ...], asked: MeasureRequest) -> Row:
    """Measures a case with one set of values after another."""
    return row(scenes_of(case, changes), asked)


def job(case: Case, changes: Sequence[Changes], asked: MeasureRequest) -> Job[Row]:
    """`measured_row` as a job, whose row is stored as a whole."""
    changed = tuple(map(dict, changes))
    first = ", ".join(f"{key} = {in_words(text_of(key, value))}" for key, value in changed[0].items())
    material = what_moves_nothing(case.scene) if any(measure(name).of_material for name in asked.measures) else {}
    own = type(engine(asked.engine)).__module__.startswith("quickreturn.engines.own.")
    return Job(
        name=f"{asked.engine}, {len(changed)} points from {first}",
        function=measured_row,
        arguments=(case, changed, asked),
        kind="row of a study",
        engines=tuple(dict.fromkeys(("reference", asked.engine))),
        # files of equal scenes may answer a change differently, such as that of a thickness with a material: the ends of the row show it
        inputs=(case.scene, material, [list(each.items()) for each in changed], scenes_of(case, (changed[0], changed[-1])), asked),
        points=len(changed),
        brief=own,  # a foreign library gets a process of its own
    )
