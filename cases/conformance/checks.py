"""What a check of an adapter says."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from cases.shown import Cell, Rows, Shown
from engines.base import Refusal

Array = NDArray[np.float64]
Status = Literal["passed", "failed", "not judged"]

#: Advice where nothing better is known.
TELL_THE_AUTHOR: Final = "debug it with the scene of this check: cases.conformance.scenes"


@dataclass(frozen=True)
class Check:
    """One thing that was looked at.

    Attributes:
        check: what was looked at.
        status: how it ended.
        cause: what is wrong, or why it was not judged; of a check that passed what was seen, or "".
        advice: what to try; "" where nothing is wrong.
    """

    check: str
    status: Status
    cause: str = ""
    advice: str = ""


@dataclass(frozen=True, repr=False)
class Conformance(Shown):
    """What was found of an engine.

    Attributes:
        engine: name.
        conforms: False if a check failed; None if there was nothing to judge by.
        checks: all of them.
    """

    engine: str
    conforms: bool | None
    checks: tuple[Check, ...]

    def _parts(self) -> Iterator[Cell]:
        yield f"{self.engine}: {self.verdict}"
        yield Rows([(each.check, each.status, each.cause, each.advice) for each in self.checks], ("check", "status", "cause", "advice"))

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that failed."""
        return tuple(check for check in self.checks if check.status == "failed")

    @property
    def verdict(self) -> str:
        """In words."""
        failed = f"does not conform: {len(self.failed)} check{'s' * (len(self.failed) > 1)} failed"
        return {True: "conforms", False: failed, None: "not judged"}[self.conforms]


class Fault(Exception):
    """A check fails: what is wrong, and what to try."""

    status: Status = "failed"

    def __init__(self, cause: str, advice: str = "") -> None:
        super().__init__(cause)
        self.cause, self.advice = cause, advice


class Unjudged(Fault):
    """A check cannot be made: why, and what to try."""

    status: Status = "not judged"


def looked_at(name: str, look: Callable[..., str | None], *arguments: Any) -> Check:
    """The check that `look` makes: it raises `Fault`, or gives back a remark, if there is one. An engine may refuse."""
    try:
        return Check(name, "passed", look(*arguments) or "")
    except Refusal as refusal:
        return Check(name, "passed", f"refused: {refusal}")
    except Fault as fault:
        return Check(name, fault.status, fault.cause, fault.advice)


def percent(share: float) -> str:
    """A share in per cent with two digits."""
    return f"{100.0 * share:.2g} %"
