"""What the engines `thesis` and `fixed-shapes` share: the explicit model with shapes that stay where they are."""

import math
import time
from abc import abstractmethod
from typing import ClassVar, Literal

import scipy

from engines.base import Comparison, Engine, EngineFailure, ModelDescription, Refusal
from engines.follower import FollowerEngine, parts
from engines.pseudo_coordinate.simulation import ExplicitSimulation, FollowerSimulation
from engines.settings import Settings
from engines.start import Start
from reference_model.follower_model import FixedShapeFollower
from reference_model.mechanism import Follower, FollowerAlone, Mechanism, Scene
from reference_model.model import ExplicitModel
from reference_model.parameters import UnsuitableShapes
from reference_model.shapes import ShapeSet, no_shapes


class FixedShapeModelEngine(Engine):
    """What the engines with fixed shapes share: features, description, start."""

    compiles = True
    integrator: ClassVar[Literal["DOP853", "LSODA"]]
    recovers: ClassVar[bool]

    @abstractmethod
    def shapes(self, follower: Follower, settings: Settings) -> ShapeSet:
        """The shapes of a flexible follower."""

    @abstractmethod
    def settings_for(self, accuracy: float, mechanism: Scene) -> Settings:
        """See `Engine.settings_for`; for either kind of scene."""

    @abstractmethod
    def comparisons(self, settings: Settings, mechanism: Scene, output_step: float) -> tuple[Comparison, ...]:
        """See `Engine.comparisons`; for either kind of scene."""

    @abstractmethod
    def exact_geometry(self, settings: Settings) -> bool:
        """Exact planar geometry, or second-order foreshortening."""

    def transverse_damping(self, settings: Settings) -> bool:
        """Whether the beam damping acts on the transverse velocity alone."""
        return False

    @abstractmethod
    def tolerance(self, settings: Settings) -> float:
        """Local error of the integration."""

    def version(self) -> str:
        """The integrator's library; the equations are this project's own."""
        return f"scipy {scipy.__version__}"

    def check(self, mechanism: Mechanism) -> None:
        """Refuse a compliant slider joint: the loop is closed exactly."""
        slider = mechanism.slider
        if math.isfinite(slider.joint_stiffness) or slider.joint_damping > 0.0:
            raise Refusal(
                f"slider.joint_stiffness: {slider.joint_stiffness:g} N/m with joint_damping {slider.joint_damping:g} N*s/m cannot be"
                f' modelled by {self.name}, which closes the loop exactly; accepted: "inf" and "0 N*s/m"'
            )

    def model(self, mechanism: Mechanism, settings: Settings) -> ExplicitModel:
        """The explicit model of a scene.

        Raises:
            Refusal: the scene has what this model or these shapes cannot carry.
        """
        self.check(mechanism)
        shapes = no_shapes(mechanism.follower.length) if mechanism.follower.is_rigid else self.shapes(mechanism.follower, settings)
        try:
            return ExplicitModel(mechanism, shapes, self.exact_geometry(settings), self.recovers, self.transverse_damping(settings))
        except UnsuitableShapes as error:
            raise Refusal(f"slider.inertia: {mechanism.slider.inertia:g} kg*m^2 is not accepted with these settings: {error}") from None

    def describe(self, mechanism: Mechanism, settings: Settings) -> ModelDescription:
        """Bodies and joints that have terms in the equations."""
        model = self.model(mechanism, settings)
        n, slider = model.shapes.count, mechanism.slider
        bodies = ["crank", f"follower beam ({n} shapes)" if n else "follower beam (rigid)"]
        if mechanism.base.inertia > 0.0:
            bodies.append("base block")
        if mechanism.tip:
            bodies.append("tip body")
        if slider.mass > 0.0:
            bodies.append("slider mass")
        if slider.inertia > 0.0:
            bodies.append("slider rotary inertia")
        crank = "crank pivot" if mechanism.crank_is_free else "crank pivot (speed prescribed)"
        return ModelDescription(
            tuple(bodies), (crank, "follower pivot", "slider on the centre line (eliminated)"), model.degrees_of_freedom
        )

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> ExplicitSimulation:
        """See `engines.base.Engine.prepare`."""
        began = time.perf_counter()
        model = self.model(mechanism, settings)
        points = model.projection_points()
        coordinates = [
            None if field is None else model.project_deflection(field(points, 0), field(points, 1))
            for field in (start.deflection, start.deflection_rate)
        ]
        state = model.initial_state(start.crank_angle, start.crank_speed, *coordinates)
        if not model.can_move(state):
            raise EngineFailure(0.0, "the loop cannot be closed in the given start", "try a start with a smaller deflection")
        return ExplicitSimulation(model, state, self.tolerance(settings), self.integrator, time.perf_counter() - began)

    def follower_alone(self) -> "FixedShapesAlone":
        """The same beam with the loop left open."""
        return FixedShapesAlone(self)


class FixedShapesAlone(FollowerEngine):
    """The follower alone in the engine's shapes."""

    def __init__(self, engine: FixedShapeModelEngine) -> None:
        super().__init__(engine)
        self._engine = engine

    def describe(self, scene: FollowerAlone, settings: Settings) -> ModelDescription:
        """Bodies and joints that have terms in the equations."""
        n = self._engine.shapes(scene.follower, settings).count
        return ModelDescription(*parts(scene, f"follower beam ({n} shapes)"), n)

    def settings_for(self, accuracy: float, scene: FollowerAlone) -> Settings:
        """The engine's table, which the run's own estimate corrects."""
        return self._engine.settings_for(accuracy, scene)

    def comparisons(self, settings: Settings, scene: FollowerAlone, output_step: float) -> tuple[Comparison, ...]:
        """The engine's: shapes converge faster without a slider, so that the estimate is too large rather than too small."""
        return self._engine.comparisons(settings, scene, output_step)

    def prepare(self, scene: FollowerAlone, start: None, settings: Settings) -> FollowerSimulation:
        """See `FollowerEngine.prepare`."""
        began, engine = time.perf_counter(), self._engine
        shapes, exact = engine.shapes(scene.follower, settings), engine.exact_geometry(settings)
        model = FixedShapeFollower(scene, shapes, exact, engine.recovers, engine.transverse_damping(settings))
        tolerance = engine.tolerance(settings)
        return FollowerSimulation(model, model.state_at_rest(), tolerance, engine.integrator, time.perf_counter() - began)
