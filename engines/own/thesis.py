"""The engine `thesis`: the model as published, one cubic with second-order foreshortening, integrated by LSODA."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
import scipy

from quickreturn.engines import refusals
from quickreturn.engines.base import DRIVEN, SPIN_UP, USUAL, Comparison, Engine, EngineFailure, ModelDescription
from quickreturn.engines.own.beam_engine import ELIMINATED_SLIDER, description
from quickreturn.engines.settings import Settings, setting
from quickreturn.engines.start import Start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.rigid import rigid_motion
from quickreturn.reference_model.shapes import ShapeSet, hermite_elements, no_shapes

if TYPE_CHECKING:
    from quickreturn.engines.own.simulation import OwnSimulation
    from quickreturn.reference_model.thesis.model import ThesisModel

#: LSODA's tolerance over the integration error of the tip deflection (`engines/LADDERS.md`, section 2).
THESIS_TOLERANCE_PER_ERROR: Final = 1e-4
#: Ratio of the errors of two runs whose tolerances differ by a factor of ten.
THESIS_ERROR_PER_DECADE: Final = 6.0
#: The loosest tolerance accepted.
LOOSEST: Final = 1e-2


@dataclass(frozen=True, kw_only=True)
class ThesisSettings(Settings):
    """Settings of `thesis`."""

    tolerance: float = setting(1e-6, "local error of the integration, relative to fixed sizes of the states", low=1e-12, high=LOOSEST)
    elements: int = setting(1, "cubic Hermite elements; 1 is the thesis", low=1, high=12)
    geometry: str = setting("second-order", "foreshortening as in the thesis, or exact", choices=("second-order", "exact"))

    @property
    def shape_count(self) -> int:
        return 2 * self.elements


class ThesisEngine(Engine[ThesisSettings]):
    """The thesis' model as published. Its discretization is the model, so that accuracy and error estimate are the integration's."""

    name = "thesis"
    method = "pseudo-coordinate at the coupler, one cubic, second-order foreshortening, LSODA (the thesis as published)"
    default_accuracy = 1e-3
    estimates = "integration"
    settings_type = ThesisSettings
    compiles = True
    quantities = (*USUAL, *DRIVEN, "slider.inertia", SPIN_UP)

    def version(self) -> str:
        """The integrator's library; the equations are this project's own."""
        return f"scipy {scipy.__version__}"

    def model(self, scene: Scene, settings: ThesisSettings) -> "ThesisModel":
        """The thesis' model of a scene. Raises Refusal: it cannot describe a part of the scene."""
        from quickreturn.reference_model.thesis.model import ThesisModel

        self.check(scene)
        return ThesisModel(scene, self._shapes(scene, settings), settings.geometry == "exact")

    def describe(self, scene: Scene, settings: ThesisSettings) -> ModelDescription:
        """Bodies and joints that have terms in the equations."""
        self.check(scene)
        n = self._shapes(scene, settings).count
        return description(scene, f"{n} shapes" if n else "rigid", ELIMINATED_SLIDER, n)

    def _shapes(self, scene: Scene, settings: ThesisSettings) -> ShapeSet:
        """Cubic elements; no shapes for a rigid follower. Raises Refusal: a slider with rotary inertia on more than one element."""
        length = scene.follower.length
        shapes = no_shapes(length) if scene.follower.is_rigid else hermite_elements(length, settings.elements)
        refusals.of_kinks(scene, shapes, "one Hermite element")
        return shapes

    def prepare(self, scene: Scene, start: Start | None, settings: ThesisSettings) -> "OwnSimulation":
        from quickreturn.engines.own.simulation import OwnSimulation

        began = time.perf_counter()
        model = self.model(scene, settings)
        if start is None:
            return OwnSimulation(model, model.state_at_rest(), settings.tolerance, time.perf_counter() - began)
        points = model.projection_points()
        coordinates = [
            None if field is None else model.project_deflection(field(points, 0), field(points, 1))
            for field in (start.deflection, start.deflection_rate)
        ]
        state = model.initial_state(start.crank_angle, start.crank_speed, *coordinates)
        if not model.can_move(state):
            raise EngineFailure(0.0, "the loop cannot be closed in the given start", "try a start with a smaller deflection")
        return OwnSimulation(model, state, settings.tolerance, time.perf_counter() - began)

    def settings_for(self, accuracy: float, mechanism: Scene) -> ThesisSettings:
        """Integration tolerance for an integration error."""
        return ThesisSettings(tolerance=accuracy * THESIS_TOLERANCE_PER_ERROR)

    def ladder(self, mechanism: Mechanism) -> tuple[ThesisSettings, ...]:
        """A coarse and a fine tolerance: the model's error exceeds that of its integration by far."""
        return tuple(self.settings_for(accuracy, mechanism) for accuracy in (1e-2, 1e-3))

    def comparisons(self, settings: ThesisSettings, mechanism: Scene, output_step: float) -> tuple[Comparison, ...]:
        """A run with ten times the tolerance, or with a tenth of one that is too loose for that; the ratio of errors is measured."""
        times, factor = 10.0, THESIS_ERROR_PER_DECADE
        if settings.tolerance > 0.1 * LOOSEST:
            times, factor = 0.1, 1.0 / THESIS_ERROR_PER_DECADE
        return (Comparison(settings, settings.replaced(tolerance=times * settings.tolerance), factor, of="time"),)

    def finer(self, settings: ThesisSettings, excess: Mapping[str, float], output_step: float) -> ThesisSettings | None:
        """A tenth of the tolerance."""
        return settings.replaced(tolerance=0.1 * settings.tolerance) if settings.tolerance > 1e-11 else None

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ThesisSettings) -> Array:
        """See `Engine.natural_frequencies`; those of the cubic elements, two per element."""
        self.check(mechanism)
        if mechanism.follower.is_rigid:
            return np.zeros(0)
        from quickreturn.reference_model.thesis.model import shape_frequencies

        support = float(rigid_motion(mechanism, np.array(crank_angle), 0.0).slider_position)
        return shape_frequencies(mechanism, hermite_elements(mechanism.follower.length, settings.elements), support, count)
