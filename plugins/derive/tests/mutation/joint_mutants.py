"""Mutants of the joint's law, each of which must miss the law of two rollers that push one by one (`roller_law.force_of_rollers`)."""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.plugins.derive.tests.mutation.mutation import Hunt, Source
from quickreturn.reference_model import joint
from quickreturn.reference_model.joint import Rollers
from tests.reference_model.motion.roller_law import force_of_rollers, sliding_share

SOURCE: Final = Source(modules=(joint,), no_equations=frozenset({"rollers", "joint_in_words"}), stand_ins={}, entry=dict)
#: Rollers with clearance, and with preload.
PAIRS: Final = (
    Rollers(plus=4e3, minus=9e3, plus_from=5e-4, minus_from=4e-4, loss=0.6, damping=3.0),
    Rollers(plus=2e3, minus=5e3, plus_from=-1e-3, minus_from=-4e-4, loss=0.4),
)
GAPS: Final = (-2e-3, -6e-4, -1e-4, 2e-4, 7e-4, 2e-3)  # m
#: m/s; at the outer ones a roller that opens so fast lets go.
RATES: Final = (-3.0, -0.5, 0.0, 0.8, 4.0)
#: Rounding of forces of some ten newtons.
TOLERANCE: Final = 1e-12


@dataclass(frozen=True)
class Check:
    """The law at a gap and its rate; friction at that rate."""

    rollers: Rollers
    gap: float
    rate: float

    def difference(self, functions: Mapping[str, Any]) -> float:
        """Largest difference of forces (N), energies (J) and shares of friction."""
        r = self.rollers
        sides = r.plus, r.minus, r.plus_from, r.minus_from
        force, energy, _ = force_of_rollers(r, self.gap, self.rate)
        try:
            found = functions["joint_force"](self.gap, self.rate, *sides, r.loss, r.damping) - force
            stored = functions["joint_energy"](self.gap, *sides) - energy
            share = functions["friction_share"](self.rate, 1.3) - sliding_share(self.rate, 1.3)
        except ZeroDivisionError:
            return math.inf
        return max(map(abs, (found, stored, share))) if math.isfinite(found + stored + share) else math.inf


def checks() -> tuple[Check, ...]:
    return tuple(itertools.starmap(Check, itertools.product(PAIRS, GAPS, RATES)))


HUNT: Final = Hunt(SOURCE, checks, TOLERANCE, {}, least=30)
