"""`quickreturn sweep`, `uncertainty`, `resonance` and `calibrate`: a machine over its quantities, and these from a recorded table."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import click

import quickreturn as qr
from quickreturn.commands import options
from quickreturn.commands.console import Call, ExitCode, check_file, tell, tell_slow, write
from quickreturn.computing import workshop
from quickreturn.dataset import dataset_file, table_file
from quickreturn.engines.settings import SettingError
from quickreturn.reports.output import PICTURES

DATASETS: Final = (".nc", ".csv", ".parquet")
TABLES: Final = (".csv", ".parquet")


class _WithMeasures(click.Command):
    """A command whose help lists the measures at its end."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the measures."""
        from quickreturn.cases.motion.catalogue import listed

        with formatter.section("Measures"):
            formatter.write_dl([(each.name, f"{each.meaning[0].upper()}{each.meaning[1:]} [{each.unit}].") for each in listed()])


def _claims(saved: str, of: str = "number") -> options.Option:
    words = f"Estimate the error of every {of} (default), or not, which saves {saved}."
    return click.option("--claims/--no-claims", default=True, help=words)


def _merged(settings: Mapping[str, Mapping[str, str]]) -> dict[str, str]:
    """The settings of the one engine of a study."""
    return {name: value for given in settings.values() for name, value in given.items()}


@options.command(
    options.case,
    options.several("--vary", "axes", metavar="AXIS", required=True, help="Key and values: KEY = a .. b : n, log a .. b : n, or a; b; c."),
    options.several("--measure", "measures", metavar="NAME", help="What to measure; default: peak.tip_acceleration and multiplier."),
    options.engines,
    options.accuracy,
    options.assignments,
    _claims("half of the time or more"),
    options.output("File for the result of every point: .nc, .csv or .parquet.  [required]", required=False),
    options.of_workshop,
    options.json,
    cls=_WithMeasures,
)
def sweep(call: Call, axes: Sequence[str], measures: Sequence[str], claims: bool) -> int:
    """Measure the settled motion of every machine of a grid.

    Any key of a case file can vary, with values and units as there, and so can engines ("engine = reference; mujoco"). Each row of the grid
    is computed as a whole, from one point to the next, and stored: an interrupted study goes on with the same command.

    Points that are unstable, impossible or fail are results and have a status; exit code 3: no point has a number.
    """
    from quickreturn.plugins.studies.sweep.grid import ENGINE, axis
    from quickreturn.plugins.studies.sweep.sweeping import USUAL, computed, dataset_of, summary

    loaded, texts = call.case(), _merged(call.settings)
    call.refuse_missing()
    varied = [axis(text) for text in (*axes, *([f"{ENGINE} = {'; '.join(call.engines)}"] if len(call.engines) > 1 else ()))]
    if call.output is None:  # after mistakes in the axes
        raise click.MissingParameter(param_type="option", param_hint="'--output'")
    check_file(call.output, loaded.source, DATASETS)
    if texts and any(each.key == ENGINE for each in varied):
        raise SettingError(f"{next(iter(texts))}: settings need one engine, and here several are asked for; vary one engine at a time")
    tell_slow([loaded])
    with workshop(None, call.quiet, [loaded], call.engines) as opened:
        found = computed(loaded, varied, measures or USUAL, call.engines[0], call.accuracy, texts, claims, opened)
    dataset = dataset_of(found)
    write(call.output, lambda ending: dataset_file(dataset, ending))
    document = {"case": loaded.name, "points": found.statuses.size, "statuses": found.counts, "output": call.output}
    call.show(document, "\n".join(summary(dataset, loaded.units)))
    if any(map(math.isfinite, found.values.flat)):
        return ExitCode.GOOD
    tell(f"{loaded.name}: no point has a number: {found.sentences.flat[0]}")
    return ExitCode.ENGINE_TROUBLE


@options.command(
    click.argument("study", metavar="STUDY", shell_complete=options.complete_case),
    options.units,
    options.several("--measure", "measures", metavar="NAME", help="What to measure, see `quickreturn sweep --help`."),
    options.single(
        "--samples", metavar="N", read=options.number(1, 1e6, 256, whole=True), help="Number of points, a power of two; default: 256."
    ),
    options.single("--engine", metavar="E", help="Engine, see `quickreturn engines`; default: reference."),
    options.accuracy,
    options.assignments,
    _claims("half of the time"),
    options.output(f"File for the points: {' or '.join(TABLES)}.", required=False),
    options.of_workshop,
    options.json,
)
def uncertainty(call: Call, study: str, measures: Sequence[str], samples: int | None, engine: str | None, claims: bool) -> int:
    """Say how much measures scatter because quantities do: bands, and the share of each quantity.

    STUDY is a TOML file with case, measures, and a table [uncertain] of distributions; optionally samples, engine and accuracy. Or it is a
    case whose values have tolerances, such as thickness = "6 mm +- 0.1 mm": within these every value is equally likely.

    Every number has two errors, kept apart: that from the finite number of points, and the simulation's own. Each point is stored at once:
    an interrupted study goes on with the same command, and one with twice as many points computes the new ones.

    Exit code 3: more than 5 % of the points have no such measure, and so it has no band.
    """
    from quickreturn.plugins.studies.uncertainty.study import is_study, points_of, study_of

    given = study_of(study, call.overrides) if is_study(study) else {"case": call.case(study)}
    if call.units is not None:
        given["case"] = given["case"].in_units(call.units)
    points = points_of(given, study, measures, samples, engine, _merged(call.settings), claims, call.accuracy)
    check_file(call.output, study, TABLES)
    with workshop(None, call.quiet, [points.case], [points.asked.engine]) as opened:
        found = points.scatter(opened)
    write(call.output, lambda ending: table_file(found.frame, found.frame.attrs["units"], ending))
    call.show({**found.document(), "output": call.output}, repr(found))
    without: dict[str, list[str]] = {}
    for name in found.measures:
        without.setdefault(found.lacking(name), []).append(name)
    without.pop("", None)
    for reason, names in without.items():
        tell(f"{points.case.name}: no band of {' and '.join(names)}: {'; '.join((reason, *found.failures))}")
    return ExitCode.ENGINE_TROUBLE if without else ExitCode.GOOD


