"""The statuses of a run."""

from collections.abc import Mapping
from enum import StrEnum
from types import MappingProxyType
from typing import Final

from quickreturn.reference_model.errors import ExitCode


class Ending(StrEnum):
    """Status of a run."""

    SETTLED = "settled"
    NEUTRAL = "neutral"
    INACCURATE = "inaccurate"
    NOT_SETTLED = "not settled"
    FAILED = "failed"
    REFUSED = "refused"
    UNAVAILABLE = "unavailable"
    TRANSIENT = "transient"
    ASSUMED = "taken as settled"

    @property
    def sentence(self) -> str:
        """Its meaning, to follow the name of the engine."""
        return _MEANINGS[self][0]

    @property
    def exit_code(self) -> ExitCode:
        """Exit code of `run` if nothing else decides it."""
        return _MEANINGS[self][1]

    @property
    def usable(self) -> bool:
        """Whether the numbers of the run are used."""
        return self.exit_code == ExitCode.GOOD or self == Ending.INACCURATE

    @property
    def incomplete(self) -> bool:
        """Whether the engine did not complete. A refusal does not count: the engine says what it cannot model."""
        return self.exit_code == ExitCode.ENGINE_TROUBLE and not self.usable


#: Status -> meaning and exit code.
_MEANINGS: Final[Mapping[Ending, tuple[str, ExitCode]]] = MappingProxyType(
    {
        Ending.SETTLED: ("reached its steady state, and by its own estimate the accuracy asked", ExitCode.GOOD),
        Ending.NEUTRAL: (
            "repeats, but a disturbance neither grows nor dies away: its largest Floquet multiplier is 1 within its error, or nothing takes"
            " energy from it; its numbers are used",
            ExitCode.GOOD,
        ),
        Ending.INACCURATE: (
            "reached its steady state, but its own estimate misses the accuracy asked; its numbers are used and marked",
            ExitCode.ENGINE_TROUBLE,
        ),
        Ending.NOT_SETTLED: (
            "did not repeat from cycle to cycle within the number of cycles allowed; its numbers are not used",
            ExitCode.ENGINE_TROUBLE,
        ),
        Ending.FAILED: ("broke down, crashed or was stopped at a limit; its numbers are not used", ExitCode.ENGINE_TROUBLE),
        Ending.REFUSED: ("says that it cannot model this scene", ExitCode.BAD_INPUT),
        Ending.UNAVAILABLE: ("cannot be used on this machine", ExitCode.ENGINE_TROUBLE),
        Ending.TRANSIENT: ("was measured in a turn on the way from the standard start, as asked", ExitCode.GOOD),
        Ending.ASSUMED: ("is a recorded table that does not show whether it repeats", ExitCode.GOOD),
    }
)
