"""Reads the file beside an FMU that makes it an engine: which parameter is which key of a case, and which output which column.

The registry of engines finds this module by the entry-point group `quickreturn.engine_files`: units are read here, and not below.
"""

import contextlib
import functools
import hashlib
import operator
import os
import re
import zipfile
from collections.abc import Callable, Collection, Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, TypeVar

from quickreturn.cases.errors import CaseError, as_written, attempted, nearest, nearest_or_all, path_shown, together
from quickreturn.cases.text.broken_toml import toml_of
from quickreturn.cases.text.number_rows import unit_factor
from quickreturn.cases.text.text_file import read_text
from quickreturn.cases.units import DIMENSIONS, TIME, QuantityError, parse_quantity
from quickreturn.engines.base import ESTIMATES, SPIN_UP, AnyEngine
from quickreturn.engines.fmu.description import Declarations, Fmu, Variable
from quickreturn.engines.fmu.engine import EXTREME_FIBRE, FmuEngine
from quickreturn.engines.registry import Missing
from quickreturn.engines.trajectory import REQUIRED
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.follower import DIMENSIONS as OF_SECTION
from quickreturn.reference_model.scene_values import SECTIONS

T = TypeVar("T")

_SECTIONS: Final = ("fmu", "method", "resolution", "parameters", "fixed", "set", "outputs")
#: Key of [resolution] -> what is accepted.
_RESOLUTION: Final = {
    "steps": 'communication steps of at most 1 s from coarse to fine, such as ["1 ms", "0.5 ms"]',
    "errors": "a number from 0 to 1 for each step, such as [0.02, 0.005]",
    "order": "a number from 0.1 to 10",
    "estimates": f"one of {', '.join(ESTIMATES)}",
}
#: Types of variables in FMI 2 and 3.
_REAL: Final = ("Real", "Float64", "Float32")
_WHOLE: Final = ("Integer", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
#: Type -> the types of Python that it takes, and what that is.
_TAKEN: Final[Mapping[str, tuple[tuple[type, ...], str]]] = (
    dict.fromkeys(_REAL, ((int, float), "a plain number"))
    | dict.fromkeys((*_WHOLE, "Enumeration"), ((int,), "a whole number"))
    | {"Boolean": ((bool,), "true or false"), "String": ((str,), "a text")}
)
_NUMBER: Final = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_MAPPED: Final = re.compile(rf"(-)?\s*(?:({_NUMBER})\s*\*\s*)?(.+?)(?:\s+\[([^\[\]]*)\])?(?:\s*([+-])\s*({_NUMBER}))?")
_EXAMPLE: Final = 'write the name of a variable, with its unit in brackets if it has another than the FMU declares, such as "r [mm]"'

#: Keys of a case to which a parameter may belong, with SI unit and count: numbers on which the motion or the strains depend.
KEYS: Final[Mapping[str, tuple[str, int]]] = {
    f"{section}.{name}": (quantity.unit, quantity.count or 1)
    for section, quantities in SECTIONS.items()
    for name, quantity in quantities.items()
    if quantity.moves and not quantity.in_file and not (section == "follower" and name in (*OF_SECTION, "elastic_modulus", "density"))
} | {EXTREME_FIBRE: ("m", 1)}
_UNITS: Final = {name: column.unit.replace(" ", "*") for name, column in COLUMNS.items() if name != "time"}


def engine_of(name: str) -> AnyEngine:
    """The engine that a file declares; one that is not available if fmpy is missing or the FMU cannot be used here.

    Raises:
        CaseError: mistakes in the file.
    """
    source, text = path_shown(name), read_text(name, "a file that declares an FMU as an engine")
    content = toml_of(text, source)
    if unknown := [key for key in content if key not in _SECTIONS]:
        raise CaseError(source, unknown[0], None, "is unknown", nearest_or_all(unknown[0], _SECTIONS))
    if not isinstance(given := content.get("fmu"), str):
        raise CaseError(source, "fmu", None, "is missing", 'give the path of the FMU, such as fmu = "chain.fmu"')
    file = os.path.abspath(Path(name).parent / given)
    try:
        written = os.stat(file)
    except OSError as error:
        raise CaseError(source, "fmu", as_written(given), f"cannot be read ({error.strerror})", "give its path from this file") from None
    if find_spec("fmpy") is None:
        return Missing(name, "fmpy is not installed; pip install 'quickreturn[fmu]'")
    try:
        about, digest = _described(file, (written.st_mtime_ns, written.st_size))
    except _UnusableError as reason:
        return Missing(name, f"{given} {reason}")
    fmu = Fmu(file, about, digest, _hash(f"{digest}{text}".encode()))
    return FmuEngine(name, fmu, _Reader(source, content, about).declarations())


class _UnusableError(Exception):
    """An FMU cannot be used here: why, as a clause."""


@functools.lru_cache(maxsize=8)
def _described(file: str, _written: tuple[int, int]) -> tuple[Any, str]:
    """The FMU's description by fmpy, and the file's hash; an FMU that was written at another time is another one. Raises _UnusableError."""
    import fmpy

    here = fmpy.platform
    try:
        about = fmpy.read_model_description(file, validate=False)
        platforms = fmpy.supported_platforms(file)
    except zipfile.BadZipFile:
        raise _UnusableError("is no FMU: it is no zip archive, or damaged") from None
    except Exception as error:  # whatever a description that is none makes of it
        cause = f"{type(error).__name__}: {' '.join(str(error).split())[:120]}"
        raise _UnusableError(f"has no description that can be read ({cause})") from error
    if about.fmiVersion[:1] not in ("2", "3"):
        raise _UnusableError(f"is of FMI {about.fmiVersion}; FMI 2 and 3 are accepted")
    if about.coSimulation is None:
        raise _UnusableError("is for model exchange; export it for co-simulation")
    if here not in platforms:
        raise _UnusableError(f"has no library for {here}, only for {' and '.join(platforms) or 'no system'}; export it for {here}")
    return about, _hash(Path(file).read_bytes())


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:12]


