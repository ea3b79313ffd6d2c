"""The largest bending stress along the whole arm, and how far it is from what the material bears.

The stress at the surface is M c / I, with c half the thickness and I = width thickness^3 / 12; the strain is that over the modulus which
stiffness and section make. It is that of bending alone: the pull along the arm is left out.

For fatigue the stress amplitude counts, half the range that a place of the surface goes through in a cycle. It is held against the
strength under fully reversed stress, and the mean stress is left out of account: the usual correction for it (Goodman's) needs the ultimate
strength (Budynas and Nisbett, Shigley's Mechanical Engineering Design, 10th edition, sections 6-7 and 6-11).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.loads.arm import NEEDED, KnownMoments, between, interpolated, known_moments, left_out
from quickreturn.cases.loads.peak import ErrorAt, Peak, peak_of
from quickreturn.cases.measures.extremes import extremes
from quickreturn.reference_model.columns import MOMENTS
from quickreturn.reference_model.mechanism import Follower, Scene

Array = NDArray[np.float64]

#: Rows of a cycle in which the worst place is looked for, at least; at that place all rows count.
SEARCHED: Final = 400


@dataclass(frozen=True)
class Factor:
    """What the material bears over what it must bear, and how far off the factor may be; None where that is not known."""

    value: float
    error: float | None


@dataclass(frozen=True)
class ArmStress:
    """Bending stress at the surface of the arm, Pa."""

    largest: Peak  # magnitude
    amplitude: Peak  # half the range in a cycle, at the place where that is largest; its crank angle is that of the extreme farther from 0
    mean: float  # mean of the extremes there
    places: Array  # arc lengths from P, m, shape (places,)
    lowest: Array  # least stress in the rows at each of them, positive where W'' > 0
    highest: Array  # greatest, likewise


def section_modulus(follower: Follower) -> float:
    """I / c of the rectangular section, m^3: moment over surface stress."""
    return follower.width * follower.thickness**2 / 6.0


def arm_stress(scene: Scene, columns: Mapping[str, Array], claim: ErrorAt) -> ArmStress | None:
    """Stress along the arm; None where the engine does not give the moments.

    Args:
        scene: gives section and bodies.
        columns: of a cycle or a trajectory.
        claim: by how much a column may be off.
    """
    if not set(columns) >= NEEDED:
        return None
    known, unit = known_moments(scene, columns), 1.0 / section_modulus(scene.follower)
    field = _Field.of(known, max(1, columns["time"].size // SEARCHED))
    largest, (amplitude, mean) = _largest(field, columns, claim), _amplitude(field, columns, claim)
    low, high = field.moments.min(axis=0), field.moments.max(axis=0)
    return ArmStress(largest.times(unit), amplitude.times(unit), unit * mean, known.places, unit * low, unit * high)


def safety(strength: float | None, stress: Peak) -> Factor | None:
    """Strength over stress; None where the strength is not known, or nothing is stressed."""
    if strength is None or stress.value == 0.0:
        return None
    factor = strength / stress.value
    return Factor(factor, None if stress.error is None else factor * stress.error / stress.value)


@dataclass(frozen=True)
class _Field:
    """The moment along the arm in some of the rows."""

    known: KnownMoments  # in all of them
    moments: Array  # N m, shape (some rows, places)
    open: Array  # by how much the interpolation may miss each of them, N m, likewise

    @classmethod
    def of(cls, known: KnownMoments, step: int) -> "_Field":
        """The field in every so many rows."""
        some = known.every(step)
        return cls(known, interpolated(known.places, some), between(known.places, left_out(some), some))

    def series(self, at: int) -> Array:
        """The moment at a place in all rows, N m, shape (rows,)."""
        return interpolated(self.known.places[[at]], self.known)[:, 0]

    def beyond(self, row: int, at: int) -> float:
        """By how much the moment may be larger beside a place: what the parabola through it and its neighbours has beyond them, N m."""
        before, middle, after = self.moments[row, np.clip(at, 1, self.moments.shape[1] - 2) + np.arange(-1, 2)]
        return float(abs(before - 2.0 * middle + after)) / 8.0


def _largest(field: _Field, columns: Mapping[str, Array], claim: ErrorAt) -> Peak:
    """The largest moment: at the slider, which carries the corner along, or at one of the places."""
    sizes, known = np.abs(field.moments), field.known
    row, at = (int(number) for number in np.unravel_index(int(sizes.argmax()), sizes.shape))
    found, beyond = _peak_at(field, at, columns, claim), field.beyond(row, at)
    if known.at_slider is not None:
        at_slider = peak_of(known.at_slider, columns, lambda angle: claim("moment_slider", angle))
        if at_slider.value >= found.value:
            place = float(np.interp(at_slider.time, columns["time"], known.slider))
            found, beyond = replace(at_slider, place=place), 0.0
    return replace(found, uncertainty=found.uncertainty + beyond + float((sizes + field.open).max() - sizes.max()))


def _amplitude(field: _Field, columns: Mapping[str, Array], claim: ErrorAt) -> tuple[Peak, float]:
    """Half the range of the moment where that is largest, and the mean of its extremes there."""
    time, at = columns["time"], int(np.ptp(field.moments, axis=0).argmax())
    low, high = extremes(time, field.series(at), time[0], time[-1])
    larger, beyond = _peak_at(field, at, columns, claim), field.beyond(int(np.abs(field.moments[:, at]).argmax()), at)
    left_open = (low.uncertainty + high.uncertainty) / 2.0 + float(field.open[:, at].max()) + beyond
    return replace(larger, value=(high.value - low.value) / 2.0, uncertainty=left_open), (high.value + low.value) / 2.0


def _peak_at(field: _Field, at: int, columns: Mapping[str, Array], claim: ErrorAt) -> Peak:
    place = float(field.known.places[at])
    return peak_of(field.series(at), columns, _Nearest(place / field.known.spacing, claim), place)


@dataclass(frozen=True)
class _Nearest:
    """What an engine claims of the moment at a place: the larger of its claims at the nearest places that it gives."""

    twelfth: float  # number of twelfths of the length from P to the place
    claim: ErrorAt  # of a column

    def __call__(self, angle: float) -> float | None:
        numbers = {min(max(number, 1), len(MOMENTS)) for number in (math.floor(self.twelfth), math.ceil(self.twelfth))}
        errors = [self.claim(MOMENTS[number - 1], angle) for number in numbers]
        known = [error for error in errors if error is not None]
        return max(known) if len(known) == len(errors) else None
