"""The largest bending stress along the whole arm, and how far it is from what the material bears.

The stress at the surface is M c / I, with c half the thickness and I = width thickness^3 / 12; the strain is that over the modulus which
stiffness and section make. It is that of bending alone: the pull along the arm is left out.

For fatigue the stress amplitude counts, half the range that a place of the surface goes through in a cycle. It is held against the
strength under fully reversed stress, and the mean stress is left out of account: the usual correction for it (Goodman's) needs the ultimate
strength (Budynas and Nisbett, Shigley's Mechanical Engineering Design, 10th edition, sections 6-7 and 6-11).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.loads.arm import ArmMoments, moments_along_arm
from cases.loads.peak import Claim, Peak, peak_of
from cases.measures.extremes import extremes
from reference_model.columns import MOMENTS
from reference_model.mechanism import Follower, Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Factor:
    """What the material bears over what it must bear, and how far off the factor may be; None where that is not known."""

    value: float
    error: float | None


@dataclass(frozen=True)
class ArmStress:
    """Bending stress at the surface of the arm, Pa.

    Attributes:
        largest: magnitude.
        amplitude: half the range in a cycle, at the place where that is largest; its crank angle is that of the extreme farther from 0.
        mean: mean of the extremes there.
        places: arc lengths from P, m, shape (places,).
        lowest: least stress in the rows at each of them, positive where W'' > 0.
        highest: greatest, likewise.
    """

    largest: Peak
    amplitude: Peak
    mean: float
    places: Array
    lowest: Array
    highest: Array


def section_modulus(follower: Follower) -> float:
    """I / c of the rectangular section, m^3: moment over surface stress."""
    return follower.width * follower.thickness**2 / 6.0


def arm_stress(scene: Scene, columns: Mapping[str, Array], claim: Claim) -> ArmStress | None:
    """Stress along the arm; None where the engine does not give the moments.

    Args:
        scene: gives section and bodies.
        columns: of a cycle or a trajectory.
        claim: by how much a column may be off.
    """
    if not set(MOMENTS) <= set(columns):
        return None
    arm, unit = moments_along_arm(scene, columns), 1.0 / section_modulus(scene.follower)
    largest, (amplitude, mean) = _largest(arm, columns, claim), _amplitude(arm, columns, claim)
    low, high = arm.moments.min(axis=0), arm.moments.max(axis=0)
    return ArmStress(largest.times(unit), amplitude.times(unit), unit * mean, arm.places, unit * low, unit * high)


def safety(strength: float | None, stress: Peak) -> Factor | None:
    """Strength over stress; None where the strength is not known, or nothing is stressed."""
    if strength is None or stress.value == 0.0:
        return None
    factor = strength / stress.value
    return Factor(factor, None if stress.error is None else factor * stress.error / stress.value)


def _largest(arm: ArmMoments, columns: Mapping[str, Array], claim: Claim) -> Peak:
    """The largest moment: at the slider, which carries the corner along, or at one of the places."""
    _, at = np.unravel_index(int(np.abs(arm.moments).argmax()), arm.moments.shape)
    found = peak_of(arm.moments[:, at], columns, _claim_at(arm, int(at), claim), float(arm.places[at]))
    open_places = float((np.abs(arm.moments) + arm.open).max() - np.abs(arm.moments).max())
    grid = _between_places(arm, int(at), columns["time"], found.time)
    if arm.at_slider is not None:
        at_slider = peak_of(arm.at_slider, columns, lambda angle: claim("moment_slider", angle))
        if at_slider.value >= found.value:
            place = float(np.interp(at_slider.time, columns["time"], columns["slider_position"]))
            found, grid = Peak(**{**vars(at_slider), "place": place}), 0.0
    return Peak(**{**vars(found), "uncertainty": found.uncertainty + open_places + grid})


def _amplitude(arm: ArmMoments, columns: Mapping[str, Array], claim: Claim) -> tuple[Peak, float]:
    """Half the range of the moment where that is largest, and the mean of its extremes there."""
    ranges = arm.moments.max(axis=0) - arm.moments.min(axis=0)
    at, time = int(ranges.argmax()), columns["time"]
    low, high = extremes(time, arm.moments[:, at], time[0], time[-1])
    larger = peak_of(arm.moments[:, at], columns, _claim_at(arm, at, claim), float(arm.places[at]))
    left_open = (low.uncertainty + high.uncertainty) / 2.0 + float(arm.open[:, at].max()) + _between_places(arm, at, time, larger.time)
    half = Peak(**{**vars(larger), "value": (high.value - low.value) / 2.0, "uncertainty": left_open})
    return half, (high.value + low.value) / 2.0


def _between_places(arm: ArmMoments, at: int, time: Array, instant: float) -> float:
    """By how much the moment may be larger between two places than at the larger one: what a parabola through three has beyond them."""
    row, here = int(np.abs(time - instant).argmin()), min(max(at, 1), arm.places.size - 2)
    before, middle, after = arm.moments[row, here - 1 : here + 2]
    return float(abs(before - 2.0 * middle + after)) / 8.0


def _claim_at(arm: ArmMoments, at: int, claim: Claim) -> "_Nearest":
    return _Nearest(float(arm.places[at]) * (len(MOMENTS) + 1) / float(arm.places[-1]), claim)


@dataclass(frozen=True)
class _Nearest:
    """What an engine claims of the moment at a place: the larger of its claims at the nearest places that it gives.

    Attributes:
        twelfth: number of twelfths of the length from P to the place.
        claim: of a column.
    """

    twelfth: float
    claim: Claim

    def __call__(self, angle: float) -> float | None:
        numbers = {min(max(number, 1), len(MOMENTS)) for number in (math.floor(self.twelfth), math.ceil(self.twelfth))}
        errors = [self.claim(MOMENTS[number - 1], angle) for number in numbers]
        known = [error for error in errors if error is not None]
        return max(known) if len(known) == len(errors) else None
