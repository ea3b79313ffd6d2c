"""A spring with damper and stops between a place of the follower and a fixed point (DERIVATION.md, equations 4.13 and 4.14).

The functions of the law are plain arithmetic: each model compiles them, or calls them as they are.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.quantities import quantity

#: Shortest length of the spring in the rigid mechanism's motion, over the follower's length. At zero it has no direction.
LEAST_LENGTH: Final = 1e-3
#: Length (m) at which a stop that is not given stands.
NOWHERE: Final = 1e300


class SpringLaw(NamedTuple):
    """Constants of the law, with stops where they are not given at zero length and at `NOWHERE`."""

    stiffness: float  # N/m
    rest: float  # m, length at which the force is `preload`
    preload: float  # N
    damping: float  # N s/m
    shortest: float  # m
    longest: float  # m
    stop: float  # N/m
    ramp: float  # m


@dataclass(frozen=True, kw_only=True)
class Spring:
    """Spring, damper and stops from a place of the follower to a fixed point; a positive force pulls the two together."""

    stiffness: float = quantity(
        "N/m", "of the spring, which pulls and pushes", sign="not negative", default=0.0, optional=False, named=True
    )
    anchor: tuple[float, float] = quantity("m", "fixed point, from O along n1 and n2", count=2)
    place: float | None = quantity("m", "arc length from P of its place on the follower, otherwise the end", sign="positive", default=None)
    free_length: float | None = quantity("m", "length at which the spring has no force", sign="positive", default=None)
    preload: float = quantity("N", "force at preload_length, in place of free_length; negative where it pushes", default=0.0, named=True)
    preload_length: float | None = quantity("m", "length at which the force is preload", sign="positive", default=None)
    damping: float = quantity("N*s/m", "of a damper along the spring's line", sign="not negative", default=0.0, named=True)
    shortest: float | None = quantity("m", "length below which a stop pushes, in addition", sign="positive", default=None)
    longest: float | None = quantity("m", "length above which a stop pulls, in addition", sign="positive", default=None)
    stop_stiffness: float = quantity("N/m", "of either stop", sign="not negative", default=0.0, named=True)
    stop_ramp: float = quantity("m", "way into a stop over which its stiffness rises from zero", sign="positive", default=1e-3)

    def __post_init__(self) -> None:
        if self.free_length is not None and (self.preload != 0.0 or self.preload_length is not None):
            other = "preload" if self.preload != 0.0 else "preload_length"
            problem = f"cannot stand together: spring.free_length is the length without force, and spring.{other} gives it one"
            raise ImpossibleMechanism(
                f"spring.{other}", problem, "give free_length, or preload with preload_length", ("spring.free_length",)
            )
        if self.stiffness > 0.0 and self.free_length is None and self.preload_length is None:
            key = "preload_length" if self.preload != 0.0 else "free_length"
            accepted = "give free_length, or preload with preload_length"
            raise ImpossibleMechanism(
                f"spring.{key}", "is missing: a spring with a stiffness needs a length", accepted, ("spring.stiffness",)
            )
        stops = {key: value for key in ("shortest", "longest") if (value := getattr(self, key)) is not None}
        if stops and self.stop_stiffness == 0.0:
            accepted = 'give one, such as "50 N/mm", or no stop'
            raise ImpossibleMechanism(
                f"spring.{next(iter(stops))}", "is a stop without spring.stop_stiffness", accepted, ("spring.stop_stiffness",)
            )
        if self.stop_stiffness > 0.0 and not stops:
            raise ImpossibleMechanism("spring.stop_stiffness", "has no stop to act in", "give spring.shortest, spring.longest or both")
        if len(stops) == 2 and stops["shortest"] >= stops["longest"]:
            problem = f"is not below spring.longest ({stops['longest']:.6g} m)"
            raise ImpossibleMechanism("spring.shortest", problem, "give a smaller length", ("spring.longest",))

    @property
    def acts(self) -> bool:
        """Whether it has any force at all."""
        return any(each != 0.0 for each in (self.stiffness, self.preload, self.damping, self.stop_stiffness))

    @property
    def law(self) -> SpringLaw:
        """The constants of its law."""
        rest = self.free_length if self.preload_length is None else self.preload_length
        stops = self.shortest or 0.0, self.longest or NOWHERE
        return SpringLaw(self.stiffness, rest or 0.0, self.preload, self.damping, *stops, self.stop_stiffness, self.stop_ramp)

    @property
    def in_words(self) -> str:
        """A line that describes it."""
        damper = f", {self.damping:g} N*s/m" if self.damping > 0.0 else ""
        stops = f", stops of {self.stop_stiffness:g} N/m" if self.stop_stiffness > 0.0 else ""
        return f"spring from the follower to a fixed point, {self.stiffness:g} N/m{damper}{stops}"

    def place_on(self, length: float) -> float:
        """Arc length of its place on a follower of this length, m."""
        return length if self.place is None else self.place

    def fit(self, pivot_distance: float, crank_length: float, length: float) -> None:
        """Raise ImpossibleMechanism if its place is not on the follower, or a rigid follower would bring it to its fixed point.

        Args:
            pivot_distance: m.
            crank_length: m; beyond `pivot_distance` the follower turns fully.
            length: of the follower, m.
        """
        place, swing = self.place_on(length), math.asin(crank_length / pivot_distance) if crank_length < pivot_distance else math.pi
        if place > length:
            accepted = f"at most the follower's length of {length:.6g} m is accepted"
            raise ImpossibleMechanism("spring.place", "is not on the follower", accepted, ("follower.length",))
        away = pivot_distance - complex(*self.anchor)  # from the anchor to P: the follower swings about this direction of its own
        nearest = abs(away - cmath.rect(place, min(max(cmath.phase(away), -swing), swing)))
        if nearest < LEAST_LENGTH * length:
            problem = f"lets the spring become {nearest:.3g} m long as the follower swings, where it has no direction"
            accepted = f"at least {LEAST_LENGTH:g} of the follower's length must be left ({LEAST_LENGTH * length:.3g} m)"
            raise ImpossibleMechanism("spring.anchor", problem, accepted, ("spring.place",))


def spring_tension(length: float, rate: float, law: SpringLaw) -> float:
    """Force that pulls the spring's ends together, N (equation 4.13), for its length (m) and the rate of that (m/s)."""
    over, under = max(length - law.longest, 0.0), max(law.shortest - length, 0.0)
    beyond = over + under  # one of the two is zero
    hard = max(beyond - law.ramp, 0.0)
    u = (beyond - hard) / law.ramp
    stopped = math.copysign(law.stop * (hard + law.ramp * u * u * u * (1.0 - 0.5 * u)), over - under)
    return law.preload + law.stiffness * (length - law.rest) + stopped + law.damping * rate


