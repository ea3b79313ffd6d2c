"""The engine `stiff-spring`: the slider's constraint replaced by a stiff transverse spring at the moving point (Lee)."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from engines.base import Comparison
from engines.own.staying_shapes import RivalEngine, ShapeSettings, shapes_of
from engines.settings import Settings, own, setting
from reference_model.mechanism import Mechanism
from reference_model.treatment import SPRING, Treatment

if TYPE_CHECKING:
    from reference_model.model import BeamModel

#: Clamped-free modes, stiffness (N/m), damping (N s/m), integration tolerance, and error of the tip deflection in run 24 over 2 s: the sum
#: of the shapes' error (`staying_shapes.LADDER`) and the spring's (8.8e-3 at 1e6 N/m, in proportion to 1/k). Shapes are too stiff and
#: springs too soft: what is left against `reference` is less: 4e-3, 3e-3 in the first two, 9e-4 in the fourth.
LADDER: Final = (
    (6, 1e6, 30.0, 1e-7, 2.2e-2),
    (8, 3e6, 90.0, 1e-7, 8.4e-3),
    (10, 1e7, 300.0, 1e-7, 4.4e-3),
    (12, 1e7, 300.0, 1e-7, 2.6e-3),
    (16, 3e7, 900.0, 1e-7, 1.1e-3),
    (20, 1e8, 3000.0, 1e-8, 4.9e-4),
    (24, 1e8, 3000.0, 1e-8, 3.4e-4),
)


@dataclass(frozen=True, kw_only=True)
class StiffSpringSettings(ShapeSettings):
    """Settings of `stiff-spring`; a scene with a compliant slider joint brings stiffness and damping of its own."""

    stiffness: float = setting(1e6, "of the spring that stands for the constraint", unit="N/m", low=1e3, high=1e9)
    damping: float = setting(30.0, "of the damper beside it", unit="N*s/m", low=0.0, high=1e5)


class StiffSpringEngine(RivalEngine):
    """A gap opens between crank tip and centre line as far as the slider force bends the spring; exact for a compliant joint."""

    name = "stiff-spring"
    method = "stiff transverse spring and damper at the slider, fixed shapes, exact planar geometry, DOP853"
    default_accuracy = 1e-2
    settings_type = StiffSpringSettings

    def model(self, mechanism: Mechanism, settings: Settings) -> "BeamModel":
        """See `BeamEngine.model`."""
        from reference_model.model import BeamModel

        shapes = shapes_of(mechanism.follower, own(ShapeSettings, settings))
        return BeamModel.staying(mechanism, shapes, self._spring(mechanism, settings))

    def _spring(self, mechanism: Mechanism, settings: Settings) -> Treatment:
        """The scene's joint if it is compliant, else the stiff spring of the settings; dampings of joint and settings do not add."""
        slider, chosen = mechanism.slider, own(StiffSpringSettings, settings)
        if math.isfinite(slider.joint_stiffness):
            return Treatment(kind=SPRING, stiffness=slider.joint_stiffness, damping=slider.joint_damping)
        return Treatment(kind=SPRING, stiffness=chosen.stiffness, damping=chosen.damping)

    def joint_line(self, mechanism: Mechanism, settings: Settings) -> str:
        """Whose spring it is."""
        spring = self._spring(mechanism, settings)
        kind = "compliant joint" if math.isfinite(mechanism.slider.joint_stiffness) else "stiff spring in place of the constraint"
        return f"slider beside the centre line ({kind}, {spring.stiffness:g} N/m, {spring.damping:g} N*s/m)"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> StiffSpringSettings:
        """Shapes and stiffness from the measured table."""
        shapes, stiffness, damping, tolerance, _ = next((rung for rung in LADDER if rung[-1] <= accuracy), LADDER[-1])
        return StiffSpringSettings(shapes=shapes, stiffness=stiffness, damping=damping, tolerance=tolerance)

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """A seventh of the shapes fewer on a spring twice as stiff.

        Shapes are too stiff, springs too soft: softening the spring along with fewer shapes would let the difference of the runs cancel.
        Fewer shapes have 1.5 times the error, the stiffer spring half of its own: the difference is half the sum of both errors. A single
        shape or element leaves nothing coarser to compare with: there twice as many, with half the error at most.
        """
        chosen = own(StiffSpringSettings, settings)
        stiffer = min(2.0 * chosen.stiffness, 1e9)
        ratio = stiffer / chosen.stiffness
        each = 2 if chosen.family == "hermite" else 1  # shapes that come and go together
        units = max(1, chosen.shapes // each)
        other, factor = (min(units - 1, round(0.85 * units)), 1.5) if units > 1 else (2, 0.5)
        changed = chosen.replaced(shapes=each * other, stiffness=stiffer, damping=min(ratio * chosen.damping, 1e5))
        return (Comparison(chosen, changed, factor),)

    def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> StiffSpringSettings | None:
        """The next rung of the ladder."""
        chosen = own(StiffSpringSettings, settings)
        for shapes, stiffness, damping, tolerance, _ in LADDER:
            if shapes > chosen.shapes or stiffness > chosen.stiffness:
                changes = {"stiffness": max(stiffness, chosen.stiffness), "damping": max(damping, chosen.damping)}
                return chosen.replaced(shapes=max(shapes, chosen.shapes), tolerance=min(tolerance, chosen.tolerance), **changes)
        return None
