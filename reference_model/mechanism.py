"""The flexible-follower quick-return mechanism as plain, frozen data in SI units; and the follower alone, on a base turned as prescribed.

Geometry (thesis, figure 4.1): the crank turns about O, the follower about P = O + d n1. The slider sits on the crank tip, a crank
length from O, and rides along the follower's centre line. Every part that a scene does not need is absent (`None`) or zero, and
no model may build anything for it.

Source of the thesis' values: sections 3.2 and 5.3, tables 3.1, 5.1 and 5.2.
"""

import math
from dataclasses import dataclass, field


class ImpossibleMechanism(ValueError):
    """The parts do not fit together. `key` names the offending quantity as `part.quantity`."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key
        self.message = message


@dataclass(frozen=True, kw_only=True)
class TorqueDrive:
    """A motor of constant torque against viscous friction; its mean speed is torque / damping (thesis, table 5.2)."""

    torque: float  # N m
    damping: float  # N m s/rad, on the crank's rate
    initial_speed: float  # rad/s


@dataclass(frozen=True, kw_only=True)
class PrescribedSpeed:
    """The crank turns at this speed whatever it takes: the crank angle is then no degree of freedom."""

    speed: float  # rad/s

    @property
    def initial_speed(self) -> float:
        """Speed at the start, rad/s: the prescribed one."""
        return self.speed


@dataclass(frozen=True, kw_only=True)
class Crank:
    """Rigid arm OC, turning about O; its centre of mass lies on the line from O to the slider."""

    length: float  # m, from O to the slider
    drive: TorqueDrive | PrescribedSpeed
    mass: float = 0.0  # kg
    center_of_mass: float = 0.0  # m, from O
    inertia: float = 0.0  # kg m^2, about the centre of mass
    initial_angle: float = math.pi  # rad, counter-clockwise from n1

    @property
    def inertia_about_pivot(self) -> float:
        """Moment of inertia about O, kg m^2."""
        return self.inertia + self.mass * self.center_of_mass**2


@dataclass(frozen=True, kw_only=True)
class Base:
    """The block that holds the follower and turns about P."""

    inertia: float = 0.0  # kg m^2, about P
    damping: float = 0.0  # N m s/rad, on the follower angle's rate


@dataclass(frozen=True, kw_only=True)
class SpinUp:
    """A base whose angle is prescribed: from rest to a steady speed without a jump in acceleration (DERIVATION.md, equation 11.1)."""

    speed: float  # rad/s, from `time` on; 0 holds the base
    time: float  # s, above 0


@dataclass(frozen=True, kw_only=True)
class Follower:
    """Uniform, inextensible, unshearable beam from P to the tip; bends about the thin side of its section."""

    length: float  # m
    mass_per_length: float  # kg/m
    bending_stiffness: float  # N m^2, math.inf for a rigid follower
    thickness: float  # m, in the plane of bending
    width: float  # m, out of the plane
    damping: float = 0.0  # N s/m^2, per unit length, on the centre line's velocity relative to the base frame
    strain_gauges: tuple[float, float, float] = (math.nan, math.nan, math.nan)  # m, arc lengths from P

    @property
    def is_rigid(self) -> bool:
        """Whether the follower has no flexible coordinate at all."""
        return math.isinf(self.bending_stiffness)

    @property
    def axial_stiffness(self) -> float:
        """EA in N from EI and the rectangular section, EA = EI A / I = 12 EI / thickness^2. For models that can stretch."""
        return 12.0 * self.bending_stiffness / self.thickness**2


@dataclass(frozen=True, kw_only=True)
class Tip:
    """Rigid body clamped to the follower's end."""

    mass: float  # kg
    inertia: float  # kg m^2, about its centre of mass
    center_of_mass: float = 0.0  # m, beyond the flexible end, along the end's tangent


@dataclass(frozen=True, kw_only=True)
class Slider:
    """What the coupler is besides a frictionless point contact. The default is exactly that: massless, rigid."""

    mass: float = 0.0  # kg
    inertia: float = 0.0  # kg m^2, turns with the follower's tangent at the slider
    joint_stiffness: float = math.inf  # N/m, along the follower's normal
    joint_damping: float = 0.0  # N s/m, along the follower's normal


@dataclass(frozen=True, kw_only=True)
class Mechanism:
    """One scene: everything a model needs to know, and nothing about how to solve it.

    Raises:
        ImpossibleMechanism: the slider cannot stay on the follower (d + LA > L) or the crank reaches the pivot (LA >= d).
    """

    pivot_distance: float  # m, d
    crank: Crank
    base: Base
    follower: Follower
    tip: Tip | None = None
    slider: Slider = field(default_factory=Slider)
    gravity: tuple[float, float] = (0.0, 0.0)  # m/s^2, along n1 and n2, on every body

    def __post_init__(self) -> None:
        d, crank, length = self.pivot_distance, self.crank.length, self.follower.length
        if crank >= d:
            raise ImpossibleMechanism(
                "crank.length", f"the crank ({crank:.6g} m) must be shorter than mechanism.pivot_distance ({d:.6g} m)"
            )
        if d + crank > length:
            raise ImpossibleMechanism(
                "crank.length",
                f"the slider leaves the follower: pivot_distance + crank.length = {d + crank:.6g} m must not exceed"
                f" follower.length = {length:.6g} m",
            )

    @property
    def has_gravity(self) -> bool:
        """Whether any gravity term exists."""
        return self.gravity != (0.0, 0.0)

    @property
    def crank_is_free(self) -> bool:
        """Whether the crank angle is a degree of freedom."""
        return isinstance(self.crank.drive, TorqueDrive)


@dataclass(frozen=True, kw_only=True)
class FollowerAlone:
    """A scene without crank and slider: the follower on a base block that turns about O as prescribed.

    At the start the follower lies straight along n1, at rest.

    Raises:
        ImpossibleMechanism: a rigid follower, whose motion is prescribed as a whole.
    """

    spin_up: SpinUp
    base: Base
    follower: Follower
    tip: Tip | None = None
    gravity: tuple[float, float] = (0.0, 0.0)  # m/s^2, along n1 and n2, on every body

    def __post_init__(self) -> None:
        if self.follower.is_rigid:
            raise ImpossibleMechanism(
                "follower.bending_stiffness",
                "a rigid follower on a base that turns as base.spin_up_speed says leaves nothing to simulate; give a finite stiffness",
            )

    @property
    def has_gravity(self) -> bool:
        """Whether any gravity term exists."""
        return self.gravity != (0.0, 0.0)


#: What an engine may be asked to simulate.
Scene = Mechanism | FollowerAlone
