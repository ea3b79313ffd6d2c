"""The statuses of a run."""

from enum import StrEnum

from quickreturn.reference_model.errors import ExitCode


class Ending(StrEnum):
    """Status of a run.

    Attributes:
        sentence: its meaning, to follow the name of the engine.
        exit_code: exit code of `run` if nothing else decides it.
        usable: whether the numbers of the run are used.
    """

    sentence: str
    exit_code: ExitCode
    usable: bool

    @property
    def incomplete(self) -> bool:
        """Whether the engine did not complete. A refusal does not count: the engine says what it cannot model."""
        return self.exit_code == ExitCode.ENGINE_TROUBLE and not self.usable

    def __new__(cls, word: str, sentence: str, exit_code: ExitCode, usable: bool) -> "Ending":
        """A member, whose value is the word."""
        member = str.__new__(cls, word)
        member._value_ = word
        member.sentence, member.exit_code, member.usable = sentence, exit_code, usable
        return member

    SETTLED = "settled", "reached its steady state, and by its own estimate the accuracy asked", ExitCode.GOOD, True
    INACCURATE = (
        "inaccurate",
        "reached its steady state, but its own estimate misses the accuracy asked; its numbers are used and marked",
        ExitCode.ENGINE_TROUBLE,
        True,
    )
    NOT_SETTLED = (
        "not settled",
        "did not repeat from cycle to cycle within the number of cycles allowed; its numbers are not used",
        ExitCode.ENGINE_TROUBLE,
        False,
    )
    FAILED = "failed", "broke down, crashed or was stopped at a limit; its numbers are not used", ExitCode.ENGINE_TROUBLE, False
    REFUSED = "refused", "says that it cannot model this scene", ExitCode.BAD_INPUT, False
    UNAVAILABLE = "unavailable", "cannot be used on this machine", ExitCode.ENGINE_TROUBLE, False
    TRANSIENT = "transient", "was measured in a turn on the way from the standard start, as asked", ExitCode.GOOD, True
    ASSUMED = "taken as settled", "is a recorded table that does not show whether it repeats", ExitCode.GOOD, True
