"""`quickreturn resonance`: the periodic motion over a quantity of the machine, through folds."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import click

from quickreturn.commands import options
from quickreturn.commands.console import ExitCode
from quickreturn.commands.options import PICTURES
from quickreturn.reports.output import check_writable, print_json, write_file

TABLES: Final = (".csv", ".nc", ".parquet")


@click.command(name="resonance")
@options.case
@options.single("--speed", metavar="RANGE", help='Prescribed crank speed: "60 rpm .. 300 rpm"; with --vary a single speed.')
@options.single("--vary", metavar="RANGE", help='Another key that varies instead: tip.mass="0 g .. 100 g".')
@options.several("--measure", "measures", metavar="NAME", help="Measure, such as peak.strain_2; default: peak.tip_acceleration.")
@options.accuracy
@click.option(
    "--claims/--no-claims", default=True, help="Estimate the error of every point (default), or not, which saves a third of the time."
)
@options.case_assignments
@options.output(f"File for the table ({', '.join(TABLES)}) or for a picture ({', '.join(PICTURES)}).", required=False)
@options.single("--plot", metavar="FILE", help="File for a picture, beside the table.")
@options.limited
@options.json
def command(
    case: str,
    speed: str | None,
    vary: str | None,
    measures: Sequence[str],
    accuracy: float | None,
    claims: bool,
    assignments: Sequence[str],
    output: str | None,
    plot: str | None,
    as_json: bool,
) -> int:
    """Follow the periodic motion of CASE over the crank's speed or another key.

    The curve passes through folds, where two motions meet. Its table has stable and unstable motions, the largest Floquet multiplier,
    special points (fold, period doubling, torus, slider left), peaks with the order of the harmonic that drives them, and the error claim
    of every point. A machine with a driving torque is held at the prescribed speed.

    Exit code 3: no periodic motion was found in the range.
    """
    from quickreturn.cases.resonance_curve.range import SPEED, range_of
    from quickreturn.cases.resonance_curve.search import USUAL, job
    from quickreturn.questions import value_of
    from quickreturn.reports.drawing.style import picture
    from quickreturn.resonance_curves import Resonance, speed_of

    loaded = options.load(case, options.read_overrides(assignments))
    if vary is not None:
        key, _, text = vary.partition("=")
        varied, held = range_of(key.strip(), text.strip(), "--vary"), speed_of(speed, "--speed")
    elif speed is not None:
        varied, held = range_of(SPEED, speed, "--speed"), None
    else:
        raise click.UsageError("Missing option '--speed'; give a range such as \"60 rpm .. 300 rpm\"")
    asked = job(loaded, varied, held, measures or (USUAL,), accuracy, claims)
    for file, endings in ((output, (*TABLES, *PICTURES)), (plot, PICTURES)):
        if file is not None:
            check_writable(Path(file), loaded.source, *endings)
    workshop = options.opened_workshop([loaded], ["reference"])
    found = Resonance(loaded.name, value_of(workshop.outcomes([asked], "resonance curve")[0]))
    for file in (each for each in (output, plot) if each is not None):
        ending = Path(file).suffix.lower()
        write_file(Path(file), picture(found.plot(), ending) if ending in PICTURES else found.written(ending))
    if as_json:
        print_json({"case": loaded.name, "output": output, **found.document()})
    else:
        click.echo(repr(found))
    return ExitCode.GOOD
