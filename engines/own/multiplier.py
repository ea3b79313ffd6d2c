"""The engine `multiplier`: the slider's constraint by a Lagrange multiplier (Beale and Scott; Lanczos)."""

from dataclasses import dataclass

from quickreturn.engines.base import FRICTION, USUAL
from quickreturn.engines.own.beam_engine import time_over_run_24
from quickreturn.engines.own.staying_shapes import RivalEngine, ShapeSettings, StayingShapesEngine
from quickreturn.engines.settings import setting
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.slider_constraint import MULTIPLIER, SliderConstraint


@dataclass(frozen=True, kw_only=True)
class MultiplierSettings(ShapeSettings):
    """Settings of `multiplier`."""

    stabilization: float = setting(
        100.0, "rate at which a gap decays (Baumgarte, critically damped); 0 shows the drift", unit="1/s", low=0.0, high=1e12
    )


class MultiplierEngine(RivalEngine[MultiplierSettings], StayingShapesEngine[MultiplierSettings]):
    """The beam of `fixed-shapes` with one more coordinate and a multiplier: index-1 form with stabilization."""

    name = "multiplier"
    method = "Lagrange multiplier at the slider, index-1 form stabilized, fixed shapes, exact planar geometry, DOP853"
    default_accuracy = 3e-3
    settings_type = MultiplierSettings
    quantities = (*USUAL, *FRICTION, "follower.material_damping")

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> MultiplierSettings:
        """Number of shapes from the measured table; the gap decays in proportion to the follower's time."""
        settings = super().settings_for(accuracy, mechanism)
        return settings.replaced(stabilization=settings.stabilization / time_over_run_24(mechanism))

    def constraint(self, scene: Scene, settings: MultiplierSettings) -> SliderConstraint:
        return SliderConstraint(kind=MULTIPLIER, stabilization=settings.stabilization)

    def joint_line(self, scene: Scene, settings: MultiplierSettings) -> str:
        return "slider on the centre line (Lagrange multiplier)"
