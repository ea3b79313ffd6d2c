"""Natural modes of the follower with the crank held still: converged, undamped, about the straight follower at rest.

The follower turns about P with the base block, is held by the slider at arc length s and carries the tip body at its free end. With the
deflection w(x) sin(omega t), the largest strain energy U equals the largest kinetic energy omega^2 T in every mode,

    2 U = EI int w''^2 dx + k w(s)^2 (+ k_s w(x_s)^2 with a spring at x_s)                    stiffness matrix K
    2 T = rhoA int w^2 dx + Jb w'(0)^2 + Js w'(s)^2 + m (w(L) + e w'(L))^2 + J w'(L)^2       mass matrix M

and the modes are the stationary points of U / T (equation 2.7): K v = omega^2 M v. A rigid joint holds w(s) = 0 in place of k.
Each of the spans P to slider and slider to tip, divided where a spring holds the follower, is one element: the four cubic Hermite shapes
plus polynomials whose second derivatives are Legendre polynomials of degree 2 and up (Szabo and Babuska, "Finite Element Analysis", 1991,
section 5.2, integrated once more). The value and the slope of such a polynomial vanish at both ends. These shapes leave the stiffness
matrix diagonal and converge exponentially; the kink of the bending moment at the slider lies between elements.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array, eigh
from quickreturn.reference_model.mechanism import Crank, FollowerAlone, Mechanism, PrescribedSpeed, Scene
from quickreturn.reference_model.rigid import crank_pace, stiffness_across
from quickreturn.reference_model.tip import Tip

#: Number of crank angles at which the lowest natural frequency is computed: in half a turn, which the other half mirrors.
RATIO_ANGLES: Final = 9
#: Shapes per span beyond the number of modes: the relative error in the frequency of the last mode is then 1e-10.
SPARE_SHAPES: Final = 8


@dataclass(frozen=True)
class BeamModes:
    """Mass-normalised modes of the follower, in ascending order, tip displacement positive.

    Attributes:
        frequencies: Hz, shape (count,).
        length: m, L.
        spans: arc lengths of the ends of the elements, m, ((0, s), (s, L)), or ((0, L),) where no slider supports it in between.
        coefficients: per span, the weights of its shapes in each mode, shape (shapes, count).
    """

    frequencies: Array
    length: float
    spans: tuple[tuple[float, float], ...]
    coefficients: tuple[Array, ...]

    def __len__(self) -> int:
        return len(self.frequencies)

    def deflection(self, arc_lengths: Array, derivative: int = 0) -> Array:
        """Deflection of each mode, or a derivative of it with respect to arc length.

        Args:
            arc_lengths: m, from P, shape (n,), within 0 .. L.
            derivative: 0 deflection, 1 slope, 2 curvature (continuous at the slider).

        Returns:
            Shape (count, n), kg^(-1/2) m^(-derivative).
        """
        return deflections((self,), arc_lengths, derivative)[0]

    def first_moments(self) -> Array:
        """Integral of each mode's deflection times x over the length, shape (count,), kg^(-1/2) m^2."""
        moments = np.zeros(len(self))
        for (start, end), weights in zip(self.spans, self.coefficients, strict=True):
            interior, h = len(weights) - 4, end - start
            # of Legendre's polynomials all but the first two are orthogonal to x
            of_shapes = _legendre_series(interior, 0)[:, :2] @ np.array([start + end, h / 3.0])
            moments += 0.5 * h * (_slope_scaling(interior, h) * of_shapes) @ weights
        return moments

    def slope_series(self) -> tuple[Array, ...]:
        """Slope of each mode as a Legendre series over each span mapped to -1..1; shape (degree + 1, count) per span."""
        series = []
        for (start, end), weights in zip(self.spans, self.coefficients, strict=True):
            interior, h = len(weights) - 4, end - start
            series.append(_legendre_series(interior, 1).T @ (_slope_scaling(interior, h)[:, None] * weights) * (2.0 / h))
        return tuple(series)

    def curvature(self, arc_lengths: Array) -> Array:
        """Curvature of each mode at the arc lengths (m, shape (n,)), shape (count, n), kg^(-1/2) m^(-2)."""
        return self.deflection(arc_lengths, 2)

    @property
    def tip_displacement(self) -> Array:
        """Deflection of each mode at the flexible end x = L, shape (count,), kg^(-1/2): the weights of the one shape that moves it."""
        return self.coefficients[-1][2]


