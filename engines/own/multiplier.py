"""The engine `multiplier`: the slider's constraint by a Lagrange multiplier (Beale and Scott; Lanczos)."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from engines import refusals
from engines.own.beam_engine import gain_of
from engines.own.staying_shapes import LADDER, RivalEngine, ShapeSettings, StayingShapesEngine, shapes_of
from engines.settings import setting
from reference_model.mechanism import Mechanism
from reference_model.treatment import MULTIPLIER, Treatment

if TYPE_CHECKING:
    from reference_model.model import BeamModel


@dataclass(frozen=True, kw_only=True)
class MultiplierSettings(ShapeSettings):
    """Settings of `multiplier`."""

    stabilization: float = setting(
        100.0, "rate at which a gap decays (Baumgarte, critically damped); 0 shows the drift", unit="1/s", low=0.0, high=1e4
    )


class MultiplierEngine(RivalEngine[MultiplierSettings], StayingShapesEngine[MultiplierSettings]):
    """Index-1 form with stabilization: the beam of `fixed-shapes`, one coordinate and one multiplier more."""

    name = "multiplier"
    method = "Lagrange multiplier at the slider, index-1 form stabilized, fixed shapes, exact planar geometry, DOP853"
    default_accuracy = 3e-3
    settings_type = MultiplierSettings

    def check(self, mechanism: Mechanism) -> None:
        """Refuse a compliant joint besides what no rival can do."""
        super().check(mechanism)
        refusals.of_compliance(self.name, mechanism, "gap")

    def model(self, mechanism: Mechanism, settings: MultiplierSettings) -> "BeamModel":
        """See `BeamEngine.model`."""
        from reference_model.model import BeamModel

        treatment = Treatment(kind=MULTIPLIER, stabilization=settings.stabilization)
        return BeamModel.staying(mechanism, shapes_of(mechanism.follower, settings), treatment)

    def joint_line(self, mechanism: Mechanism, settings: MultiplierSettings) -> str:
        """One multiplier."""
        return "slider on the centre line (Lagrange multiplier)"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> MultiplierSettings:
        """Number of shapes from the measured table; fewer where the follower is stiffer than run 24's."""
        rung = LADDER.pick(accuracy, gain_of(mechanism))
        return MultiplierSettings(shapes=rung.shapes, tolerance=rung.tolerance)
