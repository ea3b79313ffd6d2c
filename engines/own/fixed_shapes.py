"""The engine `fixed-shapes`: the thesis' method with more fixed shapes, to compare with shapes that follow the slider."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines import refusals
from quickreturn.engines.base import SPIN_UP, USUAL
from quickreturn.engines.own.staying_shapes import ShapeSettings, StayingShapesEngine
from quickreturn.engines.settings import setting
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.rigid import rigid_motion
from quickreturn.reference_model.shapes import hermite_between

if TYPE_CHECKING:
    from quickreturn.reference_model.model import BeamModel

_BOTH: Final = "both components"


@dataclass(frozen=True, kw_only=True)
class FixedShapesSettings(ShapeSettings):
    """Settings of `fixed-shapes`."""

    shapes: int = setting(16, "number of shapes (with Hermite elements: two per element)", low=1, high=64)
    damping_law: str = setting(_BOTH, "velocity relative to the base frame that the beam damping acts on", choices=(_BOTH, "transverse"))


class FixedShapesEngine(StayingShapesEngine[FixedShapesSettings]):
    """The thesis' method as its section 5.5 would continue it: more fixed shapes, exact planar geometry, equilibrium recovery."""

    name = "fixed-shapes"
    method = "pseudo-coordinate at the coupler, fixed shapes, exact planar geometry, equilibrium recovery, DOP853"
    default_accuracy = 3e-3
    settings_type = FixedShapesSettings
    quantities = (*USUAL, "slider.inertia", SPIN_UP)

    def opens_loop(self, scene: Scene) -> bool:
        """Never: the closed loop gives the follower's angle."""
        return False

    def model(self, scene: Scene, settings: FixedShapesSettings) -> "BeamModel":
        from quickreturn.reference_model.model import BeamModel

        shapes, transverse = self.shapes(scene.follower, settings), settings.damping_law != _BOTH
        refusals.of_kinks(scene, shapes, "clamped-free modes or one Hermite element")
        return BeamModel.staying(scene, shapes, self.constraint(scene, settings), transverse_damping=transverse)

    def natural_frequencies(
        self, mechanism: Mechanism, crank_angle: float, count: int, settings: FixedShapesSettings
    ) -> NDArray[np.float64]:
        """Converged: Hermite elements with a node at the slider, doubled until no frequency changes by more than 1e-6 of itself."""
        self.check(mechanism)
        if mechanism.follower.is_rigid:
            return np.zeros(0)
        from quickreturn.reference_model.thesis.frequencies import shape_frequencies

        support = float(rigid_motion(mechanism, np.array(crank_angle), 0.0).slider_position)
        elements, last = max(8, count), np.full(count, np.inf)
        while True:
            shapes = hermite_between(_nodes(mechanism.follower.length, support, elements))
            frequencies = shape_frequencies(mechanism, shapes, support, count)
            # elements of third degree: the error falls 16-fold at each doubling
            if elements > 16 * count or np.all(np.abs(frequencies - last) < 1e-6 * frequencies):
                return frequencies
            elements, last = 2 * elements, frequencies


def _nodes(length: float, support: float, elements: int) -> NDArray[np.float64]:
    """Nodes (m) of about `elements` elements, one of them at the support, where the moment has a kink."""
    inboard = max(1, round(elements * support / length))
    outboard = max(1, elements - inboard) if length - support > 1e-6 * length else 0
    if not outboard:
        return np.linspace(0.0, length, inboard + 1)
    return np.concatenate([np.linspace(0.0, support, inboard + 1), np.linspace(support, length, outboard + 1)[1:]])
