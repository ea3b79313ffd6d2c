"""The command `quickreturn`: subcommands, exit codes, and one clear line on standard error instead of a traceback.

Exit codes: 0 good; 1 engines disagree by more than they claim; 2 bad input or usage, or something that the engine cannot model; 3 an
engine failed, did not settle or did not reach the accuracy asked; 130 Ctrl-C.
"""

import contextlib
import difflib
import errno
import math
import os
import signal
import sys
import time
from collections.abc import Sequence
from functools import cache
from types import FrameType
from typing import Final

import click
from click.shell_completion import CompletionItem, shell_complete

from quickreturn.cases.files.errors import Argument, CaseError, as_written, shortened
from quickreturn.commands.console import Call, ExitCode, tell
from quickreturn.engines.plugins import entries as of_plugins
from quickreturn.engines.plugins import found
from quickreturn.reference_model.errors import EngineTrouble, ToldError

#: The commands in the order of `--help`: module of `quickreturn.commands`, and first sentence of the help. Those of plugins follow.
COMMANDS: Final = {
    "engines": (
        "cases",
        "List the engines: name, version, method, available or why not; for one ENGINE also its settings and default accuracy.",
    ),
    "cases": ("cases", "List the cases of the library: name, tags, title."),
    "new": ("cases", "Write a case file of your own to FILE, with the meaning of every key beside it."),
    "show": ("cases", "Show the scene of CASE and the parts, joints and degrees of freedom that each engine builds."),
    "simulate": ("motions", "Simulate CASE from the standard start; with --output, write the trajectory."),
    "modes": ("motions", "Compute natural frequencies (Hz) of CASE with the crank held: follower straight, at rest, no gravity, undamped."),
    "run": ("comparisons", "Bring engines to their steady state on each CASE, measure and compare them."),
    "compare": ("comparisons", "Measure recorded tables of CASE and compare them with engines."),
    "check": ("comparisons", "Judge a table by the reference results of PROBLEM."),
    "report": ("comparisons", "Write the report on each CASE; without one, on the 24 runs of the thesis."),
    "plot": ("motions", "Draw each CASE; with --engine, simulate it and draw columns of its trajectory over time."),
    "animate": ("motions", "Simulate CASE from the standard start and draw it moving, engines over each other."),
}

#: Environment variable by which a shell asks for completions, see `quickreturn --help`.
COMPLETION: Final = "_QUICKRETURN_COMPLETE"

#: Environment variable for the threads of numpy's linear algebra: with two the small eigenproblems of the shapes take several times the
#: processor time.
BLAS_THREADS: Final = "OPENBLAS_NUM_THREADS"

#: Argument of a function -> the option that gives it, where that has another name; and name of an error's class -> the option at fault.
OPTIONS: Final = {"columns": "--column", "inputs": "--input", "measures": "--measure", "outputs": "--output", "overrides": "--set"}
AT_FAULT: Final = {"OutputError": "--output", "SettingError": "--set", "UnknownEngine": "--engine"}

#: Errors of the system when there is no room to write.
FULL: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)

PATIENCE: Final = 3.0  # s after which another Ctrl-C counts; the clean-up takes a fraction of a second unless it hangs


@cache
def commands() -> dict[str, tuple[str, str]]:
    """All commands in the order of `--help`, each with its place (`engines.plugins`) and the first sentence of its help."""
    own = {name: (f"quickreturn.commands.{module}:{name}", sentence) for name, (module, sentence) in COMMANDS.items()}
    return own | of_plugins("commands")


class CommandGroup(click.Group):
    """A group that imports a subcommand from `quickreturn.commands` on its first use."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the subcommands."""
        return list(commands())

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The subcommand, or None if there is none of this name."""
        if cmd_name not in commands():
            return None
        command = found(commands()[cmd_name][0])
        assert isinstance(command, click.Command)
        if not any(each.name == "quiet" for each in command.params):
            command.params.append(_quiet_option())
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the subcommands, each with a whole sentence: click would import them all, and cut their help to one line."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, help_text) for name, (_, help_text) in commands().items()])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Completions of a subcommand or an option; no subcommand is imported for them."""
        found_names = [CompletionItem(name, help=sentence) for name, (_, sentence) in commands().items() if name.startswith(incomplete)]
        return [*found_names, *click.Command.shell_complete(self, ctx, incomplete)]

    def resolve_command(self, ctx: click.Context, args: list[str]) -> tuple[str | None, click.Command | None, list[str]]:
        """The subcommand that the arguments begin with; UsageError with the nearest name if there is none."""
        if args and args[0] not in commands() and not args[0].startswith("-"):
            near = difflib.get_close_matches(args[0], commands(), n=1)
            hint = f" (perhaps {near[0]} is meant)" if near else ""
            raise click.UsageError(f"{as_written(args[0])}: no such command{hint}; accepted: {', '.join(commands())}", ctx)
        return super().resolve_command(ctx, args)


