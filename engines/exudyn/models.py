"""The Exudyn model that suits a scene."""

from quickreturn.engines.exudyn.alone import FollowerModel
from quickreturn.engines.exudyn.flexible import FlexibleModel
from quickreturn.engines.exudyn.record import Model
from quickreturn.engines.exudyn.rigid import RigidModel
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import reconstruct
from quickreturn.reference_model.mechanism import Scene


def model_of(scene: Scene, start: Start | None, settings: ExudynSettings) -> Model:
    """The model of a scene in the state `start`, which a follower alone does not need."""
    if scene.crank is None:
        return FollowerModel(scene, settings)
    assert start is not None
    state = reconstruct(scene, start)
    if scene.follower.is_rigid:
        return RigidModel(scene, start, state)
    return FlexibleModel(scene, start, state, settings)
