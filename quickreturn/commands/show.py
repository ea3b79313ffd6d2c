"""`quickreturn show`: a scene in SI, and the model that each engine builds of it."""

import shlex
from collections.abc import Sequence

import click

from quickreturn.cases.jobs.fork_server import DESCRIBING, get_ready
from quickreturn.commands import options
from quickreturn.reports.output import print_json


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
    overrides = options.read_overrides(assignments)
    if for_others and as_json:
        raise click.UsageError("--for-other-tools and --json are both given; what other tools need is a text, give one of them")
    if not for_others:
        get_ready((*DESCRIBING, "quickreturn.engines.exudyn.models"))
    loaded = options.load_all(cases, tag, overrides)
    if for_others:
        from quickreturn.reports.other_tools import for_other_tools

        click.echo("\n\n".join(for_other_tools(case, shlex.join(options.given_as(case, overrides))) for case in loaded))
        return
    from quickreturn.commands.case_document import document_of, print_document

    around: list[dict[str, list[str]]] = [{}] * len(loaded)
    if resonance:
        from quickreturn.commands.around_case import resonances

        around = resonances(loaded)
    documents = [document_of(case) | more for case, more in zip(loaded, around, strict=True)]
    if as_json:
        print_json(documents[0] if len(documents) == 1 else documents)
        return
    for number, document in enumerate(documents):
        click.echo("\n" * (number > 0), nl=False)
        print_document(document)
