"""`quickreturn show`: a scene in SI, and the model that each engine builds of it."""

import itertools
import re
import shlex
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from quickreturn.commands import options

if TYPE_CHECKING:
    from quickreturn.cases.case import Case
    from quickreturn.cases.sweep.rows import Row
    from quickreturn.reference_model.mechanism import Scene


@click.command(name="show")
@options.cases
@options.tag
@options.case_assignments
@click.option("--for-other-tools", "for_others", is_flag=True, help="Print instead what another tool needs to build the scene.")
@click.option("--resonance", is_flag=True, help="Also follow the motion over speeds around the machine's own, which takes a while.")
@options.json
def command(cases: Sequence[str], tag: str | None, assignments: Sequence[str], for_others: bool, resonance: bool, as_json: bool) -> None:
    """Show the scene of CASE in SI units and the parts, joints and degrees of freedom that each engine builds.

    With several cases the JSON document is a list.
    """
    from quickreturn.cases.jobs.fork_server import get_ready
    from quickreturn.questions import DESCRIBING
    from quickreturn.reports.output import print_json

    overrides = options.read_overrides(assignments)
    if for_others:
        if as_json:
            raise click.UsageError("--for-other-tools and --json are both given; what other tools need is a text, give one of them")
        _print_for_others(options.load_all(cases, tag, overrides), overrides)
        return
    get_ready((*DESCRIBING, "quickreturn.engines.scene", "quickreturn.engines.exudyn.flexible"))
    loaded = options.load_all(cases, tag, overrides)
    around = _resonances(loaded) if resonance else [{}] * len(loaded)
    documents = [_document(case) | more for case, more in zip(loaded, around, strict=True)]
    if as_json:
        print_json(documents[0] if len(documents) == 1 else documents)
        return
    for number, document in enumerate(documents):
        click.echo("\n" * (number > 0), nl=False)
        _print(document)


def _print_for_others(cases: "Sequence[Case]", overrides: Mapping[str, str]) -> None:
    from quickreturn.reports.other_tools import for_other_tools

    click.echo("\n\n".join(for_other_tools(case, shlex.join(options.given_as(case, overrides))) for case in cases))


def _document(loaded: "Case") -> dict[str, Any]:
    from quickreturn.cases.keys import SECTIONS

    return {name: getattr(loaded, name) for name in ("name", "title", "tags", "source", "notes")} | {
        "scene": loaded.values,
        "derived": _derived(loaded.scene),
        "units": {section: {name: found.unit for name, found in keys.items()} for section, keys in SECTIONS.items()},
        "engines": _models(loaded.scene),
    }


def _resonances(cases: "Sequence[Case]") -> list[dict[str, list[str]]]:
    """Lines on the motion of each case over speeds around its own."""
    from quickreturn.cases.resonance_curve import job_around
    from quickreturn.cases.sweep.grid import job
    from quickreturn.cases.sweep.rows import MeasureRequest
    from quickreturn.questions import value_of
    from quickreturn.reports.results.around import Around

    workshop = options.opened_workshop()
    outcomes = workshop.outcomes([job_around(case) for case in cases], "resonance curves")
    asked = MeasureRequest(measures=("multiplier",))
    own = workshop.outcomes([job(case, [{}], asked) for case in cases], "motions at their own speeds")
    return [
        {"resonance_curve": [*Around(case, value_of(outcome)).lines, _stability(value_of(row))]}
        for case, outcome, row in zip(cases, outcomes, own, strict=True)
    ]


def _stability(row: "Row") -> str:
    """A line on the motion of a machine with its own drive, from a row of one point and its multiplier."""
    value, error = row.values[0, 0], row.errors[0, 0]
    reason = f": {row.sentences[0]}" if row.sentences[0] else ""
    if row.statuses[0] == "settled":
        left = f"{100.0 * value:.3g} % of a disturbance is left after a turn (+- {100.0 * error:.1g} %)"
        return f"with its own drive the motion is stable: {left}"
    return f"with its own drive the motion is {row.statuses[0]}{reason}"


def _derived(scene: "Scene") -> dict[str, dict[str, Any]]:
    """What follows from the follower's numbers: name -> value, unit and meaning."""
    from quickreturn.cases.loads import resonance
    from quickreturn.reference_model.natural_modes import clamped_modes

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


def _models(scene: Any) -> list[dict[str, Any]]:
    """What each engine builds, or in "refused" the reason why it does not."""
    from quickreturn.engines.registry import LIGHT
    from quickreturn.questions import asked_of_all, model

    found = []
    for outcome in asked_of_all(model, (scene,), "models", LIGHT - {"exudyn"}):
        built = vars(outcome.value) if outcome.value else {}
        found.append({"engine": outcome.job.name, "refused": str(outcome.error or "") or outcome.failure or None, **built})
    return found


def _print(document: dict[str, Any]) -> None:
    from quickreturn.cases.keys import shown_value
    from quickreturn.reports.output import print_table

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
    for model in document["engines"]:
        if model["refused"]:
            click.echo(f"\n{model['engine']}: {model['refused']}")
            continue
        count = model["degrees_of_freedom"]
        click.echo(f"\n{model['engine']}: {count} degree{'s' * (count != 1)} of freedom")
        lines = [("  body", body) for body in grouped(model["bodies"])] + [("  joint", joint) for joint in grouped(model["joints"])]
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
