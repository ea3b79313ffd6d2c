"""`quickreturn engines` and `conform`: the engines, their settings, and whether one does what it says."""

import click

import quickreturn as qr
from quickreturn.cases.jobs.fork_server import COMPUTING, get_ready
from quickreturn.cases.jobs.job import Job, Outcome
from quickreturn.commands import options
from quickreturn.commands.console import ExitCode
from quickreturn.computing import Computing
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


@click.command(name="conform")
@click.argument("engine", metavar="ENGINE")
@click.option("--quick", is_flag=True, help="Try motion, frequencies and failures alone.")
@options.json
@options.computing
def conform(engine: str, quick: bool, as_json: bool, computing: Computing) -> int:
    """Test ENGINE: rows, columns, quantities of the scene, ladder, estimates, frequencies, failures.

    The outcome is stored with the results, and the report shows it beside the engine's version; that of a quick trial is not stored.

    Exit code 0: it conforms; 1: it does not; 3: nothing could be judged. An engine that is coarse and says so still conforms.
    """
    from quickreturn.cases import conformance

    options.refuse_missing([engine])
    get_ready(COMPUTING)
    with computing.opened() as workshop:
        found = conformance.conform(engine, workshop.executor, quick=quick)
        if not quick:
            workshop.kept(Outcome(conformance.job(engine), found))
    if as_json:
        print_json(found)
    else:
        for check in found.checks:
            click.echo(f"{check.status:10}  {check.check}" + (f": {check.cause}" if check.cause else ""))
            if check.advice:
                click.echo(f"{'':10}  {check.advice}")
        click.echo(f"{engine}: {found.verdict}")
    return {True: ExitCode.GOOD, False: ExitCode.CLAIMS_BROKEN, None: ExitCode.ENGINE_TROUBLE}[found.conforms]
