"""`quickreturn plot`: a picture of cases, or curves of trajectories."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from quickreturn.commands import console, options
from quickreturn.reports.output import check_writable, write_file


@click.command(name="plot")
@click.argument("sources", metavar="[CASE|FILE]...", nargs=-1, shell_complete=options.complete_case)
@options.tag
@options.engines_for(help="Engine to simulate with, see `quickreturn engines`; may be given again.")
@click.option(
    "--column", "columns", metavar="NAME", multiple=True, help="Column to show; may be given again. Default: four, such as strain_2."
)
@options.duration
@options.accuracy
@options.assignments
@options.stored
@options.output(f"File for the picture: {', '.join(options.PICTURES)}.")
def command(
    sources: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    columns: Sequence[str],
    duration: float | None,
    accuracy: float | None,
    assignments: Sequence[str],
    output: str,
) -> int:
    """Draw each CASE; with --engine, simulate it and draw columns of its trajectory over time.

    A FILE is a table as `simulate` writes it or as `compare` takes it (its name ends in .csv): its columns are drawn over those of the
    other sources.
    """
    from quickreturn.cases.recorded import is_table, read_table
    from quickreturn.commands.trajectories import trajectories
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
        solved = trajectories(loaded, engines, settings, accuracy)
        shown |= {name if len(loaded) == 1 else f"{case} {name}": found.columns for (case, name), found in solved.items()}
        figure = curves(shown, columns, title=f"{loaded[0].name}: {loaded[0].title}" if len(loaded) == 1 else "")
    write_file(Path(output), picture(figure, Path(output).suffix.lower()))
    click.echo(output)
    return 0
