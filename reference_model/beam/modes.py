"""Shapes that follow the slider: modes of the follower supported at the slider's arc length, as smooth functions of that place.

For each place s the beam has the base block at P (pinned), a support at s, and the tip body at its free end; its natural modes W_i
come from `natural_modes`. The shape is the tangent's angle relative to the base, psi_i = W_i' - W_i'(0) (DERIVATION.md,
equations 2.7 and 2.8). Damping and friction of the base may need one more shape (equation 2.11).
"""

import dataclasses
import itertools
import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.polynomial import chebyshev, legendre

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import compliance_beyond, modes_and_base_shape, supported_modes
from quickreturn.reference_model.rigid import crank_pace, pivot_torque, rigid_motion, static_deflection
from quickreturn.reference_model.slider import Slider


@dataclass(frozen=True)
class ModeFamily:
    """psi_i(x; s) and omega_i^2(s) over a range of s, as Chebyshev series in s of Legendre series in x on both spans.

    Attributes:
        low, high: range of s, m.
        length: L, m.
        squares: Chebyshev coefficients of omega_i^2, rad^2/s^2, shape (terms, n).
        coefficients: Chebyshev coefficients of the Legendre coefficients of psi_i, rad, shape (terms, 2, degree, n).
    """

    low: float
    high: float
    length: float
    squares: Array
    coefficients: Array

    def first(self, count: int) -> "ModeFamily":
        """The family of the first `count` modes alone."""
        return dataclasses.replace(self, squares=self.squares[:, :count], coefficients=self.coefficients[..., :count])

    def squares_at(self, s: Array, derivative: int = 0) -> Array:
        """omega_i^2 (rad^2/s^2) or its derivative by s at support places s (m), shape (k,); returns shape (k, n)."""
        return self._series(self.squares, s, derivative)

    def shapes_at(self, s: Array, u: Array, span: int) -> tuple[Array, Array, Array, Array]:
        """Psi, its first and second derivative by s at fixed x (equation 2.9), and its derivative by x; each of shape (k, p, n).

        Args:
            s: support places, m, shape (k,).
            u: fractions of the span's length at which they are evaluated, 0 to 1, shape (p,).
            span: 0 from the base to the support, 1 from there to the end.
        """
        h = (s if span == 0 else self.length - s)[:, None, None]
        h_by_s = 1.0 if span == 0 else -1.0
        x_by_s = (u if span == 0 else 1.0 - u)[None, :, None]  # at fixed u
        legendre_by_s = [self._series(self.coefficients[:, span], s, order) for order in range(3)]
        degree = self.coefficients.shape[2]
        legendre_by_u = [
            legendre.legvander(2.0 * u - 1.0, degree - 1) @ np.pad(legendre.legder(np.eye(degree), m), ((0, m), (0, 0))) * 2.0**m
            for m in range(3)
        ]

        def field(by_s: int, by_u: int) -> Array:
            return np.asarray(legendre_by_u[by_u] @ legendre_by_s[by_s])

        psi_x = field(0, 1) / h
        psi_s = field(1, 0) - x_by_s * psi_x
        psi_x_by_s = field(1, 1) / h - field(0, 1) * h_by_s / h**2
        psi_s_by_u = field(1, 1) - h_by_s * psi_x - x_by_s * field(0, 2) / h
        psi_ss = field(2, 0) - x_by_s * psi_x_by_s - x_by_s * psi_s_by_u / h
        return field(0, 0), psi_s, psi_ss, psi_x

    def angles(self, s: float, x: Array) -> tuple[Array, Array]:
        """psi_i and its derivative by s, for one support place s (m), at arc lengths x (m), shape (k,); each of shape (k, n)."""
        angle, angle_s = np.empty((2, len(x), self.squares.shape[1]))
        place = np.array([s])
        for span, inside in enumerate((x <= s, x > s)):
            u = x[inside] / s if span == 0 else (x[inside] - s) / (self.length - s)
            psi, psi_s, _, _ = self.shapes_at(place, u, span)
            angle[inside], angle_s[inside] = psi[0], psi_s[0]
        return angle, angle_s

    def series_at(self, s: Array) -> Array:
        """Legendre coefficients of psi, each span mapped to -1 .. 1, at support places s (m), shape (k,); returns (k, 2, degree, n)."""
        return self._series(self.coefficients, s, 0)

    def at_slider(self, s: Array, derivative: int) -> Array:
        """psi_i(s; s) or its derivative along the moving slider, shape (k, n), for slider places s (m), shape (k,).

        It is the first span's series at the span's end, where every Legendre polynomial is 1.
        """
        return self._series(self.coefficients[:, 0].sum(axis=1), s, derivative)

    def _series(self, coefficients: Array, s: Array, derivative: int) -> Array:
        """A Chebyshev series in s (terms, ...), or its derivative of that order by s, at places s (k,); returns (k, ...)."""
        scaled = (2.0 * s - self.low - self.high) / (self.high - self.low)
        series = chebyshev.chebder(coefficients, derivative) * (2.0 / (self.high - self.low)) ** derivative if derivative else coefficients
        return np.tensordot(chebyshev.chebvander(scaled, len(series) - 1), series, axes=1)


