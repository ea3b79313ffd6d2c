"""`quickreturn simulate`, `modes`, `plot` and `animate`: trajectories from the standard start, frequencies, and pictures."""

import itertools
import math
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

import click

from quickreturn.cases.running.fork_server import COMPUTING, get_ready
from quickreturn.commands import options
from quickreturn.commands.console import Call, ExitCode, check_file, tell, write
from quickreturn.reports.output import MOVING, PICTURES

if TYPE_CHECKING:
    from quickreturn.cases.files.case import Case
    from quickreturn.commands.solved import Found


@options.command(
    options.cases,
    options.tag,
    options.engines,
    options.duration,
    options.output_step,
    options.accuracy,
    click.option("--no-estimate", is_flag=True, help="Make one run without an error estimate."),
    options.assignments,
    options.output(
        "File for the trajectory. For several engines or cases put {engine} or {case} into its name. Default: nothing is written.",
        "FILE.csv",
        required=False,
    ),
    options.limited,
    options.stored,
    options.json,
)
def simulate(call: Call, no_estimate: bool) -> int:
    """Simulate CASE from the standard start; with --output, write the trajectory.

    Exit code 3: the engine failed, did not reach the accuracy, or cannot say whether it did, because its error estimate is unknown or not
    verified; the file has the rows that it delivered. An engine that crashed or was stopped at a limit delivers none. Runs for the error
    estimate that could exceed --time-limit are not begun. The accuracy of `thesis` is that of the integration of its own equations. With
    several engines or cases the JSON document is a list.
    """
    if no_estimate and call.accuracy is not None:
        raise click.UsageError(f"--accuracy {call.accuracy:g} and --no-estimate are both given; give one of them")
    get_ready(COMPUTING)  # what it imports takes longer than what this process does
    from quickreturn.commands.solved import NOTHING, solved, written
    from quickreturn.readings import readings

    loaded = call.loaded()
    places = _places(call.output, loaded, call.engines)
    for case, name in itertools.product(loaded, call.engines):
        check_file(places[case.name, name], case.source, (".csv",))
    documents: list[dict[str, Any]] = []
    texts: list[str] = []
    refusal: Exception | None = None
    for case, name, outcome, found in solved(call, loaded, estimate=not no_estimate):
        try:
            known = written(outcome, found, places[case.name, name])
        except Exception as error:  # the results of the others are written before the error is raised
            refusal = refusal or error
            continue
        document = {"case": case.name, "engine": name, "output": places[case.name, name], "notes": case.notes, "accuracy": call.accuracy}
        documents.append(document | NOTHING | {key: {} for key in readings()} | known)
        texts.append(_text(documents[-1], found, shlex.join(["quickreturn", "show", *call.arguments_for(case)])))
    if documents:
        advice = f"no trajectory is written; --output {_example(loaded, call.engines)} writes {'it' if len(places) == 1 else 'them'}"
        text = "\n\n".join(texts) + (f"\n{advice}" if call.output is None else "")
        call.show(documents[0] if len(places) == 1 else documents, text)
    missed = [document for document in documents if not document["reached"]]
    for document in missed:
        kept = "there is nothing to keep"
        if document["rows"]:
            kept = f"{document['rows']} rows are kept {f'in {place}' if (place := document['output']) else 'only with --output'}"
        tell(f"{document['case']}: engine {document['engine']}: {document['remark']}; {kept}")
    if refusal is not None:
        raise refusal
    return ExitCode.ENGINE_TROUBLE if missed else ExitCode.GOOD


def _places(output: str | None, cases: "Sequence[Case]", engines: Sequence[str]) -> dict[tuple[str, str], str | None]:
    """The file of each case and engine, if one is to be written. UsageError: two would have the same file."""
    if output is None:
        return dict.fromkeys((case.name, engine) for case in cases for engine in engines)
    for what, several in (("{engine}", engines), ("{case}", cases)):
        if len(several) > 1 and what not in output:
            raise click.UsageError(f"--output {output}: several {what[1:-1]}s would write the same file; put {what} into its name")
    names = {engine: PurePath(engine).name for engine in engines}  # of an engine's file the name without its folder
    if twice := next((engine for engine in engines if list(names.values()).count(names[engine]) > 1), None):
        raise click.UsageError(f"--output {output}: two engines are called {names[twice]}; simulate one after the other")
    return {
        (case.name, each): output.replace("{engine}", name).replace("{case}", case.name) for case in cases for each, name in names.items()
    }


def _example(cases: "Sequence[Case]", engines: Sequence[str]) -> str:
    """A value of --output for some cases and engines."""
    return f"{cases[0].name if len(cases) == 1 else '{case}'}{'-{engine}' if len(engines) > 1 else ''}.csv"


def _text(document: Mapping[str, Any], found: "Found", notes: str) -> str:
    """A simulation as a table; `notes`: the command that shows those on the case."""
    from quickreturn.cases.files.shown import Rows

    if isinstance(found, Exception):
        rows: list[Any] = [("case", document["case"]), ("engine", f"{document['engine']} ({document['version'] or 'version unknown'})")]
        if document["notes"]:
            rows.append(("notes", f"{len(document['notes'])} on this case: see `{notes}`"))
    else:
        complete = found.reached or found.result.error_estimate is None  # otherwise standard error says why not
        rows = [row for row in found.rows(document["output"] or "", f"`{notes}`") if complete or row[0] != "remark"]
    return Rows(rows).text()


