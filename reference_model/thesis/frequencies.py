"""Natural frequencies of the explicit model with the crank frozen (thesis/DERIVATION.md, section 7)."""

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.eigenproblem import eigh
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.shapes import ShapeSet
from quickreturn.reference_model.thesis.tables import build_tables


def shape_frequencies(mechanism: Mechanism, shapes: ShapeSet, support: float, count: int) -> NDArray[np.float64]:
    """Lowest natural frequencies (Hz) of the straight follower at rest in these shapes, the slider held at arc length `support`.

    With the crank held the constraint is q2 = -sum phi_i(s) eta_i / s (equation 7.1), so that a rigid rotation goes with every shape
    (equations 7.2 and 7.3). Undamped, without gravity. By Rayleigh's principle the frequencies lie above the converged ones.

    Args:
        mechanism: the scene; its follower must be flexible.
        shapes: the follower's shapes.
        support: s, m.
        count: number of frequencies, or the number of shapes if that is less.
    """
    beam, tip = mechanism.follower, mechanism.tip_body
    tables = build_tables(shapes, 0)
    at_support = shapes.evaluate(np.array([support]))[0]
    turn = -at_support / support
    field = tables.phi + tables.x[:, None] * turn
    arm = beam.length + tip.center_of_mass
    end = tables.end_phi + tip.center_of_mass * tables.end_dphi + arm * turn
    end_turn = tables.end_dphi + turn
    slider_turn = shapes.evaluate(np.array([support]), 1)[0] + turn
    mass = beam.mass_per_length * field.T @ (tables.weights[:, None] * field)
    mass += mechanism.base.inertia * np.outer(turn, turn) + tip.mass * np.outer(end, end) + tip.inertia * np.outer(end_turn, end_turn)
    mass += mechanism.slider.inertia * np.outer(slider_turn, slider_turn)
    stiffness = beam.bending_stiffness * tables.ddphi.T @ (tables.weights[:, None] * tables.ddphi)
    # M v = v / omega^2 K v, not the other way round: round-off is relative to the largest eigenvalue
    inverse_squares = eigh(mass, stiffness)[0][::-1][:count]
    return 1.0 / (2.0 * np.pi * np.sqrt(inverse_squares))
