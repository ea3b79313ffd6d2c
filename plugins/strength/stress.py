"""The largest stress along the whole arm, and its ratio to the strength of the material.

The stress at a surface is that of bending and of the normal force, M c / I + N / A, with I the second moment of the section, c the distance
of its surface from the axis of bending, A its area; at the opposite surface the first part has the other sign. The strain is the stress
over the modulus from stiffness and section. The stress of an engine that does not give the normal force is that of bending alone.

For fatigue the stress amplitude counts, half the range of stress at a place of the surface in a cycle. A notch multiplies it by its fatigue
notch factor K_f, not the mean stress, and not the largest stress: where a ductile material yields in a notch, it is relieved there. A mean
tension counts by the line of Goodman, one that presses does not count. With the amplitude a, the mean m, the fatigue strength S_f under
fully reversed stress and the tensile strength S_u, the safety factor n, by which all stress may grow, follows from

    K_f a / S_f + max(m, 0) / S_u = 1 / n

so that a fully reversed stress of the amplitude K_f a + max(m, 0) S_f / S_u is as bad: `equivalent`. Without a tensile strength the mean
does not count. (Budynas and Nisbett, Shigley's Mechanical Engineering Design, 10th edition, sections 6-10 to 6-12.)
"""

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from quickreturn.cases.motion.extremes import ErrorAt, extremes, of_column, peak_of
from quickreturn.cases.motion.number import Number
from quickreturn.plugins.strength.arm import (
    ALONG,
    KnownMoments,
    axial_forces,
    between,
    interpolated,
    is_known,
    known_moments,
    left_out,
    missing,
)
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import AXIAL
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Scene

#: Largest error of a stress, as a part of it, with which the arm is judged: with tens of percent it is not resolved.
LARGEST_JUDGED: Final = 0.1
#: Least number of rows of a cycle for the search of the worst place; at that place all rows count.
SEARCHED: Final = 400
#: Part of the largest range below which a cycle of stress is not counted. A thousandth of its amplitude harms no metal.
COUNTED: Final = 0.01


@dataclass(frozen=True)
class Factor:
    """Strength of the material over its stress, and the interval for it, that of the stress inverted; None if the error is not known."""

    value: float
    lowest: float | None  # of the largest stress that the claim allows
    highest: float | None  # of the least one; infinite where that is zero
    error: float | None  # of the stress, as a part of it

    @property
    def judged(self) -> bool:
        """Whether the stress is good enough to say that the arm holds, or does not."""
        return self.error is not None and self.error <= LARGEST_JUDGED

    @property
    def text(self) -> str:
        """The factor, with its interval where the error of the stress forbids a judgement."""
        if self.judged or self.lowest is None or self.highest is None:
            return _digits(self.value)
        interval = f"{_digits(self.lowest)} {'or more' if math.isinf(self.highest) else f'to {_digits(self.highest)}'}"
        return f"{_digits(self.value)} ({interval})"


def _digits(value: float) -> str:
    """Three digits, without an exponent below a million: "3440"."""
    return f"{float(f'{value:.3g}'):g}"


@dataclass(frozen=True)
class Fatigue:
    """What counts for fatigue, at the place of the surface where it is worst."""

    equivalent: Number  # amplitude of the fully reversed stress that is as bad as the worst cycle there, Pa
    notch_factor: float  # there; 1 where no notch is given
    amplitude: float  # half of the range of the stress beside the notch in a turn, Pa
    mean: float  # mean of its extremes, Pa; tension is positive
    ranges: tuple[float, ...]  # of the cycles counted there in a turn, Pa, the largest first


