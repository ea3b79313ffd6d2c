"""The engines `thesis` (as published: one cubic, LSODA) and `reference` (the same method, converged)."""

import math
import time
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Final, Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from engines.base import Engine, EngineFailure, ModelDescription, Refusal
from engines.pseudo_coordinate.simulation import ExplicitSimulation
from engines.settings import Settings, setting
from engines.start import Start
from reference_model.frequencies import shape_frequencies
from reference_model.mechanism import Mechanism
from reference_model.model import ExplicitModel
from reference_model.parameters import UnsuitableShapes
from reference_model.rigid import rigid_motion
from reference_model.shapes import ShapeSet, clamped_free_modes, hermite_between, hermite_elements, no_shapes

#: LSODA tolerance for an error of the tip deflection, run 24 over 2 s: tolerances 1e-4, 1e-5, 1e-6, 1e-7 gave errors 6.6e-4, 9.4e-5,
#: 1.7e-5, 2.6e-6. The factor keeps the scatter from cycle to cycle far below what counts as settled (at 3e-5 a third of the runs
#: never settled).
THESIS_TOLERANCE_PER_ERROR: Final = 1e-4
#: Ratio of the errors of runs whose tolerances are a decade apart, from the same figures.
THESIS_ERROR_PER_DECADE: Final = 6.0

#: Number of clamped-free modes, integration tolerance and error of the tip deflection in run 24 over 2 s (`convergence_table`): the
#: difference from 32 modes plus their own error of 9.4e-5, which follows from the law 3.07 / shapes^3 that the differences obey from 12 on.
#: Tolerances leave 1e-4 of the slider force at most: fewer shapes stand looser ones, an explicit integrator makes high modes ring.
REFERENCE_LADDER: Final = (
    (4, 1e-7, 3.1e-2),
    (6, 1e-7, 1.3e-2),
    (8, 1e-7, 5.5e-3),
    (10, 1e-7, 3.5e-3),
    (12, 1e-8, 1.6e-3),
    (16, 1e-8, 7.5e-4),
    (20, 1e-8, 3.8e-4),
    (24, 1e-9, 2.3e-4),
    (32, 1e-9, 9.4e-5),
    (40, 1e-9, 4.8e-5),
)


class _PseudoCoordinateEngine(Engine):
    """What both engines share: features, description, start."""

    compiles = True
    integrator: ClassVar[Literal["DOP853", "LSODA"]]
    recovers: ClassVar[bool]

    @abstractmethod
    def shapes(self, mechanism: Mechanism, settings: Settings) -> ShapeSet:
        """The shapes of a flexible follower."""

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
        shapes = no_shapes(mechanism.follower.length) if mechanism.follower.is_rigid else self.shapes(mechanism, settings)
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


@dataclass(frozen=True, kw_only=True)
class ThesisSettings(Settings):
    """Settings of `thesis`."""

    tolerance: float = setting(1e-6, "local error of the integration, relative to fixed sizes of the states", low=1e-12, high=1e-2)
    elements: int = setting(1, "cubic Hermite elements; 1 is the thesis", low=1, high=12)
    geometry: str = setting("second-order", "foreshortening as in the thesis, or exact", choices=("second-order", "exact"))


class ThesisEngine(_PseudoCoordinateEngine):
    """The thesis' model as published: its discretization is the model, so the accuracy asked is that of the integration."""

    name = "thesis"
    method = "pseudo-coordinate at the coupler, one cubic, second-order foreshortening, LSODA (the thesis as published)"
    default_accuracy = 1e-3
    settings_type = ThesisSettings
    integrator = "LSODA"
    recovers = False

    def shapes(self, mechanism: Mechanism, settings: Settings) -> ShapeSet:
        """Cubic Hermite elements."""
        return hermite_elements(mechanism.follower.length, _thesis(settings).elements)

    def exact_geometry(self, settings: Settings) -> bool:
        """As the setting says."""
        return _thesis(settings).geometry == "exact"

    def tolerance(self, settings: Settings) -> float:
        """As the setting says."""
        return _thesis(settings).tolerance

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> ThesisSettings:
        """Integration tolerance for an error against the model's own equations."""
        return ThesisSettings(tolerance=accuracy * THESIS_TOLERANCE_PER_ERROR)

    def coarser(self, settings: Settings) -> tuple[ThesisSettings, float]:
        """Ten times the tolerance; the error factor is measured."""
        own = _thesis(settings)
        return own.replaced(tolerance=min(10.0 * own.tolerance, 1e-2)), THESIS_ERROR_PER_DECADE

    def finer(self, settings: Settings) -> ThesisSettings | None:
        """A tenth of the tolerance."""
        own = _thesis(settings)
        return own.replaced(tolerance=0.1 * own.tolerance) if own.tolerance > 1e-11 else None

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: Settings) -> NDArray[np.float64]:
        """Of the cubic elements: two per element."""
        if mechanism.follower.is_rigid:
            return np.zeros(0)
        self.check(mechanism)
        support = float(rigid_motion(mechanism, np.array(crank_angle), 0.0).slider_position)
        return shape_frequencies(mechanism, self.shapes(mechanism, settings), support, count)


