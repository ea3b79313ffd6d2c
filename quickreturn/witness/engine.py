"""The engine `derived`: a witness of `reference`, whose equations of motion the computer derives from a description.

It shares with `reference` the shapes that follow the slider, their tables and their known errors; nothing else. The ladder's errors are
those of the shapes (`engines/LADDERS.md`, section 1).
"""

import time
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from quickreturn.engines import refusals
from quickreturn.engines.base import SPRING, USUAL, Comparison, Engine, EngineFailure, ModelDescription, Refusal, Simulation, installed
from quickreturn.engines.ladder import Ladder
from quickreturn.engines.own.beam_engine import ELIMINATED_SLIDER, description
from quickreturn.engines.own.reference import ALIKE, COMPARED, RATIO, SLOWEST, SMOOTH, fitted
from quickreturn.engines.settings import Settings, setting
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import reconstruct
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.beam.tables import following
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.motion.layout import Tables
from quickreturn.reference_model.rigid import crank_pace, deflection_scale

if TYPE_CHECKING:
    from quickreturn.derive import Model

Array = NDArray[np.float64]

#: Largest number of modes. The code has no loops: it grows with the square of the points and with the modes, to 74,000 instructions for 11.
MOST_MODES: Final = 11
#: Sizes of errors: of the slider's place over the follower's length, and of a joint's gap over the deflection.
SMALL: Final = 0.01
#: Relative error that scipy's integrator takes for rounding; what counts are the fixed sizes.
ROUNDING: Final = 3e-14
#: Part of the way to the follower's end beyond which a slider that cannot be followed any farther has left it.
NEARLY: Final = 0.97


@dataclass(frozen=True, kw_only=True)
class DerivedSettings(Settings):
    """Settings of `derived`."""

    modes: int = setting(2, "modes of the beam supported at the slider", low=1, high=MOST_MODES)
    tolerance: float = setting(1e-7, "local error of the integration, relative to fixed sizes of the states", low=1e-11, high=1e-4)


#: Number of modes, tolerance, and the error of the tip deflection that this number of modes leaves in run 24 over 2 s.
_RUNGS: Final = ((1, 1e-6, 2.7e-2), (2, 1e-6, 1.5e-3), (4, 1e-7, 8e-4), (5, 1e-7, 4.9e-4), (7, 1e-8, 8.2e-5))
LADDER: Final = Ladder(
    tuple((DerivedSettings(modes=modes, tolerance=tolerance), claim) for modes, tolerance, claim in _RUNGS), "modes", "tolerance"
)


