"""The bending moment along the whole arm, from the columns of a trajectory, and how far the places between leave it open.

An engine gives the moment at the interior twelfths of the length and at the slider. At the ends moment and slope follow from Newton's and
Euler's laws for the bodies there, with q2 the angle of the base, theta that of the flexible end, n the normal, a the acceleration of the
flexible end along it, e the tip body's centre of mass beyond the end, R the force of the bearing, f the force on the tip:

    base   M(0) = J_b q2'' + c_b q2' - turning torque,          M'(0) = R n
    tip    M(L) = -J theta'' - m e (a + e theta'' - g n),       M'(L) = m (a + e theta'' - g n) - f n

On either side of the slider the moment is smooth; its slope jumps there by the slider's force, and the moment itself where the slider has
rotary inertia. Each side is interpolated apart, by polynomials through the nearest known places. What they may miss is seen where every
other twelfth is left out.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from reference_model.columns import MOMENTS, PLACES
from reference_model.mechanism import FollowerAlone, Scene
from reference_model.tip_force import tip_force

Array = NDArray[np.float64]
Numbers = NDArray[np.intp]

TWELFTHS: Final = PLACES + 1
#: Places at which the moment is evaluated in each twelfth of the length.
IN_A_TWELFTH: Final = 20
#: Known places that the interpolating polynomial goes through, where a side has as many.
THROUGH: Final = 6
#: Twelfths that are nearer to the slider than this part of a twelfth are left out: the slope between two such places would be noise.
TOO_NEAR: Final = 1.0 / 3.0
#: A known slope at an end is a further place beyond it, at this part of a twelfth: its moment is off by 5e-5 of what a parabola's is.
BEYOND: Final = 0.01
#: Of what the interpolation misses without every other twelfth, what it may miss with all of them. At half the spacing a polynomial of
#: degree one misses a quarter, one of higher degree less. Half is on the safe side: in 15 combinations of natural modes no place is
#: missed by more (`tests/cases/test_loads.py`).
REST: Final = 0.5


@dataclass(frozen=True)
class ArmMoments:
    """The bending moment along the arm over time.

    Attributes:
        places: arc lengths from P, m, shape (places,).
        moments: N m, shape (rows, places), positive where W'' > 0.
        open: by how much the interpolation may miss each of them, N m, shape (rows, places).
        at_slider: N m, on the side of the slider where its magnitude is larger, shape (rows,); None where there is no slider.
    """

    places: Array
    moments: Array
    open: Array
    at_slider: Array | None


@dataclass(frozen=True)
class KnownMoments:
    """Where the moment is known.

    Attributes:
        length: of the arm, m.
        twelfths: moments from the base to the tip, N m, shape (rows, 13).
        slider: arc length of the slider, m, shape (rows,); infinite where there is none.
        inboard: moment on the inner side of the slider, N m, shape (rows,).
        outboard: on its outer side, likewise.
        base_slope: N, shape (rows,); None where it is not known.
        tip_slope: likewise.
        ends_open: by how much the moments at base and tip may be off, N m, shape (rows,) each.
    """

    length: float
    twelfths: Array
    slider: Array
    inboard: Array
    outboard: Array
    base_slope: Array | None
    tip_slope: Array | None
    ends_open: tuple[Array, Array]

    @property
    def spacing(self) -> float:
        """Length of a twelfth, m."""
        return self.length / TWELFTHS


def moments_along_arm(scene: Scene, columns: Mapping[str, Array]) -> ArmMoments:
    """The moment along the arm.

    Args:
        scene: gives the bodies at the ends.
        columns: those of a trajectory or of a cycle, each of shape (rows,), the moments among them.

    Raises:
        KeyError: the engine does not give the moments.
    """
    places = np.linspace(0.0, scene.follower.length, TWELFTHS * IN_A_TWELFTH + 1)
    known = known_moments(scene, columns)
    has_slider = "moment_slider" in columns
    larger = np.where(np.abs(known.inboard) > np.abs(known.outboard), known.inboard, known.outboard)
    missed = left_out(known)
    return ArmMoments(places, interpolated(places, known), between(places, missed, known), larger if has_slider else None)


def known_moments(scene: Scene, columns: Mapping[str, Array]) -> KnownMoments:
    """What the columns and the bodies at slider, base and tip say; arguments as of `moments_along_arm`."""
    time, tip = columns["time"], scene.tip_body
    base, base_open = _at_base(scene, columns)
    nothing = np.zeros(time.size)
    has_slider = "moment_slider" in columns
    outboard = columns["moment_slider"] if has_slider else nothing
    rolls = 0.0 if isinstance(scene, FollowerAlone) else scene.slider.inertia
    known = KnownMoments(
        length=scene.follower.length,
        twelfths=np.column_stack([base, *(columns[name] for name in MOMENTS), nothing]),
        slider=columns["slider_position"] if has_slider else np.full(time.size, np.inf),
        inboard=outboard,
        outboard=outboard,
        base_slope=_base_slope(columns),
        tip_slope=None,
        ends_open=(base_open, nothing),
    )
    turns = nothing, nothing  # second derivative of the end's angle, and how far off the rows leave it
    if rolls > 0.0 or tip.inertia > 0.0 or tip.center_of_mass != 0.0:
        places = np.linspace(0.0, known.length, TWELFTHS * IN_A_TWELFTH + 1)
        angles = _angles(scene, columns, places, interpolated(places, known))
        turns = _second_derivative(time, angles[:, -1])
        if rolls > 0.0:
            at_slider = np.array([np.interp(s, places, row) for s, row in zip(known.slider, angles, strict=True)])
            known = replace(known, inboard=outboard - rolls * _second_derivative(time, at_slider)[0])
        known.twelfths[:, -1], off = _at_tip(scene, columns, angles[:, -1], turns)
        known = replace(known, ends_open=(base_open, off))
        normal = angles[:, -1]
    else:
        normal = columns["follower_angle"]
    return replace(known, tip_slope=_tip_slope(scene, columns, normal, turns[0]))


def _at_base(scene: Scene, columns: Mapping[str, Array]) -> tuple[Array, Array]:
    """Moment at the base, N m, and how far off the rows leave it; shape (rows,) each."""
    base, time, angle = scene.base, columns["time"], columns["follower_angle"]
    turning = columns.get("base_torque", np.zeros(time.size))
    acceleration, off = _second_derivative(time, angle)
    return base.inertia * acceleration + base.damping * CubicSpline(time, angle)(time, 1) - turning, base.inertia * off


def _base_slope(columns: Mapping[str, Array]) -> Array | None:
    if "pivot_force_x" not in columns:
        return None
    angle = columns["follower_angle"]
    return columns["pivot_force_y"] * np.cos(angle) - columns["pivot_force_x"] * np.sin(angle)


def _across(vector: Array, angle: Array) -> Array:
    """Part of a vector in the fixed frame, shape (2, rows) or (2, 1), along the normal of an angle."""
    return np.asarray(vector[1] * np.cos(angle) - vector[0] * np.sin(angle))


def _at_tip(scene: Scene, columns: Mapping[str, Array], angle: Array, turns: tuple[Array, Array]) -> tuple[Array, Array]:
    """Moment at the flexible end, N m, and how far off the rows leave it; `angle` is the end's, rad; shape (rows,) each."""
    tip, weight = scene.tip_body, _across(np.array(scene.gravity)[:, None], angle)
    about_end = tip.inertia + tip.mass * tip.center_of_mass**2
    return -about_end * turns[0] - tip.mass * tip.center_of_mass * (columns["tip_acceleration"] - weight), about_end * turns[1]


