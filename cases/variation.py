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

    A quantity is named by its place in the scene ("tip.mass"), or by its key if the variation is one of a case file.
    """

    name: str  # the change in words
    given: Mapping[str, Any] = field(default_factory=dict)  # quantity -> new value
    scaled: Mapping[str, float] = field(default_factory=dict, kw_only=True)  # quantity -> factor on the value that it has

    def values(self, value_of: Callable[[str], float]) -> dict[str, Any]:
        """All new values; `value_of` gives the present value of a quantity."""
        return {name: factor * value_of(name) for name, factor in self.scaled.items()} | dict(self.given)

    def of(self, scene: AnyScene) -> AnyScene:
        """A scene with the new values. Raises ImpossibleMechanism as the scene's dataclasses do."""
        return changed(scene, self.values(lambda name: value_at(scene, name)))


def possible_results(scene: AnyScene, variations: Iterable[Variation], result_of: Callable[[AnyScene], T]) -> Iterator[tuple[str, T]]:
    """The name and the result of each variation of a scene; variations that are impossible or cannot be simulated are left out."""
    for variation in variations:
        with contextlib.suppress(EngineFailure, ImpossibleMechanism):
            yield variation.name, result_of(variation.of(scene))


def value_at(scene: Scene, name: str) -> Any:
    """A quantity by its place in a scene ("crank.drive.torque"); None if the scene has no such part."""
    value: Any = scene
    for part in name.split("."):
        value = getattr(value, part, None)
    return value
