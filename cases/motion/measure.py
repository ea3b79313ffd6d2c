"""A settled motion, and a measure of it: a number with its error."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final, TypeVar

import numpy as np

from quickreturn.cases.motion.estimates import NUMBER
from quickreturn.cases.motion.extremes import extremes
from quickreturn.cases.motion.number import NO_NUMBER, Number
from quickreturn.cases.motion.of_turn import OfTurn, TableColumn, Turn, at_shaft, by_spacing, crank_damping
from quickreturn.cases.motion.request import Run
from quickreturn.reference_model.mechanism import Mechanism

T = TypeVar("T")

#: Error of a size over the size above which it says nothing.
SAYS_NOTHING: Final = 0.5
#: Part of the last step of the search for a periodic motion that is left as its error, see `ORBIT_TOLERANCE` of `reference`.
LEFT_BY_SEARCH: Final = 0.1


@dataclass(frozen=True)
class SettledMotion:
    """A settled motion: a machine, and the run that shows it."""

    mechanism: Mechanism
    run: Run
    _computed: dict[Any, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def of(self, compute: Callable[["SettledMotion"], T]) -> T:
        """What a function makes of the motion, computed once."""
        if compute not in self._computed:
            self._computed[compute] = compute(self)
        found: T = self._computed[compute]
        return found

    @cached_property
    def cycle(self) -> Turn:
        """The columns of the run's cycle, with the torque that reaches the crank's shaft."""
        return at_shaft(self.run.cycle, crank_damping(self.mechanism))

    def claim(self, column: str, angle: float) -> float | None:
        """Error of a column in the half cycle of a crank angle: the engine's own estimate, and the distance from the steady state."""
        begin, end = self.cycle["crank_angle"][[0, -1]]
        half = "pre" if 2.0 * abs(angle - begin) <= abs(end - begin) else "post"
        estimate = self.run.measured.extreme_estimates.get(column, {}).get(half)
        return None if estimate is None else estimate + self.run.approach.distance(column, float(np.ptp(self.cycle[column])))

    def estimate(self, name: str, what: str) -> float | None:
        """The engine's estimate of the error of a number over a turn (`MeasuredNumbers.turn_estimates`); None if it has none."""
        return self.run.measured.turn_estimates.get(name, {}).get(what)

    @property
    def left(self) -> float:
        """Relative distance from the steady state."""
        part = 1.0 if self.run.approach.periodic_orbit is None else LEFT_BY_SEARCH
        return part * (self.run.approach.settling_error or 0.0)

    def extremes(self, column: str) -> tuple[Number, Number]:
        """Least and greatest value of a column that the engine gives."""
        if column not in self._computed:
            ((low, high),) = extremes(self.cycle["time"], self.cycle[column])
            self._computed[column] = self._claimed(column, low), self._claimed(column, high)
        found: tuple[Number, Number] = self._computed[column]
        return found

    def _claimed(self, column: str, extreme: Number) -> Number:
        angle = float(np.interp(extreme.time, self.cycle["time"], self.cycle["crank_angle"]))
        return replace(extreme, estimate=self.claim(column, angle), crank_angle=angle % (2.0 * math.pi))


@dataclass(frozen=True)
class Measure:
    """A number of a settled motion."""

    name: str  # as asked for
    unit: str  # SI
    meaning: str  # in words
    of: Callable[[SettledMotion], Number]  # computes it; `NO_NUMBER` where the motion has none
    columns: tuple[str, ...] = ()  # columns of the cycle that it needs
    vibration: bool = False  # whether the first mode must be fitted for it, which takes longest
    multipliers: bool = False  # whether it needs the multiplier of the whole model, which takes some more turns
    size: bool = False  # whether it is a size: an error as large as `SAYS_NOTHING` of it leaves nothing of the number
    of_material: bool = False  # whether it depends on strengths or notches, which move nothing
    in_tables: TableColumn | None = None  # how the tables of a run show it; None: not at all

    def says_nothing(self, value: float, error: float) -> str:
        """Why a number with its error says nothing (a clause); "" if it says something, or if the error is unknown."""
        if not self.size or not error > SAYS_NOTHING * abs(value) > 0.0:
            return ""
        return f"the error of {self.name} is {error / abs(value):.2g} times its value, which says nothing"


def number_of(declared: OfTurn, motion: SettledMotion) -> Number:
    """The number that a function gives of the turn of a motion; `NO_NUMBER` where columns lack, or the speed is not prescribed."""
    if not {*declared.columns} <= motion.run.cycle.keys() or (declared.prescribed and motion.mechanism.crank_is_free):
        return NO_NUMBER
    value, spacing = declared.of(motion.cycle), by_spacing(declared.of, motion.cycle, declared.columns)
    # of a motor's torque little may be left at the shaft: it settles as the whole does
    scale = abs((declared.scale or declared.of)(motion.run.cycle))
    return Number(value, motion.estimate(declared.name, NUMBER), spacing, settling=motion.left * scale)