@options.command(
    options.case,
    options.single("--speed", metavar="RANGE", help='Prescribed crank speed: "60 rpm .. 300 rpm"; with --vary a single speed.'),
    options.single("--vary", metavar="RANGE", help='Another key that varies instead: tip.mass="0 g .. 100 g".'),
    options.several("--measure", "measures", metavar="NAME", help="Measure, such as peak.strain_2; default: peak.tip_acceleration."),
    options.accuracy,
    _claims("a third of the time", "point"),
    options.case_assignments,
    options.output(f"File for the table ({', '.join(TABLES)}) or for a picture ({', '.join(PICTURES)}).", required=False),
    options.limited,
    options.json,
)
def resonance(call: Call, speed: str | None, vary: str | None, measures: Sequence[str], claims: bool) -> int:
    """Follow the periodic motion of CASE over the crank's speed or another key.

    The curve passes through folds, where two motions meet. Its table has stable and unstable motions, the largest Floquet multiplier,
    special points (fold, period doubling, torus, slider left), peaks with the harmonic that drives them (7 x crank = first mode), and the
    error claim of every point. A machine with a driving torque is held at the prescribed speed. The answer says how many motions the
    machine has at its own speed, which are stable, and how far the nearest peak and the nearest change of stability are. Pieces of the
    curve are stored at once: an interrupted command goes on where it was.

    Exit code 3: no periodic motion was found in the range, or the curve could not be followed over all of it.
    """
    from quickreturn.descriptions import value_of
    from quickreturn.plugins.studies.resonance_curve.curve import SPEED, range_of
    from quickreturn.plugins.studies.resonance_curve.resonance import Resonance, speed_of
    from quickreturn.plugins.studies.resonance_curve.search import USUAL, job
    from quickreturn.reports.drawing.style import picture

    loaded = call.case()
    if vary is not None:
        key, _, text = vary.partition("=")
        varied, held = range_of(key.strip(), text.strip(), "--vary"), speed_of(speed, "--speed")
    elif speed is not None:
        varied, held = range_of(SPEED, speed, "--speed"), None
    else:
        raise click.UsageError("Missing option '--speed'; give a range such as \"60 rpm .. 300 rpm\"")
    curve = job(loaded, varied, held, measures or (USUAL,), call.accuracy, claims)
    check_file(call.output, loaded.source, (*TABLES, *PICTURES))
    with workshop(None, call.quiet, [loaded], ["reference"]) as opened:
        found = Resonance(loaded, value_of(opened.outcomes([curve], "resonance curve")[0]))
    frame = found.frame
    write(
        call.output, lambda ending: picture(found.plot(), ending) if ending in PICTURES else table_file(frame, frame.attrs["units"], ending)
    )
    call.show({"case": loaded.name, "output": call.output, **found.document()}, repr(found))
    return ExitCode.ENGINE_TROUBLE if found.curve.lost else ExitCode.GOOD


@options.command(
    options.case,
    click.argument("file", metavar="FILE"),
    options.several(
        "--free", metavar="KEY", required=True, help='Parameter to find, alone or with a range: "tip.center_of_mass = 0 in .. 0.5 in".'
    ),
    options.table_options,
    options.case_assignments,
    options.output("File for the case with the values found: .toml.", "CASE_FILE", required=False),
    options.limited,
    options.json,
)
def calibrate(call: Call, file: str, free: Sequence[str], **reading: Any) -> None:
    """Find parameters of CASE from a recorded table by least squares.

    FILE is a table as `quickreturn compare` reads it. A table that begins in the standard start is fitted row by row in time, any other
    table in the steady state at equal crank angles. The engine is reference; the search begins at the case's values, or those of --set.

    The 95 % intervals come from the residuals and allow for their correlation. The simulation's own error is given beside them. The output
    names the combinations of parameters that this table cannot determine.
    """
    loaded = call.case()
    check_file(call.output, loaded.source, (".toml",))
    (table,) = options.read_tables([file], reading)
    found = qr.calibrate(loaded, table, free, limits=call.limits, quiet=call.quiet)
    write(call.output, lambda ending: found.fitted.to_toml().encode())
    call.show(found.as_document(), repr(found))
