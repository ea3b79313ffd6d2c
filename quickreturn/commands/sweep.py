"""`quickreturn sweep`: the settled motion of every machine of a grid."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import click

from quickreturn.commands import console, options
from quickreturn.commands.console import ExitCode
from quickreturn.commands.options import PICTURES
from quickreturn.engines.settings import SettingError
from quickreturn.reports.output import check_writable, print_json, write_file
from quickreturn.table_files import dataset_file

ENDINGS: Final = (".nc", ".csv", ".parquet")


class _WithMeasures(click.Command):
    """A command whose help lists the measures at its end."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the measures."""
        from quickreturn.cases.measures.catalogue import listed

        with formatter.section("Measures"):
            formatter.write_dl([(each.name, f"{each.meaning[0].upper()}{each.meaning[1:]} [{each.unit}].") for each in listed()])


@click.command(name="sweep", cls=_WithMeasures)
@options.case
@options.several("--vary", "axes", metavar="AXIS", required=True, help="Key and values: KEY = a .. b : n, log a .. b : n, or a; b; c.")
@options.several("--measure", "measures", metavar="NAME", help="What to measure; default: peak.tip_acceleration and multiplier.")
@options.engines
@options.accuracy
@options.assignments
@options.single("--path", metavar="WAY", default="up", help="Direction through each row: up (default), down or both.")
@click.option(
    "--claims/--no-claims", default=True, help="Estimate the error of every number (default), or not, which saves half of the time or more."
)
@options.output("File for the result of every point: .nc, .csv or .parquet.")
@options.single("--plot", metavar="FILE", help="File for a picture: lines over one key, a heat map over two.")
@options.of_workshop
@options.json
def command(
    case: str,
    axes: Sequence[str],
    measures: Sequence[str],
    engines: Sequence[str],
    accuracy: float | None,
    assignments: Sequence[str],
    path: str,
    claims: bool,
    output: str,
    plot: str | None,
    as_json: bool,
) -> int:
    """Measure the settled motion of every machine of a grid.

    Any key of a case file can vary, with values and units as there, and so can engines ("engine = reference; mujoco"). Each row of the grid
    is computed as a whole, from one point to the next, and stored: an interrupted study goes on with the same command.

    Points that are unstable, impossible or fail are results and have a status; exit code 3: no point has a number.
    """
    from quickreturn.cases.sweep.grid import ENGINE, axis
    from quickreturn.sweeping import USUAL, computed, dataset_of, summary

    overrides, settings = options.read_assignments(assignments)
    loaded = options.load(case, overrides)
    options.refuse_missing(engines)
    check_writable(Path(output), loaded.source, *ENDINGS)
    varied = [axis(text) for text in (*axes, *([f"{ENGINE} = {'; '.join(engines)}"] if len(engines) > 1 else ()))]
    texts = {name: value for given in settings.values() for name, value in given.items()}
    if texts and any(each.key == ENGINE for each in varied):
        raise SettingError(f"{next(iter(texts))}: settings need one engine, and here several are asked for; vary one engine at a time")
    if plot is not None:
        from quickreturn.reports.drawing.study import LINES, draw, drawable
        from quickreturn.reports.drawing.style import picture

        check_writable(Path(plot), "" if loaded.source == "library" else case, *PICTURES)
        if not drawable(varied):
            accepted = f"a picture needs a key with finite numbers in order, and at most one more, with such or up to {LINES} values"
            raise click.UsageError(f"--plot: {accepted}; leave --plot out, or vary less")
    workshop = options.opened_workshop([loaded], engines)
    found = computed(loaded, varied, measures or USUAL, engines[0], accuracy, texts, claims, path, workshop)
    dataset = dataset_of(found)
    write_file(Path(output), dataset_file(dataset, Path(output).suffix.lower()))
    if plot is not None:
        write_file(Path(plot), picture(draw(found), Path(plot).suffix.lower()))
    if as_json:
        print_json({"case": loaded.name, "points": found.statuses.size, "statuses": found.counts, "output": output})
    else:
        click.echo("\n".join(summary(dataset)))
    if any(map(math.isfinite, found.values.flat)):
        return ExitCode.GOOD
    console.tell(f"{loaded.name}: no point has a number: {found.sentences.flat[0]}")
    return ExitCode.ENGINE_TROUBLE