def spring_energy(length: float, law: SpringLaw) -> float:
    """Energy stored in spring and stops at a length (m), J: zero at rest (equation 4.13)."""
    beyond = max(length - law.longest, 0.0) + max(law.shortest - length, 0.0)
    hard, stretched = max(beyond - law.ramp, 0.0), length - law.rest
    u = (beyond - hard) / law.ramp
    stopped = law.ramp * law.ramp * u * u * u * u * (0.25 - 0.1 * u) + 0.5 * hard * (law.ramp + hard)
    return stretched * (law.preload + 0.5 * law.stiffness * stretched) + law.stop * stopped


def spring_stiffness(length: float, law: SpringLaw) -> float:
    """Derivative of the force by the length, N/m (equation 4.13)."""
    beyond = max(length - law.longest, 0.0) + max(law.shortest - length, 0.0)
    u = (beyond - max(beyond - law.ramp, 0.0)) / law.ramp
    return law.stiffness + law.stop * u * u * (3.0 - 2.0 * u)


class Pull(NamedTuple):
    """What a spring does in several rows; arrays (rows,), vectors of the plane as complex numbers."""

    length: Array  # m
    rate: Array  # of the length, m/s
    direction: NDArray[np.complex128]  # from the follower to the fixed point
    tension: Array  # N

    @property
    def force(self) -> NDArray[np.complex128]:
        """On the follower, N."""
        return np.asarray(self.tension * self.direction)


def pull_of(spring: Spring, place: NDArray[np.complex128], velocity: NDArray[np.complex128]) -> Pull:
    """What the spring does where its end on the follower is at `place` (m, from O) and moves at `velocity` (m/s)."""
    away, law = complex(*spring.anchor) - place, spring.law
    length = np.abs(away)
    rate = -(away.conj() * velocity).real / length
    tensions = [spring_tension(*each, law) for each in zip(length.ravel().tolist(), rate.ravel().tolist(), strict=True)]
    return Pull(length, rate, away / length, np.array(tensions).reshape(length.shape))