def _tip_slope(scene: Scene, columns: Mapping[str, Array], angle: Array, turning: Array) -> Array:
    """Slope of the moment at the flexible end, N, shape (rows,)."""
    tip, weight = scene.tip_body, _across(np.array(scene.gravity)[:, None], angle)
    force = _across(tip_force(tip, columns["crank_angle"]), angle) if tip.is_forced else 0.0
    return np.asarray(tip.mass * (columns["tip_acceleration"] + tip.center_of_mass * turning - weight) - force)


def _angles(scene: Scene, columns: Mapping[str, Array], places: Array, moments: Array) -> Array:
    """Angle of the centre line at each place in the fixed frame, rad, shape (rows, places)."""
    steps = 0.5 * np.diff(places) * (moments[:, 1:] + moments[:, :-1]) / scene.follower.bending_stiffness
    return np.asarray(columns["follower_angle"][:, None] + np.cumsum(np.pad(steps, ((0, 0), (1, 0))), axis=1))


def _second_derivative(time: Array, values: Array) -> tuple[Array, Array]:
    """That of the cubic spline through a signal, and by how much that through every other sample differs from it."""
    found = CubicSpline(time, values)(time, 2)
    fewer = np.append(np.arange(0, time.size - 1, 2), time.size - 1)
    return found, np.abs(CubicSpline(time[fewer], values[fewer])(time, 2) - found)


def interpolated(x: Array, known: KnownMoments, parity: int | None = None) -> Array:
    """Moments at arc lengths `x` (m, shape (m,)), N m, shape (rows, m); with a `parity` from the ends and the twelfths of that parity."""
    numbers = np.arange(TWELFTHS + 1)
    kept = numbers[(numbers % TWELFTHS == 0) | (numbers % 2 == parity) | (parity is None)]
    found = np.empty((known.slider.size, x.size))
    for rows, inner, outer in _groups(known, kept):
        ahead = np.broadcast_to(x, (rows.size, x.size)) <= known.slider[rows, None]
        for wanted, nodes in ((ahead, _nodes(known, rows, inner, inner=True)), (~ahead, _nodes(known, rows, outer, inner=False))):
            some = wanted.any(axis=0)
            if some.any():
                block = np.ix_(rows, some)
                found[block] = np.where(wanted[:, some], _polynomials(*nodes, x[some]), found[block])
    return found