def mode_family(mechanism: Mechanism, modes: int, low: float, high: float, terms: int, base_shape: bool = False) -> ModeFamily:
    """The first `modes` modes for low <= s <= high (m), interpolated at `terms` Chebyshev points; the last is a `base_shape` if asked for.

    A mode keeps its sign from one point to the next. The slider has no inertia and a rigid joint, so that the curvature is continuous
    there.
    """
    bare = dataclasses.replace(mechanism, slider=Slider())
    nodes = chebyshev.chebpts1(terms)
    places = 0.5 * (low + high) + 0.5 * (high - low) * nodes
    found = modes_and_base_shape if base_shape else supported_modes
    modes_at_places = [found(bare, float(s), modes) for s in places]
    angles = []
    for modes_at_place in modes_at_places:
        series = np.stack(modes_at_place.slope_series())
        series[:, 0, :] -= (-1.0) ** np.arange(series.shape[1]) @ series[0]  # the slope at P
        angles.append(series)
    for before, after in itertools.pairwise(angles):
        after[:, :, np.einsum("xdn,xdn->n", before, after) < 0.0] *= -1.0
    # discrete orthogonality of the Chebyshev polynomials at these points
    transform = chebyshev.chebvander(nodes, terms - 1).T * (2.0 / terms)
    transform[0] *= 0.5
    squares = transform @ np.array([(2.0 * np.pi * at_place.frequencies) ** 2 for at_place in modes_at_places])
    return ModeFamily(low, high, mechanism.follower.length, squares, np.tensordot(transform, np.array(angles), axes=1))


#: Angle by which the base turns too little without the shape, over the static deflection per length, above which it is used. A machine with
#: 500 times as much has an error of 2e-2 in the deflection with four modes (`engines/LADDERS.md`, section 1).
NEEDED_FROM: Final = 5e-4
#: Number of modes in which this angle is missing: those of the coarsest run of a follower as soft as run 24's.
MODES: Final = 4
ANGLES: Final = 48  # of the crank, in a turn


@lru_cache(maxsize=64)
def needs_base_shape(mechanism: Mechanism) -> bool:
    """Whether the torque of damping and friction in the pivot P bends the follower by more than natural modes describe.

    Their moment at the base is that of the base block's inertia alone. The slower the crank, the more they count beside the forces of
    inertia; so the speed of the start decides, not the one that a torque would reach in the end.
    """
    base, follower = mechanism.base, mechanism.follower
    pace = abs(mechanism.crank.drive.initial_speed) or crank_pace(mechanism)
    if follower.is_rigid or pace == 0.0 or (base.damping == 0.0 and base.friction_torque == 0.0):
        return False
    motion = rigid_motion(mechanism, np.linspace(0.0, 2.0 * math.pi, ANGLES, endpoint=False), pace)
    torque = float(np.sqrt(np.mean(pivot_torque(base, motion.follower_speed) ** 2)))
    farthest = min(float(np.max(motion.slider_position)), (1.0 - 1e-6) * follower.length)
    allowed = NEEDED_FROM * static_deflection(mechanism, pace) / follower.length
    if torque * farthest / (3.0 * follower.bending_stiffness) <= allowed:  # of all modes, without an eigenproblem
        return False
    return torque * compliance_beyond(replace(mechanism, slider=Slider()), farthest, MODES) > allowed
