"""Shapes that follow the slider: modes of the follower supported at the slider's arc length, as smooth functions of that place.

For each place s the beam has the base block at P (pinned), a support at s, and the tip body at its free end. Its natural modes W are
computed by Galerkin's method with polynomials on the two spans (cubic Hermite functions and twice-integrated Legendre polynomials,
so that the stiffness matrix is diagonal but for four rows). The shape is the tangent's angle relative to the base,
psi_i = W_i' - W_i'(0) (DERIVATION.md, equation 10.2); mode and frequency are exact to rounding for the few modes kept.
"""

import itertools
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.polynomial import chebyshev, legendre
from numpy.typing import NDArray
from scipy.linalg import eigh

from reference_model.mechanism import Mechanism, Tip

Array = NDArray[np.float64]

#: Degree of the polynomials on a span besides two per mode kept.
SPARE_DEGREE: Final = 12


@dataclass(frozen=True)
class SupportedModes:
    """Modes for a support at s.

    Attributes:
        squares: omega_i^2, rad^2/s^2, shape (n,).
        coefficients: Legendre coefficients of psi_i on both spans, each mapped to -1..1, shape (2, degree, n), mass-normalised.
    """

    squares: Array
    coefficients: Array


class SupportedBeam:
    """Galerkin matrices of the follower as functions of the support's place."""

    def __init__(self, mechanism: Mechanism, modes: int) -> None:
        beam, tip = mechanism.follower, mechanism.tip or Tip(mass=0.0, inertia=0.0)
        self._beam, self._tip, self._base = beam, tip, mechanism.base.inertia
        self._modes = modes
        degree = SPARE_DEGREE + 2 * modes
        # local basis on -1..1 by Legendre coefficients: Hermite cubics (value and slope at both ends), then bubbles
        hermite = np.zeros((4, degree + 1))
        for row, powers in enumerate(
            ([0.5, -0.75, 0, 0.25], [0.25, -0.25, -0.25, 0.25], [0.5, 0.75, 0, -0.25], [-0.25, -0.25, 0.25, 0.25])
        ):
            hermite[row, :4] = legendre.poly2leg(powers)
        bubbles = np.zeros((degree - 3, degree + 1))
        for k in range(2, degree - 1):
            unit = np.zeros(k + 1)
            unit[k] = np.sqrt(k + 0.5)
            integral = legendre.legint(unit, 2, lbnd=-1)
            bubbles[k - 2, : len(integral)] = integral
        self._basis = np.vstack([hermite, bubbles])
        norms = 2.0 / (2.0 * np.arange(degree + 1) + 1.0)
        second = np.array([np.pad(legendre.legder(row, 2), (0, 2)) for row in self._basis])
        self._mass = (self._basis * norms) @ self._basis.T
        self._stiffness = (second * norms) @ second.T
        self._slopes = np.array([legendre.legder(row) for row in self._basis])
        self._count = degree - 3

    def modes(self, s: float) -> SupportedModes:
        """The lowest modes with the support at s (m, strictly between 0 and L); their signs are arbitrary."""
        beam, tip, n, b = self._beam, self._tip, self._modes, self._count
        size = 4 + 2 * b
        K, M = np.zeros((size, size)), np.zeros((size, size))
        maps, spans = [], (s, beam.length - s)
        for span, h in enumerate(spans):
            # global: slope at 0, slope at s, deflection at L, slope at L, bubbles of both spans
            T = np.zeros((4 + b, size))
            if span == 0:
                T[1, 0] = T[3, 1] = 0.5 * h
            else:
                T[1, 1], T[2, 2], T[3, 3] = 0.5 * h, 1.0, 0.5 * h
            first = 4 + span * b
            T[4:, first : first + b] = np.eye(b)
            K += T.T @ ((2.0 / h) ** 3 * beam.bending_stiffness * self._stiffness) @ T
            M += T.T @ (0.5 * h * beam.mass_per_length * self._mass) @ T
            maps.append(T)
        M[0, 0] += self._base
        end = np.zeros(size)
        end[2], end[3] = 1.0, tip.center_of_mass
        M += tip.mass * np.outer(end, end)
        M[3, 3] += tip.inertia
        # M v = K v / omega^2: the wanted eigenvalues are then the largest, which rounding hurts least
        scale = 1.0 / np.sqrt(np.diag(K))
        inverse_squares, vectors = eigh(M * np.outer(scale, scale), K * np.outer(scale, scale), subset_by_index=(size - n, size - 1))
        squares = 1.0 / inverse_squares[::-1]
        vectors = scale[:, None] * vectors[:, ::-1] * np.sqrt(squares)  # K-normalised to mass-normalised
        coefficients = np.stack([(2.0 / h) * self._slopes.T @ T @ vectors for T, h in zip(maps, spans, strict=True)])
        coefficients[:, 0, :] -= vectors[0]
        return SupportedModes(squares, coefficients)


