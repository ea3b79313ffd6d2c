"""Reads the file beside an FMU that makes it an engine: which parameter is which key of a case, and which output which column.

Units of quantities are read here.
"""

import contextlib
import functools
import hashlib
import operator
import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, TypeVar

from quickreturn.cases.files.errors import CaseError, as_written, attempted, nearest, nearest_or_all, path_shown, together
from quickreturn.cases.files.number_rows import unit_factor
from quickreturn.cases.files.text_file import read_text, toml_of
from quickreturn.cases.files.units import DIMENSIONS, TIME, QuantityError, parse_quantity
from quickreturn.engines.base import SPIN_UP, AnyEngine
from quickreturn.engines.registry import Missing
from quickreturn.engines.trajectory import REQUIRED
from quickreturn.plugins.fmu.engine import EXTREME_FIBRE, KEYS, FmuEngine
from quickreturn.plugins.fmu.simulation import Fmu, Variable
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.follower import DIMENSIONS as OF_SECTION

T = TypeVar("T")

_SECTIONS: Final = ("fmu", "method", "resolution", "parameters", "fixed", "set", "outputs")
#: Types of variables in FMI 2 and 3.
_REAL: Final = ("Real", "Float64", "Float32")
_WHOLE: Final = ("Integer", "Enumeration", *(f"{sign}Int{size}" for sign in ("", "U") for size in (8, 16, 32, 64)))
#: Type -> the types of Python that it takes, and what that is.
_TYPES: Final[Mapping[str, tuple[tuple[type, ...], str]]] = (
    dict.fromkeys(_REAL, ((int, float), "a plain number"))
    | dict.fromkeys(_WHOLE, ((int,), "a whole number"))
    | {"Boolean": ((bool,), "true or false"), "String": ((str,), "a text")}
)
_NUMBER: Final = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_MAPPED: Final = re.compile(rf"(-)?\s*(?:({_NUMBER})\s*\*\s*)?(.+?)(?:\s+\[([^\[\]]*)\])?(?:\s*([+-])\s*({_NUMBER}))?")
_EXAMPLE: Final = 'write the name of a variable, with its unit in brackets if it has another than the FMU declares, such as "r [mm]"'
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
    given = content.get("fmu", "")
    file = os.path.abspath(Path(name).parent / str(given))
    if not os.path.isfile(file):
        raise CaseError(source, "fmu", as_written(given), "is no file", 'give the path of the FMU from this one, such as "chain.fmu"')
    if find_spec("fmpy") is None:
        return Missing(name, "fmpy is not installed; pip install 'quickreturn[fmu]'")
    about, digest, unusable = _described(file, os.stat(file).st_mtime_ns)
    if unusable:
        return Missing(name, f"{given} {unusable}")
    declarations = _Reader(source, content, about).declarations()
    fingerprint = hashlib.sha256(f"{digest}{text}".encode()).hexdigest()[:12]
    return FmuEngine(name, Fmu(file, about, digest, fingerprint, **declarations))


@functools.lru_cache(maxsize=8)
def _described(file: str, _written: int) -> tuple[Any, str, str]:
    """An FMU's description by fmpy, the file's hash, and why it cannot be used here, a clause or "".

    An FMU that was written at another time is another one.
    """
    import fmpy

    try:
        about = fmpy.read_model_description(file, validate=False)
        platforms = fmpy.supported_platforms(file)
    except Exception as error:  # whatever a file that is none makes of it
        cause = f"{type(error).__name__}: {' '.join(str(error).split())[:120]}"
        return None, "", f"is no FMU with a description that can be read ({cause})"
    here, others = fmpy.platform, " and ".join(platforms) or "no system"
    reasons = {
        f"is of FMI {about.fmiVersion}; FMI 2 and 3 are accepted": about.fmiVersion[:1] not in ("2", "3"),
        "is for model exchange; export it for co-simulation": about.coSimulation is None,
        f"has no library for {here}, only for {others}; export it for {here}": here not in platforms,
    }
    digest = hashlib.sha256(Path(file).read_bytes()).hexdigest()[:12]
    return about, digest, next((reason for reason, holds in reasons.items() if holds), "")


