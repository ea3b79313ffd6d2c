"""Simulating a scene of either kind from its standard start, and what an engine builds for it."""

from collections.abc import Mapping

from engines import accurate
from engines.accurate import Result
from engines.base import AnyEngine, ModelDescription
from engines.start import standard_start
from reference_model.mechanism import FollowerAlone, Scene


def simulate_scene(
    engine: AnyEngine,
    scene: Scene,
    duration: float,
    output_step: float,
    settings: Mapping[str, str] | None = None,
    accuracy: float | None = None,
) -> Result:
    """`accurate.simulate` from the standard start: the mechanism's, or the follower straight and at rest.

    Raises:
        Refusal, SettingError, EngineFailure: as `accurate.simulate`; Refusal also where the engine has no model of a follower alone.
    """
    if isinstance(scene, FollowerAlone):
        return accurate.simulate(engine.follower_alone(), scene, None, duration, output_step, settings, accuracy)
    return accurate.simulate(engine, scene, standard_start(scene), duration, output_step, settings, accuracy)


def describe_scene(engine: AnyEngine, scene: Scene) -> ModelDescription:
    """What the engine builds for a scene with its default settings.

    Raises:
        Refusal: it cannot.
    """
    if isinstance(scene, FollowerAlone):
        follower = engine.follower_alone()
        follower.check(scene)
        return follower.describe(scene, follower.settings_for(follower.default_accuracy, scene))
    engine.check(scene)
    return engine.describe(scene, engine.settings_for(engine.default_accuracy, scene))
