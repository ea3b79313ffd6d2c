"""`quickreturn run`: measures engines on cases in their steady state, and compares their differences with their claims."""

from collections.abc import Sequence

import click

from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.shown import in_lines
from quickreturn.commands import options
from quickreturn.reports.output import print_json


@click.command(name="run")
@options.cases
@options.tag
@options.main_engines
@options.accuracy
@options.assignments
@options.of_workshop
@options.json
def command(
    cases: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    accuracy: float | None,
    assignments: Sequence[str],
    as_json: bool,
) -> int:
    """Bring engines to their steady state on each CASE, measure and compare them.

    Two engines may differ by the sum of their claims: their own error estimates and the uncertainty of the measures. Exit code 1: some
    differ by more. Exit code 2: an engine asked for by name is not installed or cannot model a scene. Exit code 3: an engine failed, was
    stopped at a limit, did not settle or did not reach the accuracy asked, or a default engine is not installed. The other engines go on.
    Each result is stored at once: an interrupted run continues.
    """
    from quickreturn.commands.verdicts import as_document, exit_code
    from quickreturn.engine_choice import prepared

    overrides, settings = options.read_assignments(assignments)
    loaded = options.load_all(cases, tag, overrides)
    names, texts, tables = prepared(loaded, engines, settings)
    options.refuse_missing(names if engines else ())
    options.tell_slow(loaded)
    workshop = options.opened_workshop(loaded, names)
    from quickreturn.cases.runs.campaign import cross_validate
    from quickreturn.verdict_text import parts_of

    results = cross_validate(loaded, workshop, names, accuracy, texts, tables)
    if as_json:
        print_json(as_document(results, workshop.store.notices))
    else:
        for result in results:
            if not all(each.status == Ending.REFUSED for each in result.runs.values()):  # otherwise there is nothing to show
                click.echo(in_lines(parts_of(result)))
    return exit_code(results, workshop, engines)
