"""`quickreturn engines`: the engines and their settings."""

import click

import quickreturn as qr
from quickreturn.cases.jobs.job import Job
from quickreturn.commands import options
from quickreturn.reports.output import print_json, print_table


@click.command(name="engines")
@click.argument("engine", required=False)
@options.json
def engines(engine: str | None, as_json: bool) -> None:
    """List the engines: name, version, method, available or why not; for one ENGINE also its settings and default accuracy."""
    if engine is None:
        _list(as_json)
    else:
        _describe(engine, as_json)


def _list(as_json: bool) -> None:
    found = qr.list_engines()
    if as_json:
        print_json(found)
    else:
        click.echo(repr(found))


def _describe(name: str, as_json: bool) -> None:
    from quickreturn.questions import asked, settings, value_of

    found = value_of(*asked([Job(name, settings, (name,))], name))
    if as_json:
        print_json(found)
        return
    click.echo(f"{name}: {found.method}; {found.version or f'not available: {found.reason}'}")
    click.echo(f"estimates: {found.estimate}")
    click.echo(f"finds settings for the accuracy asked, {found.default_accuracy:g} unless --accuracy says otherwise; --set fixes them:")
    print_table([(row.name, row.accepted, row.meaning) for row in found.settings], ("SETTING", "ACCEPTED", "MEANING"))