@dataclass(frozen=True)
class FrozenModes(BeamModes):
    """Modes at one place of the slider.

    Attributes:
        slider_position: m, s.
    """

    slider_position: float


def deflections(modes: Sequence[BeamModes], arc_lengths: Array, derivative: int = 0) -> Array:
    """`BeamModes.deflection` of several sets of as many modes each, at the same or at different arc lengths.

    Args:
        modes: the sets.
        arc_lengths: m, shape (n,) or (sets, n).
        derivative: as there.

    Returns:
        Shape (sets, count, n).
    """
    spans = max(len(each.spans) for each in modes)
    edges = np.full((len(modes), spans + 1), math.inf)
    shapes, count = modes[0].coefficients[0].shape
    coefficients = np.zeros((len(modes), spans, shapes, count))
    for number, each in enumerate(modes):
        edges[number, : len(each.spans)], edges[number, len(each.spans)] = [start for start, _ in each.spans], each.length
        coefficients[number, : len(each.spans)] = each.coefficients
    x = np.broadcast_to(np.asarray(arc_lengths, dtype=float), (len(modes), np.shape(arc_lengths)[-1]))
    last = np.array([len(each.spans) - 1 for each in modes])[:, None]
    span_of = np.minimum(np.sum(x[:, :, None] >= edges[:, None, 1:], axis=2), last)
    start, end = (np.take_along_axis(edges, span_of + further, axis=1) for further in (0, 1))
    values = _shapes(x, start, end, shapes - 4, derivative)
    return np.asarray(np.einsum("ajs,ajsc->acj", values, coefficients[np.arange(len(modes))[:, None], span_of]))


def clamped_modes(scene: FollowerAlone, count: int) -> BeamModes:
    """The `count` lowest natural modes of the follower clamped at its base (equation 11.2), which does not turn, with its tip body."""
    held = held_follower(scene, scene.follower.length, count + SPARE_SHAPES)
    frequencies, full = held.lowest(count)
    return BeamModes(frequencies, scene.follower.length, held.spans, held.by_span(full))


def frozen_crank_modes(mechanism: Mechanism, crank_angle: float, count: int) -> FrozenModes:
    """Natural modes with the crank held at `crank_angle` (rad); the slider is at the rigid mechanism's s = |PC|.

    Returns:
        `count` modes, none where the follower is rigid.

    Raises:
        ValueError: a joint without stiffness, which leaves the follower free to turn.
    """
    position = abs(mechanism.crank.length * np.exp(1j * crank_angle) - mechanism.pivot_distance)
    return supported_modes(mechanism, min(position, mechanism.follower.length), count, stiffness_across(mechanism, crank_angle))


def turn_angles(mechanism: Mechanism, count: int) -> Array:
    """Evenly spaced crank angles, rad, whose modes say those of a whole turn.

    Returns:
        `count` angles from 0 to pi, which the other half of the turn mirrors; twice as many less one, to 2 pi, where a spring acts from a
        point off the line through O and P.
    """
    spring = mechanism.acting_spring
    mirrored = spring is None or spring.anchor[1] == 0.0
    return np.linspace(0.0, math.pi, count) if mirrored else np.linspace(0.0, 2.0 * math.pi, 2 * count - 1)


def stiffness_ratio(scene: Scene) -> float:
    """Lowest natural frequency with the crank held at any angle, over the crank's speed (`rigid.crank_pace`).

    Without the spring, whose force bends the follower however stiff the two are together. It is 0 where the scene has no crank, the crank
    stands still, or the follower is rigid or free to turn.
    """
    if scene.crank is None or scene.follower.is_rigid or (pace := crank_pace(scene)) == 0.0 or scene.slider.closed_stiffness == 0.0:
        return 0.0
    at_rest = Crank(length=scene.crank.length, drive=PrescribedSpeed(speed=0.0))
    return 2.0 * math.pi * _lowest_frequency(replace(scene, crank=at_rest, spring=None)) / pace