@options.command(
    options.cases,
    options.tag,
    options.engines,
    options.single(
        "--crank-angle",
        "crank_angles",
        metavar="DEG",
        read=options.angles,
        default="0:180:90",
        show_default=True,
        help="Angle at which the crank is held, degrees; or FROM:TO:STEP, both ends included.",
    ),
    options.single(
        "--count",
        metavar="N",
        read=options.number(1, 100, 4, whole=True),
        default="4",
        show_default=True,
        help="Largest number of frequencies, 1 to 100.",
    ),
    options.assignments,
    options.stored,
    options.json,
)
def modes(call: Call, crank_angles: list[float], count: int) -> None:
    """Compute natural frequencies (Hz) of CASE with the crank held: follower straight, at rest, no gravity, undamped.

    With several engines, cases or angles the JSON document is a list. Exit code 3: an engine failed, or returned something other than
    natural frequencies; nothing is printed then.
    """
    get_ready(COMPUTING)
    from quickreturn.commands.solved import frequencies, frequency_lines

    rows = frequencies(call, call.loaded(), [math.radians(angle) for angle in crank_angles], count)
    text = "\n".join(line for angled in rows for line in frequency_lines(angled))
    call.show_each([each for angled in rows for each in angled], text)


@options.command(
    click.argument("sources", metavar="[CASE|FILE]...", nargs=-1, shell_complete=options.complete_case),
    options.tag,
    options.units,
    options.engines_for(help="Engine to simulate with, see `quickreturn engines`; may be given again."),
    click.option(
        "--column", "columns", metavar="NAME", multiple=True, help="Column to show; may be given again. Default: four, such as strain_2."
    ),
    options.duration,
    options.accuracy,
    options.assignments,
    options.stored,
    options.output(f"File for the picture: {', '.join(PICTURES)}."),
)
def plot(call: Call, sources: Sequence[str], columns: Sequence[str]) -> None:
    """Draw each CASE; with --engine, simulate it and draw columns of its trajectory over time.

    A FILE is a table as `simulate` writes it or as `compare` takes it (its name ends in .csv, .parquet, .nc or .json): its columns are
    drawn over those of the other sources.
    """
    from quickreturn.cases.files.recorded import is_table, read_table
    from quickreturn.cases.files.shown import units_named
    from quickreturn.commands.solved import trajectories
    from quickreturn.reports.drawing.style import picture

    files, call.cases = ([each for each in sources if is_table(each) is wanted] for wanted in (True, False))
    loaded = call.loaded() if call.cases or call.tag or not files else []
    if files and loaded and not call.engines:
        raise click.UsageError(f"to draw {loaded[0].name} over {files[0]}, give --engine: it has no trajectory yet")
    given = {"--column": () if files else columns, "--duration": call.duration, "--accuracy": call.accuracy, "--set": call.settings}
    for what, value in given.items():
        if value and not call.engines:
            raise click.UsageError(f"{what}: without --engine nothing is simulated; give --engine as well")
    check_file(call.output, "", PICTURES)
    call.begin(f"drawing {call.output}")
    if not call.engines and not files:
        from quickreturn.reports.drawing.mechanism import mechanisms

        figure = mechanisms(loaded)
    else:
        from quickreturn.reports.drawing.curves import curves

        drawn: dict[str, Mapping[str, Any]] = {Path(file).stem: read_table(file).columns for file in files}
        solved = trajectories(call, loaded)
        drawn |= {name if len(loaded) == 1 else f"{case} {name}": found.columns for (case, name), found in solved.items()}
        title = f"{loaded[0].name}: {loaded[0].title}" if len(loaded) == 1 else ""
        figure = curves(drawn, columns, title=title, units=loaded[0].units if loaded else units_named(call.units or "mm"))
    write(call.output, lambda ending: picture(figure, ending))
    click.echo(call.output)


@options.command(
    options.case,
    options.engines,
    options.duration,
    options.single(
        "--magnify",
        metavar="N",
        read=options.number(1e-3, 1e6, 5),
        help="Factor of the deflection in the picture; default: a factor that makes it visible.",
    ),
    options.accuracy,
    options.assignments,
    options.stored,
    options.output(f"File for the moving picture: {', '.join(MOVING)}."),
)
def animate(call: Call, magnify: float | None) -> None:
    """Simulate CASE from the standard start and draw it moving, engines over each other.

    A .webp, a .gif or, by ffmpeg, an .mp4 shows the last turn, slowed down. A .html is a page that opens from disk, with controls to play,
    stop and slow down the motion, and to magnify the deflection.
    """
    from quickreturn.commands.solved import trajectories

    if magnify is not None and str(call.output).lower().endswith(".html"):
        raise click.UsageError("--magnify: a page (.html) has a slider for it; leave it out")
    loaded = call.case()
    check_file(call.output, "", MOVING)
    found = {name: trajectory for (_, name), trajectory in trajectories(call, [loaded]).items()}
    call.begin(f"drawing {call.output}")
    from quickreturn.reports.drawing.mechanism import moving

    write(call.output, lambda ending: moving(loaded, found, ending, magnify))
    click.echo(call.output)
