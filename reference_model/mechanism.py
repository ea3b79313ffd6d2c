"""The flexible-follower quick-return mechanism as plain, frozen data in SI units; and the follower alone, on a base turned as prescribed.

Geometry (thesis, figure 4.1): the crank turns about O, the follower about P = O + d n1. The slider sits on the crank tip, a crank
length from O, and rides along the follower's centre line. Every part that a scene does not need is absent (`None`) or zero, and
no model may build anything for it.

Each quantity is declared here and nowhere else; case files and `quickreturn show` read the declarations (`scene_values`).

Source of the thesis' values: sections 3.2 and 5.3, tables 3.1, 5.1 and 5.2.
"""

import math
from dataclasses import dataclass, field
from typing import ClassVar, Final, Literal

import numpy as np

from quickreturn.reference_model.drive import balanced_speed
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.quantities import quantity
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.spring import Spring
from quickreturn.reference_model.table import Table
from quickreturn.reference_model.tip import Tip

#: Shortest part of a flexible follower beyond the slider's farthest place, over the follower's length. On a bent follower the slider is
#: farther along than on a straight one; tables of shapes end 1e-5 before the end (`beam.tables`).
LEAST_STUB: Final = 2e-5


@dataclass(frozen=True, kw_only=True)
class TorqueDrive:
    """A constant torque against viscous friction, which without other losses turns the crank at torque / damping (thesis, table 5.2)."""

    torque: float = quantity("N*m", "constant torque of the drive; with damping, a motor's at rest", named=True)
    damping: float = quantity(
        "N*m*s/rad",
        "friction, or what a motor's torque loses with speed: results tell the rest",
        sign="not negative",
    )
    initial_speed: float = quantity("rad/s", "speed at the start; if left out, that without torque", optional=True)

    @property
    def balanced_speed(self) -> float:
        """Speed at which no torque is left, rad/s; infinite where there is none."""
        return self.torque / self.damping if self.damping > 0.0 else math.copysign(math.inf, self.torque)

    @property
    def largest_torque(self) -> float:
        """Largest size of the torque at any speed, N m."""
        return abs(self.torque)


@dataclass(frozen=True, kw_only=True)
class MotorCurve:
    """A motor whose torque on the crank is a function of the crank's speed."""

    torque_table: Table = quantity(  # noqa: RUF009, which takes it for a value that all share
        "N*m", "a CSV file of the torque over the crank's speed, a motor's curve", named=True, in_file=True
    )
    initial_speed: float = quantity("rad/s", "speed at the start; if left out, that without torque", optional=True)
    damping: ClassVar[float] = 0.0

    @property
    def balanced_speed(self) -> float:
        """Speed at which no torque is left and beyond which it opposes the motion, rad/s; infinite where there is none."""
        return balanced_speed(self.torque_table)

    @property
    def largest_torque(self) -> float:
        """Largest size of the torque at any speed of the table, N m."""
        return self.torque_table.largest


@dataclass(frozen=True, kw_only=True)
class PrescribedSpeed:
    """A drive that keeps the crank at this speed, with whatever torque that takes: the crank angle is then no degree of freedom."""

    speed: float = quantity("rad/s", "speed of the crank, whatever it takes", key="prescribed_speed", named=True)
    damping: ClassVar[float] = 0.0

    @property
    def initial_speed(self) -> float:
        """Speed at the start, rad/s: the prescribed one."""
        return self.speed


@dataclass(frozen=True, kw_only=True)
class PrescribedMotion:
    """A drive that moves the crank as a table says, with whatever torque that takes."""

    speed_table: Table = quantity(  # noqa: RUF009
        "rad/s", "a CSV file of the crank's speed over time or its angle", named=True, in_file=True
    )
    begins_at: float  # crank angle at the start, rad
    damping: ClassVar[float] = 0.0

    @property
    def initial_speed(self) -> float:
        """Speed at the start, rad/s."""
        return float(self.speed_table.at(np.array(self.begins_at if self.speed_table.over_turn else 0.0)))


#: What turns the crank.
Drive = TorqueDrive | MotorCurve | PrescribedSpeed | PrescribedMotion