@lru_cache(maxsize=64)
def _lowest_frequency(mechanism: Mechanism) -> float:
    """Lowest natural frequency with the crank held at any angle, Hz."""
    return min(float(frozen_crank_modes(mechanism, angle, 1).frequencies[0]) for angle in np.linspace(0.0, math.pi, RATIO_ANGLES))


def supported_modes(mechanism: Mechanism, slider_position: float, count: int, spring: float = 0.0) -> FrozenModes:
    """Natural modes of the mechanism's follower supported at arc length `slider_position` (m, above 0, at most L).

    The joint's own stiffness holds the follower there (rigid unless the scene says otherwise); the slider's inertia turns with
    the tangent, its mass rests with the crank. `spring` is the stiffness across the follower at the spring's place, N/m.

    Returns:
        `count` modes, none where the follower is rigid.

    Raises:
        ValueError: the slider is not on the follower, or a joint without stiffness, which leaves the follower free to turn.
    """
    length, stiffness = mechanism.follower.length, mechanism.slider.closed_stiffness
    if not 0.0 < slider_position <= length:
        raise ValueError(f"slider_position {slider_position:.6g} m is not on the follower (0 to {length:.6g} m)")
    if not stiffness > 0.0:
        raise ValueError(f"slider.joint_stiffness {stiffness:.6g} N/m leaves the follower free to turn: it has no natural modes")
    if mechanism.follower.is_rigid:
        shapes, spans = 4, _spans(slider_position, length)
        return FrozenModes(np.empty(0), length, spans, tuple(np.empty((shapes, 0)) for _ in spans), slider_position)
    held = held_follower(mechanism, slider_position, count + SPARE_SHAPES, spring)
    frequencies, full = held.lowest(count)
    return FrozenModes(frequencies, length, held.spans, held.by_span(full), slider_position)


def modes_and_base_shape(mechanism: Mechanism, slider_position: float, count: int) -> FrozenModes:
    """The `count` - 1 lowest of `supported_modes` of a flexible follower, and a shape for a moment at the base (equation 2.11).

    That shape is mass-normalised, too, and last; its frequency is Rayleigh's quotient, above that of the modes.

    Args:
        mechanism: the scene; its slider has a rigid joint and no inertia.
        slider_position: m, above 0, less than L.
        count: at least 2.
    """
    s, length, stiffness = slider_position, mechanism.follower.length, mechanism.follower.bending_stiffness
    held = held_follower(mechanism, s, count + SPARE_SHAPES)
    M, K = held.M, held.K
    frequencies, modes = held.lowest(count - 1)
    shape = np.zeros(len(M))
    # slopes at P and slider, deflection and slope at the end; the cubic in between has no interior shapes
    shape[[1, 3, 4, 5]] = np.array([2.0, -1.0, s - length, -1.0]) * s / (6.0 * stiffness)
    shape -= modes @ (modes[1] / (2.0 * np.pi * frequencies) ** 2)
    shape /= math.sqrt(shape @ M @ shape)
    frequencies = np.append(frequencies, math.sqrt(shape @ K @ shape) / (2.0 * np.pi))
    full = np.column_stack([modes, shape])
    return FrozenModes(frequencies, length, held.spans, held.by_span(full), s)


def compliance_beyond(mechanism: Mechanism, slider_position: float, count: int) -> float:
    """Angle of the base per static moment there (rad/(N m)) that the `count` lowest of `supported_modes` leave out."""
    modes = supported_modes(mechanism, slider_position, count)
    slopes = modes.deflection(np.zeros(1), 1)[:, 0]
    modal = float(np.sum((slopes / (2.0 * np.pi * modes.frequencies)) ** 2))
    return slider_position / (3.0 * mechanism.follower.bending_stiffness) - modal


