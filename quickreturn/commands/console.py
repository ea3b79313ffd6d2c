"""What commands print on standard error, and the codes with which they end."""

import contextlib
import re
from enum import IntEnum
from typing import Final

import click

LONGEST_MESSAGE: Final = 600  # characters; a longer message repeats a huge argument

#: Keys of a click context's `meta`: whether to be quiet, and the store of results.
QUIET: Final = "quickreturn.quiet"
STORE: Final = "quickreturn.store"


class ExitCode(IntEnum):
    """What the program returns to the shell."""

    GOOD = 0
    CLAIMS_BROKEN = 1  # engines disagree by more than they claim
    BAD_INPUT = 2  # or bad usage, or something that the engine cannot model
    ENGINE_TROUBLE = 3  # an engine failed, did not settle or did not reach the accuracy asked
    INTERRUPTED = 130  # Ctrl-C


def quiet() -> bool:
    """Whether progress is not reported."""
    return bool(click.get_current_context().meta.get(QUIET))


def begin(what: str) -> None:
    """Announce a slow step on standard error, unless quiet."""
    if not quiet():
        with contextlib.suppress(OSError):  # nobody listens
            click.echo(f"  {what}", err=True)


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
