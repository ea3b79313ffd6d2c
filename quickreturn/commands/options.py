"""Arguments and options that several subcommands share, and how their texts are read."""

import contextlib
import functools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import click
from click.shell_completion import CompletionItem

from cases.errors import as_written, shortened
from cases.units import plain_number
from quickreturn.accuracy import HIGHEST, LOWEST

if TYPE_CHECKING:
    from cases.case import Case
    from cases.jobs.job import Limits
    from cases.jobs.workshop import Workshop

HIGHEST_MEMORY: Final = 2**20  # GiB; no machine has it

_ALL_ENGINES: Final = "engine"
_LARGEST_ANGLE: Final = 1_000_000  # degrees; a double keeps 1e-10 of a degree there
_MOST_ANGLES: Final = 10_000


def _accuracy(context: click.Context, option: click.Parameter, text: str | None) -> float | None:
    if text is None:
        return None
    value = plain_number(text)
    if value is None or not LOWEST <= value <= HIGHEST:
        accepted = f"give a plain number from {LOWEST:g} to {HIGHEST:g}, e.g. 1e-3"
        raise click.UsageError(f"--accuracy {as_written(text)}: {accepted}")
    return value


def _angles(context: click.Context, option: click.Parameter, text: str) -> list[float]:
    """Degrees: one number, or all from the first to the second in steps of the third, both ends included."""
    values = [plain_number(part) for part in text.split(":")]
    known = [value for value in values if value is not None and abs(value) <= _LARGEST_ANGLE]
    if len(values) == len(known) == 1:
        return known
    if len(values) == len(known) == 3 and known[2] and 0.0 <= (steps := (known[1] - known[0]) / known[2]) < _MOST_ANGLES:
        return [known[0] + step * known[2] for step in range(math.floor(steps + 1e-9) + 1)]
    accepted = f"give a plain number of degrees, from -{_LARGEST_ANGLE} to {_LARGEST_ANGLE}, e.g. 180, or FROM:TO:STEP, e.g. 0:360:10"
    raise click.UsageError(f"--crank-angle {as_written(text)}: {accepted}")


class WholeNumber(click.IntRange):
    """A whole number within limits, both inclusive."""

    def __init__(self, low: int, high: int) -> None:
        super().__init__(low, high)
        self.low, self.high = low, high

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """The number; UsageError if the text is none."""
        text = str(value)
        if not re.fullmatch(r"[+-]?[0-9]{1,9}", text) or not self.low <= int(text) <= self.high:
            option = param.opts[0] if param else "number"
            raise click.UsageError(f"{option} {as_written(text)}: give a whole number from {self.low} to {self.high}")
        return int(text)


#: In a context's `meta`: whether to be quiet, and where results are kept.
QUIET: Final = "quickreturn.quiet"
WORKSHOP: Final = "quickreturn.workshop"


class SingleOption(click.Option):
    """An option of which one value counts: UsageError with all that are given where there are more, of which click takes the last."""

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        """Have the parser keep every value."""
        parser.add_option(obj=self, opts=self.opts, dest=self.name, action="append", nargs=self.nargs)

    def handle_parse_result(self, ctx: click.Context, opts: Mapping[str, Any], args: list[str]) -> tuple[Any, list[str]]:
        """The one value."""
        given = opts.get(self.name or "")
        if isinstance(given, list):
            if len(given) > 1:
                values = " and ".join(map(as_written, given))
                raise click.UsageError(f"{self.opts[0]}: {values} are {'both' if len(given) == 2 else 'all'} given; give one of them")
            opts = {**opts, str(self.name): given[0]}
        return super().handle_parse_result(ctx, opts, args)


single: Final = functools.partial(click.option, cls=SingleOption)


def path_given(context: click.Context, option: click.Parameter, text: str) -> str:
    """The path as given; UsageError if there is none: Python would take it for the current folder."""
    if not text.strip():
        raise click.UsageError(f"{option.opts[0]} {as_written(text)}: give a path")
    return text