@dataclass(frozen=True, kw_only=True)
class ReferenceSettings(Settings):
    """Settings of `reference`."""

    shapes: int = setting(16, "number of shapes (with Hermite elements: two per element)", low=1, high=64)
    family: str = setting("clamped-free", "fixed shapes", choices=("clamped-free", "hermite"))
    tolerance: float = setting(1e-8, "local error of the integration, relative to fixed sizes of the states", low=1e-12, high=1e-4)
    damping_law: str = setting(
        "both components", "velocity relative to the base frame that the beam damping acts on", choices=("both components", "transverse")
    )


class ReferenceEngine(_PseudoCoordinateEngine):
    """The same method converged: many fixed shapes, exact planar geometry, equilibrium recovery."""

    name = "reference"
    method = "pseudo-coordinate at the coupler, fixed shapes, exact planar geometry, equilibrium recovery, DOP853"
    default_accuracy = 1e-3
    settings_type = ReferenceSettings
    integrator = "DOP853"
    recovers = True

    def shapes(self, mechanism: Mechanism, settings: Settings) -> ShapeSet:
        """Clamped-free modes or Hermite elements."""
        own = _reference(settings)
        if own.family == "hermite":
            return hermite_elements(mechanism.follower.length, max(1, own.shapes // 2))
        return clamped_free_modes(mechanism.follower.length, own.shapes)

    def exact_geometry(self, settings: Settings) -> bool:
        """Always exact."""
        return True

    def transverse_damping(self, settings: Settings) -> bool:
        """As the setting says."""
        return _reference(settings).damping_law == "transverse"

    def tolerance(self, settings: Settings) -> float:
        """As the setting says."""
        return _reference(settings).tolerance

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> ReferenceSettings:
        """Number of shapes from the measured table."""
        for shapes, tolerance, error in REFERENCE_LADDER:
            if error <= accuracy:
                return ReferenceSettings(shapes=shapes, tolerance=tolerance)
        shapes, tolerance, _ = REFERENCE_LADDER[-1]
        return ReferenceSettings(shapes=shapes, tolerance=tolerance)

    def coarser(self, settings: Settings) -> tuple[ReferenceSettings, float]:
        """Four shapes fewer (two fewer and twice the error, below eight); the factor stays a little below those of the ladder."""
        own = _reference(settings)
        if own.shapes >= 8:
            return own.replaced(shapes=own.shapes - 4), (own.shapes / (own.shapes - 4.0)) ** 2.5
        return own.replaced(shapes=max(1, own.shapes - 2)), 2.0

    def finer(self, settings: Settings) -> ReferenceSettings | None:
        """The next rung of the ladder."""
        own = _reference(settings)
        for shapes, tolerance, _ in REFERENCE_LADDER:
            if shapes > own.shapes:
                return own.replaced(shapes=shapes, tolerance=min(tolerance, own.tolerance))
        return None

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: Settings) -> NDArray[np.float64]:
        """Converged: Hermite elements with a node at the slider, doubled until no frequency changes by more than 1e-6 of itself."""
        if mechanism.follower.is_rigid:
            return np.zeros(0)
        self.check(mechanism)
        support = float(rigid_motion(mechanism, np.array(crank_angle), 0.0).slider_position)
        elements, last = max(8, count), np.full(count, np.inf)
        while True:
            shapes = hermite_between(_nodes(mechanism.follower.length, support, elements))
            found = shape_frequencies(mechanism, shapes, support, count)
            # elements of third degree: the error falls 16-fold at each doubling
            if elements > 16 * count or np.all(np.abs(found - last) < 1e-6 * found):
                return found
            elements, last = 2 * elements, found


def _nodes(length: float, support: float, elements: int) -> NDArray[np.float64]:
    """Nodes of about `elements` elements, one node at the support, where the moment has a kink."""
    inboard = max(1, round(elements * support / length))
    outboard = max(1, elements - inboard) if length - support > 1e-6 * length else 0
    if not outboard:
        return np.linspace(0.0, length, inboard + 1)
    return np.concatenate([np.linspace(0.0, support, inboard + 1), np.linspace(support, length, outboard + 1)[1:]])


def _thesis(settings: Settings) -> ThesisSettings:
    if not isinstance(settings, ThesisSettings):
        raise TypeError("not settings of the engine thesis")
    return settings


def _reference(settings: Settings) -> ReferenceSettings:
    if not isinstance(settings, ReferenceSettings):
        raise TypeError("not settings of the engine reference")
    return settings
