"""`quickreturn conform`: whether an engine does what it says."""

import click

from quickreturn.cases.jobs.fork_server import COMPUTING, get_ready
from quickreturn.cases.jobs.job import Outcome
from quickreturn.commands import options
from quickreturn.commands.console import ExitCode
from quickreturn.computing import Computing
from quickreturn.reports.output import print_json


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
    from quickreturn.plugins.conform import contract

    options.refuse_missing([engine])
    get_ready(COMPUTING)
    with computing.opened() as workshop:
        found = contract.conform(engine, workshop.executor, quick=quick)
        if not quick:
            workshop.kept(Outcome(contract.job(engine), found))
    if as_json:
        print_json(found)
    else:
        for check in found.checks:
            click.echo(f"{check.status:10}  {check.check}" + (f": {check.cause}" if check.cause else ""))
            if check.advice:
                click.echo(f"{'':10}  {check.advice}")
        click.echo(f"{engine}: {found.verdict}")
    return {True: ExitCode.GOOD, False: ExitCode.CLAIMS_BROKEN, None: ExitCode.ENGINE_TROUBLE}[found.conforms]