def output(told: str, metavar: str = "FILE") -> Callable[[Any], Any]:
    """The option that says where the result goes."""
    return single("--output", metavar=metavar, required=True, callback=path_given, help=told)


def _complete_case(context: click.Context, argument: click.Parameter, begun: str) -> list[CompletionItem]:
    from cases.library import case_names

    return [*(CompletionItem(name) for name in case_names() if name.startswith(begun)), CompletionItem(begun, type="file")]


def _complete_engine(context: click.Context, option: click.Parameter, begun: str) -> list[CompletionItem]:
    from engines.registry import engine_names

    return [CompletionItem(name) for name in engine_names() if name.startswith(begun)]


cases: Final[Callable[[Any], Any]] = click.argument("cases", metavar="[CASE]...", nargs=-1, shell_complete=_complete_case)
case: Final[Callable[[Any], Any]] = click.argument("case", metavar="CASE", shell_complete=_complete_case)
plotted: Final[Callable[[Any], Any]] = click.argument("sources", metavar="[CASE|FILE]...", nargs=-1, shell_complete=_complete_case)
tag: Final = single("--tag", metavar="TAG", help="Besides, all cases of the library with this tag.")
engines_for: Final = functools.partial(
    click.option,
    "--engine",
    "engines",
    metavar="E",
    multiple=True,
    shell_complete=_complete_engine,
)
engines: Final = engines_for(required=True, help="Engine, see `quickreturn engines`; may be given again.")
engines_if_any: Final = engines_for(help="Engine to simulate with, see `quickreturn engines`; may be given again.")
main_engines: Final = engines_for(help="Engine to run, or recorded table (.csv); may be given again. Default: the four main engines.")
json: Final = click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")
accuracy: Final = single(
    "--accuracy",
    metavar="REL",
    callback=_accuracy,
    help=f"Relative error of the tip deflection asked for, {HIGHEST:g} to {LOWEST:g}; default: the engine's.",
)
duration: Final = single("--duration", metavar="S", help='Time to simulate, "2 s" or a number of seconds; a multiple of the output step.')
crank_angle: Final = single(
    "--crank-angle",
    "crank_angles",
    metavar="DEG",
    required=True,
    callback=_angles,
    help="Angle at which the crank is held, degrees; or FROM:TO:STEP, both ends included.",
)
assignments: Final[Callable[[Any], Any]] = click.option(
    "--set",
    "assignments",
    metavar="KEY=VALUE",
    multiple=True,
    help='Override a value of the case (follower.bending_stiffness="1800 lbf*in^2") or a setting of the engine (engine.elements=32),'
    " of one among several by its name (mujoco.links=16).",
)


def read_assignments(assignments: Sequence[str]) -> tuple[dict[str, str], dict[str, dict[str, str]]]:
    """Split `--set` texts into overrides of the case by key, and settings by engine ("engine": whichever there is) and name.

    Raises:
        click.UsageError: not KEY=VALUE, or a key given twice.
    """
    case: dict[str, str] = {}
    engines: dict[str, dict[str, str]] = {}
    for text in assignments:
        key, sign, value = text.partition("=")
        key = key.strip()
        if not (key and sign):
            raise click.UsageError(f'--set {as_written(text)}: give KEY=VALUE, e.g. crank.length="5 in" or engine.elements=32')
        section, point, name = key.partition(".")
        target, name = (engines.setdefault(section, {}), name) if point and _is_engine(section) else (case, key)
        if name in target:
            values = f"{as_written(target[name])} and {as_written(value.strip())}"
            raise click.UsageError(f"--set {shortened(key)}: {values} are both given; give one of them")
        target[name] = value.strip()
    return case, engines


def _is_engine(section: str) -> bool:
    from cases.case import SECTIONS

    if section == _ALL_ENGINES or section in SECTIONS:
        return section == _ALL_ENGINES
    from engines.registry import engine_names

    return section in engine_names()


