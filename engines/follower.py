"""An engine's second model: the follower alone, without crank and slider, on a base that turns as prescribed.

What it simulates begins straight and at rest, and has no cycle: there are trajectories to compare, no steady-state measures.
"""

from abc import ABC, abstractmethod
from typing import Generic

from engines.base import Comparison, Engine, EstimateOf, ModelDescription, S, Simulation
from reference_model.mechanism import FollowerAlone


class FollowerEngine(ABC, Generic[S]):
    """What `Engine.follower_alone` returns. Settings, and unless overridden the way to finer ones, are the engine's own.

    Args:
        engine: the engine whose model it is.
    """

    def __init__(self, engine: Engine[S]) -> None:
        self.engine = engine

    @property
    def name(self) -> str:
        """The engine's."""
        return self.engine.name

    @property
    def compiles(self) -> bool:
        """The engine's."""
        return self.engine.compiles

    @property
    def default_accuracy(self) -> float:
        """The engine's."""
        return self.engine.default_accuracy

    @property
    def estimates(self) -> EstimateOf:
        """The engine's."""
        return self.engine.estimates

    def check(self, scene: FollowerAlone) -> None:  # accepting everything is a choice, not an oversight
        """Raise `Refusal` if a feature of the scene cannot be modelled; the default accepts all there are."""

    @abstractmethod
    def describe(self, scene: FollowerAlone, settings: S) -> ModelDescription:
        """See `Engine.describe`."""

    @abstractmethod
    def settings_for(self, accuracy: float, scene: FollowerAlone) -> S:
        """See `Engine.settings_for`."""

    @abstractmethod
    def comparisons(self, settings: S, scene: FollowerAlone, output_step: float) -> tuple[Comparison, ...]:
        """See `Engine.comparisons`."""

    def finer(self, settings: S, excess: tuple[float, ...], output_step: float) -> S | None:
        """See `Engine.finer`."""
        return self.engine.finer(settings, excess, output_step)

    @abstractmethod
    def prepare(self, scene: FollowerAlone, start: None, settings: S) -> Simulation:
        """Build the model, straight and at rest; see `Engine.prepare`. `start` is always None."""


def slowest_frequency(scene: FollowerAlone) -> float:
    """Lowest natural frequency of the follower clamped at its base, Hz: the time scale of its motion."""
    from reference_model.natural_modes import clamped_modes

    return float(clamped_modes(scene, 1).frequencies[0])


def parts(scene: FollowerAlone, beam: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Bodies and joints of a model with one line for the beam."""
    bodies = [beam]
    if scene.base.inertia > 0.0:
        bodies.insert(0, "base block")
    if scene.tip is not None:
        bodies.append("tip body")
    return tuple(bodies), ("base on the ground (angle prescribed)", "follower clamped to the base")
