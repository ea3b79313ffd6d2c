"""Distance of the crank's speed from a resonance of the first mode; a warning of one so slow that a turn takes minutes to simulate."""

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes, turn_angles
from quickreturn.reference_model.rigid import mean_crank_speed

if TYPE_CHECKING:
    from quickreturn.cases.files.case import Case
    from quickreturn.cases.files.shown import Units

#: Number of crank angles in half a turn over which frequencies are averaged. The mean of a smooth periodic
#: function over so many even angles is exact to round-off in all scenes of the library but those whose crank nearly reaches P.
ANGLES: Final = 25
#: Slowest crank (rad/s, 9.5 rpm) that is not looked at more closely: the computation of the first mode takes a while.
SLOWEST_CRANK: Final = 1.0
#: Vibrations of the first mode in a turn above which a steady state takes more than about a minute.
MOST_VIBRATIONS: Final = 1000.0
#: Computing time (s) of a steady state by `reference` for each of them: 0.02 to 0.07 were measured for 250 to 500 of run 24's arm.
SECONDS_PER_VIBRATION: Final = 0.07


@dataclass(frozen=True)
class Resonance:
    """The first mode's frequency and that of the crank."""

    first_mode: float  # mean over the turn of the first frequency with the crank held, Hz
    lowest: float  # least of these frequencies, Hz
    crank: float  # turns of the crank per second, Hz

    @property
    def ratio(self) -> float:
        """Oscillations of the first mode in a turn."""
        return self.first_mode / self.crank

    @property
    def harmonic(self) -> int:
        """The harmonic of the crank's speed that is nearest to the first mode; at least the first."""
        return max(1, round(self.ratio))

    @property
    def resonant_speed(self) -> float:
        """Speed of the crank at which the nearest harmonic meets the first mode, rad/s."""
        return 2.0 * math.pi * self.first_mode / self.harmonic

    @property
    def detuning(self) -> float:
        """Relative change from the crank's speed to the resonant one; negative if that is lower."""
        return self.ratio / self.harmonic - 1.0

    @property
    def nearest(self) -> str:
        """Which harmonic of the crank's speed is nearest (a clause)."""
        return f"the {ordinal(self.harmonic)} harmonic is nearest to the first mode"

    def sentence(self, units: "Units") -> str:
        """Which harmonic of the crank's speed is nearest, and the speed at which the two meet."""
        speed, change = units.of("rad/s").text(self.resonant_speed), "faster" if self.detuning > 0.0 else "slower"
        return f"{self.nearest}; the two meet at {speed}, {in_percent(abs(self.detuning))} % {change}"


def resonance(mechanism: Mechanism, mean_speed: float | None = None) -> Resonance | None:
    """First mode and crank of a scene; None where nothing vibrates, or the crank stands still.

    `mean_speed` (rad/s) is that of the crank in a settled motion; None: that of the rigid mechanism (`mean_crank_speed`).
    """
    speed = abs(mean_crank_speed(mechanism) if mean_speed is None else mean_speed)
    if mechanism.follower.is_rigid or speed == 0.0 or mechanism.slider.closed_stiffness == 0.0:
        return None
    frequencies = _first_frequencies(mechanism)
    return Resonance(float(np.trapezoid(frequencies) / (frequencies.size - 1)), float(frequencies.min()), speed / (2.0 * math.pi))


@cache
def _first_frequencies(mechanism: Mechanism) -> Array:
    """The first mode's frequency with the crank held at even angles of the turn, Hz."""
    return np.array([frozen_crank_modes(mechanism, angle, 1).frequencies[0] for angle in turn_angles(mechanism, ANGLES)])


def in_percent(share: float) -> str:
    """A share in percent, to two figures and without an exponent."""
    return f"{100.0 * share:.0f}" if share >= 0.095 else f"{100.0 * share:.2g}"


def ordinal(number: int) -> str:
    """A number in an order: "33rd"."""
    return f"{number}{ {1: 'st', 2: 'nd', 3: 'rd'}.get(number % 10 if number % 100 not in (11, 12, 13) else 0, 'th') }"


def slow_turns(case: "Case") -> str:
    """How long the steady state of a case will take, and what to do (a sentence); "" if that is not long."""
    if case.scene.crank is None or not 0.0 < abs(mean_crank_speed(case.mechanism)) < SLOWEST_CRANK:
        return ""
    first = resonance(case.mechanism)
    if first is None or first.ratio < MOST_VIBRATIONS:
        return ""
    minutes, times = max(round(SECONDS_PER_VIBRATION * first.ratio / 60.0), 1), float(f"{first.ratio:.2g}")
    return (
        f"the crank takes {1.0 / first.crank:.3g} s for a turn, in which the arm vibrates about {times:,.0f} times: a steady state by"
        f" reference takes about {minutes} min, by other engines longer; give a higher speed, or simulate a shorter time with"
        " `quickreturn simulate --duration`"
    )
