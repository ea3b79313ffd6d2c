"""What commands print on standard error, and the codes with which they end."""

import contextlib
import re
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Final

import click

if TYPE_CHECKING:
    from quickreturn.cases.jobs.store import Store

LONGEST_MESSAGE: Final = 600  # characters; a longer message repeats a huge argument


class ExitCode(IntEnum):
    """What the program returns to the shell."""

    GOOD = 0
    CLAIMS_BROKEN = 1  # engines disagree by more than they claim
    BAD_INPUT = 2  # or bad usage, or something that the engine cannot model
    ENGINE_TROUBLE = 3  # an engine failed, did not settle or did not reach the accuracy asked
    INTERRUPTED = 130  # Ctrl-C


@dataclass
class Call:
    """The present call: whether progress is not reported, units for people, the store once it is open, whether compiling was told."""

    quiet: bool = False
    units: str | None = None
    store: "Store | None" = None
    told_of_compiling: bool = False

    @property
    def lost(self) -> bool:
        """Whether a result could not be stored."""
        return self.store is not None and self.store.lost > 0

    @property
    def notices(self) -> list[str]:
        """Sentences on damaged stored results, and on results that could not be stored."""
        return [] if self.store is None else self.store.notices


def call() -> Call:
    """The present call."""
    return click.get_current_context().ensure_object(Call)


def begin(what: str) -> None:
    """Announce a slow step on standard error, unless quiet."""
    if not call().quiet:
        with contextlib.suppress(OSError):  # nobody listens
            click.echo(f"  {what}", err=True)


def keep_in(store: "Store | None") -> None:
    """Note the store of the present call; a new folder is announced, and how to choose another."""
    call().store = store
    if store is not None and store.is_new:
        begin(f"results are kept in the new folder {store.folder.resolve()}; QUICKRETURN_STORE names another one")


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
