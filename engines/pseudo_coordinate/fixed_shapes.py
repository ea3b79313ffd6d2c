"""The engine `fixed-shapes`: the thesis' method with more fixed shapes and exact geometry, the independent check of `reference`."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engines.base import Comparison
from engines.fewer_shapes import fewer_shapes
from engines.pseudo_coordinate.fixed_shape_model import FixedShapeModelEngine
from engines.settings import Settings, setting
from reference_model.frequencies import shape_frequencies
from reference_model.mechanism import Follower, Mechanism, Scene
from reference_model.rigid import rigid_motion
from reference_model.shapes import ShapeSet, clamped_free_modes, hermite_between, hermite_elements

#: Number of clamped-free modes, integration tolerance and error of the tip deflection in run 24 over 2 s (`convergence_table`): the
#: difference from 32 modes plus their own error of 9.4e-5, which follows from the law 3.07 / shapes^3 that the differences obey from 12 on.
#: Tolerances leave 1e-4 of the slider force at most: fewer shapes stand looser ones, an explicit integrator makes high modes ring.
LADDER: Final = (
    (4, 1e-7, 3.1e-2),
    (6, 1e-7, 1.3e-2),
    (8, 1e-7, 5.5e-3),
    (10, 1e-7, 3.5e-3),
    (12, 1e-8, 1.6e-3),
    (16, 1e-8, 7.5e-4),
    (20, 1e-8, 3.8e-4),
    (24, 1e-9, 2.3e-4),
    (32, 1e-9, 9.4e-5),
    (40, 1e-9, 4.8e-5),
)


@dataclass(frozen=True, kw_only=True)
class FixedShapesSettings(Settings):
    """Settings of `fixed-shapes`."""

    shapes: int = setting(16, "number of shapes (with Hermite elements: two per element)", low=1, high=64)
    family: str = setting("clamped-free", "fixed shapes", choices=("clamped-free", "hermite"))
    tolerance: float = setting(1e-8, "local error of the integration, relative to fixed sizes of the states", low=1e-12, high=1e-4)
    damping_law: str = setting(
        "both components", "velocity relative to the base frame that the beam damping acts on", choices=("both components", "transverse")
    )


class FixedShapesEngine(FixedShapeModelEngine):
    """How the thesis would have gone on (section 5.5): more fixed shapes, exact planar geometry, equilibrium recovery."""

    name = "fixed-shapes"
    method = "pseudo-coordinate at the coupler, fixed shapes, exact planar geometry, equilibrium recovery, DOP853"
    default_accuracy = 1e-3
    estimates = "unverified"
    settings_type = FixedShapesSettings
    integrator = "DOP853"
    recovers = True

    def shapes(self, follower: Follower, settings: Settings) -> ShapeSet:
        """Clamped-free modes or Hermite elements."""
        own = _own(settings)
        if own.family == "hermite":
            return hermite_elements(follower.length, max(1, own.shapes // 2))
        return clamped_free_modes(follower.length, own.shapes)

    def exact_geometry(self, settings: Settings) -> bool:
        """Always exact."""
        return True

    def transverse_damping(self, settings: Settings) -> bool:
        """As the setting says."""
        return _own(settings).damping_law == "transverse"

    def tolerance(self, settings: Settings) -> float:
        """As the setting says."""
        return _own(settings).tolerance

    def settings_for(self, accuracy: float, mechanism: Scene) -> FixedShapesSettings:
        """Number of shapes from the measured table."""
        for shapes, tolerance, error in LADDER:
            if error <= accuracy:
                return FixedShapesSettings(shapes=shapes, tolerance=tolerance)
        shapes, tolerance, _ = LADDER[-1]
        return FixedShapesSettings(shapes=shapes, tolerance=tolerance)

    def comparisons(self, settings: Settings, mechanism: Scene, output_step: float) -> tuple[Comparison, ...]:
        """Fewer shapes; the factor stays a little below those of the ladder."""
        own = _own(settings)
        shapes, factor = fewer_shapes(own.shapes, own.family)
        return (Comparison(own, own.replaced(shapes=shapes), factor),)

    def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> FixedShapesSettings | None:
        """The next rung of the ladder."""
        own = _own(settings)
        for shapes, tolerance, _ in LADDER:
            if shapes > own.shapes:
                return own.replaced(shapes=shapes, tolerance=min(tolerance, own.tolerance))
        return None

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: Settings) -> NDArray[np.float64]:
        """Converged: Hermite elements with a node at the slider, doubled until no frequency changes by more than 1e-6 of itself."""
        if mechanism.follower.is_rigid:
            return np.zeros(0)
        self.check(mechanism)
        support = float(rigid_motion(mechanism, np.array(crank_angle), 0.0).slider_position)
        elements, last = max(8, count), np.full(count, np.inf)
        while True:
            shapes = hermite_between(_nodes(mechanism.follower.length, support, elements))
            found = shape_frequencies(mechanism, shapes, support, count)
            # elements of third degree: the error falls 16-fold at each doubling
            if elements > 16 * count or np.all(np.abs(found - last) < 1e-6 * found):
                return found
            elements, last = 2 * elements, found


def _nodes(length: float, support: float, elements: int) -> NDArray[np.float64]:
    """Nodes of about `elements` elements, one node at the support, where the moment has a kink."""
    inboard = max(1, round(elements * support / length))
    outboard = max(1, elements - inboard) if length - support > 1e-6 * length else 0
    if not outboard:
        return np.linspace(0.0, length, inboard + 1)
    return np.concatenate([np.linspace(0.0, support, inboard + 1), np.linspace(support, length, outboard + 1)[1:]])


def _own(settings: Settings) -> FixedShapesSettings:
    if not isinstance(settings, FixedShapesSettings):
        raise TypeError("not settings of the engine fixed-shapes")
    return settings
