"""The same machine in another size: lengths, masses and times multiplied, every other number as its dimension asks."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from quickreturn.cases.files.keys import dimension_of
from quickreturn.cases.files.units import DIMENSIONS
from quickreturn.engines.settings import Settings
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.scene_values import scene_of, values_of
from tests.strategies import Scene as RandomScene


@dataclass(frozen=True)
class Size:
    """Factors of length, mass and time."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    def __str__(self) -> str:
        return f"length {self.length:g}, mass {self.mass:g}, time {self.time:g}"

    def factor(self, exponents: tuple[int, ...]) -> float:
        """Factor of a quantity with these exponents of metre, kilogram and second."""
        return self.length ** exponents[0] * self.mass ** exponents[1] * self.time ** exponents[2]

    def of_unit(self, unit: str) -> float:
        """Factor of a quantity with an SI unit, such as "N*m" or "N m"."""
        return self.factor(DIMENSIONS[unit.replace(" ", "*")].exponents)

    def scene(self, scene: Any) -> Any:
        """The scene in this size. The names of its keys give the dimensions."""

        def scaled(path: str, value: Any) -> Any:
            factor = self.factor(dimension_of(path).exponents)
            return tuple(factor * each for each in value) if isinstance(value, tuple) else factor * value

        values = values_of(scene)
        return scene_of({part: {key: scaled(f"{part}.{key}", value) for key, value in keys.items()} for part, keys in values.items()})

    def random_scene(self, scene: RandomScene) -> RandomScene:
        """A random scene in this size, with its bent start."""
        return replace(
            scene,
            mechanism=self.scene(scene.mechanism),
            bend=scene.bend * self.length,
            bend_rate=scene.bend_rate * self.length / self.time,
            duration=scene.duration * self.time,
        )

    def settings(self, settings: Settings) -> Settings:
        """Settings in this size, by the units with which they are declared."""
        changes = {
            each.name: getattr(settings, each.name) * self.of_unit(unit)
            for each in fields(settings)
            if (unit := each.metadata["unit"]) not in ("", "1/s")
        }
        rates = {each.name: getattr(settings, each.name) / self.time for each in fields(settings) if each.metadata["unit"] == "1/s"}
        return settings.replaced(**changes, **rates)

    def back(self, columns: Mapping[str, Array]) -> dict[str, Array]:
        """Columns of a trajectory in the size of the scene that this one was made from."""
        return {name: values / self.of_unit(COLUMNS[name].unit) for name, values in columns.items()}


def sized(scene: Scene, size: Size) -> Scene:
    """A scene in another size."""
    scaled: Scene = size.scene(scene)
    return scaled
