"""The engine `fixed-shapes`: the thesis' method with more fixed shapes, to compare with shapes that follow the slider."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.engines.base import SPIN_UP, TOOL, USUAL
from quickreturn.engines.settings import setting
from quickreturn.plugins.methods.rivals.rival import Rival, RivalEngine
from quickreturn.plugins.methods.rivals.staying_shapes import ShapeSettings, compared_shapes, ladder_of, shapes_of
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import rigid_motion
from quickreturn.reference_model.shapes import hermite_between


@dataclass(frozen=True, kw_only=True)
class FixedShapesSettings(ShapeSettings):
    """Settings of `fixed-shapes`."""

    shapes: int = setting(16, "number of shapes (with Hermite elements: two per element)", low=1, high=64)


def converged_frequencies(mechanism: Mechanism, crank_angle: float, count: int) -> Array:
    """Frequencies of Hermite elements with a node at the slider, doubled until no frequency changes by more than 1e-6 of itself."""
    from quickreturn.reference_model.thesis.model import shape_frequencies

    support = float(rigid_motion(mechanism, np.array(crank_angle), 0.0).slider_position)
    elements, last = max(8, count), np.full(count, np.inf)
    while True:
        shapes = hermite_between(_nodes(mechanism.follower.length, support, elements))
        frequencies = shape_frequencies(mechanism, shapes, support, count)
        # elements of third degree: the error falls 16-fold at each doubling
        if elements > 16 * count or np.all(np.abs(frequencies - last) < 1e-6 * frequencies):
            return frequencies
        elements, last = 2 * elements, frequencies


def _nodes(length: float, support: float, elements: int) -> Array:
    """Nodes (m) of about `elements` elements, one of them at the support, where the moment has a kink."""
    inboard = max(1, round(elements * support / length))
    outboard = max(1, elements - inboard) if length - support > 1e-6 * length else 0
    if not outboard:
        return np.linspace(0.0, length, inboard + 1)
    return np.concatenate([np.linspace(0.0, support, inboard + 1), np.linspace(support, length, outboard + 1)[1:]])


#: The thesis' method as its section 5.5 would continue it: more fixed shapes, exact planar geometry, equilibrium recovery.
ENGINE: Final = RivalEngine(
    Rival(
        name="fixed-shapes",
        method="pseudo-coordinate at the coupler, fixed shapes, exact planar geometry, equilibrium recovery, Radau IIA",
        default_accuracy=3e-3,
        settings_type=FixedShapesSettings,
        quantities=(*USUAL, *TOOL, "slider.inertia", SPIN_UP),
        ladder=ladder_of(FixedShapesSettings),
        shapes=shapes_of,
        comparisons=compared_shapes,
        natural_frequencies=converged_frequencies,
    )
)
