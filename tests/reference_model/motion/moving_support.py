"""A second formulation of the linear beam on a moving support: finite elements that stay, held by a stiff spring where the slider is."""

import math

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import rigid_motion
from quickreturn.reference_model.shapes import hermite_elements


def monodromy(
    mechanism: Mechanism, crank_speed: float, *, foreshortening: bool, elements: int = 16, stiffness: float = 1e7, steps: int = 1500
) -> Array:
    """What a turn makes of deflections and rates in the frame of the line from pivot to slider, by the implicit midpoint rule, undamped.

    `foreshortening`: whether rotation stiffens the beam, to second order; `stiffness`: of the spring, N/m.
    """
    beam, tip = mechanism.follower, mechanism.tip_body
    L, m, e = beam.length, tip.mass, tip.center_of_mass
    clamped = hermite_elements(L, elements)
    points, weights = np.polynomial.legendre.leggauss(6)
    edges = clamped.edges
    x = (0.5 * (edges[:-1] + edges[1:])[:, None] + 0.5 * np.diff(edges)[:, None] * points).ravel()
    dx = (0.5 * np.diff(edges)[:, None] * weights).ravel()

    def shapes(places: Array, derivative: int) -> Array:
        """Clamped elements, and the rotation about the pivot."""
        turned = {0: places, 1: np.ones_like(places), 2: np.zeros_like(places)}[derivative]
        return np.column_stack([turned, clamped.evaluate(places, derivative)])

    w, slope, curvature = (shapes(x, derivative) for derivative in range(3))
    (end,), (end_slope,), (base,) = shapes(np.array([L]), 0), shapes(np.array([L]), 1), shapes(np.zeros(1), 1)
    centre = end + e * end_slope
    moved = beam.mass_per_length * w.T @ (dx[:, None] * w) + m * np.outer(centre, centre)
    mass = moved + tip.inertia * np.outer(end_slope, end_slope) + mechanism.base.inertia * np.outer(base, base)
    bending = beam.bending_stiffness * curvature.T @ (dx[:, None] * curvature)
    if foreshortening:
        tension = 0.5 * beam.mass_per_length * (L**2 - x**2) + m * (L + e)
        moved = moved - slope.T @ ((tension * dx)[:, None] * slope) - m * e * (L + e) * np.outer(end_slope, end_slope)
    h, n = 2.0 * math.pi / crank_speed / steps, len(mass)
    u: Array = np.eye(2 * n)[:n]
    v: Array = np.eye(2 * n)[n:]
    for step in range(steps):
        line = rigid_motion(mechanism, np.array(math.pi + crank_speed * (step + 0.5) * h), crank_speed)
        (at,) = shapes(line.slider_position[None], 0)
        force = bending - float(line.follower_speed) ** 2 * moved + stiffness * np.outer(at, at)
        before = v
        v = np.asarray(np.linalg.solve(mass + 0.25 * h * h * force, mass @ v - h * force @ u - 0.25 * h * h * force @ v), dtype=float)
        u = u + 0.5 * h * (before + v)
    return np.vstack([u, v])
