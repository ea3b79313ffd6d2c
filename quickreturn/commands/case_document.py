"""The JSON document of a case for `show`, and its text."""

import itertools
import re
from collections.abc import Sequence
from typing import Any

import click

from quickreturn.cases.case import Case
from quickreturn.cases.keys import SECTIONS, shown_value
from quickreturn.cases.loads import resonance
from quickreturn.engines.registry import LIGHT
from quickreturn.questions import asked_of_all, model
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.natural_modes import clamped_modes
from quickreturn.reports.output import print_table


def document_of(loaded: Case) -> dict[str, Any]:
    """The scene in SI units, what follows from it, and the model that each engine builds."""
    return {name: getattr(loaded, name) for name in ("name", "title", "tags", "source", "notes")} | {
        "scene": loaded.values,
        "derived": _derived(loaded.scene),
        "units": {section: {name: found.unit for name, found in keys.items()} for section, keys in SECTIONS.items()},
        "engines": _models(loaded.scene),
    }


def _derived(scene: Scene) -> dict[str, dict[str, Any]]:
    """What follows from the follower's numbers: name -> value, unit and meaning."""
    follower = scene.follower
    found = {
        "mass": (follower.mass, "kg", "of the follower"),
        "slenderness": (follower.slenderness, "", "length over thickness"),
    }
    if scene.crank is None:
        found["first_bending_frequency"] = (float(clamped_modes(scene, 1).frequencies[0]), "Hz", "base held")
    elif first := resonance(scene):
        found["first_bending_frequency"] = (first.lowest, "Hz", "crank held, the least over its turn")
        found["mean_bending_frequency"] = (first.first_mode, "Hz", "crank held, the mean over its turn")
        found["resonance"] = (first.ratio, "", f"that mean over the crank's frequency: {first.sentence}")
    return {name: {"value": value, "unit": unit, "meaning": meaning} for name, (value, unit, meaning) in found.items()}


def _models(scene: Scene) -> list[dict[str, Any]]:
    """What each engine builds, or in "refused" the reason why it does not."""
    found = []
    for outcome in asked_of_all(model, (scene,), "models", LIGHT - {"exudyn"}):
        built = vars(outcome.value) if outcome.value else {}
        found.append({"engine": outcome.job.name, "refused": str(outcome.error or "") or outcome.failure or None, **built})
    return found


def print_document(document: dict[str, Any]) -> None:
    """Print a document, which may have lines of `around_case.resonances`."""
    click.echo(f"{document['name']}: {document['title']}")
    for note in document["notes"]:
        click.echo(f"note: {note}")
    units = document["units"]
    for section, values in document["scene"].items():
        click.echo(f"\n{section}")
        print_table([(f"  {key}", shown_value(value), units[section][key]) for key, value in values.items()])
    click.echo("\nwhat follows")
    print_table([(f"  {name}", shown_value(of["value"]), of["unit"], of["meaning"]) for name, of in document["derived"].items()])
    for line in ("", *document["resonance_curve"]) if "resonance_curve" in document else ():
        click.echo(line)
    for built in document["engines"]:
        if built["refused"]:
            click.echo(f"\n{built['engine']}: {built['refused']}")
            continue
        count = built["degrees_of_freedom"]
        click.echo(f"\n{built['engine']}: {count} degree{'s' * (count != 1)} of freedom")
        lines = [("  body", body) for body in grouped(built["bodies"])] + [("  joint", joint) for joint in grouped(built["joints"])]
        print_table(lines or [("", "")])


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
