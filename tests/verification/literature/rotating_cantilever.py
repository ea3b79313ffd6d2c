"""Linear theory of the uniform cantilever on a base that turns, solved by power series.

In the plane of rotation, about the straight state, a base that turns at the rate W gives the tension N = rho A W^2 (L^2 - x^2)/2, and

    EI w'''' - (N w')' - rho A W^2 w + rho A d^2w/dt^2 = -rho A (dW/dt) x,    w = w' = 0 at 0,    w'' = w''' = 0 at L.

Out of the plane the third term is missing, so that the square of a frequency in the plane is that out of it less W^2. The series is
the method of A. D. Wright, C. E. Smith, R. W. Thresher and J. L. C. Wang, "Vibration modes of centrifugally stiffened beams", Journal of
Applied Mechanics 49 (1982) 197-202. Everything here is without dimensions: lengths and deflections over L, times over `time_unit`.
"""

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.follower import Follower

TERMS = 80  # of the series; at a rate of 12 the last one is below 1e-40 of the sum


def time_unit(follower: Follower) -> float:
    """sqrt(rho A L^4 / EI), s."""
    return float(np.sqrt(follower.mass_per_length * follower.length**4 / follower.bending_stiffness))


def frequencies(rate: float, count: int) -> Array:
    """The `count` lowest angular frequencies in the plane of rotation of a cantilever that turns at `rate`; ascending, shape (count,)."""

    def determinant(squares: Array) -> Array:
        (a, b), _ = _ends(np.full_like(squares, rate), squares)
        return np.asarray(a[0] * b[1] - a[1] * b[0], dtype=np.float64)

    # at rest the frequencies lie below (pi n)^2, and the rate raises them by less than twice itself for each mode
    grid = np.linspace(0.0, (np.pi * (count + 0.5)) ** 2 + 2.0 * count * rate, 400 * count) ** 2
    values = determinant(grid)
    changes = np.flatnonzero(np.sign(values[1:]) != np.sign(values[:-1]))[:count]
    roots = [brentq(lambda square: float(determinant(np.array([square]))[0]), grid[i], grid[i + 1], rtol=1e-14) for i in changes]
    return np.sqrt(roots)


def cubic_frequency(rate: float) -> float:
    """The lowest frequency by Ritz's method with the one cubic a x^2 + b x^3: what the thesis' discretization makes of it."""
    # integrals from 0 to 1 of products of x^2 and x^3, of their second derivatives, and of the tension's work on their slopes
    mass = np.array([[1 / 5, 1 / 6], [1 / 6, 1 / 7]])
    bending = np.array([[4.0, 6.0], [6.0, 12.0]])
    tension = 0.5 * np.array([[4 / 3 - 4 / 5, 6 / 4 - 6 / 6], [6 / 4 - 6 / 6, 9 / 5 - 9 / 7]])
    return float(np.sqrt(eigh(bending + rate**2 * (tension - mass), mass, eigvals_only=True)[0]))


def quasi_static_deflection(rate: Array, acceleration: Array) -> Array:
    """Deflection of the end where every instant has its own equilibrium, for the base's rates and angular accelerations, shape (k,)."""
    (a, b), forced = _ends(rate, np.zeros_like(rate))
    matrices = np.stack([np.stack([a[0], b[0]], axis=-1), np.stack([a[1], b[1]], axis=-1)], axis=-2)
    weights = np.linalg.solve(matrices, forced[:2].T[:, :, None])[:, :, 0]
    return np.asarray(acceleration * (forced[2] - weights[:, 0] * a[2] - weights[:, 1] * b[2]), dtype=np.float64)


def _ends(rate: Array, squared: Array) -> tuple[tuple[Array, Array], Array]:
    """Second and third derivative and value at the end, each of shape (3, k), of three solutions with w(0) = w'(0) = 0.

    They begin with x^2 and with x^3; the third one begins with neither and carries the load -x. `squared`: of the frequency in the plane.
    """
    n = np.arange(TERMS, dtype=np.float64)
    at_end = np.stack([n * (n - 1.0), n * (n - 1.0) * (n - 2.0), np.ones(TERMS)])
    found = []
    for start in (2, 3, None):
        w = np.zeros((TERMS, len(rate)))
        if start is not None:
            w[start] = 1.0
        for k in range(TERMS - 4):
            load = 1.0 if start is None and k == 1 else 0.0
            tension = 0.5 * rate**2 * ((k + 2) * (k + 1) * w[k + 2] - k * (k + 1) * w[k])
            w[k + 4] = (tension + (squared + rate**2) * w[k] - load) / ((k + 4) * (k + 3) * (k + 2) * (k + 1))
        found.append(at_end @ w)
    return (found[0], found[1]), found[2]