@dataclass(frozen=True)
class ArmStress:
    """Stress at the surface of the arm, Pa."""

    largest: Number  # magnitude
    axial: Number | None  # part of the largest stress that the normal force has, negative where it presses; None where it is not known
    # half the range in a cycle, at the place where that is largest; its crank angle is that of the extreme farther from 0
    amplitude: Number
    mean: float  # mean of the extremes at that place
    fatigue: Fatigue  # at the place where it is worst
    notches: tuple[Fatigue, ...]  # at each notch, in the order of the file
    places: Array  # arc lengths from P, m, shape (places,)
    lowest: Array  # least stress at each place over the rows, shape (places,), at the surface that is longer where W'' > 0
    highest: Array  # greatest stress, likewise


def section_modulus(follower: Follower) -> float:
    """I / c of the section, m^3: moment over surface stress."""
    return follower.section.second_moment() / follower.extreme_fibre


def arm_stress(scene: Scene, columns: Mapping[str, Array], claim: ErrorAt) -> ArmStress | None:
    """Stress along the arm; None where the engine does not give the moments (`arm.missing`).

    Args:
        scene: gives section, bodies, notches and strengths.
        columns: of a cycle or a trajectory.
        claim: error of a column at a crank angle, by the engine's own estimate.
    """
    if missing(scene, columns):
        return None
    known, follower = known_moments(scene, columns), scene.follower
    arm = _Arm(scene, columns, known, claim, is_known(scene, columns))
    field, ratio = arm.field(known.places), goodman_ratio(follower)
    fields = [(field, np.ones(field.places.size))]
    widest = worst = _worst(arm, fields, 0.0)
    notches = [
        (arm.field(np.array([place])), np.array([factor]))
        for place, factor in zip(follower.notch_places or (), follower.notch_factors or (), strict=True)
    ]
    if ratio > 0.0 or notches:
        worst = _worst(arm, [*fields, *notches], ratio)
    largest, axial = _largest(arm, field)
    surface = field.at_surface(1.0)
    return ArmStress(
        largest=largest,
        axial=axial if arm.has_axial else None,
        amplitude=widest.equivalent,
        mean=widest.mean,
        fatigue=worst,
        notches=tuple(_worst(arm, [notch], ratio, even=False) for notch in notches),
        places=known.places,
        lowest=surface.min(axis=0),
        highest=surface.max(axis=0),
    )


def axial_stress(scene: Scene, columns: Mapping[str, Array], claim: ErrorAt) -> Number | None:
    """Largest magnitude of the stress by the normal force, Pa: at one of the places where it is given; None where it is not known."""
    if not is_known(scene, columns):
        return None
    peaks = [peak for name in AXIAL if (peak := of_column(name, columns, claim)) is not None]
    return max(peaks, key=lambda peak: peak.value).times(1.0 / scene.follower.section.area())


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
    """Stress along the arm in some of the rows, Pa, shape (some rows, places) each."""

    places: Array  # arc lengths, m, shape (places,)
    bending: Array  # at the surface that is longer where W'' > 0
    axial: Array
    open: Array  # interpolation error of both
    axial_open: Array  # that of the second

    def at_surface(self, side: float) -> Array:
        """The stress at that surface, or at the opposite one for a `side` of -1."""
        return np.asarray(side * self.bending + self.axial)

    def beyond(self, side: float, row: int, at: int) -> float:
        """Largest excess of the stress between places over that at a place: of the parabola through it and its neighbours."""
        before, middle, after = self.at_surface(side)[row, np.clip(at, 1, self.places.size - 2) + np.arange(-1, 2)]
        return float(abs(before - 2.0 * middle + after)) / 8.0


