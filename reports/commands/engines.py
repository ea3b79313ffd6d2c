"""`quickreturn engines`: which engines there are, which can be used here, and what can be set."""

from typing import Any

import click

from reports.commands.options import json_option


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
    from cases.workers import Job, default_limits, run_jobs
    from engines.registry import engine_names
    from reports import engine_jobs
    from reports.output import print_json, print_table

    names = engine_names()
    asked = run_jobs([Job(name, engine_jobs.about, (name,)) for name in names], limits=default_limits())
    outcomes = {outcome.job.name: outcome for outcome in asked}
    rows = [
        outcomes[name].value
        or {
            "name": name,
            "version": None,
            "method": "unknown",
            "estimate_of": None,
            "available": False,
            "reason": f"asked about itself, it {outcomes[name].failure}",
        }
        for name in names
    ]
    if as_json:
        print_json(rows)
        return
    state = ["available" if row["available"] else f"not available: {row['reason']}" for row in rows]
    table = [(row["name"], row["version"] or "-", _estimate(row), row["method"], text) for row, text in zip(rows, state, strict=True)]
    print_table(table, ("NAME", "VERSION", "ESTIMATES", "METHOD", "STATE"))


def _estimate(row: dict[str, Any]) -> str:
    """What the engine's error estimate is of."""
    from reports.words import ESTIMATE

    if row["estimate_of"] is None:
        return "-"
    name, beside = ESTIMATE[row["estimate_of"]]
    return f"{name.removesuffix(' estimate')}{beside and '; '}{beside}"


def _describe(name: str, as_json: bool) -> None:
    from cases.workers import Job
    from reports import engine_jobs
    from reports.output import print_json, print_table

    found = engine_jobs.answer_of(Job(name, engine_jobs.settings, (name,)))
    if as_json:
        print_json(found)
        return
    click.echo(f"{name}: {found['method']}; {found['version'] or 'not available: ' + found['reason']}")
    click.echo(f"estimates: {_estimate(found)}")
    click.echo(f"finds settings for the accuracy asked, {found['default_accuracy']:g} unless --accuracy says otherwise; --set fixes them:")
    print_table([tuple(row.values()) for row in found["settings"]], ("SETTING", "ACCEPTED", "MEANING"))
