"""`quickreturn cases`: what the library holds."""

import click

from quickreturn.commands.options import json_option, single_option


@click.command(name="cases")
@single_option("--tag", metavar="TAG", help="Only cases with this tag.")
@json_option
def command(tag: str | None, as_json: bool) -> None:
    """List the cases of the library: name, tags, title."""
    from cases.library import catalogue
    from reports.output import print_json, print_table

    known = sorted({each for entry in catalogue() for each in entry.tags})
    if tag is not None and tag not in known:
        raise click.UsageError(f'--tag "{tag}": no case has this tag; accepted: {", ".join(known)}')
    chosen = catalogue(tag)
    if as_json:
        print_json([{"name": case.name, "tags": case.tags, "title": case.title} for case in chosen])
    else:
        print_table([(case.name, ", ".join(case.tags), case.title) for case in chosen], ("NAME", "TAGS", "TITLE"))
