"""`quickreturn engines`: which engines there are, which can be used here, and what can be set."""

from typing import TYPE_CHECKING

import click

from quickreturn.commands.options import json_option

if TYPE_CHECKING:
    from quickreturn.questions import About


@click.command(name="engines")
@click.argument("engine", required=False)
@json_option
def command(engine: str | None, as_json: bool) -> None:
    """List the engines: name, version, method, available or why not; of one ENGINE also the settings and the default accuracy."""
    if engine is None:
        _list(as_json)
    else:
        _describe(engine, as_json)


def _list(as_json: bool) -> None:
    from engines.registry import OWN
    from quickreturn.questions import About, about, asked_of_all
    from reports.output import print_json, print_table

    rows = []
    for outcome in asked_of_all(about, (), "engines", OWN):
        broken = About(name=outcome.job.name, method="unknown", available=False, reason=f"asked about itself, it {outcome.failure}")
        rows.append(outcome.value or broken)
    if as_json:
        print_json(rows)
        return
    state = ["available" if row.available else f"not available: {row.reason}" for row in rows]
    table = [(row.name, row.version or "-", _estimate(row), row.method, text) for row, text in zip(rows, state, strict=True)]
    print_table(table, ("NAME", "VERSION", "ESTIMATES", "METHOD", "STATE"))


def _estimate(row: "About") -> str:
    """What the engine's error estimate is of."""
    from reports.words import ESTIMATE

    if row.estimate_of is None:
        return "-"
    name, beside = ESTIMATE[row.estimate_of]
    return f"{name.removesuffix(' estimate')}{beside and '; '}{beside}"


def _describe(name: str, as_json: bool) -> None:
    from cases.jobs.job import Job
    from quickreturn.questions import answer_of, settings
    from reports.output import print_json, print_table

    found = answer_of(Job(name, settings, (name,)))
    if as_json:
        print_json(found)
        return
    click.echo(f"{name}: {found.method}; {found.version or f'not available: {found.reason}'}")
    click.echo(f"estimates: {_estimate(found)}")
    click.echo(f"finds settings for the accuracy asked, {found.default_accuracy:g} unless --accuracy says otherwise; --set fixes them:")
    print_table([(row.name, row.accepted, row.meaning) for row in found.settings], ("SETTING", "ACCEPTED", "MEANING"))
