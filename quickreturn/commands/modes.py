"""`quickreturn modes`: natural frequencies with the crank held."""

import itertools
import math
from collections.abc import Sequence
from typing import Any

import click

from quickreturn.commands import options


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
def command(
    cases: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    crank_angles: list[float],
    count: int,
    assignments: Sequence[str],
    as_json: bool,
) -> int:
    """Compute natural frequencies (Hz) of CASE with the crank held: follower straight, at rest, no gravity, undamped.

    With several engines, cases or angles the JSON document is a list. Exit code 3: an engine failed, or returned something other than
    natural frequencies; nothing is printed then.
    """
    from quickreturn import questions
    from quickreturn.cases.jobs.fork_server import get_ready
    from quickreturn.cases.solving import frequencies_job
    from quickreturn.engines.base import EngineFailure
    from quickreturn.reference_model.errors import ExitCode
    from quickreturn.reports.output import print_json

    overrides, settings = options.read_assignments(assignments)
    get_ready(questions.COMPUTING)
    texts = questions.settings_of(settings, engines)
    loaded = options.load_all(cases, tag, overrides)
    asked = list(itertools.product(loaded, engines))
    for case, name in asked:
        questions.check(name, case.mechanism, texts[name])
    options.tell_doubts(loaded)
    angles = [math.radians(angle) for angle in crank_angles]
    jobs = [frequencies_job(f"{case.name} {name}", case.mechanism, name, angles, count, texts[name]) for case, name in asked]
    found = []
    for (case, name), outcome in zip(asked, options.answered(jobs, "natural frequencies")[0], strict=True):
        try:
            each = questions.value_of(outcome)
        except EngineFailure as failure:  # its own text names an instant, but there is none here
            options.tell(f"{case.name}: engine {name}: {failure.cause}; {failure.advice}")
            return ExitCode.ENGINE_TROUBLE
        about = {"case": case.name, "engine": name, "version": each.version, "settings": each.settings}
        found.append([about | {"crank_angle": angle, "frequencies": row} for angle, row in zip(angles, each.values, strict=True)])
    if as_json:
        documents = [each for angled in found for each in angled]
        print_json(documents[0] if len(documents) == 1 else documents)
    else:
        for angled in found:
            _print(angled)
    return ExitCode.GOOD


def _print(angled: list[dict[str, Any]]) -> None:
    """One angle: a line for each mode; several: a line for each angle."""
    from quickreturn.reports.output import print_table
    from quickreturn.reports.words import within_turn

    degrees = [f"{within_turn(math.degrees(each['crank_angle'])):g}" for each in angled]
    first = angled[0]
    if len(angled) == 1:
        click.echo(f"{first['case']}, crank at {degrees[0]} deg, {first['engine']} ({first['version']})")
        if first["frequencies"]:
            print_table([(str(number), f"{frequency:.6g} Hz") for number, frequency in enumerate(first["frequencies"], 1)])
    else:
        click.echo(f"{first['case']}, {first['engine']} ({first['version']}): natural frequencies in Hz")
        most = max(len(each["frequencies"]) for each in angled)
        rows = [[angle, *(f"{value:.6g}" for value in each["frequencies"])] for angle, each in zip(degrees, angled, strict=True)]
        print_table([row + ["-"] * (most + 1 - len(row)) for row in rows], ["crank deg", *map(str, range(1, most + 1))])
    if not any(each["frequencies"] for each in angled):
        click.echo("no natural frequency: nothing in this model can vibrate with the crank held")
