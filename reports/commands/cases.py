"""`quickreturn cases`: what the library holds."""

import click

from reports.commands.options import json_option


@click.command(name="cases")
@click.option("--tag", metavar="TAG", help="Only cases with this tag.")
@json_option
def command(tag: str | None, as_json: bool) -> None:
    """List the cases of the library: name, tags, title."""
    from cases.case_file import load_case
    from cases.library import case_names
    from reports.output import print_json, print_table

    cases = [load_case(name) for name in case_names()]
    known = sorted({each for case in cases for each in case.tags})
    if tag is not None and tag not in known:
        raise click.UsageError(f'--tag "{tag}": no case has this tag; accepted: {", ".join(known)}')
    chosen = [case for case in cases if tag is None or tag in case.tags]
    if as_json:
        print_json([{"name": case.name, "tags": case.tags, "title": case.title} for case in chosen])
    else:
        print_table([(case.name, ", ".join(case.tags), case.title) for case in chosen], ("NAME", "TAGS", "TITLE"))
