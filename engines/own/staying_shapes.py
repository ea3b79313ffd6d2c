"""What the engines with shapes that stay where they are share: settings, number of shapes, what to compare a run with."""

import math
from dataclasses import dataclass
from typing import ClassVar, Final

from engines.base import Comparison, EstimateOf, Refusal
from engines.follower import FollowerEngine
from engines.own.beam_engine import BeamEngine
from engines.settings import Settings, own, setting
from reference_model.mechanism import Follower, Mechanism
from reference_model.shapes import ShapeSet, clamped_free_modes, hermite_elements, no_shapes


@dataclass(frozen=True, kw_only=True)
class ShapeSettings(Settings):
    """Settings of the engines that take any shapes."""

    shapes: int = setting(12, "number of shapes (with Hermite elements: two per element)", low=1, high=64)
    family: str = setting("clamped-free", "shapes that stay where they are", choices=("clamped-free", "hermite"))
    tolerance: float = setting(1e-7, "local error of the integration, relative to fixed sizes of the states", low=1e-12, high=1e-4)


#: Number of clamped-free modes, integration tolerance and error of the tip deflection in run 24 over 2 s, with the slider eliminated or
#: held by a multiplier: difference from 32 modes plus their own error of 9.4e-5, by the law 3.07 / shapes^3. Tolerances leave 1e-4 of
#: the slider force at most: fewer shapes stand looser ones, an explicit integrator makes high modes ring.
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


def shapes_of(follower: Follower, settings: ShapeSettings) -> ShapeSet:
    """Clamped-free modes or Hermite elements; none for a rigid follower."""
    if follower.is_rigid:
        return no_shapes(follower.length)
    if settings.family == "hermite":
        return hermite_elements(follower.length, max(1, settings.shapes // 2))
    return clamped_free_modes(follower.length, settings.shapes)


class StayingShapesEngine(BeamEngine):
    """An engine with clamped-free modes or Hermite elements."""

    estimates: ClassVar[EstimateOf] = "unverified"

    def shape_count(self, mechanism: Mechanism, settings: Settings) -> int:
        """As set; elements bring two each."""
        return shapes_of(mechanism.follower, own(ShapeSettings, settings)).count

    def tolerance(self, settings: Settings) -> float:
        """As the setting says."""
        return own(ShapeSettings, settings).tolerance

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """Fewer shapes."""
        chosen = own(ShapeSettings, settings)
        shapes, factor = fewer_shapes(chosen.shapes, chosen.family)
        return (Comparison(chosen, chosen.replaced(shapes=shapes), factor),)

    def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> Settings | None:
        """The next rung of the ladder."""
        chosen = own(ShapeSettings, settings)
        for shapes, tolerance, _ in LADDER:
            if shapes > chosen.shapes:
                return chosen.replaced(shapes=shapes, tolerance=min(tolerance, chosen.tolerance))
        return None

    def refuse_compliance(self, mechanism: Mechanism, closes: str) -> None:
        """For methods that leave no gap."""
        slider = mechanism.slider
        if math.isfinite(slider.joint_stiffness) or slider.joint_damping > 0.0:
            raise Refusal(
                f"slider.joint_stiffness: {slider.joint_stiffness:g} N/m with joint_damping {slider.joint_damping:g} N*s/m cannot be"
                f' modelled by {self.name}, which closes the {closes} exactly; accepted: "inf" and "0 N*s/m"'
            )


class RivalEngine(StayingShapesEngine):
    """An engine whose loop is open: the follower's angle is a coordinate of its own, the slider's constraint a force."""

    def check(self, mechanism: Mechanism) -> None:
        """Refuse what a force along the normal cannot do, and parts that the open loop leaves without inertia."""
        slider, crank, follower = mechanism.slider, mechanism.crank, mechanism.follower
        if slider.inertia > 0.0:
            raise Refusal(
                f"slider.inertia: {slider.inertia:g} kg*m^2 cannot be modelled by {self.name}, its joint passes no moment; accepted: 0"
            )
        if mechanism.crank_is_free and mechanism.crank_inertia <= 0.0:
            raise Refusal(
                f"crank.inertia: {crank.inertia:g} kg*m^2 on a crank without mass cannot be modelled by {self.name}, whose open loop leaves"
                " the crank to itself; accepted: above 0, or crank.mass or slider.mass above 0"
            )
        if follower.mass_per_length <= 0.0:
            raise Refusal(
                f"follower.mass_per_length: {follower.mass_per_length:g} kg/m cannot be modelled by {self.name}, whose shapes need mass of"
                " their own; accepted: above 0"
            )

    def follower_alone(self) -> FollowerEngine:
        """Refuse: without a slider there is no constraint to treat."""
        raise Refusal(
            f"[slider]: this scene has no slider and no [crank], and engine {self.name} differs from fixed-shapes in the slider's"
            " constraint alone; use engine fixed-shapes"
        )


def fewer_shapes(shapes: int, family: str) -> tuple[int, float]:
    """Number of shapes of the run to compare with, and how many times the error it has (below 1: a part of it).

    Four fewer by the power 2.5 of their numbers; below eight two fewer, with twice the error at least; below three there is nothing
    coarser to compare with, and two more have half the error at most. Hermite elements have two shapes each: an odd one is not there.

    Args:
        shapes: of the run, 1 or more.
        family: "clamped-free" or "hermite".
    """
    taken = max(2, shapes - shapes % 2) if family == "hermite" else shapes
    if taken >= 8:
        return taken - 4, (taken / (taken - 4.0)) ** 2.5
    return (taken - 2, 2.0) if taken > 2 else (taken + 2, 0.5)
