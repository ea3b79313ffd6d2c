"""The statuses of a run."""

from collections.abc import Mapping
from enum import StrEnum
from types import MappingProxyType
from typing import Final


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
    def usable(self) -> bool:
        """Whether the numbers of the run are used."""
        return _MEANINGS[self][1]

    @property
    def incomplete(self) -> bool:
        """Whether the engine did not complete. A refusal does not count: the engine says what it cannot model."""
        return not self.usable and self != Ending.REFUSED

    @property
    def delivered(self) -> bool:
        """Whether the engine did what it was asked for, or refused to."""
        return not self.incomplete and self != Ending.INACCURATE


#: Status -> meaning, and whether the numbers are used.
_MEANINGS: Final[Mapping[Ending, tuple[str, bool]]] = MappingProxyType(
    {
        Ending.SETTLED: ("reached its steady state, and by its own estimate the accuracy asked", True),
        Ending.NEUTRAL: (
            "repeats, but a disturbance neither grows nor dies away: its largest Floquet multiplier is 1 within its error, or nothing takes"
            " energy from it; its numbers are used",
            True,
        ),
        Ending.INACCURATE: (
            "reached its steady state, but its own estimate misses the accuracy asked; its numbers are used and marked",
            True,
        ),
        Ending.NOT_SETTLED: ("did not repeat from cycle to cycle within the number of cycles allowed; its numbers are not used", False),
        Ending.FAILED: ("broke down, crashed or was stopped at a limit; its numbers are not used", False),
        Ending.REFUSED: ("says that it cannot model this scene", False),
        Ending.UNAVAILABLE: ("cannot be used on this machine", False),
        Ending.TRANSIENT: ("was measured in a turn on the way from the standard start, as asked", True),
        Ending.ASSUMED: ("is a recorded table that does not show whether it repeats", True),
    }
)
