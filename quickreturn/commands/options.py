"""Arguments and options that several subcommands share, and how their texts are read."""

import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import click
from click.shell_completion import CompletionItem

from quickreturn.accuracy import HIGHEST, LOWEST
from quickreturn.cases.errors import CaseError, as_written, shortened
from quickreturn.cases.jobs.job import Limits, default_limits
from quickreturn.cases.units import TIME, QuantityError, parse_quantity, plain_number
from quickreturn.commands import console
from quickreturn.computing import Computing
from quickreturn.engines.settings import ANY_ENGINE
from quickreturn.reference_model.native import cache_folder

if TYPE_CHECKING:
    from quickreturn.cases.case import Case
    from quickreturn.cases.jobs.workshop import Workshop

#: Converts the text of an option, given its name, to a value; raises UsageError if it cannot.
Reader = Callable[[str, str], Any]

_LARGEST_ANGLE: Final = 1_000_000  # degrees; a double keeps 1e-10 of a degree there
_MOST_ANGLES: Final = 10_000


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


#: The option by which results are not stored.
NO_STORE: Final = "--no-store"

#: Pictures that can be written.
PICTURES: Final = (".png", ".svg", ".pdf", ".webp")


def _one(option: str, given: Sequence[str]) -> str | None:
    """The value of an option, if it is given. UsageError: several are given."""
    if len(given) > 1:
        values = " and ".join(map(as_written, given))
        raise click.UsageError(f"{option}: {values} are {'both' if len(given) == 2 else 'all'} given; give one of them")
    return given[0] if given else None


def single(*names: str, read: Reader = lambda _, text: text, default: str | None = None, **more: Any) -> Callable[[Any], Any]:
    """An option with one value. UsageError: several are given, and the message names them all; click would take the last."""

    def one(context: click.Context, option: click.Parameter, given: Sequence[str]) -> Any:
        text = _one(names[0], given)
        return None if text is None else read(names[0], text)

    return click.option(*names, multiple=True, callback=one, default=default and [default], **more)


def several(*names: str, help: str, **more: Any) -> Callable[[Any], Any]:
    """An option that may be given more than once."""
    return click.option(*names, multiple=True, help=f"{help} May be given again.", **more)


def output(told: str, metavar: str = "FILE", *, required: bool = True) -> Callable[[Any], Any]:
    """The option --output, with the help `told`."""
    return single("--output", metavar=metavar, required=required, help=told)


def complete_case(context: click.Context, argument: click.Parameter, begun: str) -> list[CompletionItem]:
    """Completions of a case: names of the library that begin with `begun`, and files."""
    from quickreturn.cases.library import case_names

    return [*(CompletionItem(name) for name in case_names() if name.startswith(begun)), CompletionItem(begun, type="file")]


def _complete_engine(context: click.Context, option: click.Parameter, begun: str) -> list[CompletionItem]:
    from quickreturn.engines.registry import engine_names

    return [*(CompletionItem(name) for name in engine_names() if name.startswith(begun)), CompletionItem(begun, type="file")]


def _keep_units(context: click.Context, option: click.Parameter, given: Sequence[str]) -> None:
    context.ensure_object(console.Call).units = _one("--units", given)


#: The option of every command that takes a case; `load` applies it.
units: Final[Callable[[Any], Any]] = click.option(
    "--units",
    metavar="SET",
    multiple=True,
    expose_value=False,
    callback=_keep_units,
    help="Units of texts and pictures: si, mm or inch; default: those of the case file. Files and JSON documents are in SI.",
)