class DerivedEngine(Engine[DerivedSettings]):
    """Simulates the quick-return by equations that are derived from its description."""

    name = "derived"
    interface = 1
    method = "equations derived by the computer from a description (CasADi), shapes that follow the slider, DOP853"
    compiles = True
    default_accuracy = 3e-3
    settings_type = DerivedSettings
    quantities = (*USUAL, "slider.inertia", *SPRING, "base.friction_torque", "follower.material_damping")

    def version(self) -> str:
        """The version of CasADi."""
        return f"casadi {installed('casadi') or 'not installed'}"

    def unavailable(self) -> str | None:
        """The missing package, and how to install it."""
        return None if find_spec("casadi") else "CasADi is not installed; pip install 'quickreturn[derive]'"

    def check(self, scene: Scene) -> None:
        """Raise Refusal also for a rigid follower and, if the joint is compliant, for parts without inertia."""
        super().check(scene)
        if scene.follower.is_rigid:
            raise Refusal(f"follower.bending_stiffness: inf N*m^2 is not modelled by engine {self.name}; accepted: a finite stiffness")
        if not scene.slider.is_rigid:
            refusals.of_massless_parts(self.name, scene, " with a compliant joint, which does not hold the follower")

    def describe(self, mechanism: Mechanism, settings: DerivedSettings) -> ModelDescription:
        """The bodies and joints that have terms in the equations."""
        self.check(mechanism)
        slider, rigid = mechanism.slider, mechanism.slider.is_rigid
        compliant = f"slider beside the centre line (compliant joint, {slider.joint_stiffness:g} N/m, {slider.joint_damping:g} N*s/m)"
        beam = f"{settings.modes} shapes that follow the slider"
        return description(mechanism, beam, ELIMINATED_SLIDER if rigid else compliant, settings.modes + (not rigid))

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> DerivedSettings:
        """The settings of the ladder, with fewer modes if the follower is stiffer than that of run 24."""
        return fitted(LADDER, accuracy, mechanism)

    def comparisons(self, settings: DerivedSettings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        """Compare with a run of more modes, as many as `reference` takes; if that does not suffice, with one of still more modes."""
        more, ratio = COMPARED.get(settings.modes, (settings.modes + 2, RATIO))
        if more > MOST_MODES:
            return (Comparison(settings, LADDER.sized(settings, settings.modes - 2), 1.0 / RATIO),)
        finer, further = LADDER.sized(settings, more), None
        if more + 2 <= MOST_MODES:
            further = Comparison(finer, LADDER.sized(finer, more + 2), RATIO if settings.modes < SMOOTH else SLOWEST)
        return (Comparison(settings, finer, ratio, further, alike=ALIKE.get(settings.modes, 0.0)),)

    def finer(self, settings: DerivedSettings, excess: tuple[float, ...], output_step: float) -> DerivedSettings | None:
        """The next settings of the ladder."""
        return LADDER.finer(settings, excess)

    def prepare(self, mechanism: Mechanism, start: Start, settings: DerivedSettings) -> "DerivedSimulation":
        """See `Engine.prepare`."""
        self.check(mechanism)
        began = time.perf_counter()
        return DerivedSimulation(mechanism, start, settings, began)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: DerivedSettings) -> Array:
        """Of the discretized model with two modes more than asked for, linearised by differentiation.

        The shapes contain neither the slider's rotary inertia nor a compliant joint: each changes the third frequency by some per cent.
        """
        from quickreturn.derive import natural_frequencies
        from quickreturn.witness.description import constants

        self.check(mechanism)
        modes = min(max(settings.modes, count + 2), MOST_MODES)
        tables = following(mechanism, modes).placed.tables
        still = model(tables, modes, mechanism.slider.is_rigid, False)
        at_rest = dict.fromkeys(("gravity_1", "gravity_2", "force_1", "force_2", "torque"), 0.0)
        at = {"crank_angle": crank_angle} | _rigid_place(mechanism, crank_angle)
        found: Array = natural_frequencies(still, at, ["crank_angle"], constants(mechanism) | at_rest)
        return found[:count]


