"""`quickreturn conform`: whether an engine does what it says."""

import click

from quickreturn.commands import options


@click.command(name="conform")
@click.argument("engine", metavar="ENGINE")
@options.json
def command(engine: str, as_json: bool) -> int:
    """Try ENGINE: rows, columns, quantities of the scene, ladder, estimates, frequencies, failures.

    Exit code 0: it conforms; 1: it does not; 3: there was nothing to judge by. A coarse engine that says so is not accused.
    """
    from cases.conformance import conform
    from cases.jobs.processes import LocalProcesses, get_ready
    from quickreturn.command_line import CLAIMS_BROKEN, ENGINE_TROUBLE, GOOD
    from quickreturn.questions import COMPUTING
    from reports.output import print_json

    get_ready(COMPUTING)
    found = conform(engine, LocalProcesses())
    if as_json:
        print_json(found)
    else:
        for check in found.checks:
            click.echo(f"{check.status:10}  {check.check}" + (f": {check.cause}" if check.cause else ""))
            if check.advice:
                click.echo(f"{'':10}  {check.advice}")
        words = {True: "conforms", False: f"does not conform: {len(found.failed)} checks failed", None: "could not be judged"}
        click.echo(f"{engine} {words[found.conforms]}")
    return {True: GOOD, False: CLAIMS_BROKEN, None: ENGINE_TROUBLE}[found.conforms]
