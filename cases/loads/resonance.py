"""Distance of the crank's speed from a resonance of the first mode."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes, turn_angles
from quickreturn.reference_model.rigid import mean_crank_speed

if TYPE_CHECKING:
    from quickreturn.cases.files.shown import Units

#: Number of crank angles in half a turn over which frequencies are averaged. The mean of a smooth periodic
#: function over so many even angles is exact to round-off in all scenes of the library but those whose crank nearly reaches P.
ANGLES: Final = 25
#: Distance of a ratio of frequencies from a whole number above which it lies between two, and below which it is close to one. At the peaks
#: of run 24's machine the first mode is 0.01 to 0.14 from a multiple of the crank's speed.
BETWEEN: Final = 0.25
CLOSE: Final = 0.1
#: Harmonics on either side of one that count as its own: the first mode's frequency changes over the turn and spreads vibrations over them.
BESIDE: Final = 2
#: Share of the tip's acceleration below which harmonics hardly drive the first mode. On the curves of run 24's machine (60 to 200 rpm,
#: orders 16 to 5) and of a pusher (119 to 161 rpm, orders 38 to 29) they raise a peak where they have 24 % or more at the speed at which
#: they meet the mode, and none with 23 % or less; halfway to the next such speed they have a seventh of that, or more.
HARDLY: Final = 0.02


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

    def sentence(self, units: "Units", share: float | None = None) -> str:
        """Which harmonic of the crank's speed is nearest, and its effect or the speed at which the two meet; `share`: see `share_of`."""
        nearest = f"the {ordinal(self.harmonic)} harmonic is nearest to the first mode"
        if share is not None and share < HARDLY:
            return f"{nearest} and hardly drives it: {share_words(self.harmonic, share)}"
        speed, change = units.of("rad/s").text(self.resonant_speed), "faster" if self.detuning > 0.0 else "slower"
        known = "" if share is None else f"; {share_words(self.harmonic, share)}"
        return f"{nearest}; the two meet at {speed}, {_percent(abs(self.detuning))} % {change}{known}"


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
def _first_frequencies(mechanism: Mechanism) -> NDArray[np.float64]:
    """The first mode's frequency with the crank held at even angles of the turn, Hz."""
    return np.array([frozen_crank_modes(mechanism, angle, 1).frequencies[0] for angle in turn_angles(mechanism, ANGLES)])


def share_of(order: int, cycle: Mapping[str, NDArray[np.float64]]) -> float | None:
    """Part of the tip's varying acceleration (RMS) that the harmonics within `BESIDE` of an order have in a settled turn.

    None where the turn has no such column, or fewer than four rows in a period of these harmonics.
    """
    time, rows = cycle["time"], cycle["time"].size - 1
    if "tip_acceleration" not in cycle or rows < 4 * (order + BESIDE):
        return None
    even = np.linspace(time[0], time[-1], rows, endpoint=False)
    amplitudes = np.abs(np.fft.rfft(np.interp(even, time, cycle["tip_acceleration"])))[1:-1]
    whole = float(np.linalg.norm(amplitudes))
    return float(np.linalg.norm(amplitudes[max(0, order - BESIDE - 1) : order + BESIDE])) / whole if whole else None


def share_words(order: int, share: float) -> str:
    """What the harmonics about an order make of the tip's acceleration (a clause)."""
    return f"harmonics {max(1, order - BESIDE)} to {order + BESIDE} make {_percent(share)} % of the tip's acceleration"


def _percent(share: float) -> str:
    """A share in percent, to two figures and without an exponent."""
    return f"{100.0 * share:.0f}" if share >= 0.095 else f"{100.0 * share:.2g}"


def ordinal(number: int) -> str:
    """A number in an order: "33rd"."""
    return f"{number}{ {1: 'st', 2: 'nd', 3: 'rd'}.get(number % 10 if number % 100 not in (11, 12, 13) else 0, 'th') }"


def driven(mechanism: Mechanism) -> tuple[int, int]:
    """The harmonic of the crank's speed that drives a mode most, and the mode's number, for a scene at a peak of its resonance curve.

    That is the multiple of the speed nearest to the mean frequency of the first mode, unless the speed lies between two such multiples and
    close to one of the second mode.
    """
    modes = [frozen_crank_modes(mechanism, angle, 2).frequencies for angle in turn_angles(mechanism, ANGLES)]
    ratios = np.asarray(np.trapezoid(modes, axis=0)) / (len(modes) - 1) / (abs(mean_crank_speed(mechanism)) / (2.0 * math.pi))
    first, second = np.abs(ratios - np.round(ratios))
    mode = 1 if second > CLOSE or first < BETWEEN else 2
    return max(1, round(float(ratios[mode - 1]))), mode


def shift_of_motion(mechanism: Mechanism) -> float:
    """Difference of the mean first frequency with a turning, compliant crank from that with the crank held; Hz.

    To first order in the coupling of the modes (`cases.motion.moving_mode`); 0 where nothing vibrates.
    """
    from quickreturn.cases.motion.time_scale import TURN, time_scale

    scale = time_scale(mechanism)
    if scale is None:
        return 0.0
    angles = TURN[:-1]
    running = scale.running_frequencies(angles, np.full(angles.size, abs(mean_crank_speed(mechanism))))[:, 0]
    return float(np.mean(running - scale.frequencies(angles)[:, 0]))
