"""The engine `multiplier`: the slider's constraint by a Lagrange multiplier (Beale and Scott; Lanczos)."""

from dataclasses import dataclass
from typing import Final

from quickreturn.engines.base import FRICTION, TOOL, USUAL
from quickreturn.engines.own.beam_engine import time_over_run_24
from quickreturn.engines.settings import setting
from quickreturn.plugins.methods.rivals.rival import Rival, RivalEngine
from quickreturn.plugins.methods.rivals.staying_shapes import ShapeSettings, compared_shapes, ladder_of, shapes_of
from quickreturn.reference_model.joint import MULTIPLIER, SliderConstraint
from quickreturn.reference_model.mechanism import Mechanism, Scene


@dataclass(frozen=True, kw_only=True)
class MultiplierSettings(ShapeSettings):
    """Settings of `multiplier`."""

    stabilization: float = setting(
        100.0, "rate at which a gap decays (Baumgarte, critically damped); 0 shows the drift", unit="1/s", low=0.0, high=1e12
    )


def constraint(settings: MultiplierSettings, scene: Scene) -> SliderConstraint:
    """A multiplier, with the stabilization of the settings."""
    return SliderConstraint(kind=MULTIPLIER, stabilization=settings.stabilization)


def joint_line(settings: MultiplierSettings, scene: Scene) -> str:
    """The slider's joint in one line."""
    return "slider on the centre line (Lagrange multiplier)"


def scaled(settings: MultiplierSettings, mechanism: Mechanism) -> MultiplierSettings:
    """Settings whose gap decays in proportion to the follower's time."""
    return settings.replaced(stabilization=settings.stabilization / time_over_run_24(mechanism))


#: The beam of `fixed-shapes` with one more coordinate and a multiplier: index-1 form with stabilization.
ENGINE: Final = RivalEngine(
    Rival(
        name="multiplier",
        method="Lagrange multiplier at the slider, index-1 form stabilized, fixed shapes, exact planar geometry, Radau IIA",
        default_accuracy=3e-3,
        settings_type=MultiplierSettings,
        quantities=(*USUAL, *TOOL, *FRICTION, "follower.material_damping"),
        ladder=ladder_of(MultiplierSettings),
        shapes=shapes_of,
        comparisons=compared_shapes,
        constraint=constraint,
        joint_line=joint_line,
        scaled=scaled,
    )
)
