"""`quickreturn conform`: whether an engine does what it says."""

import click

from quickreturn.cases.jobs.fork_server import COMPUTING, get_ready
from quickreturn.cases.jobs.job import Outcome
from quickreturn.commands import options
from quickreturn.commands.console import ExitCode
from quickreturn.reports.output import print_json


@click.command(name="conform")
@click.argument("engine", metavar="ENGINE")
@click.option("--quick", is_flag=True, help="Take about half a minute: the motion first; the checks that are left out are named.")
@options.json
def command(engine: str, quick: bool, as_json: bool) -> int:
    """Test ENGINE: rows, columns, quantities of the scene, ladder, estimates, frequencies, failures.

    The outcome is stored with the results, and the report shows it beside the engine's version; the outcome of a quick trial is not stored.

    Exit code 0: it conforms; 1: it does not; 3: nothing could be judged. An engine that is coarse and says so still conforms.
    """
    from quickreturn.cases.conformance import QUICK, conform, job

    options.refuse_missing([engine])
    get_ready(COMPUTING)
    workshop = options.opened_workshop()
    found = conform(engine, workshop.executor, seconds=QUICK if quick else None)
    if not quick:
        workshop.kept(Outcome(job(engine), found))
    if as_json:
        print_json(found)
    else:
        for check in found.checks:
            if check.left_out:
                continue  # they are named below
            click.echo(f"{check.status:10}  {check.check}" + (f": {check.cause}" if check.cause else ""))
            if check.advice:
                click.echo(f"{'':10}  {check.advice}")
        if found.left_out:
            click.echo(f"{'left out':10}  for lack of time: {', '.join(found.left_out)}")
        click.echo(f"{engine}: {found.verdict}")
    return {True: ExitCode.GOOD, False: ExitCode.CLAIMS_BROKEN, None: ExitCode.ENGINE_TROUBLE}[found.conforms]
