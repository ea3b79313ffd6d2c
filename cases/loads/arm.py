"""The bending moment along the whole arm, from the columns of a trajectory, and how far the places between leave it open.

An engine gives the moment at the interior twelfths of the length and at the slider. At the ends it follows from the bodies there:

    base   M(0) = J_b q2'' + c_b q2'                                           (DERIVATION.md, equation 9.11 at x = 0)
    tip    M(L) = -J theta'' - m e (a + e theta'' - g_n),  theta = q2 + integral of M / EI over the arm

with a the acceleration of the flexible end along its normal and e the centre of mass of the tip body beyond it. On either side of the
slider the moment is smooth; its slope jumps there by the slider's force, and the moment itself where the slider has rotary inertia. Each
side is interpolated apart, by polynomials through the nearest known places. What they may miss is seen where every other twelfth is
left out.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from reference_model.columns import MOMENTS, PLACES
from reference_model.mechanism import FollowerAlone, Scene

Array = NDArray[np.float64]

#: Known places that the interpolating polynomial goes through, where a side has as many.
THROUGH: Final = 6
#: Places at which the moment is evaluated in each twelfth of the length.
IN_A_TWELFTH: Final = 20
#: Twelfths that are nearer to the slider than this part of a twelfth are left out: the slope between two such places would be noise.
TOO_NEAR: Final = 1.0 / 3.0
#: Of what the interpolation misses without every other twelfth, what it may miss with all of them. At half the spacing a polynomial
#: of degree one misses a quarter; those of higher degree miss less (measured in `tests/cases/test_loads_arm.py`).
REST: Final = 0.25


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


def moments_along_arm(scene: Scene, columns: Mapping[str, Array]) -> ArmMoments:
    """The moment along the arm.

    Args:
        scene: gives the bodies at the ends.
        columns: those of a trajectory or of a cycle, each of shape (rows,), the moments among them.

    Raises:
        KeyError: the engine does not give the moments.
    """
    length = scene.follower.length
    places = np.linspace(0.0, length, (PLACES + 1) * IN_A_TWELFTH + 1)
    base, base_open = _at_base(scene, columns)
    rows = base.size
    known = np.column_stack([base, *(columns[name] for name in MOMENTS), np.zeros(rows)])
    slider = columns["slider_position"] if "moment_slider" in columns else np.full(rows, np.inf)
    inboard = outboard = columns.get("moment_slider", np.zeros(rows))
    inertia = 0.0 if isinstance(scene, FollowerAlone) else scene.slider.inertia
    if inertia > 0.0:  # theta at the slider needs the moment inboard of it: once more with the jump that follows
        slopes = _slopes(scene, columns, places, _interpolated(places, known, slider, inboard, outboard, length))
        turned = np.array([np.interp(s, places, row) for s, row in zip(slider, slopes, strict=True)])
        inboard = outboard - inertia * _second_derivative(columns["time"], turned)[0]
    tip_open = np.zeros(rows)
    if scene.tip_body.inertia > 0.0 or scene.tip_body.center_of_mass != 0.0:
        slopes = _slopes(scene, columns, places, _interpolated(places, known, slider, inboard, outboard, length))
        known[:, -1], tip_open = _at_tip(scene, columns, slopes[:, -1])
    moments = _interpolated(places, known, slider, inboard, outboard, length)
    missed = _left_out(known, slider, inboard, outboard, length)
    missed[:, 0], missed[:, -1] = base_open / REST, tip_open / REST
    larger = np.where(np.abs(inboard) > np.abs(outboard), inboard, outboard)
    return ArmMoments(places, moments, REST * _between(places, missed, slider, length), larger if "moment_slider" in columns else None)


def _at_base(scene: Scene, columns: Mapping[str, Array]) -> tuple[Array, Array]:
    """Moment at the base, N m, and how far off the rows leave it; shape (rows,) each."""
    base, time, angle = scene.base, columns["time"], columns["follower_angle"]
    turn = 0.0 if "base_torque" not in columns else columns["base_torque"]
    if base.inertia == base.damping == 0.0:
        return np.zeros(time.size) - turn, np.zeros(time.size)
    acceleration, off = _second_derivative(time, angle)
    return base.inertia * acceleration + base.damping * CubicSpline(time, angle)(time, 1) - turn, base.inertia * off


def _at_tip(scene: Scene, columns: Mapping[str, Array], slope: Array) -> tuple[Array, Array]:
    """Moment at the flexible end, N m, and how far off the rows leave it; `slope` is the end's angle, rad; shape (rows,) each."""
    tip, (g1, g2) = scene.tip_body, scene.gravity
    acceleration, off = _second_derivative(columns["time"], slope)
    weight = g2 * np.cos(slope) - g1 * np.sin(slope)
    static = tip.mass * tip.center_of_mass * (columns["tip_acceleration"] - weight)
    about_end = tip.inertia + tip.mass * tip.center_of_mass**2
    return -about_end * acceleration - static, about_end * off


def _slopes(scene: Scene, columns: Mapping[str, Array], places: Array, moments: Array) -> Array:
    """Angle of the centre line at each place in the fixed frame, rad, shape (rows, places)."""
    steps = 0.5 * np.diff(places) * (moments[:, 1:] + moments[:, :-1]) / scene.follower.bending_stiffness
    return columns["follower_angle"][:, None] + np.cumsum(np.pad(steps, ((0, 0), (1, 0))), axis=1)


