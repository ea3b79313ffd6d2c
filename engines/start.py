"""The state in which a simulation begins, in terms that every engine can realise."""

from dataclasses import dataclass
from typing import Protocol, overload

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, Scene


class Field(Protocol):
    """A function of arc length with derivatives, such as scipy's `PPoly` and `CubicSpline`."""

    def __call__(self, x: Array, nu: int = 0, /) -> Array:
        """The nu-th derivative with respect to arc length (nu = 0 .. 2) at the arc lengths x (m, shape (n,)), shape (n,)."""


@dataclass(frozen=True)
class Start:
    """Crank angle and speed, the follower's deflection W(x) along b2 at arc length x and its rate; b1 is the base tangent.

    With the closed loop this determines the state: the slider lies on the centre line, which gives its arc length and the base angle q2,
    and the velocity loop gives their rates. `None` means a straight follower (deflection) that keeps its shape (rate), as in the standard
    start: it then moves as in the rigid mechanism.
    """

    crank_angle: float  # rad
    crank_speed: float  # rad/s
    deflection: Field | None = None  # m, with W(0) = W'(0) = 0
    deflection_rate: Field | None = None  # m/s, at fixed arc length


@overload
def standard_start(scene: Mechanism) -> Start: ...
@overload
def standard_start(scene: Scene) -> Start | None: ...
def standard_start(scene: Scene) -> Start | None:
    """The start of every case: crank at its initial angle and speed, follower straight and moving as the rigid mechanism.

    None for a follower alone: it begins straight and at rest.
    """
    return None if scene.crank is None else Start(scene.crank.initial_angle, scene.crank.drive.initial_speed)
