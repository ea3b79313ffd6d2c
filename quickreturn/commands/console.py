"""The present call of a command: what its options say, its cases, what it prints, and the code with which it ends."""

import contextlib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from quickreturn.computing import Computing

if TYPE_CHECKING:
    from quickreturn.cases.files.case import Case
    from quickreturn.cases.running.job import Limits
    from quickreturn.cases.running.store import Store
    from quickreturn.cases.running.workshop import Workshop

LONGEST_MESSAGE: Final = 600  # characters; a longer message repeats a huge argument


class ExitCode(IntEnum):
    """What the program returns to the shell."""

    GOOD = 0
    CLAIMS_BROKEN = 1  # engines disagree by more than they claim
    BAD_INPUT = 2  # or bad usage, or something that the engine cannot model
    ENGINE_TROUBLE = 3  # an engine failed, did not settle or did not reach the accuracy asked
    INTERRUPTED = 130  # Ctrl-C


@dataclass
class Call(Computing):
    """The present call. The fields that the options of `commands.options` set have their values, if the command has them."""

    units: str | None = None
    cases: Sequence[str] = ()  # names, paths and patterns
    tag: str | None = None
    engines: Sequence[str] = ()
    accuracy: float | None = None
    duration: float | None = None  # s
    output_step: float | None = None  # s
    overrides: Mapping[str, str] = field(default_factory=dict)  # dotted key of a case file -> text
    settings: Mapping[str, Mapping[str, str]] = field(default_factory=dict)  # engine -> name -> text
    output: str | None = None
    as_json: bool = False
    time_limit: float | None = None  # s
    memory_limit: float | None = None  # GiB
    no_store: bool = False
    store: "Store | None" = None  # once it is open
    announced_compiling: bool = False

    @property
    def lost(self) -> bool:
        """Whether a result could not be stored."""
        return self.store is not None and self.store.lost > 0

    def begin(self, what: str) -> None:
        """Announce a slow step on standard error, unless quiet."""
        if not self.quiet:
            with contextlib.suppress(OSError):  # nobody listens
                click.echo(f"  {what}", err=True)

    def keep_in(self, store: "Store | None") -> None:
        """Note the store of this call; a new folder is announced, and how to choose another."""
        self.store = store
        if store is not None and store.is_new:
            self.begin(f"results are kept in the new folder {store.folder.resolve()}; QUICKRETURN_STORE names another one")

    @property
    def limits(self) -> "Limits":
        """Limits of time and memory of a job."""
        from quickreturn.cases.running.job import Limits, default_limits

        usual = default_limits()
        return Limits(self.time_limit or usual.seconds, round(self.memory_limit * 2**30) if self.memory_limit else usual.memory)

    def tell(self, notice: str) -> None:
        """Print a notice on standard error."""
        tell(notice)

    def begun(self, workshop: "Workshop", cases: "Sequence[Case]", engines: Sequence[str]) -> None:
        """Announce what will run. The slow imports of the processes begin here, too."""
        from quickreturn.cases.running import fork_server

        self.keep_in(workshop.store)
        self._announce_compiling()
        if cases and not self.cluster:
            fork_server.get_ready(fork_server.PRELOAD)
        tell_doubts(cases)
        if cases:
            what = cases[0].name if len(cases) == 1 else f"{len(cases)} cases"
            self.begin(f"{what} on {', '.join(engines)}; results are kept in {workshop.store.folder}")

    def loaded(self, otherwise: Sequence[str] = ()) -> "list[Case]":
        """The cases of the names and patterns, and those with the tag; if none are given, those of the names `otherwise`."""
        from quickreturn.arguments import list_cases, loaded

        tagged = [] if self.tag is None else [line.name for line in list_cases(self.tag)]
        wanted = [*self.cases, *tagged] or otherwise
        if not wanted:
            raise click.UsageError("Missing argument 'CASE'", click.get_current_context())
        return loaded(wanted, self.case)

    def case(self, name: str | None = None) -> "Case":
        """A case, or the only one, with the values, times and units of the options."""
        from quickreturn.cases.files.errors import CaseError
        from quickreturn.cases.library import load_case, with_times

        case = load_case(self.cases[0] if name is None else name, self.overrides)
        if self.units is not None:
            case = case.in_units(self.units)
        self._announce_compiling()  # before the slow imports of a command
        try:
            return with_times(case, self.duration, self.output_step)
        except CaseError as wrong:
            raise CaseError("command line", f"--{wrong.key}".replace("_", "-"), wrong.value, wrong.problem, wrong.accepted) from None

    def _announce_compiling(self) -> None:
        """Say, once in a call, that an engine's first run compiles, if no compiled code is kept yet."""
        from quickreturn.reference_model.native import cache_folder

        if not self.announced_compiling and (sentence := cache_folder.notice_if_none()):
            self.announced_compiling = True
            self.begin(sentence)

    def arguments_for(self, case: "Case") -> list[str]:
        """Arguments that name a case with the changes of this call, for another command."""
        changes = [part for key, value in self.overrides.items() for part in ("--set", f"{key}={value}")]
        return [case.name if case.source == "library" else case.source, *changes]

    def refuse_missing(self) -> None:
        """Refusal: an engine cannot be used here. Recorded tables may stand among the engines."""
        from quickreturn.cases.files.recorded import is_table
        from quickreturn.engines.registry import usable_engine

        for name in self.engines:
            if not is_table(name):
                usable_engine(name)

    def show(self, document: Any, text: str) -> None:
        """Print the JSON document, if it was asked for, or else the text."""
        from quickreturn.reports.output import print_json

        if self.as_json:
            print_json(document)
        else:
            click.echo(text)

    def show_each(self, documents: Sequence[Any], text: str) -> None:
        """As `show`; the document of several is a list."""
        self.show(documents[0] if len(documents) == 1 else documents, text)


