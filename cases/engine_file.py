"""Reads the file beside an FMU that makes it an engine: which parameter is which key of a case, and which output which column.

The registry of engines finds this module by the entry-point group `quickreturn.engine_files`: units are read here, and not below.
"""

import functools
import hashlib
import os
import re
import zipfile
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, NamedTuple

from quickreturn.cases.errors import CaseError, as_written, attempted, nearest, nearest_or_all, path_shown, together
from quickreturn.cases.text.broken_toml import toml_of
from quickreturn.cases.text.number_rows import unit_factor
from quickreturn.cases.text.text_file import read_text
from quickreturn.cases.units import DIMENSIONS, TIME, QuantityError, parse_quantity
from quickreturn.engines.base import ESTIMATES, SPIN_UP
from quickreturn.engines.fmu.description import Declarations, Fmu, Variable
from quickreturn.engines.fmu.engine import EXTREME_FIBRE, FmuEngine
from quickreturn.engines.trajectory import REQUIRED
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.follower import DIMENSIONS as OF_SECTION
from quickreturn.reference_model.scene_values import SECTIONS

_SECTIONS: Final = ("fmu", "method", "resolution", "parameters", "fixed", "set", "outputs")
_RESOLUTION: Final = ("steps", "errors", "order", "estimates")
#: Types of numbers in FMI 2 and 3.
_REAL: Final = ("Real", "Float64", "Float32")
_NUMBERS: Final = (*_REAL, "Integer", "Int32", "Int64")
_VARIABLE: Final = re.compile(r"(.*?)(?:\s+\[([^\[\]]*)\])?")
_EXAMPLE: Final = 'write the name of a variable, with its unit in brackets if it has another than the FMU declares, such as "r [mm]"'


class _Key(NamedTuple):
    """What may be mapped: its SI unit, and how many numbers it has."""

    unit: str
    numbers: int


#: Keys of a case to which a parameter may belong: numbers and lists of them on which the motion or the strains depend.
KEYS: Final[Mapping[str, _Key]] = {
    f"{section}.{name}": _Key(quantity.unit, quantity.count or 1)
    for section, quantities in SECTIONS.items()
    for name, quantity in quantities.items()
    if quantity.moves and not quantity.in_file and not (section == "follower" and name in (*OF_SECTION, "elastic_modulus", "density"))
} | {EXTREME_FIBRE: _Key("m", 1)}
_OF_COLUMNS: Final = {name: _Key(column.unit.replace(" ", "*"), 1) for name, column in COLUMNS.items() if name != "time"}


def engine_of(name: str) -> FmuEngine:
    """The engine that a file declares; one that is not available if fmpy is missing or the FMU cannot be used here.

    Raises:
        CaseError: mistakes in the file.
    """
    source, text = path_shown(name), read_text(name, "a file that declares an FMU as an engine")
    fmu = toml_of(text, source).get("fmu")
    if not isinstance(fmu, str):
        raise CaseError(source, "fmu", None, "is missing", 'give the path of the FMU, such as fmu = "chain.fmu"')
    file = Path(name).parent / fmu
    try:
        return _engine_of(name, text, os.path.abspath(file), file.stat().st_mtime_ns)
    except OSError as error:
        raise CaseError(source, "fmu", as_written(fmu), f"cannot be read ({error.strerror})", "give its path from this file") from None


@functools.lru_cache(maxsize=8)
def _engine_of(name: str, text: str, file: str, _changed: int) -> FmuEngine:
    """See `engine_of`; an FMU that was written at another time is another one."""
    source, content = path_shown(name), toml_of(text, name)
    if unknown := [key for key in content if key not in _SECTIONS]:
        raise CaseError(source, unknown[0], None, "is unknown", nearest_or_all(unknown[0], _SECTIONS))
    if find_spec("fmpy") is None:
        return FmuEngine(name, None, None, "fmpy is not installed; pip install 'quickreturn[fmu]'")
    about, reason = _described(file)
    if about is None:
        return FmuEngine(name, None, None, f"{content['fmu']} {reason}")
    fmu = Fmu(
        path=file,
        fmi=about.fmiVersion[0],
        identifier=about.coSimulation.modelIdentifier,
        token=about.guid,
        maker=about.generationTool or "an unknown tool",
        states=int(about.numberOfContinuousStates or len(about.derivatives)),
        once=bool(about.coSimulation.canBeInstantiatedOnlyOncePerProcess),
        fingerprint=hashlib.sha256(Path(file).read_bytes() + text.encode()).hexdigest()[:12],
    )
    return FmuEngine(name, _Reader(source, content, about).declarations(), fmu)


