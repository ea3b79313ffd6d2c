"""Units of length, mass and time near a scene's own sizes, in which an engine whose library has absolute thresholds computes.

A library that takes a mass below 1e-15 for none, or a residual below 1e-8 for zero, gives a small machine another motion than the same
machine built large. In units of the scene's own every machine has sizes near one, whatever its size in SI. The units are powers of two:
numbers then change their exponents and no digit.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, Final, Self, TypeVar

from quickreturn.engines.start import Field, Start
from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.quantities import quantities_of
from quickreturn.reference_model.scene_values import Changes, changed
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.table import Table

_Scene = TypeVar("_Scene", bound=Scene)
_FACTOR: Final = re.compile(r"([*/ ]?)([A-Za-z]+|1)(?:\^(\d+))?")
#: Unit -> exponents of length, mass and time.
_EXPONENTS: Final[Mapping[str, tuple[int, int, int]]] = {
    "1": (0, 0, 0),
    "rad": (0, 0, 0),
    "m": (1, 0, 0),
    "kg": (0, 1, 0),
    "s": (0, 0, 1),
    "N": (1, 1, -2),
    "J": (2, 1, -2),
    "Pa": (-1, 1, -2),
}


@dataclass(frozen=True, kw_only=True)
class Units:
    """Sizes of the units of length (m), mass (kg) and time (s)."""

    length: float
    mass: float
    time: float

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """The powers of two next to the follower's length and mass and to the shortest time of its slow motion.

        That time is what the crank or base takes to turn by a radian, or the reciprocal of (EI / rhoA)^(1/2) / L^2, about a quarter of a
        cantilever's lowest angular frequency.
        """
        follower, times = scene.follower, list[float]()
        if scene.crank is None:
            times.append(scene.spin_up.time)
        elif scene.crank.drive.initial_speed != 0.0:
            times.append(1.0 / abs(scene.crank.drive.initial_speed))
        if not follower.is_rigid:
            times.append(follower.length**2 * math.sqrt(follower.mass_per_length / follower.bending_stiffness))
        return cls(length=_power_of_two(follower.length), mass=_power_of_two(follower.mass), time=_power_of_two(min(times, default=1.0)))

    def size(self, unit: str) -> float:
        """SI size of the unit that stands for an SI unit, such as "N*m*s/rad" or "m/s^2"."""
        size = 1.0
        for sign, name, power in _FACTOR.findall(unit):
            length, mass, time = _EXPONENTS[name]
            factor = self.length**length * self.mass**mass * self.time**time
            size *= factor ** (int(power or 1) * (-1 if sign == "/" else 1))
        return size

    def scene(self, scene: _Scene) -> _Scene:
        """A scene's numbers in these units."""
        if isinstance(scene, Mechanism) and not scene.slider.is_rigid:  # its stiffest roller may be a constant of the law, in SI
            scene = changed(scene, _both_sides(scene.slider))
        converted: _Scene = self._part(scene)
        return converted

    def start(self, start: Start) -> Start:
        """A start's numbers in these units."""
        bend, rate = start.deflection, start.deflection_rate
        return replace(
            start,
            crank_speed=start.crank_speed * self.time,
            deflection=bend and _Scaled(bend, self.length, self.length),
            deflection_rate=rate and _Scaled(rate, self.length, self.length / self.time),
        )

    def columns_in_si(self, columns: Columns) -> Columns:
        """Columns of a trajectory in SI that are given in these units."""
        return {name: values * self.size(COLUMNS[name].unit) for name, values in columns.items()}

    def _part(self, part: Any) -> Any:
        """A part of a scene, with its own parts, in these units."""
        values = {name: self._value(getattr(part, name), declared.unit) for name, _, declared in quantities_of(part)}
        parts = {field.name: self._part(each) for field in fields(part) if is_dataclass(each := getattr(part, field.name))}
        return replace(part, **(parts | values))  # a table is a value, which `_value` converts

    def _value(self, value: Any, unit: str) -> Any:
        if value is None:
            return None
        if isinstance(value, Table):
            return value.in_units(self.size)
        return tuple(each / self.size(unit) for each in value) if isinstance(value, tuple) else value / self.size(unit)


@dataclass(frozen=True)
class _Scaled:
    """A field of arc lengths in other units."""

    field: Field
    length: float  # m
    size: float  # SI size of a unit of its values

    def __call__(self, x: Array, nu: int = 0, /) -> Array:
        return self.field(x * self.length, nu) * (self.length**nu / self.size)


def _power_of_two(size: float) -> float:
    return math.ldexp(1.0, math.frexp(size)[1])


def _both_sides(slider: Slider) -> Changes:
    plus, minus = slider.sides
    return {"slider.joint_stiffness": math.inf, "slider.joint_stiffness_plus": plus, "slider.joint_stiffness_minus": minus}
