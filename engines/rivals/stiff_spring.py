"""The engine `stiff-spring`: the slider's constraint replaced by a stiff transverse spring at the moving point (Lee)."""

import math
from dataclasses import dataclass
from typing import Final

from engines.base import Comparison
from engines.rivals.rival import RivalEngine, ShapeSettings, shapes_of
from engines.settings import Settings, setting
from reference_model.constraints.joint import Joint
from reference_model.constraints.stiff_spring import stiff_spring
from reference_model.mechanism import Mechanism
from reference_model.shapes import ShapeSet


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

    def shapes(self, mechanism: Mechanism, settings: Settings) -> ShapeSet:
        """Clamped-free modes or Hermite elements."""
        return shapes_of(mechanism, _own(settings))

    def joint(self, mechanism: Mechanism, settings: Settings) -> Joint:
        """The scene's joint if it is compliant, else the stiff spring of the settings; dampings of joint and settings do not add."""
        slider = mechanism.slider
        if math.isfinite(slider.joint_stiffness):
            return stiff_spring(slider.joint_stiffness, slider.joint_damping)
        return stiff_spring(_own(settings).stiffness, _own(settings).damping)

    def joint_line(self, mechanism: Mechanism, settings: Settings) -> str:
        """Whose spring it is."""
        spring = self.joint(mechanism, settings)
        kind = "compliant joint" if math.isfinite(mechanism.slider.joint_stiffness) else "stiff spring in place of the constraint"
        return f"slider beside the centre line ({kind}, {spring.stiffness:g} N/m, {spring.damping:g} N*s/m)"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> StiffSpringSettings:
        """Shapes and stiffness from the measured table."""
        for rung in LADDER:
            if rung[-1] <= accuracy:
                break
        shapes, stiffness, damping, tolerance, _ = rung
        return StiffSpringSettings(shapes=shapes, stiffness=stiffness, damping=damping, tolerance=tolerance)

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """A seventh of the shapes fewer on a spring twice as stiff.

        Shapes are too stiff, springs too soft: softening the spring along with fewer shapes would let the difference of the runs cancel.
        Fewer shapes have 1.5 times the error, the stiffer spring half of its own: the difference is half the sum of both errors. A single
        shape or element leaves nothing coarser to compare with: there twice as many, with half the error at most.
        """
        own = _own(settings)
        stiffer = min(2.0 * own.stiffness, 1e9)
        ratio = stiffer / own.stiffness
        each = 2 if own.family == "hermite" else 1  # shapes that come and go together
        units = max(1, own.shapes // each)
        other, factor = (min(units - 1, round(0.85 * units)), 1.5) if units > 1 else (2, 0.5)
        changed = own.replaced(shapes=each * other, stiffness=stiffer, damping=min(ratio * own.damping, 1e5))
        return (Comparison(own, changed, factor),)

    def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> StiffSpringSettings | None:
        """The next rung of the ladder."""
        own = _own(settings)
        for shapes, stiffness, damping, tolerance, _ in LADDER:
            if shapes > own.shapes or stiffness > own.stiffness:
                changes = {"stiffness": max(stiffness, own.stiffness), "damping": max(damping, own.damping)}
                return own.replaced(shapes=max(shapes, own.shapes), tolerance=min(tolerance, own.tolerance), **changes)
        return None


#: Clamped-free modes, stiffness (N/m), damping (N s/m), integration tolerance, and error of the tip deflection in run 24 over 2 s: the sum
#: of the shapes' error (`engines.rivals.multiplier.LADDER`) and the spring's (8.8e-3 at 1e6 N/m, in proportion to 1/k). Shapes are too
#: stiff and springs too soft: what is left against `reference` is less: 4e-3, 3e-3 in the first two, 9e-4 in the fourth.
LADDER: Final = (
    (6, 1e6, 30.0, 1e-7, 2.2e-2),
    (8, 3e6, 90.0, 1e-7, 8.4e-3),
    (10, 1e7, 300.0, 1e-7, 4.4e-3),
    (12, 1e7, 300.0, 1e-7, 2.6e-3),
    (16, 3e7, 900.0, 1e-7, 1.1e-3),
    (20, 1e8, 3000.0, 1e-8, 4.9e-4),
    (24, 1e8, 3000.0, 1e-8, 3.4e-4),
)


def _own(settings: Settings) -> StiffSpringSettings:
    if not isinstance(settings, StiffSpringSettings):
        raise TypeError("not settings of the engine stiff-spring")
    return settings
