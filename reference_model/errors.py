"""Exit codes of the program, and the errors that it reports in a sentence."""

from enum import IntEnum
from typing import ClassVar, Final

#: Exceptions that are due to the machine, not to what it computes: memory, disk or another resource is exhausted, a library is missing.
#: They may not repeat, so they never become a result.
OF_THE_MACHINE: Final = (MemoryError, OSError, ImportError)


class ExitCode(IntEnum):
    """What the program returns to the shell."""

    GOOD = 0
    CLAIMS_BROKEN = 1  # engines disagree by more than they claim
    BAD_INPUT = 2  # or bad usage, or something that the engine cannot model
    ENGINE_TROUBLE = 3  # an engine failed, did not settle or did not reach the accuracy asked
    INTERRUPTED = 130  # Ctrl-C


class ToldError(Exception):
    """An error that the program reports as a sentence, without a traceback."""

    exit_code: ClassVar[ExitCode] = ExitCode.BAD_INPUT
    option: ClassVar[str] = ""  # command-line option whose value is wrong; the sentence begins with it

    @property
    def sentences(self) -> list[str]:
        """What the program prints: one sentence for each mistake."""
        return [f"{self.option} {self}".lstrip()]


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
