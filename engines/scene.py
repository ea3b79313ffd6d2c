"""Simulates a scene of either kind from its standard start, and describes what an engine builds for it."""

from collections.abc import Mapping

from quickreturn.engines import accurate
from quickreturn.engines.accurate import Result
from quickreturn.engines.base import AnyEngine, Engine, ModelDescription
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.mechanism import Scene


def simulate_scene(
    engine: AnyEngine,
    scene: Scene,
    duration: float,
    output_step: float,
    settings: Mapping[str, str] | None = None,
    accuracy: float | None = None,
    estimate: bool = True,
    time_limit: float | None = None,
) -> Result:
    """`accurate.simulate` from the scene's standard start.

    Raises:
        ValueError, Refusal, SettingError, EngineFailure: as `accurate.simulate`; Refusal also for a follower alone that it does not model.
    """
    check_scene(engine, scene)
    return accurate.simulate(engine, scene, standard_start(scene), duration, output_step, settings, accuracy, estimate, time_limit)


def describe_scene(engine: AnyEngine, scene: Scene) -> ModelDescription:
    """Describes what the engine builds for a scene with its default settings. Raises Refusal: it cannot model the scene."""
    check_scene(engine, scene)
    return engine.describe(scene, engine.settings_for(engine.default_accuracy, scene))


def check_scene(engine: AnyEngine, scene: Scene) -> None:
    """Refuse a scene that the engine cannot model. An override of `check` gets a follower alone only if the engine names `SPIN_UP`.

    Raises:
        Refusal: a feature of the scene that the engine does not have.
    """
    if scene.crank is None:
        Engine.check(engine, scene)
    engine.check(scene)
