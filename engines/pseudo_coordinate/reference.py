"""The engine `reference`: pseudo-coordinates with shapes that follow the slider, converged."""

import math
import time
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from engines.base import Comparison, Engine, EngineFailure, ModelDescription, NoSteadyState, Refusal, SteadyState
from engines.follower import FollowerEngine, parts
from engines.pseudo_coordinate import orbit
from engines.pseudo_coordinate.simulation import ExplicitSimulation, FollowerSimulation
from engines.rivals.simulation import OpenLoopSimulation
from engines.rivals.stiff_spring import StiffSpringEngine, StiffSpringSettings
from engines.settings import Settings, setting
from engines.start import Start, standard_start
from engines.start_state import reconstruct
from reference_model.follower_model import ClampedModel
from reference_model.mechanism import FollowerAlone, Mechanism, Scene
from reference_model.model import ExplicitModel
from reference_model.moving_model import MovingShapeModel
from reference_model.natural_modes import frozen_crank_modes, stiffness_ratio
from reference_model.shapes import no_shapes

#: Modes, integration tolerance, and error of the tip deflection in run 24 over 2 s against 12 modes (tolerance 1e-9), which differ from
#: 13 by 2e-6. Three modes are hardly better than two (1.3e-3) and left out. Over the thesis' runs the errors are 0.06 to 1.8 times these.
#:
#: Tolerances: the loosest at which the error of the tip's acceleration is no larger than that of the deflection in run 24, and within
#: what is asked in scenes that move little, where the sizes that a local error is relative to weigh more: in run 1 (6.3 rad/s) and
#: with ten times the stiffness four modes have an acceleration error of 2e-3 at 1e-6, seven one of 9e-4 at 1e-7 and 1e-4 at 1e-8.
#: From four modes on the stability of an explicit integrator bounds the steps: a tenth of the tolerance costs a tenth of the time.
LADDER: Final = (
    (1, 1e-5, 2.7e-2),
    (2, 1e-5, 1.5e-3),
    (4, 3e-7, 8e-4),
    (5, 1e-7, 4.9e-4),
    (6, 1e-7, 2.3e-4),
    (7, 1e-8, 8.2e-5),
    (8, 1e-8, 3.4e-5),
    (9, 3e-9, 1.5e-5),
    (11, 1e-9, 4e-6),
)

#: First bending frequency over the crank's in run 24 (`stiffness_ratio`). The modes left out follow the load nearly at rest, and what
#: equilibrium recovers holds their share; what is missing is their inertia, which falls with the square of that ratio. With one mode run
#: 24 (4.1), run 17 (7.4), ten times run 24's stiffness (13.1) and machines of ratios 14, 50 and 84 leave 2.7e-2, 4.2e-3, 3.2e-4, 5.9e-4,
#: 6.9e-6 and 8.1e-6 of the deflection, in the acceleration 3.1e-2, 4.2e-3, 6.2e-4, 1.8e-3, 9.4e-6 and 1.4e-5.
RATIO_OF_RUN_24: Final = 4.1
#: Tolerance for an accuracy where so few modes do: at 1e-5 the integration leaves up to 7e-4 there, at 1e-7 1e-4.
TOLERANCE_PER_ACCURACY: Final = 1e-4

#: Modes -> modes of the finer run that the error is estimated with, and the ratio of their errors. Truncation errors of modes have one
#: sign, so that differences are a little smaller than errors. Measured in sixteen scenes (thesis' runs, stiff, soft, random): two modes
#: differ from five by 0.54 to 1.0 times their error, four from seven by 0.88 to 1.0, and from five on a run differs from one with two
#: modes more by 0.8 to 0.9 times its error in the thesis' runs; 0.3 at worst, under a sudden load that sets all modes ringing. In sixteen
#: other random scenes (`cases.accuracy_campaign`) estimates were 0.87 to 2.0 times the errors. A coarser run is no measure: one mode is
#: 1.3 to 25 times worse than two, and three are no better.
COMPARED: Final = {1: (4, 0.2), 2: (5, 0.5), 3: (6, 0.25), 4: (7, 0.2)}
#: Two modes more, and two modes fewer where no more are accepted.
RATIO: Final = 0.25
MOST_MODES: Final = 16


@dataclass(frozen=True, kw_only=True)
class ReferenceSettings(Settings):
    """Settings of `reference`."""

    modes: int = setting(5, "modes of the beam supported at the slider", low=1, high=MOST_MODES)
    tolerance: float = setting(1e-7, "local error of the integration, relative to fixed sizes of the states", low=1e-12, high=1e-4)


