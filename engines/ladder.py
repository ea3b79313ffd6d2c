"""One ladder for all engines: settings from coarse to fine, what each of them claims, and how to climb from one to the next."""

from dataclasses import dataclass
from typing import Final, Generic, TypeVar

from quickreturn.engines.settings import Settings

S = TypeVar("S", bound=Settings)
Climbing = TypeVar("Climbing", bound=Settings)

#: By how much larger a size is tried where nothing is known of the error, and how many times as large one rung may be at most.
_UNKNOWN: Final = 1.5
_MOST_AT_ONCE: Final = 2.0


@dataclass(frozen=True)
class Ladder(Generic[S]):
    """Settings that differ in one size, and where it says so in a tolerance that must not be looser than fits that size."""

    rungs: tuple[tuple[S, float], ...]  # settings and the error of the tip deflection that they claim in run 24 over 2 s, coarse to fine
    size: str  # name of the setting that grows from rung to rung: modes, elements, links
    tolerance: str = ""  # name of the setting that comes with a size, or ""
    order: float = 0.0  # of the error in the size, by which climbing goes; 0: it goes from one rung to the next

    def pick(self, accuracy: float, gain: float = 1.0) -> S:
        """The coarsest rung that claims `accuracy`, or the finest one; `gain` is a scene's error over that in run 24."""
        return next((rung for rung, claim in self.rungs if gain * claim <= accuracy), self.rungs[-1][0])

    def claim(self, size: int) -> float:
        """What the first rung that has as many claims, or the finest one."""
        return self._first(size)[1]

    def sized(self, settings: Climbing, size: int) -> Climbing:
        """The settings in another size, their tolerance as tight as the first rung's that has as many, or tighter."""
        changes: dict[str, float] = {self.size: size}
        if self.tolerance:
            changes[self.tolerance] = min(getattr(settings, self.tolerance), getattr(self._first(size)[0], self.tolerance))
        return settings.replaced(**changes)

    def finer(self, settings: Climbing, excess: tuple[float, ...] = ()) -> Climbing | None:
        """The first rung as large as the estimate asks for, or the finest one; None above the ladder.

        Args:
            settings: those that do not suffice.
            excess: parts of the estimate over the accuracy asked for; empty where nothing is known.
        """
        present = getattr(settings, self.size)
        above = [size for size in (getattr(rung, self.size) for rung, _ in self.rungs) if size > present]
        if not above:
            return None
        wanted = present * min(sum(excess) ** (1.0 / self.order) if excess else _UNKNOWN, _MOST_AT_ONCE) if self.order else present
        return self.sized(settings, next((size for size in above if size >= wanted), above[-1]))

    def _first(self, size: int) -> tuple[S, float]:
        return next((rung for rung in self.rungs if getattr(rung[0], self.size) >= size), self.rungs[-1])
