"""`quickreturn report`: the whole report on one page, with its tables as CSV files beside it."""

import os
from collections.abc import Sequence
from typing import Final

import click

from quickreturn.cases.errors import as_written
from quickreturn.commands import console, options
from quickreturn.commands.console import ExitCode
from quickreturn.computing import Computing

#: Endings of files. With such a name a user expects a page, not a folder.
_OF_FILES: Final = (".html", ".htm", ".csv", ".pdf", ".md", ".json", ".zip", ".parquet")


def _folder(option: str, text: str) -> str:
    """The path as given. UsageError: it is empty, or it looks like that of a file and no such folder exists."""
    if not text.strip() or (text.lower().endswith(_OF_FILES) and not os.path.isdir(text)):
        raise click.UsageError(f"{option} {as_written(text)}: give a folder, the page in it is index.html")
    return text


@click.command(name="report")
@options.cases
@options.tag
@options.main_engines
@options.accuracy
@options.assignments
@options.single(
    "--output", metavar="DIR", default="reports/output", show_default=True, read=_folder, help="Folder of the page and its tables."
)
@options.of_workshop
@options.computing
def report(
    cases: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    accuracy: float | None,
    assignments: Sequence[str],
    output: str,
    computing: Computing,
) -> int:
    """Write the report on each CASE; without one, on the 24 runs of the thesis.

    A slow engine is quicker with coarser settings (--set my-engine.links=8) or to a lower accuracy (--accuracy 0.05).

    Exit code 0: the page is written, and every engine completed and reached its accuracy; the page shows where engines disagree. Exit code
    3: an engine failed, was stopped at a limit, did not settle or missed its accuracy, or a default engine is not installed; the page is
    still written and shows it. Each result is stored at once: an interrupted report continues where it stopped.
    """
    overrides, settings = options.read_assignments(assignments)
    for key, value in overrides.items():
        accepted = "settings of engines, e.g. engine.elements=32, are accepted; write other values into a case file"
        raise click.UsageError(f"--set {as_written(f'{key}={value}')}: the page would show another case than {key} makes; {accepted}")
    loaded = options.load_all(cases, tag, {}, otherwise=("thesis-*",))
    options.refuse_missing(engines)
    from quickreturn.cross_validation import reported

    options.tell_slow(loaded)
    written = reported(loaded, output, engines, settings, accuracy, computing)
    click.echo(written.summary)
    for case, run in (*written.incomplete, *written.inaccurate):
        console.tell(f"{case}: engine {run.engine} {run.status}: {run.remark}")
    for case, run in written.unusable:
        console.tell(f"{case}: table {run.engine} {run.status}: {run.remark}")
    if written.failed:
        return ExitCode.ENGINE_TROUBLE
    return ExitCode.BAD_INPUT if console.call().lost else ExitCode.GOOD