class _Reader:
    """Reads the declarations; `mistakes` collects what is wrong."""

    def __init__(self, source: str, content: Mapping[str, Any], about: Any) -> None:
        self.source, self.content, self.about, self.mistakes = source, content, about, list[CaseError]()
        self.variables = {variable.name: variable for variable in about.modelVariables}
        bases = {unit.name: unit.baseUnit for unit in about.unitDefinitions if unit.baseUnit is not None}
        self.units = {name: base for name, base in bases.items() if not (base.A or base.K or base.mol or base.cd)}

    def declarations(self) -> dict[str, Any]:
        """What the file says, as `Fmu` has it. CaseError: all its mistakes."""
        suggested = float(getattr(self.about.defaultExperiment, "stepSize", None) or 1e-3)
        said = {
            "method": str(self.content.get("method", "a model in an FMU")),
            "parameters": self._section("parameters", KEYS, self._parameters),
            "fixed": self._section("fixed", KEYS, self._fixed),
            "outputs": self._section("outputs", _UNITS, self._output),
            "constants": self._section("set", (), self._constant),
            "steps": self._section("resolution", ("steps",), self._steps).get("steps", (suggested,)),
        }
        self._check_together(said)
        if self.mistakes:
            raise together(self.mistakes)
        return said

    def _wrong(self, key: str, given: Any, problem: str, accepted: str) -> CaseError:
        return CaseError(self.source, key, None if given is None else as_written(given), problem, accepted)

    def _section(self, section: str, known: Collection[str], read: Callable[[str, str, Any], T]) -> dict[str, T]:
        """The entries of a section by dotted key, as `read` makes them of place, key and value. Any key is known if `known` is empty."""
        found, given = dict[str, T](), self.content.get(section, {})
        if not isinstance(given, dict):
            self.mistakes.append(self._wrong(section, given, "is no section", f"write [{section}] and its lines below it"))
            return found
        for key, value in _flat(given):
            place = f"{section}.{key}"
            if known and key not in known:
                of_section = EXTREME_FIBRE in known and key.removeprefix("follower.") in OF_SECTION
                accepted = f"{section}.{EXTREME_FIBRE} stands for it" if of_section else nearest_or_all(key, [*known], f"{section}.")
                self.mistakes.append(self._wrong(place, value, "is unknown", accepted))
            elif (entry := attempted(self.mistakes, read, place, key, value)) is not None:
                found[key] = entry
        return found

    def _each(self, place: str, key: str, given: Any) -> list[Any]:
        """The entries of a key, as many as its value has numbers."""
        entries, count = given if isinstance(given, list) else [given], KEYS[key].count or 1
        if len(entries) != count:
            raise self._wrong(place, given, f"has {len(entries)} of {count}", f"the value of {key} is {count} numbers")
        return entries

    def _parameters(self, place: str, key: str, given: Any) -> tuple[Variable, ...]:
        return tuple(self._variable(place, text, KEYS[key].unit, settable=True) for text in self._each(place, key, given))

    def _fixed(self, place: str, key: str, given: Any) -> float | tuple[float, ...]:
        dimension = DIMENSIONS[KEYS[key].unit]
        try:
            values = tuple(parse_quantity(str(text), dimension, infinity_accepted=True) for text in self._each(place, key, given))
        except QuantityError as wrong:
            raise self._wrong(place, given, wrong.problem, wrong.accepted) from None
        return values if KEYS[key].count else values[0]

    def _output(self, place: str, column: str, given: Any) -> Variable:
        return self._variable(place, given, _UNITS[column])

    def _constant(self, place: str, name: str, value: Any) -> Any:
        variable = self._known(place, name, _TYPES, settable=True)
        kinds, accepted = _TYPES[variable.type]
        if type(value) not in kinds:
            raise self._wrong(place, value, "cannot be set", f"write {accepted}, for the FMU's type is {variable.type}")
        return value

    def _steps(self, place: str, key: str, given: Any) -> tuple[float, ...]:
        """Communication steps, s."""
        with contextlib.suppress(QuantityError, TypeError):
            steps = tuple(parse_quantity(text, TIME) for text in given)
            if steps and steps[0] <= 1.0 and all(map(operator.gt, steps, (*steps[1:], 0.0))):
                return steps
        accepted = 'write communication steps of at most 1 s from coarse to fine, such as ["1 ms", "0.5 ms"]'
        raise self._wrong(place, given, "is not accepted", accepted)

    def _variable(self, place: str, given: Any, si_unit: str, settable: bool = False) -> Variable:
        """A variable of the FMU as in "name", "name [unit]", "-name" or "-2 * name [unit] + 180"."""
        if not isinstance(given, str) or not (match := _MAPPED.fullmatch(given.strip())):
            raise self._wrong(place, given, "is no variable of the FMU", _EXAMPLE)
        plain = (None, None, given, None, None, None)
        sign, number, name, unit, of_offset, offset = plain if given in self.variables else match.groups()
        variable = self._known(place, name, _REAL, settable)
        size = self._unit(place, variable, si_unit) if unit is None else unit_factor(self.source, place, si_unit, unit)
        if not (factor := float(number or 1)):
            raise self._wrong(place, given, "has the factor 0", "give another factor, or the value in [fixed]")
        shift = float(offset or 0) * (-size if of_offset == "-" else size)
        return Variable(name, variable.valueReference, variable.type, (-factor if sign else factor) * size, shift)

    def _known(self, place: str, name: str, kinds: Collection[str], settable: bool) -> Any:
        """A variable of the FMU by its name. CaseError: there is none, or it cannot be what it shall be."""
        if (variable := self.variables.get(name)) is None:
            accepted = f"the nearest one is {nearest(name, self.variables)}" if self.variables else "it has none"
            raise self._wrong(place, name, "is no variable of the FMU", accepted)
        if variable.type not in kinds or variable.dimensions or (settable and not _is_settable(variable)):
            kind = variable.type + " array" * bool(variable.dimensions)
            what = f"{variable.causality or 'local'}, {variable.variability or 'continuous'}, {kind}"
            accepted = f"a single {'real number' if kinds == _REAL else 'value'}{' that is a parameter or an input' * settable} is needed"
            raise self._wrong(place, name, f"is {what} in the FMU", accepted)
        return variable

    def _unit(self, place: str, variable: Any, si_unit: str) -> float:
        """SI value of the unit that the FMU declares for a variable and defines; 1 if it declares none."""
        if not (declared := variable.unit or getattr(variable.declaredType, "unit", None)):
            return 1.0
        base, needed = self.units.get(declared), DIMENSIONS[si_unit]
        if base is None or not needed.accepts((base.m, base.kg, base.s, base.rad)):
            problem = f"has the unit {as_written(declared)} in the FMU, which does not define it as {needed.name}"
            raise self._wrong(place, variable.name, problem, _EXAMPLE)
        return float(base.factor)

    def _check_together(self, said: Mapping[str, Any]) -> None:
        """What does not go together, or lacks; mistakes are kept."""
        uses, alone = dict[str, str](), SPIN_UP in {*said["parameters"], *said["fixed"]}
        named = [(f"parameters.{key}", variable.name) for key, variables in said["parameters"].items() for variable in variables]
        for place, name in (*named, *((f"set.{name}", name) for name in said["constants"])):
            if name in uses:
                self.mistakes.append(self._wrong(place, name, f"is given by {uses[name]} already", "a parameter of the FMU has one value"))
            uses[name] = place
        told = {mistake.key for mistake in self.mistakes}
        for name in _UNITS:
            needed = name in REQUIRED and not (alone and COLUMNS[name].of_slider)
            if needed and name not in said["outputs"] and f"outputs.{name}" not in told:
                accepted = f"name the variable of the FMU with {COLUMNS[name].meaning} ({COLUMNS[name].unit})"
                self.mistakes.append(self._wrong(f"outputs.{name}", None, "is missing", accepted))


def _flat(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """The entries of a table and of those in it, by dotted key."""
    for name, value in table.items():
        yield from _flat(value, f"{prefix}{name}.") if isinstance(value, dict) else [(f"{prefix}{name}", value)]


def _is_settable(variable: Any) -> bool:
    """Whether a variable may be set before the simulation begins."""
    if variable.causality == "calculatedParameter" or variable.variability == "constant":
        return False
    return variable.causality in ("parameter", "input") or variable.initial in ("exact", "approx")
