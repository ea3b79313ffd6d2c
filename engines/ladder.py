"""One ladder for all engines: settings from coarse to fine, what each of them claims, and how to climb from one to the next."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Generic, TypeVar

from quickreturn.engines.settings import Settings
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.natural_modes import stiffness_ratio

S = TypeVar("S", bound=Settings)
Climbing = TypeVar("Climbing", bound=Settings)

#: Tolerance of an explicit integration over the accuracy, where a scene needs fewer shapes than run 24.
TOLERANCE_PER_ACCURACY: Final = 1e-4
#: `stiffness_ratio` of run 24, on which the ladders were measured.
RATIO_OF_RUN_24: Final = 4.1
#: What is known of an estimate that there is not.
NOTHING_KNOWN: Final[Mapping[str, float]] = MappingProxyType({})
#: Factor on the size if the error is unknown, and the largest factor from one rung to the next.
_UNKNOWN: Final = 1.5
_MOST_AT_ONCE: Final = 2.0


@dataclass(frozen=True)
class Ladder(Generic[S]):
    """Settings that differ in one size, and perhaps in a tolerance that goes with it."""

    rungs: tuple[tuple[S, float], ...]  # settings, and the error of the tip deflection that they claim in run 24 over 2 s; coarse to fine
    size: str  # name of the setting that grows from rung to rung: modes, elements, links
    tolerance: str = ""  # name of the tolerance that falls from rung to rung, or ""
    order: float = 0.0  # order of the error in the size, for choosing a finer rung; 0: the next rung is taken

    def pick(self, accuracy: float, gain: float = 1.0) -> S:
        """The coarsest rung that claims `accuracy`, else the finest one; `gain` is the error in a scene over that in run 24."""
        return next((rung for rung, claim in self.rungs if gain * claim <= accuracy), self.rungs[-1][0])

    def rung(self, size: int) -> S:
        """The first rung of at least this size, else the finest one."""
        return self._first(size)[0]

    def claim(self, size: int) -> float:
        """Error that the first rung of at least this size claims, else the finest rung."""
        return self._first(size)[1]

    def sized(self, settings: Climbing, size: int) -> Climbing:
        """The settings with another size, and a tolerance no looser than that of the first rung of at least this size."""
        changes: dict[str, float] = {self.size: size}
        if self.tolerance:
            changes[self.tolerance] = min(getattr(settings, self.tolerance), getattr(self.rung(size), self.tolerance))
        return settings.replaced(**changes)

    def finer(self, settings: Climbing, excess: Mapping[str, float] = NOTHING_KNOWN) -> Climbing | None:
        """The settings with the size of the first rung that should suffice, else of the finest one; None at the end of the ladder.

        Args:
            settings: settings that do not suffice.
            excess: see `Engine.finer`.
        """
        present = getattr(settings, self.size)
        above = [size for size in (getattr(rung, self.size) for rung, _ in self.rungs) if size > present]
        if not above:
            return None
        wanted = present * min(sum(excess.values()) ** (1.0 / self.order) if excess else _UNKNOWN, _MOST_AT_ONCE) if self.order else present
        return self.sized(settings, next((size for size in above if size >= wanted), above[-1]))

    def _first(self, size: int) -> tuple[S, float]:
        return next((rung for rung in self.rungs if getattr(rung[0], self.size) >= size), self.rungs[-1])


def fitted(ladder: Ladder[S], accuracy: float, scene: Scene, tolerance_per_accuracy: float = TOLERANCE_PER_ACCURACY) -> S:
    """The coarsest rung for a scene; if that is coarser than run 24 needs, with a tolerance that fits the accuracy, a power of ten."""
    rung = ladder.pick(accuracy, gain_of(scene))
    if rung == ladder.pick(accuracy):
        return rung
    fit = 10.0 ** math.floor(math.log10(tolerance_per_accuracy * accuracy) + 1e-9)
    return rung.replaced(**{ladder.tolerance: min(getattr(rung, ladder.tolerance), fit)})


def gain_of(scene: Scene) -> float:
    """Estimated error of few shapes, elements or steps in a scene over that in run 24, at most 1.

    A stiff follower bends as in equilibrium. What few shapes or large steps miss are inertia forces, which are smaller the stiffer the
    follower is: inversely proportional to the square of `stiffness_ratio`.
    """
    ratio = stiffness_ratio(scene)
    return min(1.0, (RATIO_OF_RUN_24 / ratio) ** 2) if ratio else 1.0