def _groups(known: KnownMoments, kept: Numbers) -> Iterator[tuple[Numbers, Numbers, Numbers]]:
    """Rows whose slider lies between the same twelfths, with the numbers of those on either side of it that are not too near."""
    place = known.slider / known.spacing
    inner = np.maximum(np.searchsorted(kept, place - TOO_NEAR), 1)  # the ends stay
    outer = np.where(np.isfinite(place), np.minimum(np.searchsorted(kept, place + TOO_NEAR, side="right"), kept.size - 1), kept.size)
    for a, b in sorted(set(zip(inner.tolist(), outer.tolist(), strict=True))):
        yield np.flatnonzero((inner == a) & (outer == b)), kept[:a], kept[b:]


def _nodes(known: KnownMoments, rows: Numbers, numbers: Numbers, inner: bool) -> tuple[Array, Array]:
    """Arc lengths (m) and moments (N m) of the known places on one side of the slider, ascending, shape (rows, n) each."""
    places = list(np.broadcast_to(numbers * known.spacing, (rows.size, numbers.size)).T)
    moments, beyond = list(known.twelfths[np.ix_(rows, numbers)].T), BEYOND * known.spacing
    if numbers.size and numbers[0] == 0 and known.base_slope is not None:
        places.insert(0, np.full(rows.size, -beyond))
        moments.insert(0, moments[0] - beyond * known.base_slope[rows])
    if numbers.size and numbers[-1] == TWELFTHS and known.tip_slope is not None:
        places.append(np.full(rows.size, known.length + beyond))
        moments.append(moments[-1] + beyond * known.tip_slope[rows])
    if np.isfinite(known.slider[rows]).all():
        at = len(places) if inner else 0
        places.insert(at, known.slider[rows])
        moments.insert(at, (known.inboard if inner else known.outboard)[rows])
    return np.array(places).T, np.array(moments).T


def _polynomials(nodes: Array, values: Array, x: Array) -> Array:
    """At `x` (shape (m,)) the polynomials through the nearest of some nodes (shape (rows, n)), in Lagrange's form; shape (rows, m)."""
    count = nodes.shape[1]
    through = min(THROUGH, count)
    cell = (x[None, :, None] > nodes[:, None, :]).sum(axis=2) - 1
    first = np.clip(cell - (through - 2) // 2, 0, count - through)
    index = first[..., None] + np.arange(through)
    near, its = (np.take_along_axis(each[:, None, :], index, axis=2) for each in (nodes, values))
    found = np.zeros(first.shape)
    with np.errstate(divide="ignore", invalid="ignore"):  # a slider at the very end leaves a side without length, where nothing is asked
        for j in range(through):
            weight = np.ones(first.shape)
            for k in range(through):
                if k != j:
                    weight *= (x - near[..., k]) / (near[..., j] - near[..., k])
            found += weight * its[..., j]
    return found


def left_out(known: KnownMoments) -> Array:
    """By how much the moment at each twelfth is missed where every other one is left out, N m, shape (rows, 13); 0 at the ends."""
    missed = np.zeros(known.twelfths.shape)
    for parity in (0, 1):
        others = np.arange(1 + parity, TWELFTHS, 2)
        missed[:, others] = np.abs(interpolated(known.spacing * others.astype(float), known, parity) - known.twelfths[:, others])
    return missed


def between(x: Array, missed: Array, known: KnownMoments) -> Array:
    """By how much the interpolation may miss the moment at each place, N m, shape (rows, m).

    It is the largest of what is `missed` at the four nearest twelfths, less near a known place, and no less than what an end is off by.
    """
    twelfth, (base, tip) = known.spacing, known.ends_open
    cell = np.minimum((x / twelfth).astype(int), TWELFTHS - 1)
    near = [np.clip(cell + step, 0, TWELFTHS) for step in (-1, 0, 1, 2)]
    worst = REST * np.max([missed[:, numbers] for numbers in near], axis=0)
    distance = np.abs(x - known.slider[:, None])
    for end in (cell, cell + 1):
        used = np.abs(end * twelfth - known.slider[:, None]) > TOO_NEAR * twelfth
        distance = np.where(used, np.minimum(distance, np.abs(x - end * twelfth)), distance)
    at_base, at_tip = (np.maximum(0.0, 1.0 - away / twelfth) for away in (x, known.length - x))
    return np.maximum(worst * np.minimum(1.0, 2.0 * distance / twelfth), base[:, None] * at_base + tip[:, None] * at_tip)
