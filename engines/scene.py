"""Simulating a scene of either kind from its standard start, and what an engine builds for it."""

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
    """`accurate.simulate` from the standard start: the mechanism's, or the follower straight and at rest.

    Raises:
        ValueError, Refusal, SettingError, EngineFailure: as `accurate.simulate`; Refusal also where the engine has no model of a follower
            alone.
    """
    check_scene(engine, scene)
    return accurate.simulate(engine, scene, standard_start(scene), duration, output_step, settings, accuracy, estimate, time_limit)


def describe_scene(engine: AnyEngine, scene: Scene) -> ModelDescription:
    """What the engine builds for a scene with its default settings. Refusal: it cannot."""
    check_scene(engine, scene)
    return engine.describe(scene, engine.settings_for(engine.default_accuracy, scene))


def check_scene(engine: AnyEngine, scene: Scene) -> None:
    """Refuse a scene that the engine cannot model; an engine's own `check` sees the kinds of scene alone that the engine names.

    Raises:
        Refusal: a feature of the scene that the engine does not have.
    """
    if scene.crank is None:
        Engine.check(engine, scene)
    engine.check(scene)
