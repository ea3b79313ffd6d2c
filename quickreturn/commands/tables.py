"""How commands read recorded tables: their options, and the file that names the columns of a table."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from quickreturn.commands import options as common
from quickreturn.commands.console import ExitCode, check_file, tell, write

if TYPE_CHECKING:
    from quickreturn.cases.files.recorded import RecordedTable

_MAPPED: Final = 'What a heading of FILE is: "crank.phi = crank_angle [deg]", "phi = -1 * crank_angle [deg] + 90".'
_SIGN: Final = 'Sign between the columns of FILE: ",", ";", "tab" or "blank"; default: recognised.'
_DECIMAL: Final = 'Decimal sign of FILE, "." or ","; default: recognised.'
_SKIP: Final = "Number of lines above the headings of FILE to leave out."


def options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that say how recorded tables are to be read: the arguments of `read_table`."""
    command = common.single("--skip", metavar="LINES", read=common.number(0, 10_000, 3, whole=True), default="0", help=_SKIP)(command)
    command = common.single("--decimal", metavar="SIGN", help=_DECIMAL)(command)
    command = common.single("--separator", metavar="SIGN", help=_SIGN)(command)
    return common.several("--column", "columns", metavar="TEXT", help=_MAPPED)(command)


def read(paths: Iterable[str], reading: Mapping[str, Any]) -> "list[RecordedTable]":
    """Recorded tables; a message on standard error says how each is written."""
    from quickreturn.cases.files.recorded import read_table

    read = [read_table(path, **reading) for path in dict.fromkeys(paths)]
    for table in read:
        if table.told:
            tell(f"{table.shown}: {table.told}")
    return read


def write_mapping(files: Sequence[str], reading: Mapping[str, Any]) -> int:
    """Write the mapping of the only table to the file beside it, unless that exists."""
    from quickreturn.cases.files.column_mapping import mapping_file
    from quickreturn.cases.files.recorded import suggested_mapping

    if len(files) != 1:
        raise click.UsageError("--write-mapping: give one FILE")
    target = mapping_file(files[0])
    if Path(target).exists():
        raise click.UsageError(f"--write-mapping: {target} exists already; edit it")
    check_file(str(target), files[0], (".toml",))
    write(str(target), lambda ending: suggested_mapping(files[0], **reading).encode())
    click.echo(f"{target}: edit the lines with -, then compare again")
    return ExitCode.GOOD
