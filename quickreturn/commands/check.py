"""`quickreturn check`: a table against reference results of the pack, as `pack/check.py` judges it without the package."""

from pathlib import Path

import click

from quickreturn.commands import options
from quickreturn.commands.console import ExitCode
from quickreturn.pack.check import LARGEST, BadInput, judged
from quickreturn.reports.output import print_json


@click.command(name="check")
@click.argument("problem", metavar="PROBLEM")
@click.argument("file", metavar="FILE")
@options.single(
    "--share",
    metavar="REL",
    read=options.number(0.0, LARGEST, 1e-3),
    default="0",
    show_default=True,
    help="Part of each signal's largest value that is added to its bound.",
)
@options.json
def check(problem: str, file: str, share: float, as_json: bool) -> int:
    """Judge a table by the reference results of PROBLEM.

    A PROBLEM is a folder of the pack, such as sag or thesis-24; its problem.md says what to compute. FILE is a CSV table with `time` and
    names of signals in its first line, in SI units. Each signal is within its bound, outside, beyond the horizon or missing.

    Exit code 1: a signal is outside.
    """
    try:
        verdicts = judged(problem, Path(file), share)
    except BadInput as wrong:
        raise click.ClickException(str(wrong)) from None
    if as_json:
        print_json({"problem": problem, "signals": [each._asdict() for each in verdicts]})
    else:
        click.echo("\n".join(f"{each.signal:18} {each.status:18} {each.told}".rstrip() for each in verdicts))
    return ExitCode.CLAIMS_BROKEN if any(each.status == "outside" for each in verdicts) else ExitCode.GOOD
