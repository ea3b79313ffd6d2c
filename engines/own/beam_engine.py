"""Base of the engines whose model is one beam (`BeamModel`): description, start, preparation. An engine adds shapes and constraint.

The compiled equations are loaded when the first model is built, not when engines are listed.
"""

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np
import scipy

from quickreturn.engines.base import Comparison, Engine, EngineFailure, ModelDescription, ModelledScene
from quickreturn.engines.settings import Settings, setting
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import reconstruct
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.constants import characteristic_frequency
from quickreturn.reference_model.mechanism import Mechanism, Scene

if TYPE_CHECKING:
    from quickreturn.engines.own.simulation import OwnSimulation
    from quickreturn.reference_model.model import BeamModel


#: Integrators of a `BeamModel`.
EXPLICIT: Final = "explicit"
IMPLICIT: Final = "implicit"
#: Tolerance of the run that shows the implicit integration's error, over that of the run, and the largest part of the error that is left
#: then. With the further run that checks it, the error was 0.48 to 0.67 of what is claimed in the worst of four columns (33 cases of the
#: library, 8 fixed or 5 following shapes, 1e-5, 0.4 s, against 1e-10). A looser run would hide vibrations that both runs pass over.
TIGHTER: Final = 0.1
PART_OF_TIGHTER: Final = 0.5
LEAST_TOLERANCE: Final = 1e-12
LOOSEST: Final = 1e-3
#: Tolerance up to which the explicit integration leaves no visible error beside that of the shapes (RIVALS.md, section 3).
INVISIBLE: Final = 1e-8
#: Least error by slowing of the run that a run is compared with, over that of the run. In runs 24 and 17 (1 s, 7 and 12 fixed shapes,
#: slowed to modes 1 to 5, four columns) the estimate was 1.3 to 76 times the error.
SLOWED_MORE: Final = 2.0
#: Order of the error in the number of the mode.
ORDER_OF_SLOWING: Final = 4.0
#: Most shapes of an engine.
MOST_SHAPES: Final = 128


def tolerance(default: float, low: float = LEAST_TOLERANCE, high: float = LOOSEST) -> float:
    """The setting of that name."""
    return setting(default, "local error of the integration, relative to fixed sizes of the states", low=low, high=high)


def integrator(default: str, choices: tuple[str, ...] = (EXPLICIT, IMPLICIT)) -> str:
    """The setting of that name."""
    return setting(default, "explicit: DOP853; implicit: Radau IIA of order 5, whose steps fast vibrations do not bound", choices=choices)


@dataclass(frozen=True, kw_only=True)
class BeamSettings(Settings, ABC):
    """Settings that all these engines share."""

    tolerance: float = tolerance(1e-5)
    integrator: str = integrator(IMPLICIT)
    slowed_to: int = setting(
        0, "number of the mode to whose frequency an added inertia slows all higher ones; 0: none", low=0, high=MOST_SHAPES
    )

    @property
    def slows(self) -> bool:
        """Whether any mode of a flexible follower is slowed."""
        return 0 < self.slowed_to < self.shape_count

    @property
    @abstractmethod
    def shape_count(self) -> int:
        """Number of shapes of a flexible follower."""


S = TypeVar("S", bound=BeamSettings)

#: `characteristic_frequency` (1/s) of run 24, and of run 24 with a rigid follower.
FREQUENCY_OF_RUN_24: Final = 107.0
RATE_OF_RUN_24: Final = 1.04

#: Description of the slider's joint where the closed loop gives the follower's angle.
ELIMINATED_SLIDER: Final = "slider on the centre line (eliminated)"


class BeamEngine(Engine[S]):
    """An engine whose model is a `BeamModel`."""

    compiles = True
    #: Words for the shapes in the description, after their number; and for those of the follower alone.
    kind_of_shapes = "shapes"
    kind_of_clamped_shapes = "shapes"

    @abstractmethod
    def model(self, scene: ModelledScene, settings: S) -> "BeamModel":
        """The model of a scene. Raises Refusal: it cannot describe a part of the scene."""

    def joint_line(self, scene: Scene, settings: S) -> str:
        """The slider's joint in one line, for the description."""
        return ELIMINATED_SLIDER

    def opens_loop(self, scene: Scene) -> bool:
        """Whether the follower's angle is a coordinate of its own."""
        return True

    def version(self) -> str:
        """The libraries that it uses; equations and integrator are this project's own."""
        return f"numpy {np.__version__}, scipy {scipy.__version__}"

    def describe(self, scene: Scene, settings: S) -> ModelDescription:
        """Bodies and joints that have terms in the equations."""
        self.check(scene)
        n, kind = settings.shape_count, self.kind_of_clamped_shapes if scene.crank is None else self.kind_of_shapes
        if scene.follower.is_rigid:
            n = 0
        return description(scene, f"{n} {kind}" if n else "rigid", self.joint_line(scene, settings), n + int(self.opens_loop(scene)))

    def prepare(self, scene: Scene, start: Start | None, settings: S) -> "OwnSimulation":
        from quickreturn.engines.own.simulation import OwnSimulation

        self.check(scene)
        began = time.perf_counter()
        model = self.model(scene, settings)
        model.implicit = settings.integrator == IMPLICIT
        state = state_of(model, scene, start)
        if not np.all(np.isfinite(state)) or (model.closes_loop and not model.can_move(state)):
            advice = "try a start with a smaller deflection, or with the slider farther from the follower's end"
            raise EngineFailure(0.0, "the loop cannot be closed in the given start", advice)
        return OwnSimulation(model, state, settings.tolerance, time.perf_counter() - began + model.made_before)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: S) -> Array:
        """See `Engine.natural_frequencies`; those of the discretized model."""
        self.check(mechanism)
        return self.model(mechanism, settings).natural_frequencies(crank_angle, count)