class _Reader:
    """Reads the declarations; `mistakes` collects what is wrong."""

    def __init__(self, source: str, content: Mapping[str, Any], about: Any) -> None:
        self.source, self.content, self.about, self.mistakes = source, content, about, list[CaseError]()
        self.variables = {variable.name: variable for variable in about.modelVariables}
        bases = {unit.name: unit.baseUnit for unit in about.unitDefinitions if unit.baseUnit is not None}
        self.units = {name: base for name, base in bases.items() if not (base.A or base.K or base.mol or base.cd)}

    def declarations(self) -> Declarations:
        """What the file says. CaseError: all its mistakes."""
        parameters = self._section("parameters", KEYS, self._parameters)
        fixed = self._section("fixed", KEYS, self._fixed)
        outputs = self._section("outputs", _UNITS, self._output)
        constants = self._section("set", (), self._constant)
        self._check_together(parameters, fixed, outputs)
        resolution = self._resolution()
        if self.mistakes:
            raise together(self.mistakes)
        method = str(self.content.get("method", "a model in an FMU"))
        return Declarations(parameters, fixed, tuple(constants.values()), outputs, method=method, **resolution)

    def _wrong(self, key: str, given: Any, problem: str, accepted: str) -> CaseError:
        return CaseError(self.source, key, None if given is None else as_written(given), problem, accepted)

    def _table(self, section: str) -> Mapping[str, Any]:
        given = self.content.get(section, {})
        if isinstance(given, dict):
            return given
        self.mistakes.append(self._wrong(section, given, "is no section", f"write [{section}] and its lines below it"))
        return {}

    def _section(self, section: str, known: Collection[str], read: Callable[[str, str, Any], T]) -> dict[str, T]:
        """The entries of a section by dotted key, as `read` makes them of place, key and value. Any key is known if `known` is empty."""
        found = {}
        for key, given in _flat(self._table(section)):
            place = f"{section}.{key}"
            if known and key not in known:
                self.mistakes.append(self._wrong(place, given, "is unknown", nearest_or_all(key, [*known], f"{section}.")))
            elif (entry := attempted(self.mistakes, read, place, key, given)) is not None:
                found[key] = entry
        return found

    def _parameters(self, place: str, key: str, given: Any) -> tuple[Variable, ...]:
        unit, count = KEYS[key]
        texts = given if isinstance(given, list) else [given]
        if len(texts) != count:
            accepted = f"{count} {'variables are needed, as a list' if count > 1 else 'variable is needed'}"
            raise self._wrong(place, given, f"names {len(texts)}", accepted)
        return tuple(self._variable(place, text, unit, _REAL, settable=True) for text in texts)

    def _fixed(self, place: str, key: str, given: Any) -> float | tuple[float, ...]:
        unit, count = KEYS[key]
        texts = given if isinstance(given, list) else [given]
        if len(texts) != count or not all(isinstance(text, str) for text in texts):
            raise self._wrong(place, given, "is no value as in a case file", f"write {DIMENSIONS[unit].example}")
        try:
            values = tuple(parse_quantity(text, DIMENSIONS[unit], infinity_accepted=True) for text in texts)
        except QuantityError as wrong:
            raise self._wrong(place, given, wrong.problem, wrong.accepted) from None
        return values if count > 1 else values[0]

    def _output(self, place: str, column: str, given: Any) -> Variable:
        return self._variable(place, given, _UNITS[column], (*_REAL, *_WHOLE))

    def _constant(self, place: str, name: str, value: Any) -> tuple[Variable, Any]:
        variable = self._known(place, name, tuple(_TAKEN), settable=True)
        kinds, accepted = _TAKEN[variable.type]
        if not isinstance(value, kinds) or (isinstance(value, bool) and bool not in kinds):
            raise self._wrong(place, value, "cannot be set", f"write {accepted}, for the FMU's type is {variable.type}")
        whole = "Integer" if self.about.fmiVersion[0] == "2" else "Int64"
        return Variable(name, variable.valueReference, whole if variable.type == "Enumeration" else variable.type), value

    def _variable(self, place: str, given: Any, si_unit: str, kinds: tuple[str, ...], settable: bool = False) -> Variable:
        """A variable of the FMU as in "name", "name [unit]", "-name" or "-2 * name [unit] + 180"."""
        if not isinstance(given, str) or not (match := _MAPPED.fullmatch(given.strip())):
            raise self._wrong(place, given, "is no variable of the FMU", _EXAMPLE)
        plain = (None, None, given, None, None, None)
        sign, number, name, unit, of_offset, offset = plain if given in self.variables else match.groups()
        variable = self._known(place, name, kinds, settable)
        size = self._unit(place, unit, variable, si_unit)
        if not (factor := float(number or 1)):
            raise self._wrong(place, given, "has the factor 0", "give another factor, or the value in [fixed]")
        shift = float(offset or 0) * (-size if of_offset == "-" else size)
        return Variable(name, variable.valueReference, variable.type, (-factor if sign else factor) * size, shift)

    def _known(self, place: str, name: str, kinds: tuple[str, ...], settable: bool = False) -> Any:
        """A variable of the FMU by its name. CaseError: there is none, or it cannot be what it shall be."""
        if (variable := self.variables.get(name)) is None:
            accepted = f"the nearest one is {nearest(name, self.variables)}" if self.variables else "it has none"
            raise self._wrong(place, name, "is no variable of the FMU", accepted)
        if variable.type not in kinds or variable.dimensions:
            what = "an array" if variable.dimensions else f"of type {variable.type}"
            of_types = f" ({' or '.join(kinds)})" if kinds == _REAL else ""
            raise self._wrong(place, name, f"is {what} in the FMU", f"a single number is needed{of_types}")
        if settable and not _is_settable(variable):
            problem = f"is no parameter of the FMU, but {variable.causality or 'local'} ({variable.variability or 'continuous'})"
            raise self._wrong(place, name, problem, "give a parameter, or an input")
        return variable

    def _unit(self, place: str, unit: str | None, variable: Any, si_unit: str) -> float:
        """SI value of the unit that the file gives, or else the FMU, or else SI."""
        if unit is not None:
            return unit_factor(self.source, place, si_unit, unit)
        if not (declared := variable.unit or getattr(variable.declaredType, "unit", None)):
            return 1.0
        base, needed = self.units.get(declared), DIMENSIONS[si_unit]
        if base is not None and needed.accepts((base.m, base.kg, base.s, base.rad)):
            return float(base.factor)
        with contextlib.suppress(CaseError):
            if base is None or (base.m, base.kg, base.s, 0) == (*needed.exponents[:3], base.rad):  # some tools define no radian
                return unit_factor(self.source, place, si_unit, re.sub(r"(?<=[A-Za-z])(-?\d)", r"^\1", declared.replace(".", "*")))
        problem = f"has the unit {as_written(declared)} in the FMU, and {needed.name} is needed"
        raise self._wrong(place, variable.name, problem, _EXAMPLE)

    def _check_together(self, parameters: Mapping[str, Any], fixed: Mapping[str, Any], outputs: Mapping[str, Any]) -> None:
        given = {*parameters, *fixed}
        for first, second in (("crank.torque", "crank.prescribed_speed"), (SPIN_UP, "crank.length")):
            if {first, second} <= given:
                accepted = "give one of them, and another file for the other"
                self.mistakes.append(self._wrong(first, None, f"and {second} are both given", accepted))
        for key in parameters.keys() & fixed.keys():
            self.mistakes.append(self._wrong(f"fixed.{key}", None, "is also in [parameters]", "give one of them"))
        told = {mistake.key for mistake in self.mistakes}
        for name in REQUIRED:
            of_mechanism = SPIN_UP in given and COLUMNS[name].of_slider
            if name != "time" and not of_mechanism and name not in outputs and f"outputs.{name}" not in told:
                accepted = f"name the variable of the FMU with {COLUMNS[name].meaning} ({COLUMNS[name].unit})"
                self.mistakes.append(self._wrong(f"outputs.{name}", None, "is missing", accepted))

    def _resolution(self) -> dict[str, Any]:
        """Steps (s) and what is known of their errors; mistakes are kept. Without steps those are one, which the FMU suggests, or 1 ms."""
        given, suggested = self._table("resolution"), getattr(self.about.defaultExperiment, "stepSize", None)
        steps = given.get("steps", [f"{float(suggested or 1e-3):g} s"])
        errors, order, estimates = given.get("errors", []), given.get("order", 1.0), given.get("estimates", "integration")
        try:
            read = tuple(parse_quantity(text, TIME) for text in steps)
        except (QuantityError, TypeError):
            read = ()
        fine = {
            "steps": bool(read) and all(0.0 < step <= 1.0 for step in read) and all(map(operator.gt, read, read[1:])),
            "errors": isinstance(errors, list) and all(_is_number(one, 0.0, 1.0) for one in errors) and len(errors) in (0, len(read)),
            "order": _is_number(order, 0.1, 10.0),
            "estimates": estimates in ESTIMATES,
        }
        for key in given:
            if not fine.get(key):
                known = key in _RESOLUTION
                accepted = f"write {_RESOLUTION[key]}" if known else nearest_or_all(key, [*_RESOLUTION])
                problem = "is not accepted" if known else "is unknown"
                self.mistakes.append(self._wrong(f"resolution.{key}", given[key], problem, accepted))
        return {"steps": read, "errors": tuple(errors), "order": order, "estimates": estimates}


def _flat(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """The entries of a table and of those in it, by dotted key."""
    for name, value in table.items():
        yield from _flat(value, f"{prefix}{name}.") if isinstance(value, dict) else [(f"{prefix}{name}", value)]


def _is_number(value: Any, low: float, high: float) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and low <= value <= high


def _is_settable(variable: Any) -> bool:
    """Whether a variable may be set before the simulation begins."""
    if variable.causality in ("parameter", "input", "structuralParameter"):
        return variable.variability != "constant"
    return variable.causality != "calculatedParameter" and variable.initial in ("exact", "approx") and variable.variability != "constant"
