"""The slider on the crank's end: its mass, and the joint that holds it on the follower, with rollers, friction and clearance."""

import math
from dataclasses import dataclass
from typing import Final

from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.quantities import quantity

#: Stiffness (N/m) of a roller without a stiffness of its own in a joint that is not rigid: 1 um per newton, some ten times the deflection
#: that Hertz's theory gives for a steel roller on an aluminium strip. Rigid contact would be a series of impacts.
CONTACT_STIFFNESS: Final = 1e6


@dataclass(frozen=True, kw_only=True)
class Slider:
    """The coupler on the crank's end, with a roller on either side of the follower: massless, rigid and frictionless unless told otherwise.

    The plus roller pushes the follower along its normal n = (-W', ...), the minus roller against it; neither pulls (DERIVATION.md, 5.12).
    """

    mass: float = quantity("kg", "mass", sign="not negative", default=0.0, named=True)
    inertia: float = quantity("kg*m^2", "turns with the follower's tangent at the slider", sign="not negative", default=0.0, named=True)
    joint_stiffness: float = quantity(
        "N/m", "of either roller, along the follower's normal", sign="positive", default=math.inf, infinity=True, named=True
    )
    joint_stiffness_plus: float = quantity(
        "N/m",
        "of the roller that pushes the follower along +n (slider_force > 0)",
        sign="positive",
        default=math.inf,
        infinity=True,
        named=True,
    )
    joint_stiffness_minus: float = quantity(
        "N/m", "of the roller that pushes it along -n", sign="positive", default=math.inf, infinity=True, named=True
    )
    joint_damping: float = quantity(
        "N*s/m", "along the follower's normal, whether a roller touches or not", sign="not negative", default=0.0, named=True
    )
    clearance: float = quantity(
        "m", "free travel between the rollers, half of it on either side", sign="not negative", default=0.0, named=True
    )
    preload: float = quantity("N", "force of both rollers at rest", sign="not negative", default=0.0, named=True)
    contact_damping: float = quantity(
        "s/m",
        "loss c of a roller's force k x (1 + c dx/dt) (Hunt and Crossley)",
        sign="not negative",
        default=0.0,
        named=True,
    )
    friction: float = quantity(
        "1", "friction along the follower over the normal force (Coulomb)", sign="not negative", default=0.0, named=True
    )
    friction_force: float = quantity(
        "N", "friction along the follower whatever the normal force, as of preloaded rollers", sign="not negative", default=0.0, named=True
    )
    friction_speed: float = quantity("m/s", "sliding speed over which friction changes its sign", sign="positive", default=0.02)

    def __post_init__(self) -> None:
        if self.clearance > 0.0 and self.preload > 0.0:
            raise ImpossibleMechanism(
                "slider.clearance", f"conflicts with slider.preload ({self.preload:.6g} N)", "give one of them", ("slider.preload",)
            )
        for key in ("joint_stiffness_plus", "joint_stiffness_minus"):
            if math.isfinite(getattr(self, key)) and math.isfinite(self.joint_stiffness):
                problem = f"conflicts with slider.joint_stiffness ({self.joint_stiffness:.6g} N/m), which is that of both rollers"
                raise ImpossibleMechanism(f"slider.{key}", problem, "give that alone, or one for each side", ("slider.joint_stiffness",))
        for key in ("joint_damping", "contact_damping", "preload"):
            if getattr(self, key) > 0.0 and self.is_rigid:
                raise ImpossibleMechanism(
                    f"slider.{key}",
                    "acts on a joint that gives way, and this one is rigid",
                    f'give a finite slider.joint_stiffness such as "2e4 N/m", or no slider.{key}',
                    ("slider.joint_stiffness",),
                )

    @property
    def is_rigid(self) -> bool:
        """Whether the slider never leaves the centre line."""
        given = (self.joint_stiffness, self.joint_stiffness_plus, self.joint_stiffness_minus)
        return self.clearance == 0.0 and all(math.isinf(stiffness) for stiffness in given)

    @property
    def is_linear(self) -> bool:
        """Whether the joint is one linear spring: of equal stiffness on both sides, without clearance, preload and contact damping."""
        return not self.is_rigid and len({*self.sides}) == 1 and self.clearance == self.preload == self.contact_damping == 0.0

    @property
    def has_corners(self) -> bool:
        """Whether rollers touch and part, or differ: the joint's force is then no smooth function of the gap."""
        return not (self.is_rigid or self.is_linear)

    @property
    def has_friction(self) -> bool:
        """Whether a force acts along the follower."""
        return self.friction > 0.0 or self.friction_force > 0.0

    @property
    def sides(self) -> tuple[float, float]:
        """Stiffness (N/m) of the plus and of the minus roller; both infinite for a rigid joint, else both finite."""
        if self.is_rigid:
            return math.inf, math.inf
        given = (min(self.joint_stiffness, side) for side in (self.joint_stiffness_plus, self.joint_stiffness_minus))
        plus, minus = (CONTACT_STIFFNESS if math.isinf(stiffness) else stiffness for stiffness in given)
        return plus, minus

    @property
    def closed_stiffness(self) -> float:
        """Stiffness (N/m) of small vibrations about contact: of both rollers where they are preloaded, else of the plus roller."""
        plus, minus = self.sides
        return plus + minus if self.preload > 0.0 else plus