def settings_of(settings: Mapping[str, Mapping[str, str]], names: Sequence[str]) -> dict[str, dict[str, str]]:
    """Settings by engine: those for all of them, and before these its own.

    Raises:
        click.UsageError: of an engine that was not asked for.
    """
    for name, texts in settings.items():
        if name != _ALL_ENGINES and name not in names:
            given = f"{name}.{shortened(next(iter(texts)))}"
            raise click.UsageError(f"--set {given}: engine {name} does not run here; those that do are {', '.join(names)}")
    return {name: {**settings.get(_ALL_ENGINES, {}), **settings.get(name, {})} for name in names}


def refuse_engine_settings(settings: Mapping[str, Mapping[str, str]]) -> None:
    """For subcommands without an engine: UsageError if a setting of one was given."""
    for engine, texts in settings.items():
        key, value = next(iter(texts.items()))
        given = f"{engine}.{shortened(key)}={shortened(value)}"
        raise click.UsageError(f'--set {given}: engine settings have no meaning here; give values of the case, e.g. crank.length="5 in"')


def load_all(
    names: Sequence[str],
    tag: str | None,
    overrides: dict[str, str],
    duration: str | None = None,
    output_step: str | None = None,
    otherwise: str | None = None,
) -> "list[Case]":
    """The cases of some names and patterns, and those with a tag.

    Args:
        names: as given; a pattern stands for all that match it.
        tag: None: none besides.
        overrides: of every case.
        duration: see `load`.
        output_step: likewise.
        otherwise: tag of the cases that are meant if none are given; None: then that is an error.

    Raises:
        CaseError: no such case, or a mistake in one; two of one name.
        click.UsageError: none is given, or see `load`.
    """
    from cases.errors import CaseError
    from quickreturn.catalogue import cases, matching

    tagged = [line.name for line in cases(tag)] if tag is not None else []
    wanted = [found for name in names for found in matching(name)] + tagged
    if not wanted:
        if otherwise is None:
            raise click.UsageError("Missing argument 'CASE'", click.get_current_context())
        wanted = [line.name for line in cases(otherwise)]
    loaded = [load(name, overrides, duration, output_step) for name in dict.fromkeys(wanted)]
    called = [case.name for case in loaded]
    for name in called:
        if called.count(name) > 1:
            raise CaseError(name, None, None, "two cases have this name", "give each a name of its own")
    return loaded


def load(case: str, overrides: dict[str, str], duration: str | None = None, output_step: str | None = None) -> "Case":
    """The case with overrides; `duration` and `output_step` are quantities ("2 s") or plain numbers of seconds.

    Raises:
        CaseError: see `cases.case_file.load_case` and `with_times`.
        click.UsageError: a time is given both as an option and by `--set`.
    """
    from cases.case_file import load_case, with_times
    from cases.errors import CaseError

    times = {"--duration": duration, "--output-step": output_step}
    for option, text in times.items():
        path = f"simulation.{_key(option)}"
        if text is not None and path in overrides:
            given = f"{option} {as_written(text)} and --set {path}={as_written(overrides[path])}"
            raise click.UsageError(f"{given} are both given; give one of them")
    seconds = [None if text is None else _seconds(option, text) for option, text in times.items()]
    loaded = load_case(case, overrides)
    try:
        return with_times(loaded, *seconds)
    except CaseError as wrong:  # told with the option as it was given
        option, text = next((option, text) for option, text in times.items() if _key(option) == wrong.key)
        raise CaseError("command line", option, wrong.value if text is None else as_written(text), wrong.problem, wrong.accepted) from None


def _key(option: str) -> str:
    return option.removeprefix("--").replace("-", "_")


def quiet() -> bool:
    """Whether nothing shall be told of how far things are."""
    return bool(click.get_current_context().meta.get(QUIET))


