"""What varies in a study: axes as they are written, and the scenes of their grid."""

import itertools
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from cases.case import PATHS, Case, dimension_of
from cases.copies import as_written
from cases.errors import CaseError, nearest_or_all
from cases.errors import as_written as shown
from cases.jobs.job import Job
from cases.reading import case_of
from cases.runs.request import CODE as CODE_OF_RUNS
from cases.sweep.rows import OPEN, REFUSED, Asked, Impossible, Row, row
from cases.units import QuantityError, parse_quantity
from engines.registry import engine, engine_names
from reference_model.mechanism import ImpossibleMechanism, Mechanism

#: The axis of engines.
ENGINE: Final = "engine"
#: What a row depends on besides what the simulation does.
CODE: Final = (*CODE_OF_RUNS, "cases.sweep", "cases.loads", "cases.reading")
#: Keys that a trajectory depends on and a steady motion does not.
_OF_START: Final = ("crank.initial_angle", "crank.initial_speed", "simulation.duration", "simulation.output_step")
#: Points on one axis at most, and in all.
MOST: Final = 1_000_000
_SPEC: Final = "such as 'crank.prescribed_speed = 60 rpm .. 300 rpm : 241' or 'tip.mass = 0 g; 25 g; 50 g'"
_RANGE: Final = re.compile(r"(?P<log>log\s+)?(?P<first>.+?)\s*\.\.\s*(?P<last>.+?)\s*:\s*(?P<count>\S+)")


@dataclass(frozen=True)
class Axis:
    """What varies along one dimension of a grid.

    Attributes:
        key: dotted key of a case file, or "engine".
        texts: the values as a case file has them.
        values: the same in SI; texts again where they are no single numbers.
        unit: SI; "" of texts.
    """

    key: str
    texts: tuple[str, ...]
    values: tuple[float, ...] | tuple[str, ...]
    unit: str

    @property
    def is_numeric(self) -> bool:
        """Whether a point on it can be continued from its neighbour."""
        return bool(self.unit)


def axis(text: str) -> Axis:
    """The axis that "KEY = a .. b : n", "KEY = log a .. b : n" or "KEY = a; b; c" describes.

    Raises:
        CaseError: it cannot be read.
    """
    key, sign, values = (part.strip() for part in text.partition("="))
    if not (key and sign and values):
        raise CaseError("--vary", None, shown(text), "is no axis", f"write KEY = VALUES, {_SPEC}")
    if key == ENGINE:
        return _of_engines(_listed(key, values))
    if key not in PATHS:
        raise CaseError("--vary", key, None, "is an unknown key", nearest_or_all(key, (*PATHS, ENGINE)))
    if key in _OF_START:
        raise CaseError("--vary", key, None, "changes no steady motion", "vary another key")
    return _axis_of(key, _ranged(key, values) if ".." in values else _listed(key, values))


def si_text(key: str, value: float) -> str:
    """A value in SI as a text of a case file, from which the same value is read. CaseError: there is no such key."""
    if key not in PATHS:
        raise CaseError("--vary", key, None, "is an unknown key", nearest_or_all(key, tuple(PATHS)))
    unit = PATHS[key].unit
    return "inf" if math.isinf(value) else f"{value!r} {unit}" if unit != "1" else f"{value!r}"


def _axis_of(key: str, texts: Sequence[str]) -> Axis:
    """The axis of a key of case files with these values. CaseError: a value that cannot be read, or there are two alike."""
    unit, several = PATHS[key].unit, PATHS[key].count is not None
    values = tuple(texts) if several else tuple(_si(key, text) for text in texts)
    if len(set(values)) < len(values):
        raise CaseError("--vary", key, None, "has a value twice", "give each once")
    return Axis(key, tuple(texts), values, "" if several else unit)


def _of_engines(names: Sequence[str]) -> Axis:
    for name in names:
        if name not in engine_names():
            raise CaseError("--vary", ENGINE, shown(name), "is unknown", nearest_or_all(name, engine_names()))
    return Axis(ENGINE, tuple(names), tuple(names), "")


def _listed(key: str, values: str) -> list[str]:
    found = [each.strip() for each in values.split(";")]
    if not all(found):
        raise CaseError("--vary", key, shown(values), "has an empty value", _SPEC)
    return found


