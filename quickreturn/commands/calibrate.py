"""`quickreturn calibrate`: parameters of a case from a recorded table."""

from collections.abc import Sequence
from pathlib import Path

import click

import quickreturn as qr
from quickreturn.commands import console, options
from quickreturn.commands.console import ExitCode
from quickreturn.reports.output import check_writable, print_json, write_file


@click.command(name="calibrate")
@options.case
@click.argument("file", metavar="FILE")
@options.several(
    "--free", metavar="KEY", required=True, help='Parameter to find, alone or with a range: "tip.center_of_mass = 0 in .. 0.5 in".'
)
@options.case_assignments
@options.single("--output", metavar="CASE_FILE", help="File for the case with the values found: .toml.")
@options.limited
@options.json
def command(case: str, file: str, free: Sequence[str], assignments: Sequence[str], output: str | None, as_json: bool) -> int:
    """Find parameters of CASE from a recorded table by least squares.

    FILE is a CSV table as `quickreturn compare` reads it. A table that begins in the standard start is fitted row by row in time, any other
    table in the steady state at equal crank angles. The engine is reference; the search begins at the case's values, or those of --set.

    The 95 % intervals come from the residuals and allow for their correlation. The simulation's own error is given beside them. The output
    names the combinations of parameters that this table cannot determine.
    """
    loaded = options.load(case, options.read_overrides(assignments))
    if output is not None:
        check_writable(Path(output), loaded.source, ".toml")
    found = qr.calibrate(loaded, file, free, limits=options.limits(), quiet=console.quiet())
    if output is not None:
        write_file(Path(output), found.fitted.to_toml().encode())
    if as_json:
        print_json(found.as_document())
    else:
        click.echo(repr(found))
    return ExitCode.GOOD
