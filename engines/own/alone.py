"""The follower alone in the shapes of this project's own engines."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from quickreturn.engines.base import Engine, FollowerEngine, ModelDescription
from quickreturn.reference_model.mechanism import FollowerAlone

if TYPE_CHECKING:
    from quickreturn.engines.own.simulation import OwnSimulation
    from quickreturn.reference_model.model import BeamModel
    from quickreturn.reference_model.thesis.model import ThesisModel


class OwnAlone(FollowerEngine[Any]):
    """A model without a slider. The engine's table serves: shapes converge faster so, and estimates are too large rather than too small.

    Args:
        engine: the engine whose model it is; its settings have a `tolerance` and a `shape_count`.
        model: scene and settings -> the model.
        kind: of the shapes.
    """

    def __init__(self, engine: Engine[Any], model: "Callable[[FollowerAlone, Any], BeamModel | ThesisModel]", kind: str = "shapes") -> None:
        super().__init__(engine)
        self._model, self._kind = model, kind

    def describe(self, scene: FollowerAlone, settings: Any) -> ModelDescription:
        """Bodies and joints that have terms in the equations."""
        bodies = {
            "base block": scene.base.inertia > 0.0,
            f"follower beam ({settings.shape_count} {self._kind})": True,
            "tip body": scene.tip is not None,
        }
        joints = ("base on the ground (angle prescribed)", "follower clamped to the base")
        return ModelDescription(tuple(name for name, there in bodies.items() if there), joints, settings.shape_count)

    def prepare(self, scene: FollowerAlone, start: None, settings: Any) -> "OwnSimulation":
        from quickreturn.engines.own.simulation import OwnSimulation

        began = time.perf_counter()
        model = self._model(scene, settings)
        return OwnSimulation(model, model.state_at_rest(), settings.tolerance, time.perf_counter() - began)
