"""The options that commands share, how their texts are read, and the command that has them."""

import functools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click
from click.shell_completion import CompletionItem

from quickreturn.cases.files.errors import as_written, shortened
from quickreturn.cases.files.units import TIME, QuantityError, parse_quantity, plain_number
from quickreturn.cases.running import fork_server
from quickreturn.commands import console
from quickreturn.commands.console import Call, ExitCode, check_file, tell, write
from quickreturn.computing import CHOSEN, HIGHEST, LOWEST
from quickreturn.engines.settings import ANY_ENGINE

if TYPE_CHECKING:
    from quickreturn.cases.files.recorded import RecordedTable

#: Converts the text of an option, given its name, to a value; raises UsageError if it cannot.
Reader = Callable[[str, str], Any]
#: A decorator of click, which adds an option.
Option = Callable[[Any], Any]

_LARGEST_ANGLE: Final = 1_000_000  # degrees; a double keeps 1e-10 of a degree there
_MOST_ANGLES: Final = 10_000


def command(*options: Option, **attributes: Any) -> Callable[[Callable[..., Any]], click.Command]:
    """A command of the function's name with these options, in the order of its help.

    The function gets the `Call` with the values of the shared options, and those of its own ones as keywords.
    """

    def decorate(function: Callable[..., Any]) -> click.Command:
        @functools.wraps(function)
        def called(**own: Any) -> Any:
            call = console.call()
            before = CHOSEN.set(call)
            try:
                return function(call, **own)
            finally:
                CHOSEN.reset(before)
                fork_server.not_needed()

        for option in reversed(options):
            option(called)
        as_command: Callable[[Callable[..., Any]], click.Command] = click.command(name=function.__name__, **attributes)
        return as_command(called)

    return decorate


def number(low: float, high: float, example: float, *, of: str = "", whole: bool = False) -> Reader:
    """A reader of plain numbers from `low` to `high`, both included; the message of its error shows the example."""

    def read(option: str, text: str) -> float:
        value = plain_number(text)
        if value is None or not low <= value <= high or (whole and not text.lstrip("+").isdecimal()):
            accepted = f"give a {'whole' if whole else 'plain'} number{of} from {low:g} to {high:g}, e.g. {example:g}"
            raise click.UsageError(f"{option} {as_written(text)}: {accepted}")
        return int(value) if whole else value

    return read


def seconds(option: str, text: str) -> float:
    """Reads a positive time, a quantity or a plain number, in s."""
    value = plain_number(text)
    try:
        value = parse_quantity(text, TIME) if value is None else value
    except QuantityError as wrong:
        message = f"{option}: {as_written(text)} {wrong.problem}; {wrong.accepted}; a plain number means seconds"
        raise click.UsageError(message) from None
    if not 0.0 < value < math.inf:
        raise click.UsageError(f'{option} {as_written(text)}: give a positive time, e.g. 600 or "10 min"')
    return value


def angles(option: str, text: str) -> list[float]:
    """Reads degrees: one number, or all from the first to the second in steps of the third, both ends included."""
    values = [plain_number(part) for part in text.split(":")]
    known = [value for value in values if value is not None and abs(value) <= _LARGEST_ANGLE]
    if len(values) == len(known) == 1:
        return known
    if len(values) == len(known) == 3 and known[2] and 0.0 <= (steps := (known[1] - known[0]) / known[2]) < _MOST_ANGLES:
        return [known[0] + step * known[2] for step in range(math.floor(steps + 1e-9) + 1)]
    accepted = f"give a plain number of degrees, from -{_LARGEST_ANGLE} to {_LARGEST_ANGLE}, e.g. 180, or FROM:TO:STEP, e.g. 0:360:10"
    raise click.UsageError(f"{option} {as_written(text)}: {accepted}")


def _kept(read: Callable[[Any], Any] = lambda given: given) -> dict[str, Any]:
    """Arguments of click for an option that sets a field of the `Call`."""

    def keep(context: click.Context, option: click.Parameter, given: Any) -> None:
        setattr(context.ensure_object(Call), str(option.name), read(given))

    return {"expose_value": False, "callback": keep}


