"""The rigid body at the follower's end, and the tool that works there: its force over the crank's turn, and the friction of its slide."""

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.quantities import quantity
from quickreturn.reference_model.table import ROUNDING, Table, pieces

_NONE: Final = (0.0, 0.0)
#: Columns of a table of the force in the fixed frame, and of one that turns with the follower's end.
FIXED: Final = ("crank_angle", "force_n1", "force_n2")
FOLLOWING: Final = ("crank_angle", "force_along", "force_normal")
#: Fields of `Tip` that a table stands for, with their defaults.
_IN_PLACE_OF_TABLE: Final = {
    "force": _NONE,
    "force_following": _NONE,
    "force_from": 0.0,
    "force_to": 2.0 * math.pi,
    "force_ramp": math.radians(10.0),
}


@dataclass(frozen=True, kw_only=True)
class Tip:
    """Rigid body clamped to the follower's end, and a force there, as of a tool that cuts over a part of the crank's turn.

    The force keeps its direction in the fixed frame, or turns with the follower's end. It comes and goes over `force_ramp` of the crank's
    angle, twice continuously differentiable (DERIVATION.md, equation 4.9); over the whole turn it is constant. Or a table gives it.
    """

    mass: float = quantity("kg", "mass", sign="not negative")
    inertia: float = quantity("kg*m^2", "about its centre of mass", sign="not negative")
    center_of_mass: float = quantity("m", "beyond the flexible end, along the end's tangent", default=0.0, named=True)
    force: tuple[float, float] = quantity("N", "on the flexible end, along n1 and n2", count=2, default=_NONE, named=True)
    force_following: tuple[float, float] = quantity(
        "N", "in place of force: along the flexible end's tangent and its normal, turning with them", count=2, default=_NONE, named=True
    )
    force_from: float = quantity("rad", "crank angle at which the force begins", default=0.0)
    force_to: float = quantity("rad", "crank angle at which it ends; at most a turn later", default=2.0 * math.pi)
    force_ramp: float = quantity("rad", "crank angle over which it comes and goes", sign="positive", default=math.radians(10.0))
    force_table: Table | None = quantity(  # noqa: RUF009, which takes it for a value that all share
        "N", "in place of all these: a CSV file of the force over a turn of the crank", default=None, named=True, in_file=True
    )
    force_scale: float = quantity("1", "factor on the force, however it is given", default=1.0)
    friction_force: float = quantity(
        "N",
        "friction of the tool's slide, of constant size against the tip's velocity",
        sign="not negative",
        default=0.0,
        named=True,
    )
    friction_speed: float = quantity("m/s", "speed over which that friction changes its sign", sign="positive", default=0.02)

    def __post_init__(self) -> None:
        if self.force_table is not None:
            self._refuse_beside("force_table", *(key for key, default in _IN_PLACE_OF_TABLE.items() if getattr(self, key) != default))
        elif self.force != _NONE and self.force_following != _NONE:
            self._refuse_beside("force_following", "force")
        span = self.force_to - self.force_from
        if not self.is_always_forced and not 2.0 * self.force_ramp <= span <= 2.0 * math.pi:
            raise ImpossibleMechanism(
                "tip.force_to",
                f"lets the force act over {math.degrees(span):.6g} deg of the crank's turn",
                f"from twice force_ramp ({math.degrees(2.0 * self.force_ramp):.6g} deg) to 360 deg are accepted",
                ("tip.force_from", "tip.force_ramp"),
            )

    def _refuse_beside(self, key: str, *others: str) -> None:
        if others:
            raise ImpossibleMechanism(f"tip.{key}", f"conflicts with tip.{others[0]}", "give one of them", (f"tip.{others[0]}",))

    @property
    def follows(self) -> bool:
        """Whether the force turns with the follower's end."""
        return self.force_table.names == FOLLOWING if self.force_table is not None else self.force_following != _NONE

    @property
    def components(self) -> tuple[float, float]:
        """The force where it acts in full, N, in the frame that `follows` says; of a table zero."""
        return self.force_following if self.follows else self.force

    @property
    def largest_force(self) -> float:
        """Largest size of the force, N; of a table at its points."""
        return abs(self.force_scale) * (math.hypot(*self.components) if self.force_table is None else self.force_table.largest)

    @property
    def is_forced(self) -> bool:
        """Whether a force acts on it at all."""
        return self.force_scale != 0.0 and (self.force_table is not None or self.components != _NONE)

    @property
    def is_always_forced(self) -> bool:
        """Whether the force acts over the whole turn."""
        return abs(self.force_to - self.force_from - 2.0 * math.pi) <= ROUNDING


