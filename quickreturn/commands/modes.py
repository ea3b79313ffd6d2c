"""`quickreturn modes`: natural frequencies with the crank held."""

import math
from collections.abc import Sequence

import click

from quickreturn.cases.jobs.fork_server import COMPUTING, get_ready
from quickreturn.commands import options
from quickreturn.commands.console import ExitCode
from quickreturn.computing import Computing
from quickreturn.reports.output import print_json


@click.command(name="modes")
@options.cases
@options.tag
@options.engines
@options.single(
    "--crank-angle",
    "crank_angles",
    metavar="DEG",
    read=options.angles,
    default="0:180:90",
    show_default=True,
    help="Angle at which the crank is held, degrees; or FROM:TO:STEP, both ends included.",
)
@options.single(
    "--count",
    metavar="N",
    read=options.number(1, 100, 4, whole=True),
    default="4",
    show_default=True,
    help="Largest number of frequencies, 1 to 100.",
)
@options.assignments
@options.stored
@options.json
@options.computing
def modes(
    cases: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    crank_angles: list[float],
    count: int,
    assignments: Sequence[str],
    as_json: bool,
    computing: Computing,
) -> int:
    """Compute natural frequencies (Hz) of CASE with the crank held: follower straight, at rest, no gravity, undamped.

    With several engines, cases or angles the JSON document is a list. Exit code 3: an engine failed, or returned something other than
    natural frequencies; nothing is printed then.
    """
    overrides, settings = options.read_assignments(assignments)
    get_ready(COMPUTING)
    from quickreturn.commands.answers import frequencies, print_frequencies

    loaded = options.load_all(cases, tag, overrides)
    rows = frequencies(loaded, engines, settings, [math.radians(angle) for angle in crank_angles], count, computing)
    if as_json:
        documents = [each for angled in rows for each in angled]
        print_json(documents[0] if len(documents) == 1 else documents)
    else:
        for angled in rows:
            print_frequencies(angled)
    return ExitCode.GOOD
