"""`quickreturn plot` and `animate`: pictures of cases, curves of trajectories, and the mechanism, moving."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import click

from quickreturn.commands import console, options
from quickreturn.computing import Computing
from quickreturn.reports.output import check_writable, write_file

#: Endings of moving pictures.
MOVING: Final = (".webp", ".html")


@click.command(name="plot")
@click.argument("sources", metavar="[CASE|FILE]...", nargs=-1, shell_complete=options.complete_case)
@options.tag
@options.units
@options.engines_for(help="Engine to simulate with, see `quickreturn engines`; may be given again.")
@click.option(
    "--column", "columns", metavar="NAME", multiple=True, help="Column to show; may be given again. Default: four, such as strain_2."
)
@options.duration
@options.accuracy
@options.assignments
@options.stored
@options.output(f"File for the picture: {', '.join(options.PICTURES)}.")
@options.computing
def plot(
    sources: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    columns: Sequence[str],
    duration: float | None,
    accuracy: float | None,
    assignments: Sequence[str],
    output: str,
    computing: Computing,
) -> int:
    """Draw each CASE; with --engine, simulate it and draw columns of its trajectory over time.

    A FILE is a table as `simulate` writes it or as `compare` takes it (its name ends in .csv): its columns are drawn over those of the
    other sources.
    """
    from quickreturn.cases.recorded import is_table, read_table
    from quickreturn.cases.shown import units_named
    from quickreturn.commands.answers import trajectories
    from quickreturn.reports.drawing.style import picture

    overrides, settings = options.read_assignments(assignments)
    files, cases = ([each for each in sources if is_table(each) is wanted] for wanted in (True, False))
    loaded = options.load_all(cases, tag, overrides, duration) if cases or tag or not files else []
    if files and loaded and not engines:
        raise click.UsageError(f"to draw {loaded[0].name} over {files[0]}, give --engine: it has no trajectory yet")
    given = {"--column": () if files else columns, "--duration": duration, "--accuracy": accuracy, "--set": settings}
    for what, value in given.items():
        if value and not engines:
            raise click.UsageError(f"{what}: without --engine nothing is simulated; give --engine as well")
    check_writable(Path(output), "", *options.PICTURES)
    console.begin(f"drawing {output}")
    if not engines and not files:
        from quickreturn.reports.drawing.mechanism import mechanisms

        figure = mechanisms(loaded)
    else:
        from quickreturn.reports.drawing.curves import curves

        shown: dict[str, Mapping[str, Any]] = {Path(file).stem: read_table(file).columns for file in files}
        solved = trajectories(loaded, engines, settings, accuracy, computing)
        shown |= {name if len(loaded) == 1 else f"{case} {name}": found.columns for (case, name), found in solved.items()}
        title = f"{loaded[0].name}: {loaded[0].title}" if len(loaded) == 1 else ""
        figure = curves(shown, columns, title=title, units=loaded[0].units if loaded else units_named(console.call().units or "mm"))
    write_file(Path(output), picture(figure, Path(output).suffix.lower()))
    click.echo(output)
    return 0


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
@options.output(f"File for the moving picture: {', '.join(MOVING)}.")
@options.computing
def animate(
    case: str,
    engines: Sequence[str],
    duration: float | None,
    magnify: float | None,
    accuracy: float | None,
    assignments: Sequence[str],
    output: str,
    computing: Computing,
) -> int:
    """Simulate CASE from the standard start and draw it moving, engines over each other.

    A .webp is a picture of the last turn, slowed down. A .html is a page that opens from disk, with controls to play, stop and slow down
    the motion, and to magnify the deflection.
    """
    from quickreturn.commands.answers import trajectories

    overrides, settings = options.read_assignments(assignments)
    if magnify is not None and output.lower().endswith(".html"):
        raise click.UsageError("--magnify: a page (.html) has a slider for it; leave it out")
    loaded = options.load(case, overrides, duration)
    check_writable(Path(output), "", *MOVING)
    solved = trajectories([loaded], engines, settings, accuracy, computing)
    found = {name: trajectory for (_, name), trajectory in solved.items()}
    console.begin(f"drawing {output}")
    from quickreturn.reports.drawing.animation import moving

    write_file(Path(output), moving(loaded, found, Path(output).suffix.lower(), magnify))
    click.echo(output)
    return 0
