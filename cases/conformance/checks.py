"""The outcome of a check of an adapter."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.displayed import Cell, Displayed, Rows
from quickreturn.engines.base import EngineFailure, Refusal, first_line
from quickreturn.engines.one_run import raised_at

Array = NDArray[np.float64]
Status = Literal["passed", "failed", "not judged"]

#: Beginning of the cause of a check that was left out for lack of time.
LEFT_OUT: Final = "left out"
#: Largest number of names in a sentence.
_NAMED: Final = 4
#: Default advice.
TELL_THE_AUTHOR: Final = "debug it with the scene of this check: cases.conformance.scenes"
#: Advice where time was short for a check.
NOT_QUICK: Final = "try the whole comparison, not the quick one"


@dataclass(frozen=True)
class Check:
    """One check of an adapter."""

    check: str  # name of the check
    status: Status  # how it ended
    cause: str = ""  # what is wrong, or why it was not judged; for a passed check a remark, or ""
    advice: str = ""  # what to try; "" if nothing is wrong

    @property
    def left_out(self) -> bool:
        """Whether it was left out for lack of time."""
        return self.status == "not judged" and self.cause.startswith(LEFT_OUT)


@dataclass(frozen=True, repr=False)
class Conformance(Displayed):
    """The outcome of all checks of an engine."""

    engine: str
    conforms: bool | None  # False if a check failed; None if nothing could be judged
    checks: tuple[Check, ...]

    def _parts(self) -> Iterator[Cell]:
        yield f"{self.engine}: {self.verdict}"
        yield Rows([(each.check, each.status, each.cause, each.advice) for each in self.checks], ("check", "status", "cause", "advice"))

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that failed."""
        return tuple(check for check in self.checks if check.status == "failed")

    @property
    def left_out(self) -> tuple[str, ...]:
        """Names of the checks that were left out for lack of time."""
        return tuple(check.check for check in self.checks if check.left_out)

    @property
    def verdict(self) -> str:
        """The outcome in words."""
        failed = f"does not conform: {len(self.failed)} check{'s' * (len(self.failed) > 1)} failed"
        verdict = {True: "conforms", False: failed, None: "not judged"}[self.conforms]
        return f"{verdict}, as far as there was time: {len(self.left_out)} checks are left out" if self.left_out else verdict


class Fault(Exception):
    """A check fails: what is wrong, and what to try."""

    status: Status = "failed"

    def __init__(self, cause: str, advice: str = "") -> None:
        super().__init__(cause)
        self.cause, self.advice = cause, advice


class Unjudged(Fault):
    """A check cannot be made: why, and what to try."""

    status: Status = "not judged"


class LeftOut(Unjudged):
    """A check was not begun, because it would have exceeded the time."""


def check_by(name: str, look: Callable[..., str | None], *arguments: Any) -> Check:
    """The check by a function, which raises `Fault` or returns a remark. The engine that it runs may refuse, or raise anything."""
    try:
        return Check(name, "passed", look(*arguments) or "")
    except Refusal as refusal:
        return Check(name, "passed", f"refused: {refusal}")
    except Exception as error:  # an author's engine may raise anything
        return ended(name, error)


def ended(name: str, error: Exception) -> Check:
    """The check that an exception ended."""
    if isinstance(error, Fault):
        return Check(name, error.status, error.cause, error.advice)
    if isinstance(error, EngineFailure):
        return Check(name, "failed", f"a run breaks down: {error.cause}", error.advice)
    cause = f"the engine raises {type(error).__name__}{raised_at(error)}: {first_line(error)}"
    return Check(name, "failed", cause, "only Refusal, EngineFailure and SettingError say something to a user")


def some(names: Sequence[str]) -> str:
    """Names for a sentence: the first ones, and the number of the others."""
    more = len(names) - _NAMED
    return ", ".join(names) if more <= 1 else f"{', '.join(names[:_NAMED])} and {more} more"
