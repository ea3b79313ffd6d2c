"""`quickreturn modes`: natural frequencies with the crank held."""

import math
from collections.abc import Sequence

import click

from quickreturn.commands.options import (
    WholeNumber,
    case_argument,
    crank_angle_option,
    engine_option,
    json_option,
    load,
    read_assignments,
    set_option,
    single_option,
    tell,
)


@click.command(name="modes")
@case_argument
@engine_option
@crank_angle_option
@single_option("--count", metavar="N", type=WholeNumber(1, 100), default=4, show_default=True, help="How many at most.")
@set_option
@json_option
def command(case: str, engine: str, crank_angle: float, count: int, assignments: Sequence[str], as_json: bool) -> int:
    """Natural frequencies (Hz) of CASE with the crank held: follower straight, at rest, no gravity, undamped.

    Exit code 3: the engine failed, or what it returned are no natural frequencies; nothing is printed then.
    """
    from cases.jobs.job import Job
    from cases.jobs.processes import get_ready
    from engines.base import EngineFailure
    from quickreturn.command_line import ENGINE_TROUBLE, GOOD
    from quickreturn.questions import COMPUTING, answer_of, modes
    from reports.output import print_json, print_table

    overrides, settings = read_assignments(assignments)
    get_ready(COMPUTING)
    loaded = load(case, overrides)
    job = Job(engine, modes, (engine, loaded.mechanism, crank_angle, count, settings))
    try:
        found = answer_of(job)
    except EngineFailure as failure:  # its own text tells of an instant, which there is none of here
        tell(f"{loaded.name}: engine {engine}: {failure.cause}; {failure.advice}")
        return ENGINE_TROUBLE
    if as_json:
        print_json({"case": loaded.name, "crank_angle": crank_angle, **vars(found)})
        return GOOD
    click.echo(f"{loaded.name}, crank at {math.degrees(crank_angle):g} deg, {engine} ({found.version})")
    if not found.frequencies:
        click.echo("no natural frequency: nothing in this model can vibrate with the crank held")
        return GOOD
    print_table([(str(number), f"{frequency:.6g} Hz") for number, frequency in enumerate(found.frequencies, 1)])
    return GOOD