@dataclass(frozen=True)
class _Arm:
    """What is known of the arm in all rows."""

    scene: Scene
    columns: Mapping[str, Array]
    known: KnownMoments
    claim: ErrorAt
    has_axial: bool  # whether the normal force is known

    @cached_property
    def units(self) -> tuple[float, float]:
        """Stress over moment, 1/m^3, and over normal force, 1/m^2."""
        return 1.0 / section_modulus(self.scene.follower), 1.0 / self.scene.follower.section.area()

    def field(self, places: Array) -> _Field:
        """The stress at some places in some rows."""
        step = max(1, self.known.slider.size // SEARCHED)
        known, (of_moment, of_force) = self.known.every(step), self.units
        moments, open_moments = interpolated(places, known), between(places, left_out(known), known)
        rows = {name: values[::step] for name, values in self.columns.items()}
        forces, open_forces = axial_forces(self.scene, rows, known, places)
        axial_open = of_force * open_forces
        return _Field(places, of_moment * moments, of_force * forces, of_moment * open_moments + axial_open, axial_open)

    def series(self, place: float, side: float) -> Array:
        """The stress at a place of a surface in all rows, Pa, shape (rows,)."""
        places, (of_moment, of_force) = np.array([place]), self.units
        forces, _ = axial_forces(self.scene, self.columns, self.known, places)
        return np.asarray(side * of_moment * interpolated(places, self.known) + of_force * forces)[:, 0]

    def at_slider(self) -> Iterator[tuple[Array, Array]]:
        """Stress by bending and by the normal force on either side of the slider, Pa, shape (rows,) each; nothing where there is none."""
        known, (of_moment, of_force) = self.known, self.units
        if np.isfinite(known.slider).all():
            for moment, name in ((known.outboard, "axial_slider"), (known.inboard, "axial_inboard")):
                yield of_moment * moment, of_force * (self.columns[name] if self.has_axial else np.zeros(moment.size))

    def peak(self, place: float, series: Array) -> Number:
        """Peak of the magnitude of a `series` at a place.

        The claim is that for the moments at the nearest given places; a moment at an end without a column is zero.
        """
        twelfth = place / self.known.spacing
        given = [ALONG[number] for number in {math.floor(twelfth), math.ceil(twelfth)} if ALONG[number] in self.columns]
        return peak_of(series, self.columns, self.claimed(given), place)

    def claimed(self, moments: Collection[str]) -> Callable[[float], float | None]:
        """Crank angle -> claim for a stress, Pa: the largest for the moments of these columns, and the largest for normal forces."""
        forces = [name for name in AXIAL if name in self.columns] if self.has_axial else []

        def at(angle: float) -> float | None:
            total = 0.0
            for unit, names in zip(self.units, (moments, forces), strict=True):
                errors = [error for name in names if (error := self.claim(name, angle)) is not None]
                if len(errors) < len(names):
                    return None
                total += unit * max(errors, default=0.0)
            return total

        return at


def _side(bending: float, axial: float) -> float:
    """The surface, see `_Field.at_surface`, at which both stresses have one sign."""
    return -1.0 if bending * axial < 0.0 else 1.0


def _largest(arm: _Arm, field: _Field) -> tuple[Number, Number]:
    """The largest stress, at the slider, where the moment has its corner, or at one of the places; and the part of the normal force."""
    sizes = np.abs(field.bending) + np.abs(field.axial)
    row, at = (int(number) for number in np.unravel_index(int(sizes.argmax()), sizes.shape))
    axial = Number(float(field.axial[row, at]), measurement=float(field.axial_open[row, at]))
    side = _side(float(field.bending[row, at]), axial.value)
    place, beyond = float(field.places[at]), field.beyond(side, row, at)
    peak = arm.peak(place, arm.series(place, side))
    for bending, along in arm.at_slider():
        row = int((np.abs(bending) + np.abs(along)).argmax())
        at_slider = peak_of(_side(float(bending[row]), float(along[row])) * bending + along, arm.columns, arm.claimed(["moment_slider"]))
        if at_slider.value >= peak.value:
            place = float(np.interp(at_slider.time, arm.columns["time"], arm.known.slider))
            peak, beyond, axial = replace(at_slider, place=place), 0.0, Number(float(along[row]))
    axial = replace(axial, estimate=arm.claimed([])(peak.crank_angle or 0.0), crank_angle=peak.crank_angle, place=peak.place)
    return replace(peak, measurement=peak.measurement + beyond + float((sizes + field.open).max() - sizes.max())), axial


def _worst(arm: _Arm, fields: Sequence[tuple[_Field, Array]], ratio: float, *, even: bool = True) -> Fatigue:
    """Fatigue at the place of the surface where the equivalent amplitude is largest.

    Args:
        arm: gives the stress in all rows.
        fields: stress at places, with the notch factor at each, shape (places,).
        ratio: see `equivalent_amplitude`.
        even: whether the places of the first field are even.
    """
    found = list[tuple[float, _Field, float, int, float]]()
    for field, factors in fields:
        for side in (1.0, -1.0):
            low, high = field.at_surface(side).min(axis=0), field.at_surface(side).max(axis=0)
            equivalent = equivalent_amplitude(factors * (high - low) / 2.0, (high + low) / 2.0, ratio)
            at = int(equivalent.argmax())
            found.append((float(equivalent[at]), field, side, at, float(factors[at])))
    _, field, side, at, factor = max(found, key=lambda each: each[0])
    place, time = float(field.places[at]), arm.columns["time"]
    series = arm.series(place, side)
    ((low, high),) = extremes(time, series)
    amplitude, mean = (high.value - low.value) / 2.0, (high.value + low.value) / 2.0
    left_open = (low.uncertainty + high.uncertainty) / 2.0 + float(field.open[:, at].max())
    if even and field is fields[0][0]:
        left_open += field.beyond(side, int(np.abs(field.at_surface(side)[:, at]).argmax()), at)
    error = replace(arm.peak(place, series), measurement=left_open).times(factor + (ratio if mean > 0.0 else 0.0))
    return Fatigue(
        equivalent=replace(error, value=float(equivalent_amplitude(factor * amplitude, mean, ratio))),
        notch_factor=factor,
        amplitude=amplitude,
        mean=mean,
        ranges=counted_ranges(series),
    )


def goodman_ratio(follower: Follower) -> float:
    """Fatigue strength over tensile strength; 0 where one is not known, so that the mean stress does not count."""
    if follower.fatigue_strength is None or follower.tensile_strength is None:
        return 0.0
    return follower.fatigue_strength / follower.tensile_strength


def equivalent_amplitude(amplitude: Array | float, mean: Array | float, ratio: float) -> Array:
    """Amplitude of the fully reversed stress that is as bad; `ratio`: see `goodman_ratio`."""
    return np.asarray(amplitude + ratio * np.maximum(mean, 0.0))


def counted_ranges(stress: Array) -> tuple[float, ...]:
    """Ranges of the cycles that count in a stress that repeats, the largest first; `stress`: of a turn, shape (rows,)."""
    ranges = sorted((high - low for low, high in cycles_of(stress)), reverse=True)
    return tuple(each for each in ranges if each >= COUNTED * ranges[0])


def cycles_of(stress: Array) -> list[tuple[float, float]]:
    """Lowest and highest stress of each cycle in a stress that repeats, by rainflow counting from its greatest value on.

    ASTM E1049-85, section 5.4.5: in a history that repeats every cycle is a whole one.
    """
    first = int(np.argmax(stress))
    cycles, open_ = list[tuple[float, float]](), list[float]()
    for value in _turning_points(np.concatenate([stress[first:], stress[: first + 1]])):
        open_.append(value)
        while len(open_) > 2 and abs(open_[-1] - open_[-2]) >= abs(open_[-2] - open_[-3]):
            cycles.append((min(open_[-3:-1]), max(open_[-3:-1])))
            del open_[-3:-1]
    return cycles


def _turning_points(values: Array) -> list[float]:
    """The first and the last value, and all between them at which the sequence turns."""
    moving = values[np.concatenate([[True], np.diff(values) != 0.0])]
    steps = np.sign(np.diff(moving))
    turns = np.concatenate([[True], steps[:-1] != steps[1:], [True]]) if steps.size else [True]
    return [float(value) for value in moving[turns]]
