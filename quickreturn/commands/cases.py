"""`quickreturn cases`: what the library holds."""

import click

from quickreturn.commands.options import json_option, single_option


@click.command(name="cases")
@single_option("--tag", metavar="TAG", help="Only cases with this tag.")
@json_option
def command(tag: str | None, as_json: bool) -> None:
    """List the cases of the library: name, tags, title."""
    from quickreturn.catalogue import cases
    from reports.output import print_json

    found = cases(tag)
    if as_json:
        print_json([{"name": case.name, "tags": case.tags, "title": case.title} for case in found])
    else:
        click.echo(repr(found))