def _ranged(key: str, values: str) -> list[str]:
    """The values of a range: in its first unit if both ends have the same one, else in SI."""
    found = _RANGE.fullmatch(values)
    count = found["count"] if found else ""
    if not found or not count.isdecimal() or not 2 <= int(count) <= MOST:
        accepted = f"write FIRST .. LAST : COUNT with 2 to {MOST} values, {_SPEC}"
        raise CaseError("--vary", key, shown(values), "is no range", accepted)
    ends, units = [found["first"], found["last"]], {end.partition(" ")[2] for end in (found["first"], found["last"])}
    si = [_si(key, end) for end in ends]
    if not all(map(math.isfinite, si)):
        raise CaseError("--vary", key, shown(values), "has no end", "a range needs two finite ends")
    in_units = len(units) == 1 and all(re.fullmatch(r"[-+\d.eE]+", end.partition(" ")[0]) for end in ends)
    low, high = (float(end.partition(" ")[0]) for end in ends) if in_units else si
    unit = units.pop() if in_units else PATHS[key].unit
    if found["log"] and not (low > 0.0 and high > 0.0):
        raise CaseError("--vary", key, shown(values), "has an end that is not positive", "a logarithmic range needs positive ends")
    numbers = np.geomspace(low, high, int(count)) if found["log"] else np.linspace(low, high, int(count))
    return [f"{number:.12g} {unit}".strip() if unit != "1" else f"{number:.12g}" for number in numbers]


def _si(key: str, text: str) -> float:
    try:
        return parse_quantity(text, dimension_of(key), infinity_accepted=PATHS[key].infinity)
    except QuantityError as wrong:
        raise CaseError("--vary", key, shown(text), wrong.problem, wrong.accepted) from None


@dataclass(frozen=True)
class Grid:
    """A case, and what of it varies.

    Attributes:
        case: in which all other values are.
        axes: dimensions of the grid, in the order in which they were given; that of engines may be among them.
    """

    case: Case
    axes: tuple[Axis, ...]

    def __post_init__(self) -> None:
        _ = self.case.mechanism  # CaseError for a follower alone, which has no settled motion
        keys = [each.key for each in self.axes]
        if twice := next((key for key in keys if keys.count(key) > 1), None):
            raise CaseError("--vary", twice, None, "varies twice", "give each key once")
        points = math.prod(len(each.texts) for each in self.axes)
        if points > MOST:
            raise CaseError("--vary", None, None, f"gives {points} points", f"at most {MOST} are accepted")

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis."""
        return tuple(len(each.texts) for each in self.axes)

    @property
    def along(self) -> int:
        """The axis along which rows run: the longest one of numbers, of those first that leave the follower's shapes as they are."""
        numeric = [place for place, each in enumerate(self.axes) if each.is_numeric]
        kept = [place for place in numeric if keeps_shapes(self.axes[place].key)]
        return max(kept or numeric or range(len(self.axes)), key=lambda place: len(self.axes[place].texts))

    def rows(self) -> Iterator[tuple[int, ...]]:
        """The places of the grid where rows begin: at 0 on the axis along which they run."""
        yield from itertools.product(*(range(1 if place == self.along else size) for place, size in enumerate(self.shape)))

    def engine_at(self, place: tuple[int, ...], otherwise: str) -> str:
        """The engine at a place of the grid."""
        return next((axis.texts[at] for axis, at in zip(self.axes, place, strict=True) if axis.key == ENGINE), otherwise)

    def overrides(self, place: tuple[int, ...]) -> dict[str, str]:
        """What is changed of the case at a place of the grid, as texts of a case file."""
        return {axis.key: axis.texts[at] for axis, at in zip(self.axes, place, strict=True) if axis.key != ENGINE}


def keeps_shapes(key: str) -> bool:
    """Whether the follower's shapes, whose tables a row shares, stay the same while a key varies."""
    return key.startswith(("crank.", "base.", "slider.", "tip.force", "mechanism.gravity", "follower.damping")) and key != "crank.length"


def scenes_of(case: Case, changes: Iterable[Mapping[str, str]]) -> list[Mechanism | Impossible]:
    """The scenes of a case with other values, as texts of a case file; where one cannot be, why."""
    document = as_written(case)

    def scene(overrides: Mapping[str, str]) -> Mechanism | Impossible:
        try:
            return case_of(document.overridden_by(overrides)).mechanism
        except CaseError as wrong:
            impossible = wrong.__context__  # what the parts do not fit together by
            open_loop = isinstance(impossible, ImpossibleMechanism) and impossible.key == "crank.length"
            return Impossible(OPEN if open_loop else REFUSED, str(wrong))

    return [scene(overrides) for overrides in changes]


def measured_row(case: Case, changes: tuple[Mapping[str, str], ...], asked: Asked) -> Row:
    """The row of a case with these values, one after the other."""
    return row(scenes_of(case, changes), asked)


def job(case: Case, changes: Sequence[Mapping[str, str]], asked: Asked) -> Job[Row]:
    """The same as a job, which is stored as a whole."""
    engines = tuple(dict.fromkeys(("reference", asked.engine)))
    changed = tuple(dict(each) for each in changes)
    first = ", ".join(f"{key} = {text}" for key, text in changed[0].items())
    inputs = (case.scene, [list(each.items()) for each in changed], asked)
    arguments = (case, changed, asked)
    name = f"{asked.engine}, {len(changed)} points from {first}"
    own = type(engine(asked.engine)).__module__.startswith("engines.own.")  # a library that is foreign gets a process of its own
    return Job(name, measured_row, arguments, "row of a study", engines, CODE, inputs, points=len(changed), brief=own)
