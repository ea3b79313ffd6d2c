"""Bending moment and normal force along the whole arm, from the columns of a trajectory, and the errors of their interpolation.

An engine gives the moment at the interior twelfths of the length, at both ends, and at either side of the slider. Those at the ends are
what the bodies there require by the engine's own accelerations. They are not made of other columns here: the angle of the end follows from
the moments, the moment at the end from that angle's second derivative, and this circle diverges for rows closer than the period of the last
twelfth with the tip body on it. The slopes at the ends follow from Newton's law, with n the normal, a the acceleration of the flexible end
along it, theta the angle of the end, e the tip body's centre of mass beyond the end, R the force of the bearing, f that of the tool and of
the friction of its slide, c the damping of the beam, which acts between it and the base:

    base   dM(0)/dx = R n + integral of c dW/dt over x
    tip    dM(L)/dx = m (a + e theta'' - g n) - f n,   M(L) = -J theta'' - m e (a + e theta'' - g n)

A spring at the end adds its force to f. Elsewhere it makes a kink at its place x_s: what is interpolated is the moment less the part
F n (x_s - x) that its force F has inboard of it.

On either side of the slider the moment is smooth; its slope jumps there by the slider's force, and the moment itself where the slider has
rotary inertia. Each side is interpolated separately, by polynomials through the nearest known places. Their error is estimated by leaving
out every other twelfth.

The normal force, positive in tension, is given at the base, on either side of the slider, and at the flexible end. Between two of these
places, a and b, it is that of a rigid arm through both values, with the weight w of a length along the arm; c follows from the value at b:

    N(x) = N(a) - w (x - a) + c (x^2 - a^2)

A bent arm departs from this: its tangent turns into the direction of the shear force, and its points move along it. Both are of the second
order in the deflection, and at most about the shear force times the angle by which the tangent turns: that is the error claimed between the
given places. Beside the stress of bending it is small: of the order of thickness times deflection over the square of the length.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import AXIAL, MOMENTS, PLACES, SHAPE
from quickreturn.reference_model.interpolation import CubicSpline
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.tip import slide_friction, tip_force

Numbers = NDArray[np.intp]

TWELFTHS: Final = PLACES + 1
#: Columns without which there is no moment along the arm; see also `missing`.
NEEDED: Final = frozenset((*MOMENTS, "time", "follower_angle", "tip_acceleration"))
#: The moments from the base to the tip, a twelfth of the length apart.
ALONG: Final = ("moment_base", *MOMENTS, "moment_tip")
#: Number of places in each twelfth of the length at which the moment is computed.
IN_A_TWELFTH: Final = 10
#: Number of known places that the interpolating polynomial passes through, if a side has as many.
THROUGH: Final = 6
#: Twelfths that are nearer to the slider than this part of a twelfth are left out: the slope between two such places would be noise.
TOO_NEAR: Final = 1.0 / 3.0
#: A known slope at an end becomes a further known place beyond it, at this part of a twelfth. The moment there, extrapolated linearly, is
#: off by 5e-5 of its second derivative times the square of a twelfth.
BEYOND: Final = 0.01
#: Ratio of the interpolation error with all twelfths to that without every other one. At half the spacing a polynomial of degree one has a
#: quarter of the error, one of higher degree less. Half is on the safe side: in 15 combinations of one to five natural modes, in three
#: scenes, the error of the largest moment was below it. Single places, most of them beyond a slider near the tip, exceeded it by up to 6e-4
#: of the peak.
REMAINING_ERROR: Final = 0.5


@dataclass(frozen=True)
class KnownMoments:
    """The bending moment at the places where it is known, in each row of a trajectory."""

    length: float  # of the arm, m
    twelfths: Array  # moments from the base to the tip, N m, shape (rows, 13)
    slider: Array  # arc length of the slider, m, shape (rows,); infinite where there is none
    inboard: Array  # moment on the inner side of the slider, N m, shape (rows,)
    outboard: Array  # on its outer side, likewise
    base_slope: Array | None  # N, shape (rows,); None where it is not known
    tip_slope: Array | None  # likewise
    spring: float = 0.0  # arc length of the spring's place, m
    pull: NDArray[np.complex128] | None = None  # its force along the arm + i across, N, shape (rows,); None without one, or at the end

    @property
    def spacing(self) -> float:
        """Length of a twelfth, m."""
        return self.length / TWELFTHS

    @property
    def places(self) -> Array:
        """Arc lengths at which the moment is computed, m, shape (places,)."""
        return np.linspace(0.0, self.length, TWELFTHS * IN_A_TWELFTH + 1)

    def of_spring(self, x: Array, rows: Numbers | slice = slice(None)) -> Array:
        """Part of the spring in the moment of some rows at arc lengths `x` (m, shape (some rows, m)), N m; 0 without one."""
        return np.zeros(x.shape) if self.pull is None else self.pull.imag[rows, None] * np.maximum(self.spring - x, 0.0)

    def every(self, step: int) -> "KnownMoments":
        """These moments in every `step`-th row."""
        of_rows: dict[str, Any] = {name: value[::step] for name, value in vars(self).items() if isinstance(value, np.ndarray)}
        return replace(self, **of_rows)


def missing(scene: Scene, columns: Mapping[str, Array]) -> str:
    """Why there is no moment along the arm (a clause), because an engine or a table lacks a column; "" where nothing lacks.

    Without its column the moment at an end is known only where no body there asks for one: then it is zero. That at the slider's inboard
    side is known without one where the slider passes no moment.
    """
    base, tip, slider = scene.base, scene.tip_body, scene.slider
    at_base = base.inertia > 0.0 or base.damping > 0.0 or base.friction_torque > 0.0 or scene.follower.damping > 0.0 or scene.crank is None
    passes = slider.inertia > 0.0 or (not slider.is_rigid and (slider.friction > 0.0 or slider.friction_force > 0.0))
    needed = {
        **dict.fromkeys(sorted(NEEDED), True),
        "moment_base": at_base,
        "moment_tip": tip.inertia > 0.0 or tip.mass * tip.center_of_mass != 0.0,
        "moment_inboard": passes and "moment_slider" in columns,
        "spring_force": scene.acting_spring is not None,
    }
    return next((f"column {name} is missing" for name, needs in needed.items() if needs and name not in columns), "")


def known_moments(scene: Scene, columns: Mapping[str, Array]) -> KnownMoments:
    """The known moments along the arm.

    Args:
        scene: gives the bodies.
        columns: those of a trajectory or of a cycle, each of shape (rows,), of which none is `missing`.
    """
    nothing = np.zeros(columns["time"].size)
    outboard = columns.get("moment_slider", nothing)
    known = KnownMoments(
        length=scene.follower.length,
        twelfths=np.column_stack([columns.get(name, nothing) for name in ALONG]),
        slider=columns["slider_position"] if "moment_slider" in columns else np.full(nothing.size, np.inf),
        inboard=columns.get("moment_inboard", outboard),
        outboard=outboard,
        base_slope=_base_slope(scene, columns),
        tip_slope=None,
    )
    tip_slope = _tip_slope(scene, columns, known)
    if (spring := scene.acting_spring) is None:
        return replace(known, tip_slope=tip_slope)
    place, pull = spring.place_on(known.length), _pull(scene, columns)
    if place < known.length:
        return replace(known, tip_slope=tip_slope, spring=place, pull=pull)
    return replace(known, tip_slope=tip_slope - pull.imag)


def _pull(scene: Scene, columns: Mapping[str, Array]) -> NDArray[np.complex128]:
    """Force of the spring along the arm at its place + i times that across, N, shape (rows,).

    The place is that of the deflection on the base's tangent.
    """
    spring, angle, rows = scene.acting_spring, columns["follower_angle"], columns["time"].size
    assert spring is not None
    place = np.array([spring.place_on(scene.follower.length)])
    bend = turned = np.zeros(rows)
    if {*SHAPE, "tip_deflection"} <= set(columns):
        line = np.array([np.zeros(rows), *(columns[name] for name in SHAPE), columns["tip_deflection"]])
        spline = CubicSpline(np.linspace(0.0, scene.follower.length, TWELFTHS + 1), line)
        bend, turned = spline(place)[0], np.arctan(spline(place, 1)[0])
    along = complex(*spring.anchor) - scene.pivot_distance - np.exp(1j * angle) * (place + 1j * bend)
    return np.asarray(columns["spring_force"] * (along / np.abs(along) * np.exp(-1j * (angle + turned))))


def _base_slope(scene: Scene, columns: Mapping[str, Array]) -> Array | None:
    """Slope of the moment at the base, N, shape (rows,); None where the engine does not give the force of the bearing."""
    if "pivot_force_x" not in columns:
        return None
    across = _across(np.array([columns["pivot_force_x"], columns["pivot_force_y"]]), columns["follower_angle"])
    return across + _damping(scene, columns, power=0)


def _damping(scene: Scene, columns: Mapping[str, Array], power: int) -> Array:
    """Force of the beam's damping on the base across the arm, N, or its moment, N m, with `power` 1; 0 without shapes, (rows,)."""
    follower, time = scene.follower, columns["time"]
    if follower.damping == 0.0 or not {*SHAPE, "tip_deflection"} <= set(columns):
        return np.zeros(time.size)
    deflections = np.array([np.zeros(time.size), *(columns[name] for name in SHAPE), columns["tip_deflection"]])
    x = np.linspace(0.0, follower.length, TWELFTHS + 1)
    rates = CubicSpline(time, deflections.T)(time, 1).T
    simpson = x[1] / 3.0 * np.array([1.0, *[4.0, 2.0] * (TWELFTHS // 2 - 1), 4.0, 1.0])
    return np.asarray(follower.damping * (simpson * x**power) @ rates)


def _across(vector: Array, angle: Array) -> Array:
    """Part of a vector in the fixed frame, shape (2, rows) or (2, 1), along the normal of an angle."""
    return np.asarray(vector[1] * np.cos(angle) - vector[0] * np.sin(angle))


def _tip_slope(scene: Scene, columns: Mapping[str, Array], known: KnownMoments) -> Array:
    """Slope of the moment at the flexible end, N, shape (rows,)."""
    tip, angle = scene.tip_body, _end_angle(scene, columns, known)
    across = columns["tip_acceleration"] - _across(np.array(scene.gravity)[:, None], angle)
    lever, about_end = tip.mass * tip.center_of_mass, tip.inertia + tip.mass * tip.center_of_mass**2
    turning = -(known.twelfths[:, -1] + lever * across) / about_end if about_end > 0.0 else 0.0
    slope = tip.mass * across + lever * turning
    if tip.is_forced:
        force = tip_force(tip, columns["crank_angle"], angle)
        slope -= _across(np.array([force.real, force.imag]), angle)
    if tip.friction_force > 0.0:
        velocity = CubicSpline(columns["time"], np.column_stack([columns["tip_x"], columns["tip_y"]]))(columns["time"], 1)
        rubbing = slide_friction(tip, velocity @ np.array([1.0, 1j]))
        slope -= _across(np.array([rubbing.real, rubbing.imag]), angle)
    return np.asarray(slope)


def _end_angle(scene: Scene, columns: Mapping[str, Array], known: KnownMoments) -> Array:
    """Angle of the centre line in the fixed frame at the flexible end, rad, shape (rows,).

    It is the angle of the base plus the curvature summed by the trapezoidal rule between known places: good to a percent of the sum, and
    only the directions of gravity and of the force on the tip depend on it.
    """
    rows, numbers = known.slider.size, np.arange(TWELFTHS + 1.0)
    slider = np.minimum(known.slider / known.spacing, TWELFTHS)
    places = np.column_stack([np.broadcast_to(numbers, (rows, numbers.size)), slider])
    inner, outer = (np.column_stack([known.twelfths, each]) for each in (known.inboard, known.outboard))
    order = np.argsort(places, axis=1, kind="stable")
    places, inner, outer = (np.take_along_axis(each, order, axis=1) for each in (places, inner, outer))
    steps = known.spacing * np.diff(places) * (outer[:, :-1] + inner[:, 1:]) / (2.0 * scene.follower.bending_stiffness)
    return np.asarray(columns["follower_angle"] + steps.sum(axis=1))


def interpolated(x: Array, known: KnownMoments, parity: int | None = None) -> Array:
    """Moments at arc lengths `x` (m, shape (m,)), N m, shape (rows, m).

    With a `parity`, 0 or 1, they come from the ends and the twelfths with even or odd numbers only.
    """
    numbers = np.arange(TWELFTHS + 1)
    kept = numbers[(numbers % TWELFTHS == 0) | (numbers % 2 == parity) | (parity is None)]
    moments = np.empty((known.slider.size, x.size))
    for rows, inner, outer in _groups(known, kept):
        inboard = np.broadcast_to(x, (rows.size, x.size)) <= known.slider[rows, None]
        for side, nodes in ((inboard, _nodes(known, rows, inner, inner=True)), (~inboard, _nodes(known, rows, outer, inner=False))):
            places = side.any(axis=0)
            if places.any():
                block = np.ix_(rows, places)
                moments[block] = np.where(side[:, places], _polynomials(*nodes, x[places]), moments[block])
    return moments + known.of_spring(np.broadcast_to(x, moments.shape))


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
    nodes = np.array(places).T
    return nodes, np.array(moments).T - known.of_spring(nodes, rows)


def _polynomials(nodes: Array, values: Array, x: Array) -> Array:
    """Values at `x` (shape (m,)) of Newton's polynomials through the nearest of the nodes (shape (rows, n)), shape (rows, m)."""
    count = nodes.shape[1]
    through = min(THROUGH, count)
    cell = (x[None, :, None] > nodes[:, None, :]).sum(axis=2) - 1
    first = np.clip(cell - (through - 2) // 2, 0, count - through)
    windows = np.arange(through)[:, None] + np.arange(count - through + 1)
    near, differences = (np.moveaxis(each[:, windows], 1, 0) for each in (nodes, values))  # (through, rows, windows) each
    with np.errstate(divide="ignore", invalid="ignore"):  # a slider at the very end leaves a side without length, where no `x` lies
        for order in range(1, through):
            differences[order:] = np.diff(differences[order - 1 :], axis=0) / (near[order:] - near[:-order])
        rows = np.arange(len(nodes))[:, None]
        near, differences = near[:, rows, first], differences[:, rows, first]
        interpolant = differences[-1]
        for node, difference in zip(near[-2::-1], differences[-2::-1], strict=True):
            interpolant = interpolant * (x - node) + difference
    return interpolant


def left_out(known: KnownMoments) -> Array:
    """Error of the moment at each twelfth if every other one is left out, N m, shape (rows, 13); 0 at the ends."""
    missed = np.zeros(known.twelfths.shape)
    for parity in (0, 1):
        others = np.arange(1 + parity, TWELFTHS, 2)
        missed[:, others] = np.abs(interpolated(known.spacing * others.astype(float), known, parity) - known.twelfths[:, others])
    return missed


def between(x: Array, missed: Array, known: KnownMoments) -> Array:
    """Interpolation error of the moment at each place, N m, shape (rows, m).

    It is the largest `missed` of the four nearest twelfths, smaller near a known place.
    """
    twelfth = known.spacing
    cell = np.minimum((x / twelfth).astype(int), TWELFTHS - 1)
    near = [np.clip(cell + step, 0, TWELFTHS) for step in (-1, 0, 1, 2)]
    worst = REMAINING_ERROR * np.max([missed[:, numbers] for numbers in near], axis=0)
    distance = np.abs(x - known.slider[:, None])
    for end in (cell, cell + 1):
        used = np.abs(end * twelfth - known.slider[:, None]) > TOO_NEAR * twelfth
        distance = np.where(used, np.minimum(distance, np.abs(x - end * twelfth)), distance)
    return np.asarray(worst * np.minimum(1.0, 2.0 * distance / twelfth))


def is_known(scene: Scene, columns: Mapping[str, Array]) -> bool:
    """Whether an engine gives the normal force."""
    return {name for name in AXIAL if scene.crank is not None or name in ("axial_base", "axial_tip")} <= set(columns)


def axial_forces(scene: Scene, columns: Mapping[str, Array], known: KnownMoments, x: Array) -> tuple[Array, Array]:
    """Normal force at arc lengths `x` (m, shape (m,)), N, and its interpolation error, shape (rows, m) each; zeros where it is not known.

    Args:
        scene: gives the mass of the arm, and gravity.
        columns: of the rows of `known`.
        known: the moments, which give the shear force and how far the tangent turns.
        x: places.
    """
    shape = (known.slider.size, x.size)
    if not is_known(scene, columns):
        return np.zeros(shape), np.zeros(shape)
    follower, angle = scene.follower, columns["follower_angle"]
    weight = follower.mass_per_length * (scene.gravity[0] * np.cos(angle) + scene.gravity[1] * np.sin(angle))[:, None]
    base, tip = columns["axial_base"], columns["axial_tip"]
    step, at = (np.zeros(base.size), 0.0) if known.pull is None else (known.pull.real, known.spring)  # of a spring, inboard of its place
    of_slider = np.where(known.slider < at, step, 0.0)
    begin, slider, end = np.zeros(base.size), np.minimum(known.slider, known.length), np.full(base.size, known.length)

    def span(a: Array, at_a: Array, b: Array, at_b: Array) -> Array:
        a, at_a, b, at_b = (each[:, None] for each in (a, at_a, b, at_b))
        square, change = b**2 - a**2, at_b - at_a + weight * (b - a)
        return at_a - weight * (x - a) + np.divide(change, square, out=np.zeros_like(change), where=square > 0.0) * (x**2 - a**2)

    inboard = span(begin, base - step, slider, columns.get("axial_inboard", tip) - of_slider)
    outboard = span(slider, columns.get("axial_slider", tip) - of_slider, end, tip)
    shear = np.abs(np.diff(known.twelfths, axis=1)).max(axis=1) / known.spacing
    turned = np.abs(known.twelfths).sum(axis=1) * known.spacing / follower.bending_stiffness
    missed = shear * turned
    missed = np.maximum(missed, np.sqrt(np.mean(missed**2)))[:, None]  # the shear force passes through zero
    return np.where(x <= slider[:, None], inboard, outboard) + np.where(x < at, step[:, None], 0.0), np.broadcast_to(missed, shape)