@dataclass(frozen=True)
class HeldFollower:
    """The follower with its bodies and supports, in the shapes of its spans.

    Attributes:
        M: mass matrix, shape (size, size).
        K: stiffness matrix, likewise.
        spans: see `BeamModes`.
        numbering: per span, the numbers of its shapes. Deflection (m) and slope at P come first, then those at the other ends of spans.
        fixed: numbers of the coordinates that the supports hold at zero.
    """

    M: Array
    K: Array
    spans: tuple[tuple[float, float], ...]
    numbering: tuple[NDArray[np.intp], ...]
    fixed: list[int]

    @property
    def free(self) -> NDArray[np.intp]:
        """Numbers of the coordinates that the supports leave free."""
        return np.delete(np.arange(len(self.M)), self.fixed)

    def by_span(self, vectors: Array) -> tuple[Array, ...]:
        """The `coefficients` of `BeamModes` for vectors of shape (size, count)."""
        return tuple(vectors[numbers] for numbers in self.numbering)

    def lowest(self, count: int) -> tuple[Array, Array]:
        """Frequencies (Hz), shape (count,), and mass-normalised vectors, shape (size, count), of the `count` lowest modes.

        The deflection at the flexible end is positive in every mode.
        """
        free, tip = self.free, self.numbering[-1][2]
        both = free[:, None], free
        # M v = v / omega^2 K v, not the other way round: round-off is relative to the largest eigenvalue, so the lowest modes stay
        # exact however short and stiff a span is
        inverse_squares, vectors = eigh(self.M[both], self.K[both])
        inverse_squares, vectors = inverse_squares[::-1][:count], vectors[:, ::-1][:, :count] / np.sqrt(inverse_squares[::-1][:count])
        full = np.zeros((len(self.M), count))
        full[free] = vectors
        full *= np.where(full[tip] < 0.0, -1.0, 1.0)
        return 1.0 / np.sqrt(inverse_squares) / (2.0 * np.pi), full


def held_follower(scene: Scene, slider_position: float, interior: int, spring: float = 0.0) -> HeldFollower:
    """The matrices of a flexible follower, `interior` polynomials to a span; a follower alone is clamped at its base.

    `slider_position`, `spring`: see `supported_modes`.
    """
    follower, slider = scene.follower, scene.slider
    place = scene.spring.place_on(follower.length) if scene.spring is not None and spring > 0.0 else follower.length
    spans = _spans(slider_position, follower.length, place)
    numbering = _numbering(len(spans), interior)
    size = 1 + max(int(numbers.max()) for numbers in numbering)
    M, K = np.zeros((size, size)), np.zeros((size, size))
    for span, numbers in zip(spans, numbering, strict=True):
        mass, bending = _element(span, interior)
        block = numbers[:, None], numbers
        M[block] += follower.mass_per_length * mass
        K[block] += follower.bending_stiffness * bending
    slope_at_base, deflection_at_slider = 1, 2 * _node_at(spans, slider_position)
    slope_at_slider = deflection_at_slider + 1
    M[slope_at_base, slope_at_base] += scene.base.inertia
    M[slope_at_slider, slope_at_slider] += slider.inertia
    _add_tip(M, scene.tip, numbering)
    fixed = [0, slope_at_base if scene.crank is None else deflection_at_slider]
    if math.isfinite(slider.closed_stiffness):
        K[deflection_at_slider, deflection_at_slider] += slider.closed_stiffness
        fixed = [0]
    if spring > 0.0:
        at = 2 * _node_at(spans, place)
        K[at, at] += spring
    return HeldFollower(M, K, spans, numbering, fixed)


def _spans(position: float, length: float, spring: float = math.inf) -> tuple[tuple[float, float], ...]:
    """Arc lengths (m) of the ends of each span, from those of slider and spring."""
    nodes = [0.0]
    for place in sorted((position, spring)):
        if nodes[-1] + 1e-9 * length < place < (1.0 - 1e-9) * length:  # not a span of round-off
            nodes.append(place)
    return tuple(pairwise((*nodes, length)))


