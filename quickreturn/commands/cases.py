"""`quickreturn cases`: the cases of the library."""

import click

import quickreturn as qr
from quickreturn.commands import options
from quickreturn.reports.output import print_json


@click.command(name="cases")
@options.single("--tag", metavar="TAG", help="Only cases with this tag.")
@options.json
def command(tag: str | None, as_json: bool) -> None:
    """List the cases of the library: name, tags, title."""
    found = qr.list_cases(tag)
    if as_json:
        print_json([{"name": case.name, "tags": case.tags, "title": case.title} for case in found])
    else:
        click.echo(repr(found))
