"""The largest bending stress along the whole arm, and its ratio to the strength of the material.

The stress at the surface is M c / I, with I the second moment of the section and c the distance of its surface from the axis of bending;
the strain is the stress over the modulus from stiffness and section. It is the stress of bending alone: the pull along the arm is left out.

For fatigue the stress amplitude counts, half the range of stress at a place of the surface in a cycle. It is compared with the strength
under fully reversed stress, without the mean stress: the usual correction for it (Goodman's) needs the ultimate strength (Budynas and
Nisbett, Shigley's Mechanical Engineering Design, 10th edition, sections 6-7 and 6-11).
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.loads.arm import ALONG, KnownMoments, between, interpolated, known_moments, left_out, missing
from quickreturn.cases.loads.peak import ErrorAt, peak_of
from quickreturn.cases.measures.extremes import extremes
from quickreturn.cases.measures.number import Number
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.witnesses import Witness, Witnesses

Array = NDArray[np.float64]

#: Largest error of a stress, as a part of it, with which the arm is judged: with tens of percent it is not resolved.
LARGEST_JUDGED: Final = 0.1
#: Least number of rows of a cycle for the search of the worst place; at that place all rows count.
SEARCHED: Final = 400


@dataclass(frozen=True)
class Factor:
    """Strength of the material over its stress, and the interval for it, that of the stress inverted; None if the error is not known."""

    value: float
    lowest: float | None  # of the largest stress that the claim allows
    highest: float | None  # of the least one; infinite where that is zero
    error: float | None  # of the stress, as a part of it

    witnesses: ClassVar[Witnesses] = {
        "value": Witness("the closed form of a rigid arm", 1e-6, "tests/cases/test_loads.py::test_forces_and_safety"),
        **dict.fromkeys(
            ("lowest", "highest", "error"),
            Witness(
                "intervals inverted by hand",
                1e-6,
                "tests/cases/test_loads.py::test_the_interval_of_a_factor_is_that_of_the_stress_inverted",
            ),
        ),
    }

    @property
    def judged(self) -> bool:
        """Whether the stress is good enough to say that the arm holds, or does not."""
        return self.error is not None and self.error <= LARGEST_JUDGED

    @property
    def text(self) -> str:
        """The factor, with its interval where the error of the stress forbids a judgement."""
        value = f"{self.value:.3g}"
        if self.judged or self.lowest is None or self.highest is None:
            return value
        return f"{value} ({self.lowest:.3g} or more)" if math.isinf(self.highest) else f"{value} ({self.lowest:.3g} to {self.highest:.3g})"


@dataclass(frozen=True)
class ArmStress:
    """Bending stress at the surface of the arm, Pa."""

    largest: Number  # magnitude
    # half the range in a cycle, at the place where that is largest; its crank angle is that of the extreme farther from 0
    amplitude: Number
    mean: float  # mean of the extremes at that place
    places: Array  # arc lengths from P, m, shape (places,)
    lowest: Array  # least stress at each place over the rows, shape (places,); positive where W'' > 0
    highest: Array  # greatest stress, likewise

    witnesses: ClassVar[Witnesses] = dict.fromkeys(
        ("mean", "places", "lowest", "highest"),
        Witness("the closed form of a rigid arm", 0.02, "tests/cases/test_loads.py::test_largest_stress_and_amplitude_of_a_rigid_arm"),
    )


def section_modulus(follower: Follower) -> float:
    """I / c of the section, m^3: moment over surface stress."""
    return follower.section.second_moment() / follower.extreme_fibre


def arm_stress(scene: Scene, columns: Mapping[str, Array], claim: ErrorAt) -> ArmStress | None:
    """Stress along the arm; None where the engine does not give the moments (`arm.missing`).

    Args:
        scene: gives section and bodies.
        columns: of a cycle or a trajectory.
        claim: error of a column at a crank angle, by the engine's own estimate.
    """
    if missing(scene, columns):
        return None
    known, unit = known_moments(scene, columns), 1.0 / section_modulus(scene.follower)
    field = _Field.of(known, max(1, columns["time"].size // SEARCHED))
    largest, (amplitude, mean) = _largest(field, columns, claim), _amplitude(field, columns, claim)
    low, high = field.moments.min(axis=0), field.moments.max(axis=0)
    return ArmStress(largest.times(unit), amplitude.times(unit), unit * mean, known.places, unit * low, unit * high)


def safety(strength: float | None, stress: Number) -> Factor | None:
    """Strength over stress; None where the strength is not known, or nothing is stressed."""
    if strength is None or stress.value == 0.0:
        return None
    factor = strength / stress.value
    if math.isnan(stress.error):
        return Factor(factor, None, None, None)
    error = stress.error / stress.value
    return Factor(factor, factor / (1.0 + error), factor / (1.0 - error) if error < 1.0 else math.inf, error)


@dataclass(frozen=True)
class _Field:
    """The moment along the arm in some of the rows."""

    known: KnownMoments  # the known moments in all rows
    moments: Array  # moments in some rows at `known.places`, N m, shape (some rows, places)
    open: Array  # interpolation error of each of them, N m, likewise

    @classmethod
    def of(cls, known: KnownMoments, step: int) -> "_Field":
        """The field in every `step`-th row."""
        fewer = known.every(step)
        return cls(known, interpolated(known.places, fewer), between(known.places, left_out(fewer), fewer))

    def series(self, at: int) -> Array:
        """The moment at a place in all rows, N m, shape (rows,)."""
        return interpolated(self.known.places[[at]], self.known)[:, 0]

    def beyond(self, row: int, at: int) -> float:
        """Largest excess of the moment between places over that at a place, N m: of the parabola through it and its neighbours."""
        before, middle, after = self.moments[row, np.clip(at, 1, self.moments.shape[1] - 2) + np.arange(-1, 2)]
        return float(abs(before - 2.0 * middle + after)) / 8.0


def _largest(field: _Field, columns: Mapping[str, Array], claim: ErrorAt) -> Number:
    """The largest moment: at the slider, where the moment has its corner, or at one of the places."""
    sizes, known = np.abs(field.moments), field.known
    row, at = (int(number) for number in np.unravel_index(int(sizes.argmax()), sizes.shape))
    peak, beyond = _peak_at(field, at, columns, claim), field.beyond(row, at)
    if known.at_slider is not None:
        at_slider = peak_of(known.at_slider, columns, lambda angle: claim("moment_slider", angle))
        if at_slider.value >= peak.value:
            place = float(np.interp(at_slider.time, columns["time"], known.slider))
            peak, beyond = replace(at_slider, place=place), 0.0
    return replace(peak, measurement=peak.measurement + beyond + float((sizes + field.open).max() - sizes.max()))


def _amplitude(field: _Field, columns: Mapping[str, Array], claim: ErrorAt) -> tuple[Number, float]:
    """Half the range of the moment where that is largest, and the mean of its extremes there."""
    time, at = columns["time"], int(np.ptp(field.moments, axis=0).argmax())
    low, high = extremes(time, field.series(at), time[0], time[-1])
    larger, beyond = _peak_at(field, at, columns, claim), field.beyond(int(np.abs(field.moments[:, at]).argmax()), at)
    left_open = (low.uncertainty + high.uncertainty) / 2.0 + float(field.open[:, at].max()) + beyond
    return replace(larger, value=(high.value - low.value) / 2.0, measurement=left_open), (high.value + low.value) / 2.0


def _peak_at(field: _Field, at: int, columns: Mapping[str, Array], claim: ErrorAt) -> Number:
    place = float(field.known.places[at])
    return peak_of(field.series(at), columns, _Nearest(place / field.known.spacing, claim, columns), place)


@dataclass(frozen=True)
class _Nearest:
    """An engine's claim for the moment at a place: the larger of its claims at the nearest given places."""

    twelfth: float  # number of twelfths of the length from P to the place
    claim: ErrorAt  # of a column
    given: Collection[str]  # columns of the engine; the moment at an end without one is zero

    def __call__(self, angle: float) -> float | None:
        numbers = {math.floor(self.twelfth), math.ceil(self.twelfth)}
        errors = [self.claim(ALONG[number], angle) for number in numbers if ALONG[number] in self.given]
        claimed = [error for error in errors if error is not None]
        return max(claimed, default=0.0) if len(claimed) == len(errors) else None
