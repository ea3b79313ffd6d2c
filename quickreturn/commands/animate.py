"""`quickreturn animate`: the mechanism, moving."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import click

from cases.errors import as_written
from cases.units import plain_number
from quickreturn.commands import options

ENDINGS: Final = (".webp", ".html")


def _factor(context: click.Context, option: click.Parameter, text: str | None) -> float | None:
    value = None if text is None else plain_number(text)
    if text is not None and (value is None or not 0.0 < value <= 1e6):
        raise click.UsageError(f"--magnify {as_written(text)}: give a positive number, e.g. 5")
    return value


@click.command(name="animate")
@options.case
@options.engines
@options.duration
@options.single("--magnify", metavar="N", callback=_factor, help="How many times the deflection is magnified; default: so that it shows.")
@options.accuracy
@options.assignments
@options.output(f"Where it goes: {', '.join(ENDINGS)}.")
def command(
    case: str,
    engines: Sequence[str],
    duration: str | None,
    magnify: float | None,
    accuracy: float | None,
    assignments: Sequence[str],
    output: str,
) -> int:
    """Simulate CASE from the standard start and draw it moving, engines over each other.

    A .webp is a picture of the last turn, slowed down. A .html is a page that opens from disk, to be played, stopped and slowed down;
    there the deflection is magnified as the reader likes.
    """
    from quickreturn.commands.simulate import trajectories
    from reports.output import check_writable, write_file

    overrides, settings = options.read_assignments(assignments)
    names = list(dict.fromkeys(engines))
    texts = options.settings_of(settings, names)
    if magnify is not None and output.lower().endswith(".html"):
        raise click.UsageError("--magnify: in a page (.html) it is chosen with a slider; leave it out")
    loaded = options.load(case, overrides, duration)
    check_writable(Path(output), "", *ENDINGS)
    found = {name: trajectory for (_, name), trajectory in trajectories([loaded], names, texts, accuracy).items()}
    options.begin(f"drawing {output}")
    from quickreturn.animation import moving

    write_file(Path(output), moving(loaded, found, Path(output).suffix.lower(), magnify))
    click.echo(output)
    return 0
