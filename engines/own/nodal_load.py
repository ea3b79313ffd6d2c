"""The engine `nodal-load`: standard finite elements with fixed nodes, the slider force shared between two of them (Buchanan)."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from engines.base import Comparison
from engines.own.staying_shapes import RivalEngine
from engines.settings import Settings, own, setting
from reference_model.mechanism import Mechanism
from reference_model.shapes import hermite_elements, no_shapes
from reference_model.treatment import CHORDS, LEVER, MULTIPLIER, Treatment

if TYPE_CHECKING:
    from reference_model.model import BeamModel

_DISTRIBUTIONS: Final = {"lever": LEVER, "consistent": MULTIPLIER, "both linear": CHORDS}

#: Elements, integration tolerance and error of the tip deflection in run 24 over 2 s against `reference` with 9 modes, lever rule.
LADDER: Final = ((6, 1e-7, 2.3e-1), (8, 1e-7, 1.2e-1), (12, 1e-7, 3.7e-2), (16, 1e-7, 2.6e-2), (24, 1e-7, 1.4e-2))


@dataclass(frozen=True, kw_only=True)
class NodalLoadSettings(Settings):
    """Settings of `nodal-load`."""

    elements: int = setting(12, "cubic Hermite elements of equal length", low=1, high=64)
    distribution: str = setting(
        "lever",
        "slider force on the nodes by the lever rule, or as Hermite interpolation distributes it, or lever rule and slider on the chords",
        choices=tuple(_DISTRIBUTIONS),
    )
    stabilization: float = setting(100.0, "rate at which a gap decays (Baumgarte, critically damped)", unit="1/s", low=0.0, high=1e4)
    bending_damping: float = setting(
        3e-6,
        "damping moment over elastic moment per curvature rate, with the lever rule alone, which flutters without",
        unit="s",
        low=0.0,
        high=1e-2,
    )
    tolerance: float = setting(1e-7, "local error of the integration, relative to fixed sizes of the states", low=1e-12, high=1e-4)


class NodalLoadEngine(RivalEngine):
    """The textbook way: with the lever rule, force on the nodes and motion of the slider are not conjugate and make spurious power."""

    name = "nodal-load"
    method = "Hermite elements, slider force shared between two nodes, index-1 form stabilized, exact planar geometry, DOP853"
    default_accuracy = 5e-2
    settings_type = NodalLoadSettings

    def check(self, mechanism: Mechanism) -> None:
        """Refuse a compliant joint besides what no rival can do."""
        super().check(mechanism)
        self.refuse_compliance(mechanism, "gap")

    def model(self, mechanism: Mechanism, settings: Settings) -> "BeamModel":
        """See `BeamEngine.model`; conjugate distributions need no damping, and a rigid follower has no nodes but one multiplier."""
        from reference_model.model import BeamModel

        chosen = own(NodalLoadSettings, settings)
        follower = mechanism.follower
        shapes = no_shapes(follower.length) if follower.is_rigid else hermite_elements(follower.length, chosen.elements)
        damping = chosen.bending_damping if chosen.distribution == "lever" else 0.0
        kind = MULTIPLIER if follower.is_rigid else _DISTRIBUTIONS[chosen.distribution]
        return BeamModel.staying(mechanism, shapes, Treatment(kind=kind, stabilization=chosen.stabilization, bending_damping=damping))

    def shape_count(self, mechanism: Mechanism, settings: Settings) -> int:
        """Two per element."""
        return 2 * own(NodalLoadSettings, settings).elements

    def tolerance(self, settings: Settings) -> float:
        """As the setting says."""
        return own(NodalLoadSettings, settings).tolerance

    def joint_line(self, mechanism: Mechanism, settings: Settings) -> str:
        """Which distribution."""
        return f"slider on the elements (force on two nodes, {own(NodalLoadSettings, settings).distribution})"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> NodalLoadSettings:
        """Number of elements from the measured table."""
        elements, tolerance, _ = next((rung for rung in LADDER if rung[-1] <= accuracy), LADDER[-1])
        return NodalLoadSettings(elements=elements, tolerance=tolerance)

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """Two thirds of the elements (twice as many as a single one); the error factor is that of second order."""
        chosen = own(NodalLoadSettings, settings)
        other = 2 * chosen.elements // 3 or 2 * chosen.elements
        return (Comparison(chosen, chosen.replaced(elements=other), (chosen.elements / other) ** 2.0),)

    def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> NodalLoadSettings | None:
        """The next rung of the ladder."""
        chosen = own(NodalLoadSettings, settings)
        for elements, tolerance, _ in LADDER:
            if elements > chosen.elements:
                return chosen.replaced(elements=elements, tolerance=min(tolerance, chosen.tolerance))
        return None