def _second_derivative(time: Array, values: Array) -> tuple[Array, Array]:
    """That of the cubic spline through a signal, and by how much that through every other sample differs from it."""
    found = CubicSpline(time, values)(time, 2)
    fewer = np.append(np.arange(0, time.size - 1, 2), time.size - 1)
    return found, np.abs(CubicSpline(time[fewer], values[fewer])(time, 2) - found)


def _interpolated(x: Array, known: Array, slider: Array, inboard: Array, outboard: Array, length: float, every: int = 1) -> Array:
    """Moments at `x` (m, shape (m,)), shape (rows, m).

    Args:
        x: arc lengths.
        known: moments at twelfths of the length from the base to the tip, shape (rows, 13).
        slider: its arc length, m, infinite where there is none, shape (rows,).
        inboard: moment on the slider's inner side, likewise.
        outboard: on its outer side.
        length: of the arm, m.
        every: 1 for all twelfths; 2 for those of an even number, -2 for the ends and those of an odd number.
    """
    twelfths = np.linspace(0.0, length, known.shape[1])
    numbers = np.arange(twelfths.size)
    kept = numbers[(numbers % 2 == 0) | (every == 1)] if every > 0 else numbers[(numbers % 2 == 1) | (numbers % 12 == 0)]
    found = np.empty((slider.size, x.size))
    for rows, inner, outer in _groups(slider, twelfths, kept):
        s, at = slider[rows, None], known[rows]
        ahead = np.broadcast_to(x, (rows.size, x.size)) <= s
        for side, numbers_of_side, here in ((-1, inner, inboard[rows, None]), (1, outer, outboard[rows, None])):
            wanted = ahead if side < 0 else ~ahead
            some = wanted.any(axis=0)
            if not some.any():
                continue
            nodes, values = np.broadcast_to(twelfths[numbers_of_side], (rows.size, numbers_of_side.size)), at[:, numbers_of_side]
            if np.isfinite(s).all():
                parts = ((nodes, s), (values, here)) if side < 0 else ((s, nodes), (here, values))
                nodes, values = (np.hstack(part) for part in parts)
            block = found[np.ix_(rows, some)]
            found[np.ix_(rows, some)] = np.where(wanted[:, some], _polynomials(nodes, values, x[some]), block)
    return found


def _groups(slider: Array, twelfths: Array, kept: NDArray[np.intp]) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]]:
    """Rows whose slider lies between the same twelfths, with the numbers of those on either side of it that are not too near."""
    near = TOO_NEAR * twelfths[1]
    inner = np.searchsorted(twelfths[kept], np.where(np.isfinite(slider), slider - near, np.inf))
    outer = np.searchsorted(twelfths[kept], slider + near, side="right")
    inner, outer = np.maximum(inner, 1), np.where(np.isfinite(slider), np.minimum(outer, kept.size - 1), kept.size)  # the ends stay
    for a, b in sorted(set(zip(inner.tolist(), outer.tolist(), strict=True))):
        yield np.flatnonzero((inner == a) & (outer == b)), kept[:a], kept[b:]


def _polynomials(nodes: Array, values: Array, x: Array) -> Array:
    """At `x` (shape (m,)) the polynomials through the nearest of some nodes (shape (rows, n)), in Lagrange's form; shape (rows, m)."""
    count = nodes.shape[1]
    through = min(THROUGH, count)
    cell = (x[None, :, None] > nodes[:, None, :]).sum(axis=2) - 1
    first = np.clip(cell - (through - 2) // 2, 0, count - through)
    index = first[..., None] + np.arange(through)
    near, its = (np.take_along_axis(each[:, None, :], index, axis=2) for each in (nodes, values))
    found = np.zeros(first.shape)
    for j in range(through):
        weight = np.ones(first.shape)
        for k in range(through):
            if k != j:
                weight *= (x - near[..., k]) / (near[..., j] - near[..., k])
        found += weight * its[..., j]
    return found


def _left_out(known: Array, slider: Array, inboard: Array, outboard: Array, length: float) -> Array:
    """By how much the moment at each twelfth is missed where every other one is left out, N m, shape (rows, 13); 0 at the ends."""
    twelfths, missed = np.linspace(0.0, length, known.shape[1]), np.zeros(known.shape)
    for every, between in ((2, np.arange(1, 12, 2)), (-2, np.arange(2, 12, 2))):
        found = _interpolated(twelfths[between], known, slider, inboard, outboard, length, every)
        missed[:, between] = np.abs(found - known[:, between])
    return missed


def _between(x: Array, missed: Array, slider: Array, length: float) -> Array:
    """The larger of what is missed at the two twelfths beside each place, less the nearer a known place is; shape (rows, m)."""
    twelfth = length / (missed.shape[1] - 1)
    cell = np.minimum((x / twelfth).astype(int), missed.shape[1] - 2)
    worst = np.maximum(missed[:, cell], missed[:, cell + 1])
    ends = cell * twelfth, (cell + 1) * twelfth
    nearest = np.minimum(np.minimum(x - ends[0], ends[1] - x), np.abs(x - slider[:, None]))
    bodies = np.where(cell == 0, missed[:, [0]] * (1.0 - x / twelfth), 0.0) + np.where(
        cell == missed.shape[1] - 2, missed[:, [-1]] * (x - ends[0]) / twelfth, 0.0
    )
    return np.maximum(worst * np.minimum(1.0, 2.0 * nearest / twelfth), bodies)
