"""The engine `thesis`: the model as published, one cubic with second-order foreshortening, integrated by LSODA."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engines.base import Comparison
from engines.pseudo_coordinate.fixed_shape_model import FixedShapeModelEngine
from engines.settings import Settings, setting
from reference_model.frequencies import shape_frequencies
from reference_model.mechanism import Follower, Mechanism, Scene
from reference_model.rigid import rigid_motion
from reference_model.shapes import ShapeSet, hermite_elements

#: LSODA tolerance for an error of the tip deflection, run 24 over 2 s: tolerances 1e-4, 1e-5, 1e-6, 1e-7 gave errors 6.6e-4, 9.4e-5,
#: 1.7e-5, 2.6e-6. The factor keeps the scatter from cycle to cycle far below what counts as settled (at 3e-5 a third of the runs
#: never settled).
THESIS_TOLERANCE_PER_ERROR: Final = 1e-4
#: Ratio of the errors of runs whose tolerances are a decade apart, from the same figures.
THESIS_ERROR_PER_DECADE: Final = 6.0
#: The loosest tolerance accepted.
LOOSEST: Final = 1e-2


@dataclass(frozen=True, kw_only=True)
class ThesisSettings(Settings):
    """Settings of `thesis`."""

    tolerance: float = setting(1e-6, "local error of the integration, relative to fixed sizes of the states", low=1e-12, high=LOOSEST)
    elements: int = setting(1, "cubic Hermite elements; 1 is the thesis", low=1, high=12)
    geometry: str = setting("second-order", "foreshortening as in the thesis, or exact", choices=("second-order", "exact"))


class ThesisEngine(FixedShapeModelEngine):
    """The thesis' model as published. Its discretization is the model: accuracy asked and error estimate are the integration's."""

    name = "thesis"
    method = "pseudo-coordinate at the coupler, one cubic, second-order foreshortening, LSODA (the thesis as published)"
    default_accuracy = 1e-3
    estimates = "integration"
    settings_type = ThesisSettings
    integrator = "LSODA"
    recovers = False

    def shapes(self, follower: Follower, settings: Settings) -> ShapeSet:
        """Cubic Hermite elements."""
        return hermite_elements(follower.length, _own(settings).elements)

    def exact_geometry(self, settings: Settings) -> bool:
        """As the setting says."""
        return _own(settings).geometry == "exact"

    def tolerance(self, settings: Settings) -> float:
        """As the setting says."""
        return _own(settings).tolerance

    def settings_for(self, accuracy: float, mechanism: Scene) -> ThesisSettings:
        """Integration tolerance for an error against the model's own equations."""
        return ThesisSettings(tolerance=accuracy * THESIS_TOLERANCE_PER_ERROR)

    def ladder(self, mechanism: Mechanism) -> tuple[ThesisSettings, ...]:
        """A coarse and a fine tolerance: what is wrong with this model is not its integration."""
        return tuple(self.settings_for(accuracy, mechanism) for accuracy in (1e-2, 1e-3))

    def comparisons(self, settings: Settings, mechanism: Scene, output_step: float) -> tuple[Comparison, ...]:
        """Ten times the tolerance, or a tenth of one that leaves no more; the error factor is measured."""
        own = _own(settings)
        if own.tolerance > 0.1 * LOOSEST:
            return (Comparison(own, own.replaced(tolerance=0.1 * own.tolerance), 1.0 / THESIS_ERROR_PER_DECADE),)
        return (Comparison(own, own.replaced(tolerance=10.0 * own.tolerance), THESIS_ERROR_PER_DECADE),)

    def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> ThesisSettings | None:
        """A tenth of the tolerance."""
        own = _own(settings)
        return own.replaced(tolerance=0.1 * own.tolerance) if own.tolerance > 1e-11 else None

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: Settings) -> NDArray[np.float64]:
        """Of the cubic elements: two per element."""
        if mechanism.follower.is_rigid:
            return np.zeros(0)
        self.check(mechanism)
        support = float(rigid_motion(mechanism, np.array(crank_angle), 0.0).slider_position)
        return shape_frequencies(mechanism, self.shapes(mechanism.follower, settings), support, count)


def _own(settings: Settings) -> ThesisSettings:
    if not isinstance(settings, ThesisSettings):
        raise TypeError("not settings of the engine thesis")
    return settings
