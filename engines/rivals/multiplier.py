"""The engine `multiplier`: the slider's constraint by a Lagrange multiplier (Beale and Scott; Lanczos)."""

from dataclasses import dataclass
from typing import Final

from engines.base import Comparison
from engines.fewer_shapes import fewer_shapes
from engines.rivals.rival import RivalEngine, ShapeSettings, shapes_of
from engines.settings import Settings, setting
from reference_model.constraints.joint import Joint
from reference_model.constraints.multiplier import multiplier
from reference_model.mechanism import Mechanism
from reference_model.shapes import ShapeSet


@dataclass(frozen=True, kw_only=True)
class MultiplierSettings(ShapeSettings):
    """Settings of `multiplier`."""

    stabilization: float = setting(
        100.0, "rate at which a gap decays (Baumgarte, critically damped); 0 shows the drift", unit="1/s", low=0.0, high=1e4
    )


class MultiplierEngine(RivalEngine):
    """Index-1 form with stabilization: the same equations of the beam as `fixed-shapes`, one coordinate and one multiplier more."""

    name = "multiplier"
    method = "Lagrange multiplier at the slider, index-1 form stabilized, fixed shapes, exact planar geometry, DOP853"
    default_accuracy = 3e-3
    settings_type = MultiplierSettings

    def check(self, mechanism: Mechanism) -> None:
        """Refuse a compliant joint besides what no rival can do."""
        super().check(mechanism)
        self.refuse_compliance(mechanism)

    def shapes(self, mechanism: Mechanism, settings: Settings) -> ShapeSet:
        """Clamped-free modes or Hermite elements."""
        return shapes_of(mechanism, _own(settings))

    def joint(self, mechanism: Mechanism, settings: Settings) -> Joint:
        """The multiplier with its stabilization."""
        return multiplier(_own(settings).stabilization)

    def joint_line(self, mechanism: Mechanism, settings: Settings) -> str:
        """One multiplier."""
        return "slider on the centre line (Lagrange multiplier)"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> MultiplierSettings:
        """Number of shapes from the measured table."""
        for shapes, tolerance, error in LADDER:
            if error <= accuracy:
                return MultiplierSettings(shapes=shapes, tolerance=tolerance)
        shapes, tolerance, _ = LADDER[-1]
        return MultiplierSettings(shapes=shapes, tolerance=tolerance)

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """Fewer shapes: the method has the errors of its shapes."""
        own = _own(settings)
        shapes, factor = fewer_shapes(own.shapes, own.family)
        return (Comparison(own, own.replaced(shapes=shapes), factor),)

    def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> MultiplierSettings | None:
        """The next rung of the ladder."""
        own = _own(settings)
        for shapes, tolerance, _ in LADDER:
            if shapes > own.shapes:
                return own.replaced(shapes=shapes, tolerance=min(tolerance, own.tolerance))
        return None


#: Clamped-free modes, integration tolerance and error of the tip deflection in run 24 over 2 s against `reference` with 9 modes: those of
#: `fixed-shapes`, as it must be. The last two are taken from there.
LADDER: Final = (
    (4, 1e-7, 3.1e-2),
    (6, 1e-7, 1.3e-2),
    (8, 1e-7, 5.5e-3),
    (10, 1e-7, 3.5e-3),
    (12, 1e-8, 1.7e-3),
    (16, 1e-8, 7.7e-4),
    (20, 1e-8, 4.0e-4),
    (24, 1e-8, 2.5e-4),
    (32, 1e-9, 9.4e-5),
    (40, 1e-9, 4.8e-5),
)


def _own(settings: Settings) -> MultiplierSettings:
    if not isinstance(settings, MultiplierSettings):
        raise TypeError("not settings of the engine multiplier")
    return settings
