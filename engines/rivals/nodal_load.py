"""The engine `nodal-load`: standard finite elements with fixed nodes, the slider force shared between two of them (Buchanan)."""

from dataclasses import dataclass
from typing import Final

from engines.base import Comparison
from engines.rivals.rival import RivalEngine, RivalSettings
from engines.settings import Settings, setting
from reference_model.constraints.joint import BOTH_LINEAR, CONSISTENT, LEVER, Joint
from reference_model.constraints.nodal_load import nodal_load
from reference_model.mechanism import Mechanism
from reference_model.shapes import ShapeSet, hermite_elements, no_shapes

_DISTRIBUTIONS: Final = {"lever": LEVER, "consistent": CONSISTENT, "both linear": BOTH_LINEAR}


@dataclass(frozen=True, kw_only=True)
class NodalLoadSettings(RivalSettings):
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


class NodalLoadEngine(RivalEngine):
    """The textbook way: with the lever rule, force on the nodes and motion of the slider are not conjugate and make spurious power."""

    name = "nodal-load"
    method = "Hermite elements, slider force shared between two nodes, index-1 form stabilized, exact planar geometry, DOP853"
    default_accuracy = 5e-2
    settings_type = NodalLoadSettings

    def check(self, mechanism: Mechanism) -> None:
        """Refuse a compliant joint besides what no rival can do."""
        super().check(mechanism)
        self.refuse_compliance(mechanism)

    def shapes(self, mechanism: Mechanism, settings: Settings) -> ShapeSet:
        """Cubic Hermite elements; none for a rigid follower."""
        length = mechanism.follower.length
        return no_shapes(length) if mechanism.follower.is_rigid else hermite_elements(length, _own(settings).elements)

    def joint(self, mechanism: Mechanism, settings: Settings) -> Joint:
        """The distribution with its stabilization; conjugate ones need no damping."""
        own = _own(settings)
        damping = own.bending_damping if own.distribution == "lever" else 0.0
        return nodal_load(_DISTRIBUTIONS[own.distribution], own.stabilization, damping)

    def joint_line(self, mechanism: Mechanism, settings: Settings) -> str:
        """Which distribution."""
        return f"slider on the elements (force on two nodes, {_own(settings).distribution})"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> NodalLoadSettings:
        """Number of elements from the measured table."""
        for rung in LADDER:
            if rung[-1] <= accuracy:
                break
        elements, tolerance, _ = rung
        return NodalLoadSettings(elements=elements, tolerance=tolerance)

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """Two thirds of the elements (twice as many as a single one); the error factor is that of second order."""
        own = _own(settings)
        other = 2 * own.elements // 3 or 2 * own.elements
        return (Comparison(own, own.replaced(elements=other), (own.elements / other) ** 2.0),)

    def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> NodalLoadSettings | None:
        """The next rung of the ladder."""
        own = _own(settings)
        for elements, tolerance, _ in LADDER:
            if elements > own.elements:
                return own.replaced(elements=elements, tolerance=min(tolerance, own.tolerance))
        return None


#: Elements, integration tolerance and error of the tip deflection in run 24 over 2 s against `reference` with 9 modes, lever rule.
LADDER: Final = ((6, 1e-7, 2.3e-1), (8, 1e-7, 1.2e-1), (12, 1e-7, 3.7e-2), (16, 1e-7, 2.6e-2), (24, 1e-7, 1.4e-2))


def _own(settings: Settings) -> NodalLoadSettings:
    if not isinstance(settings, NodalLoadSettings):
        raise TypeError("not settings of the engine nodal-load")
    return settings