class ReferenceEngine(Engine):
    """Modes of the beam supported where the slider is, projected on the free speeds; observables recovered from equilibrium."""

    name = "reference"
    method = "pseudo-coordinate, shapes that follow the slider, exact planar geometry, equilibrium recovery, compiled DOP853"
    compiles = True
    default_accuracy = 1e-3
    settings_type = ReferenceSettings

    def version(self) -> str:
        """The library that it computes with; equations and integrator are this project's own."""
        return f"numpy {np.__version__}, scipy {scipy.__version__}"

    def check(self, mechanism: Mechanism) -> None:
        """Refuse what a compliant joint cannot carry, and a damper beside a rigid one."""
        slider = mechanism.slider
        if math.isfinite(slider.joint_stiffness):
            _COMPLIANT.check(mechanism)
        elif slider.joint_damping > 0.0:
            raise Refusal(
                f"slider.joint_damping: {slider.joint_damping:g} N*s/m does nothing in a rigid joint; accepted: 0, or a finite"
                " slider.joint_stiffness"
            )

    def describe(self, mechanism: Mechanism, settings: Settings) -> ModelDescription:
        """Bodies and joints that have terms in the equations."""
        if math.isfinite(mechanism.slider.joint_stiffness):
            return _COMPLIANT.describe(mechanism, _compliant(_own(settings)))
        rigid, slider = mechanism.follower.is_rigid, mechanism.slider
        modes = 0 if rigid else _own(settings).modes
        bodies = ["crank", "follower beam (rigid)" if rigid else f"follower beam ({modes} shapes that follow the slider)"]
        if mechanism.base.inertia > 0.0:
            bodies.append("base block")
        if mechanism.tip:
            bodies.append("tip body")
        if slider.mass > 0.0:
            bodies.append("slider mass")
        if slider.inertia > 0.0:
            bodies.append("slider rotary inertia")
        crank = "crank pivot" if mechanism.crank_is_free else "crank pivot (speed prescribed)"
        free = modes + (1 if mechanism.crank_is_free else 0)
        return ModelDescription(tuple(bodies), (crank, "follower pivot", "slider on the centre line (eliminated)"), free)

    def settings_for(self, accuracy: float, mechanism: Scene) -> ReferenceSettings:
        """Number of modes from the measured table; fewer where the follower is stiffer than run 24's."""
        usual = next(((modes, tolerance) for modes, tolerance, error in LADDER if error <= accuracy), LADDER[-1][:2])
        ratio = stiffness_ratio(mechanism) if isinstance(mechanism, Mechanism) else 0.0
        gain = min(1.0, (RATIO_OF_RUN_24 / ratio) ** 2) if ratio else 1.0
        modes, tolerance = next(((modes, tolerance) for modes, tolerance, error in LADDER if error * gain <= accuracy), usual)
        if modes < usual[0]:
            tolerance = min(tolerance, 10.0 ** math.floor(math.log10(TOLERANCE_PER_ACCURACY * accuracy) + 1e-9))
        return ReferenceSettings(modes=modes, tolerance=tolerance)

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """A run with more modes and a tolerance fit for them: it shows truncation and integration at once.

        A compliant joint takes fixed shapes (`_compliant`), whose error falls with the power 2.5 of their number or faster.
        """
        own = _own(settings)
        if math.isfinite(mechanism.slider.joint_stiffness):
            more = min(own.modes + max(2, own.modes // 2), MOST_MODES)
            other = more if more > own.modes else own.modes - 4
            return (Comparison(own, _with_modes(own, other), (own.modes / other) ** 2.5),)
        more, ratio = COMPARED.get(own.modes, (own.modes + 2, RATIO))
        if more > MOST_MODES:
            more, ratio = own.modes - 2, 1.0 / RATIO
        return (Comparison(own, _with_modes(own, more), ratio),)

    def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> ReferenceSettings | None:
        """The next rung of the ladder."""
        own = _own(settings)
        for modes, tolerance, _ in LADDER:
            if modes > own.modes:
                return own.replaced(modes=modes, tolerance=min(tolerance, own.tolerance))
        return None

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> ExplicitSimulation | OpenLoopSimulation:
        """See `engines.base.Engine.prepare`; with a compliant slider joint the model of `stiff-spring` (`_compliant`)."""
        self.check(mechanism)
        if math.isfinite(mechanism.slider.joint_stiffness):
            return _COMPLIANT.prepare(mechanism, start, _compliant(_own(settings)))
        own, began = _own(settings), time.perf_counter()
        model: ExplicitModel | MovingShapeModel
        if mechanism.follower.is_rigid:
            model = ExplicitModel(mechanism, no_shapes(mechanism.follower.length), True, False)
            state = model.initial_state(start.crank_angle, start.crank_speed)
        else:
            model = MovingShapeModel(mechanism, own.modes)
            state = _state(model, start)
        if not model.can_move(state):
            raise EngineFailure(0.0, "the loop cannot be closed in the given start", "try a start with a smaller deflection")
        return ExplicitSimulation(model, state, own.tolerance, "DOP853", time.perf_counter() - began)

    def steady_state(self, mechanism: Mechanism, start: Start, settings: Settings) -> SteadyState | None:
        """See `engines.base.Engine.steady_state`; a rigid follower or a compliant slider joint is marched."""
        simulation = self.prepare(mechanism, start, settings)
        return None if isinstance(simulation, OpenLoopSimulation) else orbit.steady_state(simulation)

    def periodic_start(self, mechanism: Mechanism, settings: Settings) -> Start:
        """The periodic steady state at the slider's farthest place, as a start for any engine.

        Raises:
            NoSteadyState: there is none, it was not found, or it is not stable.
        """
        found = self.steady_state(mechanism, standard_start(mechanism), settings)
        if found is None or not found.stable:
            raise NoSteadyState("a rigid follower or a soft joint is marched" if found is None else "the periodic state is not stable")
        assert isinstance(found.simulation, ExplicitSimulation)
        return found.simulation.present_start()

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: Settings) -> NDArray[np.float64]:
        """Converged, whatever the number of modes kept in simulations."""
        self.check(mechanism)
        if math.isfinite(mechanism.slider.joint_stiffness):
            shapes = max(48, 6 * count)
            return _COMPLIANT.natural_frequencies(mechanism, crank_angle, count, StiffSpringSettings(shapes=min(shapes, 64)))
        return frozen_crank_modes(mechanism, crank_angle, count).frequencies

    def follower_alone(self) -> "ReferenceAlone":
        """Modes of the beam clamped at its base in place of those that follow the slider."""
        return ReferenceAlone(self)


class ReferenceAlone(FollowerEngine):
    """The follower alone in its clamped modes; geometry and recovery are those of the mechanism."""

    def __init__(self, engine: ReferenceEngine) -> None:
        super().__init__(engine)
        self._engine = engine

    def describe(self, scene: FollowerAlone, settings: Settings) -> ModelDescription:
        """Bodies and joints that have terms in the equations."""
        modes = _own(settings).modes
        return ModelDescription(*parts(scene, f"follower beam ({modes} clamped modes)"), modes)

    def settings_for(self, accuracy: float, scene: FollowerAlone) -> ReferenceSettings:
        """The mechanism's table: clamped modes converge faster (five leave 6e-5 in the spin-up of the library)."""
        return self._engine.settings_for(accuracy, scene)

    def comparisons(self, settings: Settings, scene: FollowerAlone, output_step: float) -> tuple[Comparison, ...]:
        """A run with more modes, as with the mechanism; its error is a smaller part here, which makes the estimate a little too large."""
        own = _own(settings)
        more = own.modes + 2
        if more > MOST_MODES:
            return (Comparison(own, _with_modes(own, own.modes - 2), 1.0 / RATIO),)
        return (Comparison(own, _with_modes(own, more), RATIO),)

    def prepare(self, scene: FollowerAlone, start: None, settings: Settings) -> FollowerSimulation:
        """See `FollowerEngine.prepare`."""
        own, began = _own(settings), time.perf_counter()
        model = ClampedModel(scene, own.modes)
        return FollowerSimulation(model, model.state_at_rest(), own.tolerance, "DOP853", time.perf_counter() - began)


class _SoftJoint(StiffSpringEngine):
    """The model of `stiff-spring`, whose refusals name the engine that was asked for."""

    name = "reference"
    estimates = ReferenceEngine.estimates


_COMPLIANT: Final = _SoftJoint()


def _with_modes(settings: ReferenceSettings, modes: int) -> ReferenceSettings:
    """Other modes, with the tolerance of the first rung that has as many unless the present one is tighter."""
    fit = next((tolerance for rung, tolerance, _ in LADDER if rung >= modes), LADDER[-1][1])
    return settings.replaced(modes=modes, tolerance=min(settings.tolerance, fit))


def _compliant(settings: ReferenceSettings) -> StiffSpringSettings:
    """Settings of a scene with a compliant slider joint: shapes that follow the slider are those of a rigid support.

    Four clamped-free modes for each mode asked for leave about the same error (`engines.pseudo_coordinate.fixed_shapes.LADDER`).
    """
    return StiffSpringSettings(shapes=4 * settings.modes, tolerance=settings.tolerance)


def _state(model: MovingShapeModel, start: Start) -> NDArray[np.float64]:
    if start.deflection is None and start.deflection_rate is None:
        return model.straight_state(start.crank_angle, start.crank_speed)
    bent = reconstruct(model.mechanism, start)
    x = np.linspace(0.0, model.mechanism.follower.length, 32 * (model.modes + 2) + 1)
    angle = bent.tangent(x) - bent.follower_angle
    rate = bent.tangent_rate(x) - bent.follower_rate
    slider = (bent.slider_position, bent.slider_speed)
    return model.bent_state(start.crank_angle, start.crank_speed, slider, x, angle, rate)


def _own(settings: Settings) -> ReferenceSettings:
    if not isinstance(settings, ReferenceSettings):
        raise TypeError("not settings of the engine reference")
    return settings
