"""The errors that the program reports in a sentence."""

from typing import Final

#: Exceptions that are due to the machine, not to what it computes: memory, disk or another resource is exhausted, a library is missing.
#: They may not repeat, so they never become a result.
OF_THE_MACHINE: Final = (MemoryError, OSError, ImportError)


class ToldError(Exception):
    """An error that the program reports as a sentence, without a traceback: the input is at fault, unless it is an `EngineTrouble`."""


class EngineTrouble(ToldError):
    """An engine did not deliver what it was asked for."""


class ImpossibleMechanism(ToldError, ValueError):
    """The parts do not fit together.

    Attributes:
        key: the quantity at fault, as `part.quantity`.
        problem: a clause that follows the quantity's key and value.
        accepted: what is accepted instead; may be empty.
        others: quantities that may be at fault as well.
    """

    def __init__(self, key: str, problem: str, accepted: str = "", others: tuple[str, ...] = ()) -> None:
        super().__init__(f"{key} {problem}" + (f"; {accepted}" if accepted else ""))
        self.key = key
        self.problem = problem
        self.accepted = accepted
        self.others = others
