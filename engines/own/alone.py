"""The follower alone in the shapes of this project's own engines."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from engines.base import Comparison, Engine, ModelDescription
from engines.follower import FollowerEngine, parts
from reference_model.mechanism import FollowerAlone

if TYPE_CHECKING:
    from engines.own.simulation import OwnSimulation
    from reference_model.model import BeamModel
    from reference_model.thesis.model import ThesisModel


class OwnAlone(FollowerEngine[Any]):
    """A model without a slider: settings and comparisons are the engine's, which takes any scene for them.

    Args:
        engine: the engine whose model it is; its settings have a `tolerance`.
        shapes: settings -> number and kind of the shapes, "5 clamped modes".
        model: scene and settings -> the model.
    """

    def __init__(
        self,
        engine: Engine[Any],
        shapes: Callable[[Any], tuple[int, str]],
        model: "Callable[[FollowerAlone, Any], BeamModel | ThesisModel]",
    ) -> None:
        super().__init__(engine)
        self._shapes, self._model = shapes, model

    def describe(self, scene: FollowerAlone, settings: Any) -> ModelDescription:
        """Bodies and joints that have terms in the equations."""
        count, kind = self._shapes(settings)
        return ModelDescription(*parts(scene, f"follower beam ({count} {kind})"), count)

    def settings_for(self, accuracy: float, scene: FollowerAlone) -> Any:
        """The engine's table: shapes converge faster without a slider."""
        return self.engine.settings_for(accuracy, scene)  # type: ignore[arg-type]

    def comparisons(self, settings: Any, scene: FollowerAlone, output_step: float) -> tuple[Comparison, ...]:
        """As with the mechanism: the estimate is too large rather than too small."""
        return self.engine.comparisons(settings, scene, output_step)  # type: ignore[arg-type]

    def prepare(self, scene: FollowerAlone, start: None, settings: Any) -> "OwnSimulation":
        """See `FollowerEngine.prepare`."""
        from engines.own.simulation import OwnSimulation

        began = time.perf_counter()
        model = self._model(scene, settings)
        return OwnSimulation(model, model.state_at_rest(), settings.tolerance, time.perf_counter() - began)