@dataclass(frozen=True, kw_only=True)
class Crank:
    """Rigid arm OC, turning about O; its centre of mass lies on the line from O to the slider."""

    length: float = quantity("m", "from O to the slider; with pivot_distance at most the follower's length", sign="positive")
    drive: Drive
    mass: float = quantity("kg", "mass", sign="not negative", default=0.0, optional=False)
    center_of_mass: float = quantity("m", "centre of mass, from O towards the slider", default=0.0, optional=False)
    inertia: float = quantity("kg*m^2", "about the centre of mass", sign="not negative", default=0.0, optional=False)
    initial_angle: float = quantity("rad", "at the start, counter-clockwise from n1", default=math.pi, optional=False)
    wanted_fluctuation: float | None = quantity(
        "1", "of the speed, (max - min) / mean, for the flywheel's inertia", sign="positive", default=None, moves=False, measured=True
    )

    @property
    def inertia_about_pivot(self) -> float:
        """Moment of inertia about O, kg m^2."""
        return self.inertia + self.mass * self.center_of_mass**2


@dataclass(frozen=True, kw_only=True)
class Base:
    """The block that holds the follower and turns about P."""

    inertia: float = quantity("kg*m^2", "about P", sign="not negative", default=0.0, optional=False)
    damping: float = quantity("N*m*s/rad", "on the follower angle's rate", sign="not negative", default=0.0, optional=False, named=True)
    friction_torque: float = quantity(
        "N*m", "friction of the pivot, of constant size against the follower angle's rate", sign="not negative", default=0.0, named=True
    )
    friction_rate: float = quantity("rad/s", "rate over which that friction changes its sign", sign="positive", default=0.1)


@dataclass(frozen=True, kw_only=True)
class SpinUp:
    """A base whose angle is prescribed: from rest to a steady speed without a jump in acceleration (DERIVATION.md, equation 11.1)."""

    speed: float = quantity("rad/s", "of the base from `spin_up_time` on; 0 holds it", key="spin_up_speed", named=True)
    time: float = quantity("s", "until the base turns steadily", key="spin_up_time", sign="positive")


@dataclass(frozen=True, kw_only=True)
class _Bodies:
    """The parts that a mechanism and a follower alone have in common."""

    base: Base
    follower: Follower
    tip: Tip | None = None
    gravity: tuple[float, float] = quantity("m/s^2", "along n1 and n2, on every body", count=2, default=(0.0, 0.0), named=True)
    spring: Spring | None = None

    @property
    def acting_spring(self) -> Spring | None:
        """The spring, if it has a force."""
        return self.spring if self.spring and self.spring.acts else None

    @property
    def has_gravity(self) -> bool:
        """Whether gravity acts."""
        return self.gravity != (0.0, 0.0)

    @property
    def tip_body(self) -> Tip:
        """The tip; one without mass where there is none."""
        return self.tip or Tip(mass=0.0, inertia=0.0)