def cases(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the argument for any number of cases."""
    return click.argument("cases", metavar="[CASE]...", nargs=-1, shell_complete=complete_case)(units(command))


def case(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the argument for one case."""
    return click.argument("case", metavar="CASE", shell_complete=complete_case)(units(command))


tag: Final = single("--tag", metavar="TAG", help="Add all cases of the library with this tag.")
engines_for: Final = functools.partial(
    click.option,
    "--engine",
    "engines",
    metavar="E",
    multiple=True,
    callback=lambda _, __, names: list(dict.fromkeys(names)),
    shell_complete=_complete_engine,
)
engines: Final = engines_for(default=["reference"], show_default=True, help="Engine, see `quickreturn engines`; may be given again.")
main_engines: Final = engines_for(help="Engine to run, or recorded table (.csv); may be given again. Default: the four main engines.")
json: Final = click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")
accuracy_of: Final = functools.partial(single, "--accuracy", metavar="REL", read=number(LOWEST, HIGHEST, 1e-3))
accuracy: Final = accuracy_of(help=f"Relative error of the tip deflection asked for, {HIGHEST:g} to {LOWEST:g}; default: the engine's.")
duration: Final = single(
    "--duration", metavar="S", read=seconds, help='Time to simulate, "2 s" or a number of seconds; a multiple of the output step.'
)
_set: Final = functools.partial(click.option, "--set", "assignments", metavar="KEY=VALUE", multiple=True)
_OVERRIDE: Final = 'Override a value of the case (follower.bending_stiffness="1800 lbf*in^2")'
case_assignments: Final[Callable[[Any], Any]] = _set(help=f"{_OVERRIDE}; may be given again.")
assignments: Final[Callable[[Any], Any]] = _set(
    help=f"{_OVERRIDE} or a setting of the engine (engine.elements=32), of one among several by its name (mujoco.links=16);"
    " may be given again."
)


def read_assignments(assignments: Sequence[str]) -> tuple[dict[str, str], dict[str, dict[str, str]]]:
    """Split `--set` texts into overrides of the case by key, and settings by engine (see `engine_choice.settings_of`) and name."""
    case: dict[str, str] = {}
    engines: dict[str, dict[str, str]] = {}
    for text in assignments:
        key, sign, value = text.partition("=")
        key = key.strip()
        if not (key and sign):
            raise click.UsageError(f'--set {as_written(text)}: give KEY=VALUE, e.g. crank.length="5 in" or engine.elements=32')
        parts = (key.partition("."), key.rpartition("."))  # the path of an engine's file has points of its own
        section, name = next(((before, after) for before, point, after in parts if point and _is_engine(before)), ("", key))
        target = engines.setdefault(section, {}) if section else case
        if name in target:
            values = f"{as_written(target[name])} and {as_written(value.strip())}"
            raise click.UsageError(f"--set {shortened(key)}: {values} are both given; give one of them")
        target[name] = value.strip()
    return case, engines


def read_overrides(assignments: Sequence[str]) -> dict[str, str]:
    """Overrides of the case, for subcommands without an engine. UsageError: a setting of an engine was given."""
    overrides, settings = read_assignments(assignments)
    for engine, texts in settings.items():
        given = "=".join(map(shortened, next(iter(texts.items()))))
        accepted = 'give values of the case, e.g. crank.length="5 in"'
        raise click.UsageError(f"--set {engine}.{given}: engine settings have no meaning here; {accepted}")
    return overrides


def _is_engine(section: str) -> bool:
    from quickreturn.cases.keys import SECTIONS
    from quickreturn.engines.registry import is_engine

    return section == ANY_ENGINE or (section not in SECTIONS and is_engine(section))


def refuse_missing(engines: Sequence[str]) -> None:
    """Refusal: an engine cannot be used here. Recorded tables may stand among the engines."""
    from quickreturn.cases.recorded import is_table
    from quickreturn.engines.registry import usable_engine

    for name in engines:
        if not is_table(name):
            usable_engine(name)


def load_all(
    names: Sequence[str],
    tag: str | None,
    overrides: dict[str, str],
    duration: float | None = None,
    output_step: float | None = None,
    otherwise: Sequence[str] = (),
) -> "list[Case]":
    """The cases of some names and patterns, and those with a tag; if none are given, those of the names `otherwise`."""
    from quickreturn.catalogue import list_cases, loaded

    tagged = [] if tag is None else [line.name for line in list_cases(tag)]
    wanted = [*names, *tagged] or otherwise
    if not wanted:
        raise click.UsageError("Missing argument 'CASE'", click.get_current_context())
    return loaded(wanted, lambda name: load(name, overrides, duration, output_step))


def load(case: str, overrides: dict[str, str], duration: float | None = None, output_step: float | None = None) -> "Case":
    """The case with overrides and other simulation times, s."""
    from quickreturn.cases.case_file import load_case, with_times

    for key, seconds in (("duration", duration), ("output_step", output_step)):
        if seconds is not None and f"simulation.{key}" in overrides:
            given = f"{_option(key)} ({seconds:g} s) and --set simulation.{key}={as_written(overrides[f'simulation.{key}'])}"
            raise click.UsageError(f"{given} are both given; give one of them")
    loaded = in_units(load_case(case, overrides))
    _tell_of_compiling()  # before the slow imports of a command
    try:
        return with_times(loaded, duration, output_step)
    except CaseError as wrong:
        raise CaseError("command line", _option(wrong.key or ""), wrong.value, wrong.problem, wrong.accepted) from None


def _tell_of_compiling() -> None:
    """Say, once in a call, that an engine's first run compiles, if no compiled code is kept yet."""
    present = console.call()
    if not present.told_of_compiling and (sentence := cache_folder.notice_if_none()):
        present.told_of_compiling = True
        console.begin(sentence)


def in_units(case: "Case") -> "Case":
    """The case, shown in the set of units that --units gives, if it does."""
    name = console.call().units
    return case if name is None else case.in_units(name)


def given_as(case: "Case", overrides: Mapping[str, str]) -> list[str]:
    """Arguments that name the same case with the same changes, for another command."""
    changes = [part for key, value in overrides.items() for part in ("--set", f"{key}={value}")]
    return [case.name if case.source == "library" else case.source, *changes]


def tell_doubts(cases: "Sequence[Case]") -> None:
    """Name doubtful values of the user's own cases on standard error, each doubt once; values of the library are intended."""
    from quickreturn.cases.plausibility import doubts

    concerned: dict[str, list[str]] = {}
    for case in cases:
        for doubt in doubts(case.scene):
            if doubt in case.notes:
                concerned.setdefault(doubt, []).append(case.name)
    for doubt, (first, *others) in concerned.items():
        console.tell(f"{first}{f' and {len(others)} more' if others else ''}: note: {doubt}")


def tell_slow(cases: "Sequence[Case]") -> None:
    """Name on standard error each case whose crank turns so slowly that its steady state takes minutes."""
    from quickreturn.cases.runs.slow_turns import warning

    for case in cases:
        if slow := warning(case):
            console.tell(f"{case.name}: {slow}")


def _option(key: str) -> str:
    return f"--{key.replace('_', '-')}"


def limited(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options for limits of time and memory, see `computing`."""
    time = 'Time after which an engine is stopped on a case, "90 s", "1 h" or a number of seconds; default: 3600.'
    memory = "Memory in GiB that an engine may take on a case; default: 8, or what the machine has if that is less."
    command = single("--memory-limit", metavar="GIB", read=number(1e-3, 1e6, 4, of=" of GiB"), help=memory)(command)
    return single("--time-limit", metavar="S", read=seconds, help=time)(command)


stored: Final[Callable[[Any], Any]] = click.option(NO_STORE, is_flag=True, help="Compute everything anew, and store nothing.")


def of_workshop(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of `limited`, the address of a cluster and the number of processes, see `computing`."""
    told = "Compute on a cluster of Dask, whose scheduler has this address, e.g. tcp://host:8786."
    command = single("--cluster", metavar="ADDRESS", help=told)(limited(command))
    told = "Processes at a time on this machine; default: one per core."
    return single("--jobs", metavar="N", read=number(1, 1000, 2, whole=True), help=told)(command)


class Announced(Computing):
    """How the jobs of a command run. Standard error is told what will run on which engines, and the notices of the store."""

    def tell(self, notice: str) -> None:
        """Print a notice of the store."""
        console.tell(notice)

    @contextmanager
    def opened(self, cases: "Sequence[Case]" = (), engines: Sequence[str] = ()) -> "Iterator[Workshop]":
        """See `Computing.opened`. The slow imports of the processes begin here, too."""
        from quickreturn.cases.jobs import fork_server

        with super().opened(cases, engines) as workshop:
            console.keep_in(workshop.store)
            _tell_of_compiling()
            if cases and self.cluster is None:
                fork_server.get_ready(fork_server.PRELOAD)
            tell_doubts(cases)
            if cases:
                what = cases[0].name if len(cases) == 1 else f"{len(cases)} cases"
                console.begin(f"{what} on {', '.join(engines)}; results are kept in {workshop.store.folder}")
            try:
                yield workshop
            finally:
                fork_server.not_needed()


def computing(command: Callable[..., Any]) -> Callable[..., Any]:
    """Pass the options of `limited`, `stored` and `of_workshop`, as far as a command has them, to it as one argument `computing`."""

    @functools.wraps(command)
    def called(
        *,
        jobs: int | None = None,
        cluster: str | None = None,
        time_limit: float | None = None,
        memory_limit: float | None = None,
        no_store: bool = False,
        **others: Any,
    ) -> Any:
        usual = default_limits()
        limits = Limits(time_limit or usual.seconds, round(memory_limit * 2**30) if memory_limit else usual.memory)
        return command(computing=Announced(jobs, cluster or None, limits, not no_store, console.call().quiet), **others)

    return called
