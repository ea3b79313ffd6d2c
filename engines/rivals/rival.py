"""What the rival methods share: the beam, its shapes, features and refusals, description, start. A method is its joint."""

import math
import time
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import scipy
from numpy.typing import NDArray

from engines.base import Engine, EngineFailure, EstimateOf, ModelDescription, Refusal
from engines.follower import FollowerEngine
from engines.rivals.simulation import OpenLoopSimulation
from engines.settings import Settings, setting
from engines.start import Start
from reference_model.constraints.joint import Joint
from reference_model.constraints.model import OpenLoopModel
from reference_model.mechanism import Mechanism
from reference_model.model import ObservationFailed
from reference_model.shapes import ShapeSet, clamped_free_modes, hermite_elements, no_shapes


@dataclass(frozen=True, kw_only=True)
class RivalSettings(Settings):
    """Settings that all rivals have."""

    tolerance: float = setting(1e-7, "local error of the integration, relative to fixed sizes of the states", low=1e-12, high=1e-4)
    recovery: bool = setting(True, "curvature and deflection from equilibrium at output times, else the shapes as they are")


@dataclass(frozen=True, kw_only=True)
class ShapeSettings(RivalSettings):
    """Settings of the rivals that take any fixed shapes."""

    shapes: int = setting(12, "number of shapes (with Hermite elements: two per element)", low=1, high=64)
    family: str = setting("clamped-free", "fixed shapes", choices=("clamped-free", "hermite"))


def shapes_of(mechanism: Mechanism, settings: ShapeSettings) -> ShapeSet:
    """Clamped-free modes or Hermite elements; none for a rigid follower."""
    length = mechanism.follower.length
    if mechanism.follower.is_rigid:
        return no_shapes(length)
    if settings.family == "hermite":
        return hermite_elements(length, max(1, settings.shapes // 2))
    return clamped_free_modes(length, settings.shapes)


class RivalEngine(Engine):
    """An engine whose loop is open: q2 is a coordinate of its own, the slider's constraint a force."""

    compiles = True
    estimates: ClassVar[EstimateOf] = "unverified"

    @abstractmethod
    def shapes(self, mechanism: Mechanism, settings: Settings) -> ShapeSet:
        """The follower's shapes."""

    @abstractmethod
    def joint(self, mechanism: Mechanism, settings: Settings) -> Joint:
        """The treatment of the constraint."""

    @abstractmethod
    def joint_line(self, mechanism: Mechanism, settings: Settings) -> str:
        """The slider's joint in one line, for the description."""

    def version(self) -> str:
        """The library that it computes with; equations and integrator are this project's own."""
        return f"numpy {np.__version__}, scipy {scipy.__version__}"

    def check(self, mechanism: Mechanism) -> None:
        """Refuse what a force along the normal cannot do, and parts that the open loop leaves without inertia."""
        slider, crank, follower = mechanism.slider, mechanism.crank, mechanism.follower
        if slider.inertia > 0.0:
            raise Refusal(
                f"slider.inertia: {slider.inertia:g} kg*m^2 cannot be modelled by {self.name}, its joint passes no moment; accepted: 0"
            )
        if mechanism.crank_is_free and crank.inertia_about_pivot + slider.mass * crank.length**2 <= 0.0:
            raise Refusal(
                f"crank.inertia: {crank.inertia:g} kg*m^2 on a crank without mass cannot be modelled by {self.name}, whose open loop leaves"
                " the crank to itself; accepted: above 0, or crank.mass or slider.mass above 0"
            )
        if follower.mass_per_length <= 0.0:
            raise Refusal(
                f"follower.mass_per_length: {follower.mass_per_length:g} kg/m cannot be modelled by {self.name}, whose shapes need mass of"
                " their own; accepted: above 0"
            )

    def refuse_compliance(self, mechanism: Mechanism) -> None:
        """For methods that close the gap exactly."""
        slider = mechanism.slider
        if math.isfinite(slider.joint_stiffness) or slider.joint_damping > 0.0:
            raise Refusal(
                f"slider.joint_stiffness: {slider.joint_stiffness:g} N/m with joint_damping {slider.joint_damping:g} N*s/m cannot be"
                f' modelled by {self.name}, which closes the gap exactly; accepted: "inf" and "0 N*s/m"'
            )

    def model(self, mechanism: Mechanism, settings: Settings) -> OpenLoopModel:
        """The open-loop model of a scene.

        Raises:
            Refusal: the scene has what this method cannot carry.
        """
        self.check(mechanism)
        recovery = isinstance(settings, RivalSettings) and settings.recovery
        return OpenLoopModel(mechanism, self.shapes(mechanism, settings), self.joint(mechanism, settings), recovery)

    def describe(self, mechanism: Mechanism, settings: Settings) -> ModelDescription:
        """Bodies and joints that have terms in the equations."""
        self.check(mechanism)
        n, slider = self.shapes(mechanism, settings).count, mechanism.slider
        bodies = ["crank", f"follower beam ({n} shapes)" if n else "follower beam (rigid)"]
        if mechanism.base.inertia > 0.0:
            bodies.append("base block")
        if mechanism.tip:
            bodies.append("tip body")
        if slider.mass > 0.0:
            bodies.append("slider mass")
        crank = "crank pivot" if mechanism.crank_is_free else "crank pivot (speed prescribed)"
        free = n + (2 if mechanism.crank_is_free else 1)
        return ModelDescription(tuple(bodies), (crank, "follower pivot", self.joint_line(mechanism, settings)), free)

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> OpenLoopSimulation:
        """See `engines.base.Engine.prepare`."""
        began = time.perf_counter()
        model = self.model(mechanism, settings)
        points = model.closed.projection_points()
        coordinates = [
            None if field is None else model.closed.project_deflection(field(points, 0), field(points, 1))
            for field in (start.deflection, start.deflection_rate)
        ]
        try:
            state = model.initial_state(start.crank_angle, start.crank_speed, *coordinates)
        except ObservationFailed:
            raise EngineFailure(0.0, "the loop cannot be closed in the given start", "try a start with a smaller deflection") from None
        assert isinstance(settings, RivalSettings)
        return OpenLoopSimulation(model, state, settings.tolerance, time.perf_counter() - began)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: Settings) -> NDArray[np.float64]:
        """Of the discretized model."""
        if mechanism.follower.is_rigid and math.isinf(mechanism.slider.joint_stiffness):
            return np.zeros(0)
        return self.model(mechanism, settings).natural_frequencies(crank_angle, count)

    def follower_alone(self) -> FollowerEngine:
        """Refuse: without a slider there is no constraint to treat."""
        raise Refusal(
            f"[slider]: this scene has no slider and no [crank], and engine {self.name} differs from fixed-shapes in the slider's"
            " constraint alone; use engine fixed-shapes"
        )
