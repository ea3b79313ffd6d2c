"""Gets the natural frequencies for `modes`, and prints them."""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import click

from quickreturn.cases.case import Case
from quickreturn.cases.solving import frequencies_job
from quickreturn.commands import options
from quickreturn.commands.answers import answered
from quickreturn.engine_choice import check, settings_of
from quickreturn.engines.base import EngineFailure
from quickreturn.questions import EngineDied, value_of
from quickreturn.reports.output import print_table
from quickreturn.reports.words import within_turn


def found(
    cases: Sequence[Case], engines: Sequence[str], settings: Mapping[str, Mapping[str, str]], angles: Sequence[float], count: int
) -> list[list[dict[str, Any]]]:
    """For each case and engine a document for each angle (rad), after all checks.

    Raises as `check`, and EngineDied if an engine failed.
    """
    texts = settings_of(settings, engines)
    asked = list(itertools.product(cases, engines))
    for case, name in asked:
        check(name, case.mechanism, texts[name])
    options.tell_doubts(cases)
    jobs = [frequencies_job(f"{case.name} {name}", case.mechanism, name, angles, count, texts[name]) for case, name in asked]
    rows = []
    for (case, name), outcome in zip(asked, answered(jobs, "natural frequencies")[0], strict=True):
        try:
            each = value_of(outcome)
        except EngineFailure as failure:  # its own text names an instant, but there is none here
            raise EngineDied(f"{case.name}: engine {name}: {failure.cause}; {failure.advice}") from failure
        about = {"case": case.name, "engine": name, "version": each.version, "settings": each.settings}
        rows.append([about | {"crank_angle": angle, "frequencies": row} for angle, row in zip(angles, each.values, strict=True)])
    return rows


def print_rows(angled: list[dict[str, Any]]) -> None:
    """One angle: a line for each mode; several: a line for each angle."""
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
