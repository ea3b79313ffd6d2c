"""Reads a document: values in SI units, or messages about its mistakes. Doubtful values are reported, never refused."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

from quickreturn.cases.files import units
from quickreturn.cases.files.document import Document, header_of, with_changes
from quickreturn.cases.files.errors import CaseError, as_written, attempted, together
from quickreturn.cases.files.keys import PATHS, PLUS_MINUS, SECTIONS, Written, dimension_of, toleranced, usual_unit, value_at
from quickreturn.cases.files.units import QuantityError
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.scene_values import MissingQuantity, Value, misfits_of_keys, replaced_by, scene_of
from quickreturn.reference_model.table import Table

#: Least and largest usual length of a follower, m: a watch's lever and a crane's jib.
_LENGTHS: Final = (1e-3, 20.0)
#: Least and largest density of solids, kg/m^3: rigid foam, and metals such as platinum.
_DENSITIES: Final = (20.0, 25e3)
#: Least elastic modulus, Pa: soft plastics have less, as metals in MPa for GPa have; and the largest: diamond has 1.1e12 Pa.
_MODULI: Final = (0.5e9, 1.5e12)
#: Density, kg/m^3, above which materials are metal, glass or stone, and the modulus, Pa, that these exceed: lead has 16 GPa.
_METAL_DENSITY, _METAL_MODULUS = 2500.0, 10e9
#: Largest usual mass of a tip, as a multiple of the follower's.
_HEAVIEST_TIP: Final = 5.0
#: Largest usual crank speed, rad/s (19,000 rpm): only spindles turn faster.
_FASTEST: Final = 2e3


def doubts(scene: Scene) -> Iterator[str]:
    """Sentences on values that are possible, but probably mistakes."""
    follower, tip, crank = scene.follower, scene.tip, scene.crank
    length = f"{follower.length:.6g} m"
    found = [*_of_follower(follower)]
    if tip is not None and tip.mass > _HEAVIEST_TIP * follower.mass:
        found.append(f"tip.mass is {tip.mass:.6g} kg, {tip.mass / follower.mass:.3g} times the follower's ({follower.mass:.3g} kg)")
    if tip is not None and abs(tip.center_of_mass) > follower.length:
        found.append(f"tip.center_of_mass is {tip.center_of_mass:.6g} m, more than the follower's length ({length})")
    if crank is not None and abs(crank.center_of_mass) > scene.pivot_distance:
        found.append(
            f"crank.center_of_mass is {abs(crank.center_of_mass):.6g} m, more than the pivot distance ({scene.pivot_distance:.6g} m)"
        )
    if crank is not None and abs(crank.drive.initial_speed) > _FASTEST:
        found.append(f"the crank turns at {abs(crank.drive.initial_speed) / units.in_si('rpm'):.6g} rpm")
    yield from (f"{each}: is that meant?" for each in found)


def _of_follower(follower: Follower) -> Iterator[str]:
    if not _LENGTHS[0] <= follower.length <= _LENGTHS[1]:
        yield f"follower.length is {follower.length:.6g} m"
    section, key = follower.section, "thickness" if follower.diameter is None else "diameter"
    if section.depth > 0.25 * follower.length:
        slender = f"more than a quarter of the length ({follower.length:.6g} m), and shear is not modelled"
        yield f"follower.{key} is {section.depth:.6g} m, {slender}"
    if section.depth > section.breadth and section.name == "rectangle":
        plane = "and lies in the plane of motion, so that the follower bends about its stiff side"
        yield f"follower.thickness is {section.depth:.6g} m, more than the width ({section.breadth:.6g} m), {plane}"
    density, modulus = follower.density, follower.elastic_modulus
    if not _DENSITIES[0] <= density <= _DENSITIES[1]:
        yield f"follower.mass_per_length (or density) and the section make a density of {density:.3g} kg/m^3"
    least = _METAL_MODULUS if density > _METAL_DENSITY else _MODULI[0]
    if not follower.is_rigid and not least <= modulus <= _MODULI[1]:
        unit = "GPa" if modulus >= units.in_si("GPa") else "MPa"
        made = f"a modulus of {modulus / units.in_si(unit):.3g} {unit} at a density of {density:.4g} kg/m^3"
        yield f"follower.bending_stiffness (or elastic_modulus) and the section make {made} (aluminium has 70 GPa, steel 210 GPa)"


_MOST_STEPS: Final = 2_000_000  # output steps: a table of a gigabyte
_LARGEST_ANGLE: Final = math.radians(1e6)  # doubles are 4e-12 rad apart there; at far larger angles a crank would turn in jumps
_ROUNDING: Final = 1e-9  # relative error allowed in a quotient of two doubles that were read from decimal texts


class Content(NamedTuple):
    """What a document says: see `cases.files.case.Case`."""

    name: str
    title: str
    tags: tuple[str, ...]
    scene: Scene
    duration: float  # s
    output_step: float  # s
    notes: tuple[str, ...]  # doubts about values


def read(document: Document) -> Content:
    """The content of a document.

    Raises:
        CaseError: all mistakes of single values; if every value can be read, values that contradict each other.
    """
    mistakes = list(document.mistakes)
    header = attempted(mistakes, header_of, document)
    values = _values(document, mistakes)
    mistakes += _mistaken_keys(document)
    if header is None or mistakes:
        raise together(mistakes)
    name, title, tags = header
    times = values.pop("simulation")
    try:
        scene = scene_of(values)
    except ImpossibleMechanism as impossible:
        mistakes.append(_impossible(document, impossible))
    if problem := misfit(times["duration"], times["output_step"]):
        mistakes.append(document.error(document.blame("simulation.duration", "simulation.output_step"), *problem))
    if mistakes:
        raise together(mistakes)
    return Content(name, with_changes(title, document.overridden), tags, scene, **times, notes=tuple(doubts(scene)))


def changes_of(texts: Mapping[str, Any], source: str) -> dict[str, Value]:
    """Changes in SI, which remember their texts: dotted key -> text as on the command line, or list of texts.

    CaseError, which names `source`: all mistakes.
    """
    if ranged := next((path for path, text in texts.items() if PLUS_MINUS in str(text)), None):
        raise CaseError(source, ranged, as_written(texts[ranged]), "has a tolerance", "give single values here")
    document = Document(source, {}, {}).overridden_by(texts, source)
    values = in_si(document)
    return {path: _written(text, values.at(path)) for path, text in document.overridden.items()}


def _written(text: Any, value: Any) -> Value:
    if isinstance(value, Table):
        return value
    return tuple(map(Written, value, text)) if isinstance(value, tuple) else Written(value, text)


def in_si(document: Document) -> Document:
    """The document with numbers in SI in place of its texts, under the keys that it has. CaseError: all mistakes of single values."""
    mistakes = list(document.mistakes)
    values = _values(document, mistakes)
    if mistakes:
        raise together(mistakes)
    return replace(document, values=values)


def misfit(duration: float, output_step: float) -> tuple[str, str] | None:
    """The mistake in a pair of simulation times (s) and what is accepted, or None."""
    steps = duration / output_step
    times = f"duration {duration:.9g} s, output step {output_step:.9g} s"
    if steps > _MOST_STEPS:
        return f"gives {steps:.3g} output steps ({times})", f"at most {_MOST_STEPS // 1_000_000} million are accepted"
    if round(steps) < 1 or abs(steps - round(steps)) > _ROUNDING * steps:
        return f"gives {steps:.6g} output steps ({times})", "the duration must be a whole multiple of the output step"
    return None


def _mistaken_keys(document: Document) -> Iterator[CaseError]:
    """Conflicting keys and missing ones. A key that is given with a mistake, or probably meant by an unknown key, is not missing."""
    given = {section: set(keys) for section, keys in document.values.items()}
    for mistake in document.mistakes:
        section, _, key = (mistake.key or "").partition(".")
        given.setdefault(section, set()).add(key)
    times = given.get("simulation")
    missing = ["[simulation]"] if times is None else [f"simulation.{key}" for key in SECTIONS["simulation"] if key not in times]
    accepted = ""
    for misfit_of_keys in misfits_of_keys(given):
        if isinstance(misfit_of_keys, MissingQuantity):
            missing, accepted = [*misfit_of_keys.keys, *missing], misfit_of_keys.accepted
        else:
            yield _impossible(document, misfit_of_keys)
    meant = " ".join(mistake.accepted for mistake in document.mistakes)
    if missing := [key for key in missing if key.strip("[]") not in meant]:
        yield _missing(document, missing, accepted)


def _impossible(document: Document, impossible: ImpossibleMechanism) -> CaseError:
    """Values that contradict each other as a mistake of the document, with the exception as its cause."""
    blamed, problem = document.blame(impossible.key, *impossible.others), impossible.problem
    if blamed != impossible.key and not problem.startswith("cannot be:"):
        problem = f"does not fit: {impossible.key} {problem}"
    mistake = document.error(blamed, problem, impossible.accepted)
    mistake.__cause__ = impossible
    return mistake


def _missing(document: Document, keys: Sequence[str], accepted: str = "") -> CaseError:
    """The message for keys, and sections as `[name]`, that must be there."""
    first, *others = keys
    also = ", ".join(others[:-1]) + " and " * (len(others) > 1) + "".join(others[-1:])
    told = "is missing" + (f", and so {'are' if len(others) > 1 else 'is'} {also}" if others else "")
    for old, new in document.replaced.items():
        if new in document.overridden and new != first and old in replaced_by([first]):
            problem, accepted = f"takes the place of {old} and needs {first} as well", f"give both, or {old} alone"
            return document.error(new, problem, f"{accepted}; {first} is {dimension_of(first).name}, such as {dimension_of(first).example}")
    if first in PATHS:
        dimension = dimension_of(first)
        example = dimension.example_in(usual_unit(first, document.values))
        return document.error(first, f"this key {told}", accepted or f"write {dimension.name}, such as {example}")
    return document.error(first, f"this section {told}", accepted or f"its keys are {', '.join(SECTIONS[first.strip('[]')])}")


def _values(document: Document, mistakes: list[CaseError]) -> dict[str, dict[str, Any]]:
    """SI value, or tuple of SI values, by section and key; mistakes are added to `mistakes`."""
    return {
        section: {key: attempted(mistakes, _quantity, document, f"{section}.{key}", written) for key, written in keys.items()}
        for section, keys in document.values.items()
    }


def _quantity(document: Document, path: str, written: Any) -> Any:
    """SI value, or tuple of SI values, of the text at a key; of one with a tolerance the nominal value."""
    if isinstance(written, (list, tuple)):
        return tuple(_quantity(document, path, one) for one in written)
    if isinstance(written, Table) or (isinstance(written, float) and path not in document.overridden):
        return written
    try:
        is_toleranced = isinstance(written, str) and PLUS_MINUS in written
        value = toleranced(path, written).nominal if is_toleranced else value_at(path, written)
    except QuantityError as wrong:
        dimension = dimension_of(path)
        accepted = wrong.accepted.replace(dimension.advice(), dimension.advice(usual_unit(path, document.values)))
        raise document.error(path, wrong.problem, accepted, value=written) from None
    if path == "crank.initial_angle" and abs(value) > _LARGEST_ANGLE:
        raise document.error(path, "is beyond a million degrees", "angles from -1e6 deg to 1e6 deg are accepted")
    return value
