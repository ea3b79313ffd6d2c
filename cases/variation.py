"""A scene with a few quantities changed."""

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from quickreturn.engines.base import EngineFailure
from quickreturn.reference_model.mechanism import ImpossibleMechanism, Scene, changed

T = TypeVar("T")
AnyScene = TypeVar("AnyScene", bound=Scene)


@dataclass(frozen=True)
class Variation:
    """Quantities of a scene that get new values, all at once.

    A quantity is named by its place in the scene ("tip.mass"), or by its key where the variation is one of a case file.
    """

    name: str  # in words, what is changed
    given: Mapping[str, Any] = field(default_factory=dict)  # quantity -> new value
    scaled: Mapping[str, float] = field(default_factory=dict, kw_only=True)  # quantity -> factor on the value that it has

    def values(self, value_of: Callable[[str], float]) -> dict[str, Any]:
        """All new values; `value_of` gives the value that a quantity has."""
        return {name: factor * value_of(name) for name, factor in self.scaled.items()} | dict(self.given)

    def of(self, scene: AnyScene) -> AnyScene:
        """A scene with the new values. Raises ImpossibleMechanism as the scene's dataclasses do."""
        return changed(scene, self.values(lambda name: value_at(scene, name)))


def imagined(scene: AnyScene, variations: Iterable[Variation], look: Callable[[AnyScene], T]) -> Iterator[tuple[str, T]]:
    """What `look` finds of each variation of a scene, with its name; those that cannot be, or cannot be simulated, are left out."""
    for variation in variations:
        with contextlib.suppress(EngineFailure, ImpossibleMechanism):
            yield variation.name, look(variation.of(scene))


def value_at(scene: Scene, name: str) -> Any:
    """A quantity by its place in a scene ("crank.drive.torque"); None where the scene has no such part."""
    value: Any = scene
    for part in name.split("."):
        value = getattr(value, part, None)
    return value
