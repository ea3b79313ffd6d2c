"""How commands read recorded tables: their options, how a table was read, and the file that names its columns."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from quickreturn.commands import console
from quickreturn.commands import options as common
from quickreturn.commands.console import ExitCode
from quickreturn.reports.output import check_writable, write_file

if TYPE_CHECKING:
    from quickreturn.cases.recorded import RecordedTable

_MAPPED: Final = 'What a heading of FILE is: "crank.phi = crank_angle [deg]", "phi = -1 * crank_angle [deg] + 90".'


def options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that say how recorded tables are to be read."""
    sign = 'Decimal sign of FILE, "." or ",", where it can be read in two ways.'
    return common.several("--column", "columns", metavar="TEXT", help=_MAPPED)(
        common.single("--decimal", metavar="SIGN", help=sign)(command)
    )


def read(paths: Iterable[str], columns: Sequence[str], decimal: str | None) -> "list[RecordedTable]":
    """Recorded tables; standard error is told how each is written."""
    from quickreturn.cases.recorded import read_table

    read = [read_table(path, columns, decimal) for path in dict.fromkeys(paths)]
    for table in read:
        if table.told:
            console.tell(f"{table.shown}: {table.told}")
    return read


def write_mapping(files: Sequence[str], columns: Sequence[str], decimal: str | None) -> int:
    """Write the mapping of the only table to the file beside it, unless that exists."""
    from quickreturn.cases.recorded import suggested_mapping
    from quickreturn.cases.text.column_mapping import mapping_file

    if len(files) != 1:
        raise click.UsageError("--write-mapping: give one FILE")
    target = Path(mapping_file(files[0]))
    if target.exists():
        raise click.UsageError(f"--write-mapping: {target} exists already; edit it")
    check_writable(target, files[0], ".toml")
    write_file(target, suggested_mapping(files[0], columns, decimal).encode())
    click.echo(f"{target}: edit the lines with -, then compare again")
    return ExitCode.GOOD