def single(
    *names: str, read: Reader = lambda _, text: text, default: str | None = None, shared: bool = False, **more: Any
) -> Callable[[Any], Any]:
    """An option with one value. UsageError: several are given, and the message names them all; click would take the last."""

    def one(given: Sequence[str]) -> Any:
        if len(given) > 1:
            values = " and ".join(map(as_written, given))
            raise click.UsageError(f"{names[0]}: {values} are {'both' if len(given) == 2 else 'all'} given; give one of them")
        return read(names[0], given[0]) if given else None

    keep = _kept(one) if shared else {"callback": lambda context, option, given: one(given)}
    return click.option(*names, multiple=True, default=default and [default], **keep, **more)


def several(*names: str, help: str, **more: Any) -> Callable[[Any], Any]:
    """An option that may be given more than once."""
    return click.option(*names, multiple=True, help=f"{help} May be given again.", **more)


shared: Final = functools.partial(single, shared=True)


def output(help: str, metavar: str = "FILE", *, required: bool = True, **more: Any) -> Callable[[Any], Any]:
    """The option --output."""
    return shared("--output", metavar=metavar, required=required, help=help, **more)


def complete_case(context: click.Context, argument: click.Parameter, begun: str) -> list[CompletionItem]:
    """Completions of a case: names of the library that begin with `begun`, and files."""
    from quickreturn.cases.library import case_names

    return [*(CompletionItem(name) for name in case_names() if name.startswith(begun)), CompletionItem(begun, type="file")]


def _complete_engine(context: click.Context, option: click.Parameter, begun: str) -> list[CompletionItem]:
    from quickreturn.engines.registry import engine_names

    return [*(CompletionItem(name) for name in engine_names() if name.startswith(begun)), CompletionItem(begun, type="file")]


def _assignments(accept: Callable[[dict[str, str], dict[str, dict[str, str]]], None], help: str) -> Option:
    """The option --set; `accept` raises UsageError for what the command does not take."""

    def keep(context: click.Context, option: click.Parameter, texts: Sequence[str]) -> None:
        present = context.ensure_object(Call)
        overrides, settings = _assigned(texts)
        accept(overrides, settings)
        present.overrides, present.settings = overrides, settings

    return click.option("--set", metavar="KEY=VALUE", multiple=True, expose_value=False, callback=keep, help=f"{help}; may be given again.")


def _assigned(texts: Sequence[str]) -> tuple[dict[str, str], dict[str, dict[str, str]]]:
    """Overrides of the case by key, and settings by engine (see `arguments.settings_of`) and name, from the texts of --set."""
    overrides: dict[str, str] = {}
    settings: dict[str, dict[str, str]] = {}
    for text in texts:
        key, sign, value = text.partition("=")
        key = key.strip()
        if not (key and sign):
            raise click.UsageError(f'--set {as_written(text)}: give KEY=VALUE, e.g. crank.length="5 in" or engine.elements=32')
        parts = (key.partition("."), key.rpartition("."))  # the path of an engine's file has points of its own
        engine, name = next(((before, after) for before, point, after in parts if point and _is_engine(before)), ("", key))
        target = settings.setdefault(engine, {}) if engine else overrides
        if name in target:
            values = f"{as_written(target[name])} and {as_written(value.strip())}"
            raise click.UsageError(f"--set {shortened(key)}: {values} are both given; give one of them")
        target[name] = value.strip()
    return overrides, settings


def _is_engine(section: str) -> bool:
    from quickreturn.cases.files.keys import SECTIONS
    from quickreturn.engines.registry import is_engine

    return section == ANY_ENGINE or (section not in SECTIONS and is_engine(section))


def _of_case(overrides: dict[str, str], settings: dict[str, dict[str, str]]) -> None:
    """UsageError: a setting of an engine was given to a command without an engine."""
    for engine, texts in settings.items():
        given = "=".join(map(shortened, next(iter(texts.items()))))
        accepted = 'give values of the case, e.g. crank.length="5 in"'
        raise click.UsageError(f"--set {engine}.{given}: engine settings have no meaning here; {accepted}")


def _of_engines(overrides: dict[str, str], settings: dict[str, dict[str, str]]) -> None:
    """UsageError: a value of the case was given to the report."""
    for key, value in overrides.items():
        accepted = "settings of engines, e.g. engine.elements=32, are accepted; write other values into a case file"
        raise click.UsageError(f"--set {as_written(f'{key}={value}')}: the page would show another case than {key} makes; {accepted}")