@dataclass(frozen=True)
class ModeFamily:
    """psi_i(x; s) and omega_i^2(s) over a range of s, as Chebyshev series in s of Legendre series in x on both spans.

    Attributes:
        low, high: range of s, m.
        length: L, m.
        squares: Chebyshev coefficients of omega_i^2, shape (terms, n).
        coefficients: Chebyshev coefficients of the Legendre coefficients, shape (terms, 2, degree, n).
    """

    low: float
    high: float
    length: float
    squares: Array
    coefficients: Array

    def squares_at(self, s: Array, derivative: int = 0) -> Array:
        """omega_i^2 or its derivative by s at places s (k,), shape (k, n)."""
        return self._series(self.squares, s, derivative)

    def shapes_at(self, s: Array, u: Array, span: int) -> tuple[Array, Array, Array, Array]:
        """psi, its derivatives by s (once and twice, at fixed x) and by x, at the fractions u (p,) of a span; each (k, p, n).

        Args:
            s: support places, m, shape (k,).
            u: fractions of the span's length, 0 to 1.
            span: 0 from the base to the support, 1 from there to the end.
        """
        h = (s if span == 0 else self.length - s)[:, None, None]
        slope_of_h = 1.0 if span == 0 else -1.0
        a = (u if span == 0 else 1.0 - u)[None, :, None]  # derivative of x by s at fixed u
        legendre_of = [self._series(self.coefficients[:, span], s, order) for order in range(3)]
        vander = [
            legendre.legvander(2.0 * u - 1.0, self.coefficients.shape[2] - 1) @ _derivative_matrix(self.coefficients.shape[2], m) * 2.0**m
            for m in range(3)
        ]

        def field(by_s: int, by_u: int) -> Array:
            return np.einsum("pd,kdn->kpn", vander[by_u], legendre_of[by_s])

        psi_x = field(0, 1) / h
        psi_s = field(1, 0) - a * psi_x
        psi_x_by_s = field(1, 1) / h - field(0, 1) * slope_of_h / h**2
        psi_s_by_u = field(1, 1) - slope_of_h * psi_x - a * field(0, 2) / h
        psi_ss = field(2, 0) - a * psi_x_by_s - a * psi_s_by_u / h
        return field(0, 0), psi_s, psi_ss, psi_x

    def _series(self, coefficients: Array, s: Array, derivative: int) -> Array:
        scaled = (2.0 * s - self.low - self.high) / (self.high - self.low)
        series = chebyshev.chebder(coefficients, derivative) * (2.0 / (self.high - self.low)) ** derivative if derivative else coefficients
        return np.tensordot(chebyshev.chebvander(scaled, len(series) - 1), series, axes=1)


def _derivative_matrix(degree: int, order: int) -> Array:
    """Matrix that differentiates Legendre coefficients `order` times, acting on columns."""
    matrix = np.eye(degree)
    for _ in range(order):
        matrix = np.pad(legendre.legder(matrix), ((0, 1), (0, 0)))
    return matrix


def mode_family(mechanism: Mechanism, modes: int, low: float, high: float, terms: int) -> ModeFamily:
    """The family over low <= s <= high (m), interpolated at `terms` Chebyshev points; signs are continued from one to the next."""
    beam = SupportedBeam(mechanism, modes)
    nodes = chebyshev.chebpts1(terms)
    places = 0.5 * (low + high) + 0.5 * (high - low) * nodes
    found = [beam.modes(float(s)) for s in places]
    for before, after in itertools.pairwise(found):
        turned = np.einsum("xdn,xdn->n", before.coefficients, after.coefficients) < 0.0
        after.coefficients[:, :, turned] *= -1.0
    # discrete orthogonality of the Chebyshev polynomials at these points
    transform = chebyshev.chebvander(nodes, terms - 1).T * (2.0 / terms)
    transform[0] *= 0.5
    squares = transform @ np.array([modes.squares for modes in found])
    coefficients = np.tensordot(transform, np.array([modes.coefficients for modes in found]), axes=1)
    return ModeFamily(low, high, mechanism.follower.length, squares, coefficients)
