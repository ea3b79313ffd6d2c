"""`quickreturn engines`: which engines there are, and which can be used here."""

import click

from reports.commands.options import json_option


@click.command(name="engines")
@json_option
def command(as_json: bool) -> None:
    """List the engines: name, version, method, available or why not."""
    from cases.workers import Job, run_jobs
    from engines.registry import engine_names
    from reports import engine_jobs
    from reports.output import print_json, print_table

    names = engine_names()
    outcomes = {outcome.job.name: outcome for outcome in run_jobs([Job(name, engine_jobs.about, (name,)) for name in names], preload=())}
    rows = [
        outcomes[name].value
        or {
            "name": name,
            "version": None,
            "method": "unknown",
            "available": False,
            "reason": f"asked about itself, it {outcomes[name].failure}",
        }
        for name in names
    ]
    if as_json:
        print_json(rows)
        return
    state = ["available" if row["available"] else f"not available: {row['reason']}" for row in rows]
    table = [(row["name"], row["version"] or "-", row["method"], text) for row, text in zip(rows, state, strict=True)]
    print_table(table, ("NAME", "VERSION", "METHOD", "STATE"))
