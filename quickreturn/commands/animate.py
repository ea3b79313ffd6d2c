"""`quickreturn animate`: the mechanism, moving."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import click

from quickreturn.commands import console, options
from quickreturn.reports.output import check_writable, write_file

ENDINGS: Final = (".webp", ".html")


@click.command(name="animate")
@options.case
@options.engines
@options.duration
@options.single(
    "--magnify",
    metavar="N",
    read=options.number(1e-3, 1e6, 5),
    help="Factor of the deflection in the picture; default: a factor that makes it visible.",
)
@options.accuracy
@options.assignments
@options.stored
@options.output(f"File for the moving picture: {', '.join(ENDINGS)}.")
def command(
    case: str,
    engines: Sequence[str],
    duration: float | None,
    magnify: float | None,
    accuracy: float | None,
    assignments: Sequence[str],
    output: str,
) -> int:
    """Simulate CASE from the standard start and draw it moving, engines over each other.

    A .webp is a picture of the last turn, slowed down. A .html is a page that opens from disk, with controls to play, stop and slow down
    the motion, and to magnify the deflection.
    """
    from quickreturn.commands.trajectories import trajectories

    overrides, settings = options.read_assignments(assignments)
    if magnify is not None and output.lower().endswith(".html"):
        raise click.UsageError("--magnify: a page (.html) has a slider for it; leave it out")
    loaded = options.load(case, overrides, duration)
    check_writable(Path(output), "", *ENDINGS)
    found = {name: trajectory for (_, name), trajectory in trajectories([loaded], engines, settings, accuracy).items()}
    console.begin(f"drawing {output}")
    from quickreturn.reports.drawing.animation import moving

    write_file(Path(output), moving(loaded, found, Path(output).suffix.lower(), magnify))
    click.echo(output)
    return 0