def opened_workshop() -> "Workshop":
    """The store of results and the processes of this machine, as `of_workshop` or `limited` say.

    What the store has to tell it tells on standard error at once. StoreError if its folder cannot be used.
    """
    from cases.jobs.processes import LocalProcesses
    from cases.jobs.store import Store
    from cases.jobs.workshop import Workshop

    meta = click.get_current_context().meta
    workshop = Workshop(Store(tell=tell), LocalProcesses(meta.get("jobs"), limits(), quiet=quiet()))
    meta[WORKSHOP] = workshop
    return workshop


def announce(cases: "Sequence[Case]", engines: Sequence[str], workshop: "Workshop") -> None:
    """Say what begins, before what takes a while is imported."""
    what = cases[0].name if len(cases) == 1 else f"{len(cases)} cases"
    begin(f"{what} on {', '.join(engines)}; results are kept in {workshop.store.folder}")


def begin(what: str) -> None:
    """Say on standard error what will take a moment, unless to be quiet."""
    if not quiet():
        with contextlib.suppress(OSError):  # nobody listens
            click.echo(f"  {what}", err=True)


def tell(sentence: str) -> None:
    """Say something on standard error, on one line."""
    from quickreturn.command_line import one_line

    with contextlib.suppress(OSError):  # nobody listens
        click.echo(f"quickreturn: {one_line(sentence)}", err=True)


def limits() -> "Limits":
    """What an engine may take, as `limited` say; the usual where a command has no such options."""
    from cases.jobs.job import Limits, default_limits

    meta, usual = click.get_current_context().meta, default_limits()
    return Limits(seconds=meta.get("time_limit") or usual.seconds, memory=meta.get("memory_limit") or usual.memory)


def _keep_time(context: click.Context, option: click.Parameter, text: str | None) -> None:
    seconds = None if text is None else _seconds("--time-limit", text)
    if seconds is not None and not 0.0 < seconds < math.inf:
        raise click.UsageError(f'--time-limit {as_written(text)}: give a positive number of seconds or a time, e.g. 600 or "10 min"')
    context.meta["time_limit"] = seconds


def _keep_memory(context: click.Context, option: click.Parameter, text: str | None) -> None:
    gibibytes = None if text is None else plain_number(text)
    if text is not None and (gibibytes is None or not 0.0 < gibibytes < HIGHEST_MEMORY):
        raise click.UsageError(f"--memory-limit {as_written(text)}: give a positive number of GiB, e.g. 4")
    context.meta["memory_limit"] = gibibytes and round(gibibytes * 2**30)


def _keep_jobs(context: click.Context, option: click.Parameter, number: int | None) -> None:
    context.meta["jobs"] = number


def limited(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options on what an engine may take; the command asks `limits` or `opened_workshop` for them."""
    time = 'Time after which an engine is stopped on a case, "90 s", "1 h" or a number of seconds; default: 3600.'
    memory = "Memory in GiB that an engine may take on a case; default: 8, or what the machine has if that is less."
    for name, metavar, keep, told in (("--memory-limit", "GIB", _keep_memory, memory), ("--time-limit", "S", _keep_time, time)):
        command = single(name, metavar=metavar, callback=keep, expose_value=False, help=told)(command)
    return command


def of_workshop(command: Callable[..., Any]) -> Callable[..., Any]:
    """These, and how many processes there may be at a time."""
    told = "Processes at a time; default: one per core."
    keep = single("--jobs", metavar="N", type=WholeNumber(1, 1000), callback=_keep_jobs, expose_value=False, help=told)
    return keep(limited(command))


def _seconds(option: str, text: str) -> float:
    from cases.errors import CaseError
    from cases.units import TIME, QuantityError, parse_quantity

    number = plain_number(text)
    if number is not None and math.isfinite(number):
        return number
    try:
        return parse_quantity(text, TIME)
    except QuantityError as wrong:
        raise CaseError(
            "command line", option, as_written(text), wrong.problem, f"{wrong.accepted}; a plain number means seconds"
        ) from None
