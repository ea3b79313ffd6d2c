"""Natural frequencies of the straight follower with the crank held."""

import dataclasses
import math

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from engines.mujoco import chain, kernels
from reference_model.mechanism import Mechanism, PrescribedSpeed


def natural_frequencies(mechanism: Mechanism, crank_angle: float, count: int, links: int) -> NDArray[np.float64]:
    """Lowest `count` frequencies, Hz, of the chain that the slider supports at the straight follower's |PC|; none if it is rigid.

    The hinges have no armature here: it is an aid of the time integration.
    """
    hinges = chain.hinge_count(mechanism, links)
    held = dataclasses.replace(mechanism, crank=dataclasses.replace(mechanism.crank, drive=PrescribedSpeed(speed=0.0)))
    mass, stiffness = chain.follower_matrices(chain.build(held, hinges, 0.0), held, hinges)
    arm = mechanism.crank.length
    slider = math.hypot(mechanism.pivot_distance - arm * math.cos(crank_angle), arm * math.sin(crank_angle))
    coefficients = kernels.centre_line_coefficients(slider, hinges, mechanism.follower.length / max(hinges, 1), 0)
    constraint = np.cumsum(coefficients[::-1])[::-1]  # a hinge turns every link beyond it
    free = scipy.linalg.null_space(constraint[None, :])
    squares = scipy.linalg.eigvalsh(free.T @ stiffness @ free, free.T @ mass @ free) if free.size else np.empty(0)
    return np.sqrt(np.maximum(squares[:count], 0.0)) / (2.0 * math.pi)