#: Smallest part of the turn (rad) that counts as the whole turn, over which the force is constant.
WHOLE: Final = 2.0 * math.pi - ROUNDING
#: Part of `friction_speed` below which the direction of a velocity does not matter: the friction is then zero to twelve digits.
STILL: Final = 1e-12


def tool_force(
    crank_angle: float, first: float, second: float, begin: float, span: float, ramp: float, table: Array
) -> tuple[float, float, float]:
    """Fraction of the force that acts at a crank angle, and the force in full, N, in its frame; each model compiles it.

    The fraction rises and falls by a polynomial and is twice continuously differentiable. A table acts in full; its force is continuously
    differentiable.

    Args:
        crank_angle: rad.
        first: constant force, N, along the first axis of its frame.
        second: along the second.
        begin: crank angle at which the force, or the table, begins, rad.
        span: crank angle over which it acts, rad.
        ramp: crank angle over which it rises, and over which it falls, rad.
        table: see `tool_constants`; without rows for a constant force.
    """
    if len(table) == 0 and span >= WHOLE:
        return 1.0, first, second
    turned = (crank_angle - begin) % (2.0 * math.pi)
    if len(table) > 0:
        piece = table[np.searchsorted(table[:, 0], turned, side="right") - 1]
        u = turned - piece[0]
        first = ((piece[1] * u + piece[2]) * u + piece[3]) * u + piece[4]
        return 1.0, first, ((piece[5] * u + piece[6]) * u + piece[7]) * u + piece[8]
    u = min(turned, span - turned) / ramp
    if u >= 1.0:
        return 1.0, first, second
    return u * u * u * (10.0 + u * (6.0 * u - 15.0)) if u > 0.0 else 0.0, first, second


def tool_constants(tip: Tip) -> dict[str, Any]:
    """The constants of the force for the equations of motion, by their symbols: N and rad.

    `force_table`, shape (points, 9), has the angle of each point from the first one, and for either component the coefficients of the
    cubic behind it by powers of the angle from there, the third power first; (0, 9) without a table.
    """
    table = tip.force_table
    return {
        "force_1": tip.force_scale * tip.components[0],
        "force_2": tip.force_scale * tip.components[1],
        "force_begin": tip.force_from if table is None else table.points[0],
        "force_span": tip.force_to - tip.force_from,
        "force_ramp": tip.force_ramp,
        "force_table": np.zeros((0, 9)) if table is None else pieces(table, tip.force_scale),
    }


def tip_force(tip: Tip, crank_angle: Array, end_angle: Array | float) -> NDArray[np.complex128]:
    """The force of the tool in the fixed frame, N, along n1 + i n2; shape as the angles.

    Args:
        tip: says what acts.
        crank_angle: rad.
        end_angle: of the follower's tangent at its flexible end, from n1, rad.
    """
    if not tip.is_forced:
        return np.zeros(np.shape(crank_angle), dtype=np.complex128)
    given = tool_constants(tip).values()
    at = np.array([tool_force(angle, *given) for angle in np.ravel(crank_angle)]).reshape(*np.shape(crank_angle), 3)
    force = at[..., 0] * (at[..., 1] + 1j * at[..., 2])
    return np.asarray(np.exp(1j * np.asarray(end_angle)) * force if tip.follows else force)


def slide_friction(tip: Tip, velocity: NDArray[Any]) -> NDArray[np.complex128]:
    """Friction on the tip that moves at a velocity (m/s, along n1 + i n2), N, likewise (equation 4.12)."""
    speed = np.abs(velocity) + STILL * tip.friction_speed
    return np.asarray(-tip.friction_force * np.tanh(speed / tip.friction_speed) / speed * velocity)