def call() -> Call:
    """The present call."""
    return click.get_current_context().ensure_object(Call)


def check_file(file: str | None, keep: str, endings: Sequence[str]) -> None:
    """Check a file that is to be written, if there is one; `keep` must not be replaced. OutputError: as `check_writable`."""
    from quickreturn.reports.output import check_writable

    if file is not None:
        check_writable(Path(file), keep, *endings)


def write(file: str | None, content: Callable[[str], bytes]) -> None:
    """Write a file, if there is one, with the content for its ending."""
    from quickreturn.reports.output import write_file

    if file is not None:
        write_file(Path(file), content(Path(file).suffix.lower()))


def tell_doubts(cases: "Sequence[Case]") -> None:
    """Name doubtful values of the user's own cases on standard error, each doubt once; values of the library are intended."""
    from quickreturn.cases.files.reading import doubts

    concerned: dict[str, list[str]] = {}
    for case in cases:
        for doubt in doubts(case.scene):
            if doubt in case.notes:
                concerned.setdefault(doubt, []).append(case.name)
    for doubt, (first, *others) in concerned.items():
        tell(f"{first}{f' and {len(others)} more' if others else ''}: note: {doubt}")


def tell_slow(cases: "Sequence[Case]") -> None:
    """Name on standard error each case whose crank turns so slowly that its steady state takes minutes."""
    from quickreturn.cases.motion.resonance import slow_turns

    for case in cases:
        if slow := slow_turns(case):
            tell(f"{case.name}: {slow}")


def tell(sentence: str) -> None:
    """Print a sentence on standard error, on one line."""
    with contextlib.suppress(OSError):  # nobody listens, or its disk is full
        click.echo(f"quickreturn: {_one_line(sentence)}", err=True)


def _one_line(sentence: str) -> str:
    """The sentence on one line of limited length, without characters that control the terminal."""
    joined = re.sub(r"\s*[\r\n]\s*", " ", sentence.strip())  # blanks within a line stay: a value is shown as it was given
    text = "".join(sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in joined)
    half = LONGEST_MESSAGE // 2
    return text if len(text) <= LONGEST_MESSAGE else f"{text[:half]} ... {text[-half:]}"
