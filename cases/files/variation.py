"""A scene with a few quantities changed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.scene_values import AnyScene, changed, value_at


@dataclass(frozen=True)
class Variation:
    """Quantities of a scene, by their keys in a case file, that get new values, all at once."""

    name: str  # the change in words
    given: Mapping[str, Any] = field(default_factory=dict)  # dotted key -> new value, as in `scene_values.Changes`
    scaled: Mapping[str, float] = field(default_factory=dict, kw_only=True)  # dotted key -> factor on the value that it has

    def changes(self, scene: Scene) -> dict[str, Any]:
        """All new values, for a scene."""
        return {path: factor * value_at(scene, path) for path, factor in self.scaled.items()} | dict(self.given)

    def of(self, scene: AnyScene) -> AnyScene:
        """A scene with the new values. ImpossibleMechanism: as `scene_values.changed`."""
        return changed(scene, self.changes(scene))
