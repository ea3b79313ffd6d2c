"""From a document to a `Case` in SI units, or to one sentence about what is wrong with it."""

import math
from collections.abc import Mapping
from typing import Any, Final

from cases.case import Case
from cases.document import Document, header_of, read_document
from cases.errors import CaseError
from cases.keys import PATHS, SECTIONS, dimension_of
from cases.units import QuantityError, parse_quantity
from reference_model.mechanism import ImpossibleMechanism, Scene, doubts
from reference_model.scene_values import MissingQuantity, scene_of

_MOST_STEPS: Final = 2_000_000  # a table of a gigabyte
_LARGEST_ANGLE: Final = math.radians(1e6)  # there a double is still exact to 4e-12 rad; far beyond, a crank would turn in jumps
_ROUNDING: Final = 1e-9  # relative; a quotient of two doubles that were read from decimal texts


def parse_case(text: str, source: str, overrides: Mapping[str, str] | None = None) -> Case:
    """The case that a TOML text describes.

    Args:
        text: of the file.
        source: what messages call it.
        overrides: dotted key -> text as in the file, e.g. {"crank.length": "5 in"}.

    Raises:
        CaseError: any mistake in text or overrides.
    """
    return case_of(read_document(text, source).overridden_by(overrides or {}))


def case_of(document: Document) -> Case:
    """The case that a document describes.

    Raises:
        CaseError: any mistake in it.
    """
    name, title, tags = header_of(document)
    values = {section: _section(document, section) for section in SECTIONS if section in document.sections}
    scene = _scene(document, {section: keys for section, keys in values.items() if section != "simulation"})
    times = values.get("simulation", {})
    for key in SECTIONS["simulation"]:
        if "simulation" not in values:
            problem, accepted = "this section is missing", f"its keys are {', '.join(SECTIONS['simulation'])}"
            raise CaseError(document.source, "[simulation]", None, problem, accepted)
        if key not in times:
            raise _missing(document, f"simulation.{key}", "this key is missing")
    if problem_of_times := misfit(times["duration"], times["output_step"]):
        raise document.error(document.blame("simulation.duration", "simulation.output_step"), *problem_of_times)
    return Case(name=name, title=title, tags=tags, scene=scene, source=document.source, notes=tuple(doubts(scene)), **times)


def misfit(duration: float, output_step: float) -> tuple[str, str] | None:
    """What is wrong with a pair of simulation times (s) and what is accepted, or None."""
    steps = duration / output_step
    times = f"duration {duration:.9g} s, output step {output_step:.9g} s"
    if steps > _MOST_STEPS:
        return f"gives {steps:.3g} output steps ({times})", f"at most {_MOST_STEPS // 1_000_000} million are accepted"
    if round(steps) < 1 or abs(steps - round(steps)) > _ROUNDING * steps:
        return f"gives {steps:.6g} output steps ({times})", "the duration must be a whole multiple of the output step"
    return None


def _scene(document: Document, values: Mapping[str, Mapping[str, Any]]) -> Scene:
    if abs(values.get("crank", {}).get("initial_angle", 0.0)) > _LARGEST_ANGLE:
        raise document.error("crank.initial_angle", "is beyond a million degrees", "angles from -1e6 deg to 1e6 deg are accepted")
    try:
        return scene_of(values)
    except MissingQuantity as lacking:
        if lacking.key in PATHS:
            raise _missing(document, lacking.key, lacking.problem) from None
        raise CaseError(document.source, lacking.key, None, lacking.problem, lacking.accepted) from None
    except ImpossibleMechanism as impossible:
        key = document.blame(impossible.key, *impossible.others)
        raise document.error(key, impossible.problem, impossible.accepted) from None


def _missing(document: Document, path: str, problem: str) -> CaseError:
    """The message for a key that must be there."""
    dimension = dimension_of(path)
    return document.error(path, problem, f"write {dimension.name}, such as {dimension.example}")


def _section(document: Document, section: str) -> dict[str, Any]:
    """SI values of a section's keys that are written there."""
    paths = {name: f"{section}.{name}" for name in SECTIONS[section]}
    return {name: _quantity(document, path, document.values[path]) for name, path in paths.items() if path in document.values}


def _quantity(document: Document, path: str, written: Any) -> Any:
    """SI value, or tuple of SI values, of what is written at a key."""
    if isinstance(written, (list, tuple)):
        return tuple(_quantity(document, path, one) for one in written)
    if isinstance(written, float):
        return written
    wanted, dimension = PATHS[path], dimension_of(path)
    try:
        value = parse_quantity(written, dimension, infinity_accepted=wanted.infinity)
    except QuantityError as wrong:
        raise document.error(path, wrong.problem, wrong.accepted, value=written) from None
    if wanted.sign == "positive" and value <= 0.0:
        raise document.error(path, "is not positive", f"{dimension.name} greater than zero is accepted", value=written)
    if wanted.sign == "not negative" and value < 0.0:
        raise document.error(path, "is negative", f"{dimension.name} of zero or more is accepted", value=written)
    return value