def _described(file: str) -> tuple[Any, str]:
    """The FMU's description by fmpy; None if it cannot be used here, with a clause that says why."""
    import fmpy

    try:
        about = fmpy.read_model_description(file, validate=False)
        platforms = fmpy.supported_platforms(file)
    except zipfile.BadZipFile:
        return None, "is no FMU: it is no zip archive, or damaged"
    except Exception as error:  # whatever a description that is none makes of it
        return None, f"has no description that can be read ({type(error).__name__}: {' '.join(str(error).split())[:120]})"
    if about.fmiVersion[:1] not in ("2", "3"):
        return None, f"is of FMI {about.fmiVersion}; FMI 2 and 3 are accepted"
    if about.coSimulation is None:
        return None, "is for model exchange; export it for co-simulation"
    if fmpy.platform not in platforms:
        return None, f"has no library for {fmpy.platform}, only for {' and '.join(platforms) or 'no system'}; export it for {fmpy.platform}"
    return about, ""


class _Reader:
    """Reads the declarations; `mistakes` collects what is wrong."""

    def __init__(self, source: str, content: Mapping[str, Any], about: Any) -> None:
        self.source, self.content, self.mistakes = source, content, list[CaseError]()
        self.variables = {variable.name: variable for variable in about.modelVariables}

    def declarations(self) -> Declarations:
        """What the file says. CaseError: all its mistakes."""
        parameters, fixed = {}, {}
        for key, given in self._entries("parameters", KEYS):
            if (read := attempted(self.mistakes, self._parameters, key, given)) is not None:
                parameters[key] = read
        for key, given in self._entries("fixed", KEYS):
            if (value := attempted(self.mistakes, self._fixed, key, given)) is not None:
                fixed[key] = value
        outputs = {}
        for column, given in self._entries("outputs", _OF_COLUMNS):
            if (
                one := attempted(self.mistakes, self._variable, f"outputs.{column}", given, _OF_COLUMNS[column].unit, _NUMBERS)
            ) is not None:
                outputs[column] = one
        constants = [attempted(self.mistakes, self._constant, name, value) for name, value in self._table("set").items()]
        self._check_together(parameters, fixed, outputs)
        resolution = attempted(self.mistakes, self._resolution) or {}
        if self.mistakes:
            raise together(self.mistakes)
        method = str(self.content.get("method", ""))
        return Declarations(parameters, fixed, tuple(each for each in constants if each), outputs, method=method, **resolution)

    def _table(self, section: str) -> Mapping[str, Any]:
        given = self.content.get(section, {})
        if isinstance(given, dict):
            return given
        self.mistakes.append(
            CaseError(self.source, section, as_written(given), "is no section", f"write [{section}] and its lines below it")
        )
        return {}

    def _entries(self, section: str, known: Mapping[str, _Key]) -> Iterator[tuple[str, Any]]:
        """The entries of a section by dotted key; unknown keys are mistakes."""

        def within(prefix: str, table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
            for name, value in table.items():
                if isinstance(value, dict) and "variable" not in value and f"{prefix}{name}" not in known:
                    yield from within(f"{prefix}{name}.", value)
                else:
                    yield f"{prefix}{name}", value

        for key, value in within("", self._table(section)):
            if key in known:
                yield key, value
            else:
                accepted = nearest_or_all(key, [*known], f"{section}.") if section != "outputs" else nearest_or_all(key, [*known])
                self.mistakes.append(CaseError(self.source, f"{section}.{key}", as_written(value), "is unknown", accepted))

    def _parameters(self, key: str, given: Any) -> tuple[Variable, ...]:
        unit, count = KEYS[key]
        names = given if isinstance(given, list) else [given]
        if len(names) != count:
            accepted = f"{count} {'variables are needed, as a list' if count > 1 else 'variable is needed'}"
            raise CaseError(self.source, f"parameters.{key}", as_written(given), f"names {len(names)}", accepted)
        return tuple(self._variable(f"parameters.{key}", name, unit, _REAL, settable=True) for name in names)

    def _fixed(self, key: str, given: Any) -> float | tuple[float, ...]:
        (unit, count), place = KEYS[key], f"fixed.{key}"
        texts = given if isinstance(given, list) else [given]
        if len(texts) != count or not all(isinstance(text, str) for text in texts):
            raise CaseError(self.source, place, as_written(given), "is no value as in a case file", f"write {DIMENSIONS[unit].example}")
        try:
            values = tuple(parse_quantity(text, DIMENSIONS[unit], infinity_accepted=True) for text in texts)
        except QuantityError as wrong:
            raise CaseError(self.source, place, as_written(given), wrong.problem, wrong.accepted) from None
        return values if count > 1 else values[0]

    def _variable(self, place: str, given: Any, si_unit: str, kinds: tuple[str, ...], settable: bool = False) -> Variable:
        """A variable of the FMU as `given`: "name [unit]", "-name [unit]", or a table with `variable`, `unit`, `factor` and `offset`."""
        table = given if isinstance(given, dict) else {"variable": given}
        known = ("variable", "unit", "factor", "offset")
        if unknown := [name for name in table if name not in known]:
            raise CaseError(self.source, f"{place}.{unknown[0]}", None, "is unknown", nearest_or_all(unknown[0], known))
        numbers = {name: table.get(name, default) for name, default in (("factor", 1.0), ("offset", 0.0))}
        for name, number in numbers.items():
            if isinstance(number, bool) or not isinstance(number, (int, float)) or (name == "factor" and not number):
                accepted = f"write a plain number{' other than 0' if name == 'factor' else f' in {si_unit}'}"
                raise CaseError(self.source, f"{place}.{name}", as_written(number), "is not accepted", accepted)
        if not isinstance(table["variable"], str) or not (match := _VARIABLE.fullmatch(table["variable"].strip())):
            raise CaseError(self.source, place, as_written(given), "is no variable of the FMU", _EXAMPLE)
        name, unit, sign = match[1], table.get("unit", match[2]), 1.0
        if name not in self.variables and name.startswith("-"):
            name, sign = name[1:].strip(), -1.0
        variable = self._known(place, name, kinds)
        if settable and not _is_settable(variable):
            problem = f"is no parameter of the FMU, but {variable.causality or 'local'} ({variable.variability or 'continuous'})"
            raise CaseError(self.source, place, as_written(name), problem, "give a parameter, or an input")
        factor = sign * numbers["factor"] * self._unit(place, unit, variable, si_unit)
        return Variable(name, variable.valueReference, variable.type, factor, numbers["offset"])

    def _known(self, place: str, name: str, kinds: tuple[str, ...]) -> Any:
        if (variable := self.variables.get(name)) is None:
            accepted = f"the nearest one is {nearest(name, self.variables)}" if self.variables else "it has none"
            raise CaseError(self.source, place, as_written(name), "is no variable of the FMU", accepted)
        if variable.type not in kinds or variable.dimensions:
            what = "an array" if variable.dimensions else f"of type {variable.type}"
            raise CaseError(
                self.source, place, as_written(name), f"is {what} in the FMU", f"a single number is needed ({' or '.join(kinds)})"
            )
        return variable

    def _unit(self, place: str, unit: Any, variable: Any, si_unit: str) -> float:
        """SI value of the unit that the file gives, or else the FMU, or else SI."""
        if unit is not None:
            return unit_factor(self.source, place, si_unit, str(unit))
        if not (declared := variable.unit or getattr(variable.declaredType, "unit", None)):
            return 1.0
        try:
            return unit_factor(self.source, place, si_unit, re.sub(r"(?<=[A-Za-z])(-?\d)", r"^\1", declared.replace(".", "*")))
        except CaseError:
            problem = f"has the unit {as_written(declared)} in the FMU, and {DIMENSIONS[si_unit].name} is needed"
            raise CaseError(self.source, place, as_written(variable.name), problem, _EXAMPLE) from None

    def _constant(self, name: str, value: Any) -> tuple[Variable, float]:
        variable = self._known(f"set.{name}", name, _NUMBERS)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not _is_settable(variable):
            raise CaseError(
                self.source, f"set.{name}", as_written(value), "cannot be set", "write a plain number for a parameter of the FMU"
            )
        return Variable(name, variable.valueReference, variable.type), float(value)

    def _check_together(self, parameters: Mapping[str, Any], fixed: Mapping[str, Any], outputs: Mapping[str, Any]) -> None:
        given = {*parameters, *fixed}
        for first, second in (("crank.torque", "crank.prescribed_speed"), (SPIN_UP, "crank.length")):
            if {first, second} <= given:
                accepted = "give one of them, and another file for the other"
                self.mistakes.append(CaseError(self.source, first, None, f"and {second} are both given", accepted))
        for key in parameters:
            if key in fixed:
                self.mistakes.append(CaseError(self.source, f"fixed.{key}", None, "is also in [parameters]", "give one of them"))
        needed = [name for name in REQUIRED if name != "time" and not (SPIN_UP in given and COLUMNS[name].of_slider)]
        told = {mistake.key for mistake in self.mistakes}
        for name in needed:
            if name not in outputs and f"outputs.{name}" not in told:
                accepted = f"name the variable of the FMU with {COLUMNS[name].meaning} ({COLUMNS[name].unit})"
                self.mistakes.append(CaseError(self.source, f"outputs.{name}", None, "is missing", accepted))

    def _resolution(self) -> dict[str, Any]:
        given = self._table("resolution")
        for key in given:
            if key not in _RESOLUTION:
                raise CaseError(self.source, f"resolution.{key}", as_written(given[key]), "is unknown", nearest_or_all(key, _RESOLUTION))
        steps = self._list("steps", given.get("steps", ["1 ms"]), lambda text: parse_quantity(text, TIME))
        errors = self._list("errors", given.get("errors", []), float)
        order, estimates = given.get("order", 1.0), given.get("estimates", "integration")
        if sorted(steps, reverse=True) != steps or not steps:
            raise CaseError(
                self.source, "resolution.steps", as_written(given["steps"]), "does not fall", "list the steps from coarse to fine"
            )
        if errors and len(errors) != len(steps):
            accepted = f"give one number for each of the {len(steps)} steps, or leave it out"
            raise CaseError(self.source, "resolution.errors", as_written(given["errors"]), "does not fit", accepted)
        if isinstance(order, bool) or not isinstance(order, (int, float)) or not 0.1 <= order <= 10:
            raise CaseError(self.source, "resolution.order", as_written(order), "is not accepted", "write a number from 0.1 to 10")
        if estimates not in ESTIMATES:
            raise CaseError(self.source, "resolution.estimates", as_written(estimates), "is unknown", f"known are {', '.join(ESTIMATES)}")
        return {"steps": tuple(steps), "errors": tuple(errors), "order": float(order), "estimates": estimates}

    def _list(self, key: str, given: Any, read: Any) -> list[float]:
        try:
            values = [read(each) for each in given]
            if not isinstance(given, list) or any(not 0.0 < value <= 1.0 for value in values):
                raise ValueError("no list of such numbers")
        except (QuantityError, TypeError, ValueError):
            accepted = (
                'write a list such as ["1 ms", "0.5 ms"]' if key == "steps" else "write a list of numbers from 0 to 1 such as [0.02, 0.005]"
            )
            raise CaseError(self.source, f"resolution.{key}", as_written(given), "is not accepted", accepted) from None
        return values


def _is_settable(variable: Any) -> bool:
    """Whether a variable may be set before the simulation begins."""
    if variable.causality in ("parameter", "input", "structuralParameter"):
        return variable.variability != "constant"
    return variable.causality != "calculatedParameter" and variable.initial in ("exact", "approx") and variable.variability != "constant"
