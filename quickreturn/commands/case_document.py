"""A case as a JSON document and as text for `show`, and as a new case file for `new`."""

import itertools
import math
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import click

from quickreturn.cases.files.case import Case, written_document
from quickreturn.cases.files.document import NAME
from quickreturn.cases.files.errors import CaseError, path_shown
from quickreturn.cases.files.keys import PATHS, SECTIONS, shown_value, unit_given
from quickreturn.cases.files.reading import doubts
from quickreturn.cases.files.shown import Unit
from quickreturn.cases.files.written import as_toml
from quickreturn.cases.library import in_library
from quickreturn.cases.motion.resonance import resonance
from quickreturn.descriptions import by_each, model
from quickreturn.engines.registry import own_engines
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.natural_modes import clamped_modes
from quickreturn.reports.output import OutputError, check_writable, print_table

ENDING: Final = ".toml"


def document_of(loaded: Case) -> dict[str, Any]:
    """The scene in SI units, and what follows from it."""
    return {name: getattr(loaded, name) for name in ("name", "title", "tags", "source", "notes")} | {
        "scene": loaded.values,
        "derived": _derived(loaded),
        "units": {section: {name: found.unit for name, found in keys.items()} for section, keys in SECTIONS.items()},
    }


def _derived(case: Case) -> dict[str, dict[str, Any]]:
    """What follows from the follower's numbers: name -> value, unit and meaning."""
    scene, follower = case.scene, case.scene.follower
    found = {
        "mass": (follower.mass, "kg", "of the follower"),
        "area": (follower.section.area(), "m^2", f"of the section: {follower.section.name}"),
        "second_moment": (follower.section.second_moment(), "m^4", "of that area, about the axis of bending"),
        "slenderness": (follower.slenderness, "", "length over thickness"),
    }
    if scene.crank is None:
        found["first_bending_frequency"] = (float(clamped_modes(scene, 1).frequencies[0]), "Hz", "base held")
    elif first := resonance(scene):
        if case.mechanism.crank_is_free:
            found["mean_crank_speed"] = (2.0 * math.pi * first.crank, "rad/s", "of the rigid mechanism, with its loads and losses")
        found["first_bending_frequency"] = (first.lowest, "Hz", "crank held, the least over its turn")
        found["mean_bending_frequency"] = (first.first_mode, "Hz", "crank held, the mean over its turn")
        found["resonance"] = (first.ratio, "", f"vibrations in a turn: {first.sentence(case.units)} (`run` says how strongly it is driven)")
    return {name: {"value": value, "unit": unit, "meaning": meaning} for name, (value, unit, meaning) in found.items()}


def models(scene: Scene) -> Iterator[dict[str, Any]]:
    """What each engine builds, as it comes, or in "refused" the reason why it does not."""
    for outcome in by_each(model, (scene,), "models", own_engines().keys() - {"exudyn"}):
        built = vars(outcome.value) if outcome.value else {}
        yield {"engine": outcome.job.name, "refused": str(outcome.error or "") or outcome.failure or None, **built}


def print_document(document: dict[str, Any], case: Case) -> None:
    """Print the document of a case, in the case's units; then what engines build, as it comes."""
    click.echo(f"{document['name']}: {document['title']}")
    for note in document["notes"]:
        click.echo(f"note: {note}")
    for section, values in document["scene"].items():
        click.echo(f"\n{section}")
        print_table([(f"  {key}", *_in_units(case, f"{section}.{key}", value)) for key, value in values.items()])
    click.echo("\nwhat follows")
    derived = document["derived"].items()
    print_table([(f"  {name}", *_texts(of["value"], case.units.of(of["unit"])), of["meaning"]) for name, of in derived])
    for built in models(case.scene):
        if built["refused"]:
            click.echo(f"\n{built['engine']}: {built['refused']}")
            continue
        count = built["degrees_of_freedom"]
        click.echo(f"\n{built['engine']}: {'an unknown number of' if count is None else count} degree{'s' * (count != 1)} of freedom")
        lines = [("  body", body) for body in grouped(built["bodies"])] + [("  joint", joint) for joint in grouped(built["joints"])]
        print_table(lines or [("", "")])


def _in_units(case: Case, path: str, value: Any) -> tuple[str, str]:
    """A value (SI) at a key as text, and its unit: that in which the file gives it, if it does. A table tells its own."""
    if PATHS[path].in_file:
        return shown_value(value), ""
    written = None if case.shown_in or case.document is None else case.document.at(path)
    texts = [written] if isinstance(written, str) else written
    if texts and all(isinstance(text, str) for text in texts):
        unit = Unit(*unit_given(path, texts))
        return _texts(value, unit) if unit.name != PATHS[path].unit else _texts(value, case.units.of(unit.name))
    return _texts(value, case.units.of(PATHS[path].unit))


def _texts(value: Any, unit: Unit) -> tuple[str, str]:
    scaled = tuple(each / unit.size for each in value) if isinstance(value, (list, tuple)) else value / unit.size
    return shown_value(scaled), unit.name


def grouped(texts: Sequence[str]) -> list[str]:
    """Neighbours that differ only in their numbers, as one line: "link 1: rod", "link 2: rod" become "link 1 to 2: rod"."""
    lines = []
    for _, group in itertools.groupby(texts, lambda text: re.sub(r"\d+", "#", text)):
        members = list(group)
        first, last = re.search(r"\d+", members[0]), re.search(r"\d+", members[-1])
        if len(members) > 1 and first and last:
            lines.append(f"{members[0][: first.end()]} to {last[0]}{members[0][first.end() :]}")
        else:
            lines += members
    return lines


def text_of(original: Case, header: dict[str, str], *, copied: bool) -> str:
    """The text of a file with the values of a case under another name and title; `copied`: comments name the case."""
    return as_toml(replace(written_document(original), header=header), tuple(_origin(original)) if copied else ())


def header_for(file: str) -> dict[str, str]:
    """Name and title of the case in a new file, after the file's name.

    Raises:
        CaseError: the file exists, or its name is invalid for a case or is that of a case of the library.
        UsageError: it cannot be written.
    """
    if os.path.lexists(file) and not os.path.isdir(file):
        raise CaseError(path_shown(file), None, None, "this file exists and is not overwritten", "give another name")
    try:
        check_writable(Path(file), "", ENDING)
    except OutputError as wrong:
        raise click.UsageError(str(wrong)) from None
    name = Path(file).stem
    if not NAME.fullmatch(name):
        usable = re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("._-")[:64] or "my-machine"
        accepted = f"up to 64 letters from a to z, digits, points, hyphens and underscores are accepted, such as {usable}{ENDING}"
        raise CaseError(path_shown(file), None, None, "its name is also that of the case, and cannot be one", accepted)
    if in_library(name):
        raise CaseError(path_shown(file), None, None, f"the library has a case {name}", f"give another name, such as my-{name}{ENDING}")
    title = name.replace("-", " ").replace("_", " ")
    return {"name": name, "title": title[:1].upper() + title[1:]}


def _origin(case: Case) -> Iterator[str]:
    """Comment lines in a copy that name the copied case and its notes."""
    yield f"A copy of {case.name} ({case.title})."
    meant = tuple(doubts(case.scene))
    yield from (f"Note: {note}." for note in case.notes if note not in meant)