def _quiet_option() -> click.Option:
    """The option of every command that silences reports of progress."""

    def keep(context: click.Context, option: click.Parameter, given: bool) -> None:
        context.ensure_object(Call).quiet |= given

    words = "Do not report progress; errors and doubtful values are still reported."
    return click.Option(["-q", "--quiet"], is_flag=True, expose_value=False, callback=keep, help=words)


@click.group(name="quickreturn", cls=CommandGroup, context_settings={"help_option_names": ["-h", "--help"]}, params=[_quiet_option()])
@click.version_option(package_name="quickreturn", message="%(prog)s %(version)s")
def quickreturn() -> None:
    """Cross-validate flexible-multibody engines on a quick-return mechanism with a flexible follower.

    A CASE is the name of a library case, a pattern such as 'thesis-2*', or the path of a case file.

    Completion for bash: eval "$(_QUICKRETURN_COMPLETE=bash_source quickreturn)"; for zsh and fish write zsh_source and fish_source.
    """


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        argv: arguments without the program's name; None: those of the process.

    Returns:
        The exit code. No exception leaves this function.
    """
    if argv is None:  # this process serves the command alone; read when numpy is imported
        os.environ.setdefault(BLAS_THREADS, "1")
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # otherwise it is ignored, or another program handles it
        signal.signal(signal.SIGINT, _Interrupts())
    try:
        return _exit_code(list(sys.argv[1:] if argv is None else argv))
    finally:
        if argv is not None and signal.getsignal(signal.SIGINT) is not before:  # the caller goes on; a program only leaves
            signal.signal(signal.SIGINT, before)


def _exit_code(arguments: list[str]) -> int:
    """The exit code of a call."""
    for stream in (sys.stdout, sys.stderr):  # a terminal that lacks a sign gets an escape in its place
        with contextlib.suppress(AttributeError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    call = Call()
    try:
        if instruction := os.environ.get(COMPLETION):  # the shell asks for completions
            return shell_complete(quickreturn, {}, "quickreturn", COMPLETION, instruction)
        try:
            with quickreturn.make_context("quickreturn", arguments or ["--help"], obj=call) as context:
                code = quickreturn.invoke(context)
        except click.exceptions.Exit as leaving:  # --help
            code = leaving.exit_code
        sys.stdout.flush()
        return code if isinstance(code, int) else ExitCode.GOOD
    except BrokenPipeError:  # the reader (`head`) has enough
        _drop_output()
        return ExitCode.GOOD
    except (KeyboardInterrupt, click.Abort):
        with contextlib.suppress(ValueError):  # not the main thread
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # only the exit remains
        go_on = "nothing is kept, the same command begins anew"
        if call.store is not None:
            go_on = f"what was finished is kept in {call.store.folder}; the same command goes on from there"
        tell(f"interrupted; {go_on}")
        return ExitCode.INTERRUPTED
    except click.ClickException as error:
        tell(_with_help(error))
    except ToldError as error:
        for sentence in _sentences(error):
            tell(sentence)
        return ExitCode.ENGINE_TROUBLE if isinstance(error, EngineTrouble) else ExitCode.BAD_INPUT
    except Exception as error:  # the last resort: one sentence for any error
        if not (isinstance(error, OSError) and error.filename is None and error.errno in FULL):  # files have sentences of their own
            tell(f"unforeseen: {type(error).__name__}: {error}; please report this")
            return ExitCode.ENGINE_TROUBLE
        _drop_output()
        tell(f"standard output cannot be written ({os.strerror(error.errno).lower()})")
    return ExitCode.BAD_INPUT


class _Interrupts:
    """Ctrl-C interrupts once; another one soon after it must not disturb the clean-up."""

    def __init__(self) -> None:
        self._last = -math.inf

    def __call__(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if now - self._last > PATIENCE:
            self._last = now
            raise KeyboardInterrupt


def _drop_output() -> None:
    """Discard the output that is still to be printed, so that it does not fail again at exit."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _with_help(error: click.ClickException) -> str:
    """The message; click's own messages begin with a capital and do not say what is accepted, so the help is named."""
    message, context = error.format_message(), getattr(error, "ctx", None)
    if isinstance(error, click.NoSuchOption):
        near = f" (perhaps {error.possibilities[0]} is meant)" if error.possibilities else ""
        message = f"No such option: {shortened(error.option_name)}{near}"
    if context is None or not message[:1].isupper():
        return message
    return f"{message.rstrip('.')}; see {context.command_path} --help"


def _sentences(error: ToldError) -> list[str]:
    """One sentence for each mistake, which names the option that is at fault, if one is."""
    if not isinstance(error, CaseError):
        return [f"{AT_FAULT.get(type(error).__name__, '')} {error}".lstrip()]
    lines = str(error).splitlines()
    for name in {each.source for each in (error, *error.further) if isinstance(each.source, Argument)}:
        lines = [f"{OPTIONS.get(name, f'--{name}')}{line.removeprefix(name)}" if line.startswith(f"{name}: ") else line for line in lines]
    return lines