def compared_integration(settings: S) -> tuple[Comparison, ...]:
    """The comparison that shows the error of the integration, with a tighter tolerance; with a looser one where none is tighter.

    The explicit integration needs none up to `INVISIBLE`.
    """
    if settings.integrator == EXPLICIT and settings.tolerance <= INVISIBLE:
        return ()
    tenth, hundredth = (settings.replaced(tolerance=max(part * settings.tolerance, LEAST_TOLERANCE)) for part in (TIGHTER, TIGHTER**2))
    if TIGHTER * settings.tolerance < LEAST_TOLERANCE:
        other = settings.replaced(tolerance=settings.tolerance / TIGHTER)
        return (Comparison(settings, other, 1.0 / PART_OF_TIGHTER, of="time"),)
    checked = TIGHTER**2 * settings.tolerance >= LEAST_TOLERANCE
    before = Comparison(tenth, hundredth, PART_OF_TIGHTER, of="time") if checked else None
    return (Comparison(settings, tenth, PART_OF_TIGHTER, before, of="time"),)


def compared_slowing(settings: S) -> tuple[Comparison, ...]:
    """The comparison that shows the error by slowing: with a run slowed to a lower mode, or from the first one to the second.

    A motion at omega finds the compliance of a slowed mode wrong by a part below omega^2 / omega_c^2 (equation 5.15). The clamped
    follower's omega_c^2 rises as (c - 1/2)^4, and that of the follower supported at the slider no less.
    """
    if not settings.slows:
        return ()
    lower = int((settings.slowed_to - 0.5) / SLOWED_MORE ** (1.0 / ORDER_OF_SLOWING) + 0.5)
    other, factor = (lower, SLOWED_MORE) if lower > 0 else (settings.slowed_to + 1, 1.0 / SLOWED_MORE)
    return (Comparison(settings, settings.replaced(slowed_to=other), factor, of="slowing"),)


def time_over_run_24(scene: Scene) -> float:
    """Time of a scene over that of run 24, to two digits, to which rates and time constants of settings are in proportion.

    It is the follower's sqrt(rho A / EI) L^2, or of a rigid follower the time of the crank.
    """
    frequency = RATE_OF_RUN_24 if scene.follower.is_rigid else FREQUENCY_OF_RUN_24
    return float(f"{frequency / characteristic_frequency(scene, 0 if scene.follower.is_rigid else 1):.2g}")


def description(scene: Scene, beam: str, joint: str, coordinates: int) -> ModelDescription:
    """Bodies and joints with terms in the equations: `beam` in two words, `joint` in a line, `coordinates` besides the crank's angle."""
    bodies = {
        "crank": scene.crank is not None,
        f"follower beam ({beam})": True,
        "base block": scene.base.inertia > 0.0,
        "tip body": scene.tip is not None,
        "slider mass": scene.slider.mass > 0.0,
        "slider rotary inertia": scene.slider.inertia > 0.0,
    }
    joints: tuple[str, ...] = ("base on the ground (angle prescribed)", "follower clamped to the base")
    if bodies["crank"]:
        joints = ("crank pivot" if scene.crank_is_free else "crank pivot (speed prescribed)", "follower pivot", joint)
        if scene.acting_spring is not None:
            joints = (*joints, scene.acting_spring.in_words)
    return ModelDescription(tuple(name for name, there in bodies.items() if there), joints, coordinates + int(scene.crank_is_free))


def state_of(model: "BeamModel", scene: Scene, start: Start | None) -> Array:
    """The model's state closest to a start; for a follower alone straight and at rest."""
    if start is None or scene.crank is None:
        return model.state_at_rest()
    straight = start.deflection is None and start.deflection_rate is None
    if straight or scene.follower.is_rigid:
        return model.straight_state(start.crank_angle, start.crank_speed)
    bent = reconstruct(scene, start)
    x = np.linspace(0.0, scene.follower.length, 32 * (model.shapes + 2) + 1)
    angle = bent.tangent(x) - bent.follower_angle
    rate = bent.tangent_rate(x) - bent.follower_rate
    slider = (bent.slider_position, bent.slider_speed)
    return model.bent_state(start.crank_angle, start.crank_speed, slider, x, angle, rate)
