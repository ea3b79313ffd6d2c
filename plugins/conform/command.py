"""`quickreturn conform`: whether an engine does what it says."""

import click

from quickreturn.cases.running.fork_server import COMPUTING, get_ready
from quickreturn.cases.running.job import Outcome
from quickreturn.commands import options
from quickreturn.commands.console import Call, ExitCode
from quickreturn.computing import workshop


@options.command(
    click.argument("engine", metavar="ENGINE"),
    click.option("--quick", is_flag=True, help="Try motion, frequencies and failures alone."),
    options.json,
)
def conform(call: Call, engine: str, quick: bool) -> int:
    """Test ENGINE: rows, columns, quantities of the scene, ladder, estimates, frequencies, failures.

    The outcome is stored with the results, and the report shows it beside the engine's version; that of a quick trial is not stored.

    Exit code 0: it conforms; 1: it does not; 3: nothing could be judged. An engine that is coarse and says so still conforms.
    """
    from quickreturn.plugins.conform import contract

    call.engines = (engine,)
    call.refuse_missing()
    get_ready(COMPUTING)
    with workshop(None, call.quiet) as opened:
        found = contract.conform(engine, opened.executor, quick=quick)
        if not quick:
            opened.kept(Outcome(contract.job(engine), found))
    call.show(found, repr(found))
    return {True: ExitCode.GOOD, False: ExitCode.CLAIMS_BROKEN, None: ExitCode.ENGINE_TROUBLE}[found.conforms]
