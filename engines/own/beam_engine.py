"""What the engines on the one beam share: description, start, preparation. An engine chooses shapes and slider constraint.

The compiled equations are loaded when the first model is built, not when engines are listed.
"""

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from quickreturn.engines.base import Engine, EngineFailure, ModelDescription, ModelledScene
from quickreturn.engines.settings import Settings, setting
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import reconstruct
from quickreturn.reference_model.mechanism import FollowerAlone, Mechanism, Scene
from quickreturn.reference_model.natural_modes import stiffness_ratio

if TYPE_CHECKING:
    from quickreturn.engines.own.simulation import OwnSimulation
    from quickreturn.reference_model.model import BeamModel


@dataclass(frozen=True, kw_only=True)
class BeamSettings(Settings, ABC):
    """What all engines on the one beam can be set to."""

    tolerance: float = setting(1e-9, "local error of the integration, relative to fixed sizes of the states", low=1e-12, high=1e-4)

    @property
    @abstractmethod
    def shape_count(self) -> int:
        """Number of shapes of a flexible follower."""


S = TypeVar("S", bound=BeamSettings)

#: First bending frequency over the crank's in run 24, on which ladders were measured.
RATIO_OF_RUN_24: Final = 4.1

#: The slider's joint where the follower's angle follows from the crank's.
ELIMINATED_SLIDER: Final = "slider on the centre line (eliminated)"


class BeamEngine(Engine[S]):
    """An engine whose model is a `BeamModel`."""

    compiles = True
    #: What the description says of the shapes behind their number.
    kind_of_shapes = "shapes"
    #: The same for the follower alone.
    kind_of_clamped_shapes = "shapes"

    @abstractmethod
    def model(self, scene: ModelledScene, settings: S) -> "BeamModel":
        """The model of a scene. Refusal: the scene has what this model cannot carry."""

    def joint_line(self, mechanism: Mechanism, settings: S) -> str:
        """The slider's joint in one line, for the description."""
        return ELIMINATED_SLIDER

    def opens_loop(self, mechanism: Mechanism) -> bool:
        """Whether the follower's angle is a coordinate of its own."""
        return True

    def version(self) -> str:
        """The libraries that it computes with; equations and integrator are this project's own."""
        return f"numpy {np.__version__}, scipy {scipy.__version__}"

    def describe(self, scene: Scene, settings: S) -> ModelDescription:
        """Bodies and joints that have terms in the equations."""
        self.check(scene)
        if isinstance(scene, FollowerAlone):
            return alone_description(scene, f"{settings.shape_count} {self.kind_of_clamped_shapes}", settings.shape_count)
        mechanism = scene
        n = 0 if mechanism.follower.is_rigid else settings.shape_count
        joint, coordinates = self.joint_line(mechanism, settings), n + int(self.opens_loop(mechanism))
        return description(mechanism, f"{n} {self.kind_of_shapes}" if n else "rigid", joint, coordinates)

    def prepare(self, scene: Scene, start: Start | None, settings: S) -> "OwnSimulation":
        from quickreturn.engines.own.simulation import OwnSimulation

        self.check(scene)
        began = time.perf_counter()
        model = self.model(scene, settings)
        state = state_of(model, scene, start)
        if model.closes_loop and not model.can_move(state):
            raise EngineFailure(0.0, "the loop cannot be closed in the given start", "try a start with a smaller deflection")
        return OwnSimulation(model, state, settings.tolerance, time.perf_counter() - began + model.made_before)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: S) -> NDArray[np.float64]:
        """Of the discretized model."""
        self.check(mechanism)
        return self.model(mechanism, settings).natural_frequencies(crank_angle, count)


def gain_of(scene: Scene) -> float:
    """Error of few shapes over that in run 24.

    Equilibrium recovers what the shapes left out hold nearly at rest; what is missing is their inertia, which falls with the square of
    the ratio of the first bending frequency to the crank's.
    """
    ratio = stiffness_ratio(scene) if isinstance(scene, Mechanism) else 0.0
    return min(1.0, (RATIO_OF_RUN_24 / ratio) ** 2) if ratio else 1.0


def alone_description(scene: FollowerAlone, beam: str, coordinates: int) -> ModelDescription:
    """What has terms in the equations of a follower alone: beam in a word or two, number of coordinates."""
    bodies = {"base block": scene.base.inertia > 0.0, f"follower beam ({beam})": True, "tip body": scene.tip is not None}
    joints = ("base on the ground (angle prescribed)", "follower clamped to the base")
    return ModelDescription(tuple(name for name, there in bodies.items() if there), joints, coordinates)


def description(mechanism: Mechanism, beam: str, joint: str, coordinates: int) -> ModelDescription:
    """What has terms in the equations: beam in a word or two, the slider's joint in a line, coordinates besides the crank's angle."""
    slider = mechanism.slider
    bodies = {
        "crank": True,
        f"follower beam ({beam})": True,
        "base block": mechanism.base.inertia > 0.0,
        "tip body": mechanism.tip is not None,
        "slider mass": slider.mass > 0.0,
        "slider rotary inertia": slider.inertia > 0.0,
    }
    pivot = "crank pivot" if mechanism.crank_is_free else "crank pivot (speed prescribed)"
    return ModelDescription(
        tuple(name for name, there in bodies.items() if there),
        (pivot, "follower pivot", joint),
        coordinates + int(mechanism.crank_is_free),
    )


def state_of(model: "BeamModel", mechanism: Scene, start: Start | None) -> NDArray[np.float64]:
    """The model's state closest to a start; of a follower alone straight and at rest."""
    if start is None or isinstance(mechanism, FollowerAlone):
        return model.state_at_rest()
    straight = start.deflection is None and start.deflection_rate is None
    if straight or mechanism.follower.is_rigid:
        return model.straight_state(start.crank_angle, start.crank_speed)
    bent = reconstruct(mechanism, start)
    x = np.linspace(0.0, mechanism.follower.length, 32 * (model.shapes + 2) + 1)
    angle = bent.tangent(x) - bent.follower_angle
    rate = bent.tangent_rate(x) - bent.follower_rate
    slider = (bent.slider_position, bent.slider_speed)
    return model.bent_state(start.crank_angle, start.crank_speed, slider, x, angle, rate)
