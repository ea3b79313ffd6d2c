"""The rigid body at the follower's end, and the tool that works there: its force over the crank's turn, and the friction of its slide."""

import math
from dataclasses import dataclass, field
from typing import Final

from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.quantities import quantity

#: Two angles count as one turn apart if their difference misses a turn by no more than this (rad): a file may give few digits.
ROUNDING: Final = 1e-6
_NONE: Final = (0.0, 0.0)
#: Fields of `Tip` that a table stands for, with their defaults.
_IN_PLACE_OF_TABLE: Final = {
    "force": _NONE,
    "force_following": _NONE,
    "force_from": 0.0,
    "force_to": 2.0 * math.pi,
    "force_ramp": math.radians(10.0),
}


@dataclass(frozen=True)
class ForceTable:
    """A force at four crank angles or more, and between two of them a cubic that stays between both (DERIVATION.md, equation 4.11)."""

    angles: tuple[float, ...]  # of the crank, rad, ascending; the first one comes again after the last one, a turn later
    first: tuple[float, ...]  # N, along n1, or along the follower's tangent at its flexible end
    second: tuple[float, ...]  # N, along n2, or along the normal there
    follows: bool = False  # whether the force turns with the follower's end
    file: str = field(default="", compare=False)  # that it comes from; "" if a case file holds it
    text: str = field(default="", compare=False)  # the table as it was written, heading and rows

    def __truediv__(self, size: float) -> "ForceTable":
        """The same force in a unit of `size` newtons."""
        first, second = (tuple(each / size for each in values) for values in (self.first, self.second))
        return ForceTable(self.angles, first, second, self.follows, self.file, self.text)

    def __str__(self) -> str:
        frame = ("along the follower", "along its normal") if self.follows else ("along n1", "along n2")
        ranges = (f"{min(each):.9g} to {max(each):.9g} N {way}" for each, way in zip((self.first, self.second), frame, strict=True))
        return f"{self.file or 'a table'} of {len(self.angles)} points: {', '.join(ranges)}"


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
    force_table: ForceTable | None = quantity(  # noqa: RUF009, which takes it for a value that all share
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
        return self.force_table.follows if self.force_table is not None else self.force_following != _NONE

    @property
    def components(self) -> tuple[float, float]:
        """The force where it acts in full, N, in the frame that `follows` says; of a table zero."""
        return self.force_following if self.follows else self.force

    @property
    def largest_force(self) -> float:
        """Largest size of the force, N; of a table at its points."""
        table = self.force_table
        sizes = [math.hypot(*self.components)] if table is None else map(math.hypot, table.first, table.second)
        return abs(self.force_scale) * max(sizes)

    @property
    def is_forced(self) -> bool:
        """Whether a force acts on it at all."""
        return self.force_scale != 0.0 and (self.force_table is not None or self.components != _NONE)

    @property
    def is_always_forced(self) -> bool:
        """Whether the force acts over the whole turn."""
        return abs(self.force_to - self.force_from - 2.0 * math.pi) <= ROUNDING
