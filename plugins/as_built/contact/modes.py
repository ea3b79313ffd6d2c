"""Natural frequencies of the straight chain of links with the crank held."""

import math

import numpy as np
import scipy  # whose linear algebra is imported when it is used
from numpy.typing import NDArray

from quickreturn.engines.units import Units
from quickreturn.plugins.as_built.contact.chain import straight_chain
from quickreturn.reference_model.eigenproblem import eigh
from quickreturn.reference_model.mechanism import Mechanism


def natural_frequencies(mechanism: Mechanism, crank_angle: float, count: int, links: int) -> NDArray[np.float64]:
    """Lowest `count` frequencies, Hz; without armature, which serves the time integration only."""
    units = Units.of(mechanism)
    scene = units.scene(mechanism)
    mass, stiffness = straight_chain(scene, links, 0.0)
    arm, h = scene.crank.length, scene.follower.length / links
    slider = math.hypot(scene.pivot_distance - arm * math.cos(crank_angle), arm * math.sin(crank_angle))
    row = np.maximum(slider - h * np.arange(links), 0.0)  # a hinge moves the point at the slider by its distance
    free = scipy.linalg.null_space(row[None, :])
    squares = eigh(free.T @ stiffness @ free, free.T @ mass @ free)[0]
    return np.sqrt(np.maximum(squares[:count], 0.0)) / (2.0 * math.pi * units.time)
