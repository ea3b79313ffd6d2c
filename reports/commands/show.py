"""`quickreturn show`: a scene in SI, and what each engine makes of it."""

import itertools
import re
from collections.abc import Sequence
from typing import Any

import click

from reports.commands.options import case_argument, json_option, load, read_assignments, refuse_engine_settings, set_option


@click.command(name="show")
@case_argument
@set_option
@json_option
def command(case: str, assignments: Sequence[str], as_json: bool) -> None:
    """Show the scene of CASE in SI units and the parts, joints and degrees of freedom that each engine builds."""
    from reports.output import print_json
    from reports.scene import scene_in_si, units

    overrides, settings = read_assignments(assignments)
    refuse_engine_settings(settings)
    loaded = load(case, overrides)
    document = {
        "name": loaded.name,
        "title": loaded.title,
        "tags": loaded.tags,
        "source": loaded.source,
        "notes": loaded.notes,
        "scene": scene_in_si(loaded),
        "units": units(),
        "engines": _models(loaded.scene),
    }
    if as_json:
        print_json(document)
    else:
        _print(document)


def _models(scene: Any) -> list[dict[str, Any]]:
    """Per engine what it builds, or in "refused" why it does not."""
    from cases.workers import Job, default_limits, run_jobs
    from engines.registry import engine_names
    from reports import engine_jobs

    names = engine_names()
    found = {}
    for outcome in run_jobs([Job(name, engine_jobs.model, (name, scene)) for name in names], limits=default_limits()):
        refused = str(outcome.error or "") or outcome.failure
        found[outcome.job.name] = {"engine": outcome.job.name, "refused": refused or None, **(outcome.value or {})}
    return [found[name] for name in names]


def _print(document: dict[str, Any]) -> None:
    from reports.output import print_table

    click.echo(f"{document['name']}: {document['title']}")
    for note in document["notes"]:
        click.echo(f"note: {note}")
    units = document["units"]
    for section, values in document["scene"].items():
        click.echo(f"\n{section}")
        print_table([(f"  {key}", _text(value), units[section][key]) for key, value in values.items()])
    for model in document["engines"]:
        if model["refused"]:
            click.echo(f"\n{model['engine']}: {model['refused']}")
            continue
        click.echo(f"\n{model['engine']}: {model['degrees_of_freedom']} degrees of freedom")
        lines = [("  body", body) for body in grouped(model["bodies"])] + [("  joint", joint) for joint in grouped(model["joints"])]
        print_table(lines or [("", "")])


def grouped(texts: Sequence[str]) -> list[str]:
    """Neighbours that differ in their numbers alone as one line: "link 1: rod", "link 2: rod" become "link 1 to 2: rod"."""
    lines = []
    for _, group in itertools.groupby(texts, lambda text: re.sub(r"\d+", "#", text)):
        members = list(group)
        first, last = re.search(r"\d+", members[0]), re.search(r"\d+", members[-1])
        if len(members) > 1 and first and last:
            lines.append(f"{members[0][: first.end()]} to {last[0]}{members[0][first.end() :]}")
        else:
            lines += members
    return lines


def _text(value: Any) -> str:
    return ", ".join(map(_text, value)) if isinstance(value, (list, tuple)) else f"{value:.9g}"