units: Final[Option] = shared(
    "--units",
    metavar="SET",
    help="Units of texts and pictures: si, mm or inch; default: those of the case file. Files and JSON documents are in SI.",
)
_cases: Final = functools.partial(click.argument, "cases", shell_complete=complete_case)


def cases(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the argument for any number of cases."""
    return _cases(metavar="[CASE]...", nargs=-1, **_kept())(units(command))


def case(command: Callable[..., Any], metavar: str = "CASE") -> Callable[..., Any]:
    """Add the argument for one case."""
    return _cases(metavar=metavar, **_kept(lambda name: (name,)))(units(command))


tag: Final = shared("--tag", metavar="TAG", help="Add all cases of the library with this tag.")
engines_for: Final = functools.partial(
    click.option,
    "--engine",
    "engines",
    metavar="E",
    multiple=True,
    shell_complete=_complete_engine,
    **_kept(lambda names: list(dict.fromkeys(names))),
)
engines: Final = engines_for(default=["reference"], show_default=True, help="Engine, see `quickreturn engines`; may be given again.")
main_engines: Final = engines_for(help="Engine to run, or recorded table (.csv); may be given again. Default: the four main engines.")
json: Final = click.option("--json", "as_json", is_flag=True, help="Print one JSON document.", **_kept())
accuracy_of: Final = functools.partial(shared, "--accuracy", metavar="REL", read=number(LOWEST, HIGHEST, 1e-3))
accuracy: Final = accuracy_of(help=f"Relative error of the tip deflection asked for, {HIGHEST:g} to {LOWEST:g}; default: the engine's.")
duration: Final = shared(
    "--duration", metavar="S", read=seconds, help='Time to simulate, "2 s" or a number of seconds; a multiple of the output step.'
)
output_step: Final = shared("--output-step", metavar="S", read=seconds, help='Time between rows, "1 ms" or a number of seconds.')
_OVERRIDE: Final = 'Override a value of the case (follower.bending_stiffness="1800 lbf*in^2")'
_ASSIGNMENTS: Final = f"{_OVERRIDE} or a setting of the engine (engine.elements=32), of one among several by its name (mujoco.links=16)"
case_assignments: Final[Option] = _assignments(_of_case, _OVERRIDE)
assignments: Final[Option] = _assignments(lambda overrides, settings: None, _ASSIGNMENTS)
engine_assignments: Final[Option] = _assignments(_of_engines, _ASSIGNMENTS)
stored: Final[Option] = click.option("--no-store", is_flag=True, help="Compute everything anew, and store nothing.", **_kept())


def limited(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options for limits of time and memory."""
    time = 'Time after which an engine is stopped on a case, "90 s", "1 h" or a number of seconds; default: 3600.'
    memory = "Memory in GiB that an engine may take on a case; default: 8, or what the machine has if that is less."
    command = shared("--memory-limit", metavar="GIB", read=number(1e-3, 1e6, 4, of=" of GiB"), help=memory)(command)
    return shared("--time-limit", metavar="S", read=seconds, help=time)(command)


def of_workshop(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of `limited`, the address of a cluster and the number of processes."""
    address = "Compute on a cluster of Dask, whose scheduler has this address, e.g. tcp://host:8786."
    command = shared("--cluster", metavar="ADDRESS", help=address)(limited(command))
    processes = "Processes at a time on this machine; default: one per core."
    return shared("--jobs", metavar="N", read=number(1, 1000, 2, whole=True), help=processes)(command)


_MAPPED: Final = 'What a heading of FILE is: "crank.phi = crank_angle [deg]", "phi = -1 * crank_angle [deg] + 90".'
_SIGN: Final = 'Sign between the columns of FILE: ",", ";", "tab" or "blank"; default: recognised.'
_DECIMAL: Final = 'Decimal sign of FILE, "." or ","; default: recognised.'
_SKIP: Final = "Number of lines above the headings of FILE to leave out."


def table_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that say how recorded tables are to be read: the arguments of `read_table`."""
    command = single("--skip", metavar="LINES", read=number(0, 10_000, 3, whole=True), default="0", help=_SKIP)(command)
    command = single("--decimal", metavar="SIGN", help=_DECIMAL)(command)
    command = single("--separator", metavar="SIGN", help=_SIGN)(command)
    return several("--column", "columns", metavar="TEXT", help=_MAPPED)(command)


def read_tables(paths: Iterable[str], reading: Mapping[str, Any]) -> "list[RecordedTable]":
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