def _node_at(spans: tuple[tuple[float, float], ...], place: float) -> int:
    """Number of the span's end, counted from P, that is at a place (m)."""
    return int(np.argmin([abs(node - place) for node in (0.0, *(end for _, end in spans))]))


@cache
def _numbering(spans: int, interior: int) -> tuple[NDArray[np.intp], ...]:
    """Global numbers of each span's shapes: deflection and slope at P, slider and tip come first, interior shapes follow."""
    nodes = 2 * (spans + 1)
    return tuple(
        np.r_[2 * span : 2 * span + 4, nodes + span * interior : nodes + (span + 1) * interior].astype(np.intp) for span in range(spans)
    )


def _add_tip(M: Array, tip: Tip | None, numbering: tuple[NDArray[np.intp], ...]) -> None:
    """Add the tip body to the mass matrix in place."""
    if tip is not None:
        m, J, offset = tip.mass, tip.inertia, tip.center_of_mass
        end = numbering[-1][2:4]
        # kinetic energy m/2 (w' + offset theta')^2 + J/2 theta'^2
        M[end[:, None], end] += np.array([[m, m * offset], [m * offset, J + m * offset**2]])


def _element(span: tuple[float, float], interior: int) -> tuple[Array, Array]:
    """Mass matrix for unit mass per length and stiffness matrix for unit bending stiffness of one span."""
    h = span[1] - span[0]
    scaling = _slope_scaling(interior, h)
    scale = np.outer(scaling, scaling)
    return _reference_matrix(interior, 0) * scale * (h / 2.0), _reference_matrix(interior, 2) * scale * (2.0 / h) ** 3


@cache
def _reference_matrix(interior: int, derivative: int) -> Array:
    """Integrals over [-1, 1] of the products of the shapes' derivatives of this order, shape (4 + interior, 4 + interior)."""
    points, weights = legendre.leggauss(interior + 4)  # exact for products of shapes of degree interior + 3
    shapes = legendre.legval(points, _legendre_series(interior, derivative).T)
    return np.asarray((shapes * weights) @ shapes.T, dtype=np.float64)


@cache
def _legendre_series(interior: int, derivative: int) -> Array:
    """Legendre coefficients on [-1, 1] of the shapes' derivatives of this order, one row per shape."""
    series = np.zeros((4 + interior, interior + 4))
    # cubic Hermite shapes (2 -+ 3 xi +- xi^3)/4 and (+-1 - xi -+ xi^2 + xi^3)/4 in Legendre polynomials
    series[0, :4] = 1 / 2, -3 / 5, 0, 1 / 10
    series[1, :4] = 1 / 6, -1 / 10, -1 / 6, 1 / 10
    series[2, :4] = 1 / 2, 3 / 5, 0, -1 / 10
    series[3, :4] = -1 / 6, -1 / 10, 1 / 6, 1 / 10
    for degree in range(2, interior + 2):
        twice_integrated = legendre.legint(np.eye(degree + 1)[degree], 2, lbnd=-1)
        series[degree + 2, : degree + 3] = twice_integrated * math.sqrt(degree + 0.5)
    return np.asarray(legendre.legder(series, derivative, axis=1) if derivative else series, dtype=np.float64)


def _slope_scaling(interior: int, h: float | Array) -> Array:
    """Factors that make the slope shapes have unit slope on elements of length h (m, shape (...)), shape (..., 4 + interior)."""
    scale = np.ones((*np.shape(h), 4 + interior))
    scale[..., [1, 3]] = np.asarray(h)[..., None] / 2.0
    return scale


def _shapes(x: Array, start: Array, end: Array, interior: int, derivative: int) -> Array:
    """The shapes at arc lengths x (m) of spans from `start` to `end` (m), all of shape (...), or a derivative, (..., 4 + interior)."""
    h = end - start
    series = _legendre_series(interior, derivative)
    values = legendre.legvander((2.0 * x - start - end) / h, series.shape[1] - 1) @ series.T
    return _slope_scaling(interior, h) * values * ((2.0 / h) ** derivative)[..., None]