class DerivedSimulation(Simulation):
    """Advances the state of the described system."""

    def __init__(self, mechanism: Mechanism, start: Start, settings: DerivedSettings, began: float) -> None:
        from quickreturn.witness.description import constants

        self.mechanism, self.settings, self.time = mechanism, settings, 0.0
        self.shapes = following(mechanism, settings.modes)
        values = constants(mechanism)
        if not mechanism.crank_is_free:
            values["start_angle"] = start.crank_angle
        self.values = self.model().values(values)
        self.state = self._begin(start)
        self.sizes = self._sizes()
        self.setup_seconds = time.perf_counter() - began + self.shapes.seconds

    def model(self) -> "Model":
        """The compiled equations, with this scene's shapes in their tables."""
        mechanism = self.mechanism
        return model(self.shapes.placed.tables, self.settings.modes, mechanism.slider.is_rigid, not mechanism.crank_is_free)

    def advance(self, duration: float, output_step: float) -> Trajectory:
        """See `Simulation.advance`."""
        from quickreturn.witness.recovery import columns

        began, equations = time.perf_counter(), self.model()
        times = self.time + output_step * np.arange(round(duration / output_step) + 1, dtype=np.float64)
        tolerance = self.settings.tolerance
        found = solve_ivp(
            equations.rates, (times[0], times[-1]), self.state, "DOP853", times, args=(self.values,), rtol=ROUNDING,
            atol=tolerance * self.sizes,
        )  # fmt: skip
        place = equations.system.tables[0].index
        states = found.y.T if len(found.t) else self.state[None]
        left = states[:, place] > self.shapes.placed.reach
        states = states[: max(int(np.argmax(left)), 1)] if left.any() else states
        rows = equations.observe(times[: len(states)], states, self.values)
        shown = {str(name): values.to_numpy(dtype=np.float64) for name, values in rows.items()}
        table = {"time": times[: len(states)]} | columns(self.mechanism, shown, self.mechanism.follower.material_damping)
        trajectory = Trajectory(table, time.perf_counter() - began, {"right_hand_side_calls": float(found.nfev)})
        self.state, self.time = states[-1], float(times[len(states) - 1])
        if len(states) < len(times):
            gone = left.any() or states[-1, place] > NEARLY * self.shapes.placed.reach
            cause = "the slider has left the follower's end" if gone else "the integration does not get on"
            raise EngineFailure(self.time, cause, "try a slower crank, a stiffer or longer follower", trajectory)
        return trajectory

    def _begin(self, start: Start) -> Array:
        """The state closest to a start, its loop closed without a gap."""
        from quickreturn.derive import DescriptionError

        equations, mechanism, n = self.model(), self.mechanism, self.settings.modes
        names = [each.name for each in equations.system.coordinates]
        q, v = np.zeros(len(names)), np.zeros(len(names))
        bent = reconstruct(mechanism, start)
        q[:3], v[:3] = (start.crank_angle, bent.follower_angle, bent.slider_position), (start.crank_speed, 0.0, 0.0)
        if start.deflection is not None or start.deflection_rate is not None:
            x = np.linspace(0.0, mechanism.follower.length, 32 * (n + 2) + 1)
            psi, psi_s = self.shapes.family.angles(bent.slider_position, x)
            q[3 : 3 + n] = np.linalg.lstsq(psi, bent.tangent(x) - bent.follower_angle, rcond=None)[0]
            rate = bent.tangent_rate(x) - bent.follower_rate - psi_s @ q[3 : 3 + n] * bent.slider_speed
            v[3 : 3 + n] = np.linalg.lstsq(psi, rate, rcond=None)[0]
        try:
            return equations.closed(q, v, self.values, [1, 2], [1, 2])
        except DescriptionError as open_loop:
            cause = "the loop cannot be closed in the given start"
            raise EngineFailure(0.0, cause, "try a start with a smaller deflection") from open_loop

    def _sizes(self) -> Array:
        """What errors are relative to: for amplitudes the scene's deflection, and what turns the follower's end by as much.

        Fixed, so that none vanishes. Rates are measured in the lowest frequency of the shapes. The integrals of power are not controlled.
        """
        equations, scene = self.model(), self.mechanism
        beam, bends = scene.follower, deflection_scale(scene)
        size = {"crank_angle": 0.1, "follower_angle": bends / beam.length, "slider_position": SMALL * beam.length, "gap": SMALL * bends}
        sizes = np.array([size.get(each.name, bends * np.sqrt(beam.mass)) for each in equations.system.coordinates])
        rates = np.sqrt(self.shapes.family.squares_at(np.array([self.state[2]]), 0)[0, 0]) * sizes
        rates[0] = 0.1 * crank_pace(scene)
        return np.concatenate([sizes, rates[equations.equations.free], [np.inf, np.inf]])


_MODELS: Final[dict[tuple[int, int, bool, bool], "Model"]] = {}


def model(tables: Tables, modes: int, rigid: bool, prescribed: bool) -> "Model":
    """The equations of a structure, compiled once; the scene's values are inputs, and its shapes go into the table."""
    from quickreturn.derive import Model
    from quickreturn.witness.description import quick_return

    key = (modes, tables.gauss_points, rigid, prescribed)
    if key not in _MODELS:
        _MODELS[key] = Model(quick_return(tables, modes, rigid=rigid, prescribed=prescribed))
    _MODELS[key].system.tables[0].put(tables.low, tables.step, tables.coefficients)
    return _MODELS[key]


def _rigid_place(mechanism: Mechanism, crank_angle: float) -> dict[str, float]:
    """Follower's angle and slider's place of the straight follower."""
    chord = mechanism.crank.length * np.exp(1j * crank_angle) - mechanism.pivot_distance
    return {"follower_angle": float(np.pi + np.angle(-chord)), "slider_position": float(abs(chord))}
