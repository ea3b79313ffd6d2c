"""`quickreturn report`: everything on one page, with its tables as CSV files beside it."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from reports.commands.options import jobs_option, load, path_given

if TYPE_CHECKING:
    from reports.report import Written


@click.command(name="report")
@click.argument("cases", metavar="[CASE]...", nargs=-1)
@click.option(
    "--output", metavar="DIR", default="reports/output", show_default=True, callback=path_given, help="Folder of the page and its tables."
)
@jobs_option
def command(cases: Sequence[str], output: str, jobs: int | None) -> int:
    """Write the report on each CASE; without one, on the 24 runs of the thesis.

    Exit code 0 once the page is written and every engine completed: missed tolerances are shown in the page. Exit code 3: an engine
    failed or did not settle; the page is written all the same and shows it.
    """
    from cases.library import catalogue
    from cases.store import Store
    from reports.command_line import ENGINE_TROUBLE, GOOD
    from reports.report import write_report

    loaded = [load(case, {}) for case in dict.fromkeys(cases or [entry.name for entry in catalogue("thesis")])]
    _check_names([case.name for case in loaded])
    written = write_report(loaded, Path(output), Store(), jobs)
    _print(written)
    return ENGINE_TROUBLE if written.failed else GOOD


def _check_names(names: Sequence[str]) -> None:
    """Two cases of one name could not be told apart in the page."""
    for name in names:
        if names.count(name) > 1:
            raise click.UsageError(f'two cases are called "{name}"; give each a name of its own')


def _print(written: "Written") -> None:
    content = written.content
    checks = [check for result in content.results for check in result.checks]
    runs = sum(len(result.runs) for result in content.results)
    failures = [trouble for trouble in content.troubles if trouble.is_failure]
    click.echo(str(written.page))
    click.echo(
        f"{len(content.results)} cases, {runs} simulations: {runs - len(content.troubles)} settled, {len(failures)} did not complete"
    )
    click.echo(f"{sum(not check.passed for check in checks)} of {len(checks)} tolerances missed")
    click.echo(f"{len(written.tables)} tables as CSV beside the page")
