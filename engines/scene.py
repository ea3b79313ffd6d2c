"""Simulating a scene of either kind from its standard start, and what an engine builds for it."""

from collections.abc import Mapping
from typing import Any

from quickreturn.engines import accurate
from quickreturn.engines.accurate import Result
from quickreturn.engines.base import AnyEngine, ModelDescription, Solver
from quickreturn.engines.start import Start, standard_start
from quickreturn.reference_model.mechanism import FollowerAlone, Scene


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
    solver, start = solver_of(engine, scene)
    return accurate.simulate(solver, scene, start, duration, output_step, settings, accuracy, estimate, time_limit)


def describe_scene(engine: AnyEngine, scene: Scene) -> ModelDescription:
    """What the engine builds for a scene with its default settings. Refusal: it cannot."""
    solver, _ = solver_of(engine, scene)
    solver.check(scene)
    return solver.describe(scene, solver.settings_for(solver.default_accuracy, scene))


def solver_of(engine: AnyEngine, scene: Scene) -> tuple[Solver[Any, Any, Any], Start | None]:
    """The engine's model for the scene's kind, and the standard start. Raises Refusal where it has none of a follower alone."""
    return (engine.follower_alone(), None) if isinstance(scene, FollowerAlone) else (engine, standard_start(scene))
