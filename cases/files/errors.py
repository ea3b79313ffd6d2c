"""The exception for a mistake in a case, a data file or an override, and the form of its message."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import SequenceMatcher
from typing import Any, ParamSpec, TypeVar

from quickreturn.reference_model.errors import ToldError

P = ParamSpec("P")
T = TypeVar("T")

_LONGEST_VALUE = 60
_LONGEST_PATH = 255
_MOST_TOLD = 10  # largest number of mistakes in one message: they fit on a terminal's screen
_NEAR = 0.6  # share of letters in the same order; below it a name is no typing error


class Argument(str):
    """The source of a mistake: the name of a function's argument, to which an option of the command line may correspond."""


class CaseError(ToldError):
    """A mistake in a case; the text is one sentence, followed by one for each further mistake, a line each.

    Attributes:
        source: file name, name of the case, or an `Argument`.
        key: dotted key in it, or None for the file as a whole.
        value: the given value, as written, or None if none was given.
        problem: what is wrong with it.
        accepted: what is accepted instead; may be empty.
        further: other mistakes of the same case, in the order of its file.
    """

    def __init__(self, source: str, key: str | None, value: str | None, problem: str, accepted: str = "") -> None:
        what = ("" if key is None else f"{key}: ") + ("" if value is None else f"{value} ")
        super().__init__(f"{source}: {what}{problem}" + (f"; {accepted}" if accepted else ""))
        self.source = source
        self.key = key
        self.value = value
        self.problem = problem
        self.accepted = accepted
        self.further: tuple[CaseError, ...] = ()

    def __str__(self) -> str:
        told = [str(mistake.args[0]) for mistake in (self, *self.further[: _MOST_TOLD - 1])]
        if left := len(self.further) - len(told) + 1:
            told.append(f"{self.source}: {left} more mistake{'s' * (left > 1)}; mend those above first")
        return "\n".join(told)


def together(mistakes: Sequence[CaseError]) -> CaseError:
    """One error for all mistakes (at least one): the first mistake, with the others in its `further`."""
    first, *others = mistakes
    first.further += tuple(one for other in others for one in (other, *other.further))
    return first


def attempted(mistakes: list[CaseError], function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | None:
    """The result of a function; None if it raises a CaseError, which is added to `mistakes`."""
    try:
        return function(*args, **kwargs)
    except CaseError as mistake:
        mistakes.append(mistake)
        return None


def as_written(value: Any) -> str:
    """A value of a TOML file as it would be written there, shortened, and safe to print on a terminal."""
    if isinstance(value, str):
        return f'"{shortened(value)}"'
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "[" + ", ".join([as_written(item) for item in value[:4]] + ["..."] * (len(value) > 4)) + "]"
    if isinstance(value, dict):
        return "{ ... }" if value else "{}"
    return shortened(str(value))


def texts_given(given: Any, source: str, example: str) -> list[str]:
    """One text or several, as a list. CaseError, which names `source`: anything else."""
    texts = [given] if isinstance(given, str) else list(given) if isinstance(given, Iterable) else [given]
    for text in texts:
        if not isinstance(text, str):
            raise CaseError(source, None, as_written(text), "is not a text", f"give one or several, such as {as_written(example)}")
    return texts


def shortened(text: str) -> str:
    """At most 60 characters of any text, safe to print on a terminal."""
    return printable(text[:_LONGEST_VALUE]) + ("..." if len(text) > _LONGEST_VALUE else "")


def path_shown(path: str) -> str:
    """A path in full, or the beginning of one that is longer than any file's name, safe to print on a terminal."""
    return printable(path) if len(path) <= _LONGEST_PATH else shortened(path)


def printable(text: str) -> str:
    """Any text with quotes and control characters escaped as in a string of a TOML file."""
    return "".join(_printable(character) for character in text)


def _printable(character: str) -> str:
    if character in '"\\':
        return "\\" + character
    return character if character.isprintable() else character.encode("unicode_escape").decode("ascii")


def nearest(given: str, known: Iterable[str]) -> str:
    """The name in `known` (not empty) that resembles `given` most."""
    return max(known, key=lambda name: _resemblance(given, name))


def similar_name(given: str, known: Sequence[str]) -> str:
    """The nearest name in `known` if it is near enough for a typing error, otherwise ""."""
    near = nearest(given, known) if known else ""
    return near if _resemblance(given, near) >= _NEAR else ""


def nearest_or_all(given: str, known: Sequence[str], within: str = "") -> str:
    """A clause on what to write for an unknown name: the nearest one, after the text `within`, or else all of `known` (not empty)."""
    near = similar_name(given, known)
    return f"the nearest known one is {within}{near}" if near else f"known are {', '.join(known)}"


def _resemblance(given: str, name: str) -> float:
    return SequenceMatcher(None, given[:_LONGEST_VALUE].lower(), name.lower()).ratio()


class UnknownColumn(ToldError, LookupError):
    """No such column; the text is one sentence with the nearest known one."""


def known_column(name: str, columns: Mapping[str, Any]) -> str:
    """`name` itself. Raises UnknownColumn if it is the name of none of these columns."""
    if not isinstance(name, str):
        raise UnknownColumn(f'{as_written(name)}: no name of a column; give one after the other, such as "tip_deflection"')
    if name not in columns:
        raise UnknownColumn(f"{as_written(name)}: no such column; {nearest_or_all(name, tuple(columns))}")
    return name