@dataclass(frozen=True, kw_only=True)
class Mechanism(_Bodies):
    """One scene: everything a model needs to know, and nothing about how to solve it.

    Raises:
        ImpossibleMechanism: the slider cannot stay on the follower (d + LA > L, with a flexible one d + LA > (1 - `LEAST_STUB`) L), or it
            meets the pivot (LA = d).
    """

    pivot_distance: float = quantity("m", "from O to P", sign="positive")
    crank: Crank
    slider: Slider = field(default_factory=Slider)

    def __post_init__(self) -> None:
        d, crank, length = self.pivot_distance, self.crank.length, self.follower.length
        others = ("mechanism.pivot_distance", "follower.length")
        if math.isclose(crank, d, rel_tol=1e-9):
            raise ImpossibleMechanism(
                "crank.length",
                f"cannot be: a crank as long as mechanism.pivot_distance ({d:.6g} m) brings the slider to the follower's pivot, where the"
                " follower has no direction",
                "with a shorter crank the follower swings to and fro, with a longer one it turns fully",
                others,
            )
        if d + crank > length:
            raise ImpossibleMechanism(
                "crank.length",
                f"cannot be: the slider leaves the follower: pivot_distance + crank.length = {d + crank:.6g} m must not exceed"
                f" follower.length = {length:.6g} m",
                others=others,
            )
        if not self.follower.is_rigid and d + crank > (1.0 - LEAST_STUB) * length:
            raise ImpossibleMechanism(
                "crank.length",
                f"cannot be: the slider reaches the follower's end, and leaves it where the follower bends: pivot_distance + crank.length ="
                f" {d + crank:.7g} m must not exceed {1.0 - LEAST_STUB:g} follower.length = {(1.0 - LEAST_STUB) * length:.7g} m",
                others=others,
            )
        if self.spring is not None:
            self.spring.fit(d, crank, length)

    @property
    def turns_fully(self) -> bool:
        """Whether the follower turns with the crank, which is longer than `pivot_distance` (Whitworth's mechanism), or only swings."""
        return self.crank.length > self.pivot_distance

    @property
    def nearest(self) -> float:
        """Distance (m) of the slider from P with the crank at 0, its least in the rigid mechanism."""
        return abs(self.pivot_distance - self.crank.length)

    @property
    def half_return(self) -> float:
        """Crank angle (rad) on either side of 0 between which the follower returns.

        At its ends crank and follower are square, so that the follower's swing reverses. A follower that turns fully is square to OP
        there: over this half of its turn it is faster than the crank.
        """
        d, crank = self.pivot_distance, self.crank.length
        return math.acos(min(d, crank) / max(d, crank))

    @property
    def crank_is_free(self) -> bool:
        """Whether the crank angle is a degree of freedom."""
        return isinstance(self.crank.drive, TorqueDrive | MotorCurve)

    @property
    def loses_energy(self) -> bool:
        """Whether damping or friction anywhere takes energy from a vibration."""
        base, follower, slider = self.base, self.follower, self.slider
        losses = (
            *(base.damping, base.friction_torque, follower.damping, follower.material_damping, self.crank.drive.damping),
            *(slider.joint_damping, slider.contact_damping, slider.friction, slider.friction_force, self.tip_body.friction_force),
            0.0 if self.spring is None else self.spring.damping,
        )
        return any(loss > 0.0 for loss in losses)

    @property
    def crank_mass(self) -> float:
        """Mass of all that turns with the crank, kg: the crank and the slider."""
        return self.crank.mass + self.slider.mass

    @property
    def crank_inertia(self) -> float:
        """Moment of inertia about O of all that turns with the crank, kg m^2: the crank and the slider's mass."""
        return self.crank.inertia_about_pivot + self.slider.mass * self.crank.length**2

    @property
    def crank_moment(self) -> float:
        """First moment of mass about O of all that turns with the crank, kg m, along the crank."""
        return self.crank.mass * self.crank.center_of_mass + self.slider.mass * self.crank.length


@dataclass(frozen=True, kw_only=True)
class FollowerAlone(_Bodies):
    """A scene without crank and slider: the follower on a base block that turns about O as prescribed.

    At the start the follower lies straight along n1, at rest. Its pivot P is at O. `crank` is None, unlike in a mechanism.

    Raises:
        ImpossibleMechanism: the follower is rigid, so that its whole motion is prescribed; or a force on the tip depends on a crank angle.
    """

    spin_up: SpinUp
    crank: ClassVar[None] = None
    crank_is_free: ClassVar[Literal[False]] = False
    turns_fully: ClassVar[Literal[False]] = False
    pivot_distance: ClassVar[float] = 0.0
    slider: ClassVar[Slider] = Slider()

    def __post_init__(self) -> None:
        if self.follower.is_rigid:
            raise ImpossibleMechanism(
                "follower.bending_stiffness",
                "cannot be: a rigid follower on a base that turns as base.spin_up_speed says leaves nothing to simulate",
                "give a finite stiffness",
                ("base.spin_up_speed", "base.spin_up_time"),
            )
        if self.tip_body.is_forced:
            raise ImpossibleMechanism("tip.force", "acts over a part of the crank's turn, and there is no crank", "leave it out")
        if self.tip_body.friction_force > 0.0:
            raise ImpossibleMechanism("tip.friction_force", "is that of a slide beside the crank, and there is none", "leave it out")
        if self.spring is not None:
            raise ImpossibleMechanism("spring.anchor", "belongs to a machine with a crank", "leave out [spring], or give [crank]")


#: What an engine may be asked to simulate.
Scene = Mechanism | FollowerAlone


def base_motion(speed: float, time: float, t: float) -> tuple[float, float, float]:
    """Angle (rad), rate (rad/s) and acceleration (rad/s^2) of a base that is spun up, equation 11.1; each model compiles it.

    Args:
        speed: steady speed from `time` on, rad/s.
        time: duration of the spin-up, s.
        t: instant, s, not negative.
    """
    if t >= time:
        return speed * (t - 0.5 * time), speed, 0.0
    turn = 2.0 * math.pi / time
    # 1 - cos without cancellation: the start is straight and still
    small = 2.0 * math.sin(0.5 * turn * t) ** 2
    return speed / time * (0.5 * t * t - small / turn**2), speed / time * (t - math.sin(turn * t) / turn), speed / time * small
