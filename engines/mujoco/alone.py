"""The follower alone as a chain of links whose base is turned by an exact torque."""

from engines.base import Comparison, FollowerEngine, ModelDescription, Simulation
from engines.mujoco import settings as ladder
from engines.mujoco.settings import ChainSettings
from reference_model.mechanism import FollowerAlone


class MujocoAlone(FollowerEngine[ChainSettings]):
    """The base link is turned; the tangent of the beam that the chain stands for lies h²/24 of the curvature's slope beside it."""

    def describe(self, scene: FollowerAlone, settings: ChainSettings) -> ModelDescription:
        """See `FollowerEngine.describe`."""
        from engines.mujoco import chain

        return chain.describe_alone(scene, chain.hinge_count(scene, settings.links))

    def settings_for(self, accuracy: float, scene: FollowerAlone) -> ChainSettings:
        """The engine's ladder, which the run's own estimate corrects."""
        return ladder.for_accuracy(accuracy)

    def comparisons(self, settings: ChainSettings, scene: FollowerAlone, output_step: float) -> tuple[Comparison, ...]:
        """As with the mechanism."""
        return ladder.comparisons(settings)

    def prepare(self, scene: FollowerAlone, start: None, settings: ChainSettings) -> Simulation:
        """See `Solver.prepare`."""
        from engines.mujoco.simulation import FollowerSimulation

        return FollowerSimulation(scene, settings)
