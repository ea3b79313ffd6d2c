"""Exit codes of the program, and errors that it answers by a sentence and one of them."""

from enum import IntEnum
from typing import ClassVar


class ExitCode(IntEnum):
    """What the program returns."""

    GOOD = 0
    CLAIMS_BROKEN = 1  # engines disagree by more than they claim
    BAD_INPUT = 2  # or bad usage, or something that the engine cannot model
    ENGINE_TROUBLE = 3  # an engine failed, did not settle or did not reach the accuracy asked
    INTERRUPTED = 130  # Ctrl-C


class ToldError(Exception):
    """An error whose text is a sentence for a person."""

    exit_code: ClassVar[ExitCode] = ExitCode.BAD_INPUT
    option: ClassVar[str] = ""  # of the command line, by which what is wrong is given

    @property
    def sentences(self) -> list[str]:
        """What the program says, one for each mistake."""
        return [f"{self.option} {self}".lstrip()]
