"""A running simulation of the quick-return whose equations the computer derived, and its natural frequencies."""

import time
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.integrate import solve_ivp

from quickreturn.engines.base import EngineFailure, Simulation
from quickreturn.engines.start import Start
from quickreturn.engines.start_state import reconstruct
from quickreturn.engines.trajectory import Trajectory
from quickreturn.engines.units import Units
from quickreturn.plugins.derive.model import Model
from quickreturn.plugins.derive.statics import natural_frequencies
from quickreturn.plugins.derive.units import DescriptionError
from quickreturn.plugins.derive.witness.description import constants, quick_return
from quickreturn.plugins.derive.witness.recovery import columns
from quickreturn.plugins.derive.witness.tool import ForceRows
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.beam.tables import following
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.motion.layout import BeamTables
from quickreturn.reference_model.rigid import crank_pace, deflection_scale, rigid_motion, stiffness_across
from quickreturn.reference_model.spring import Spring
from quickreturn.reference_model.tip import Tip

#: Scale of the error of the slider's place, relative to the follower's length, and of a joint's gap, relative to the deflection.
SMALL: Final = 0.01
#: Relative tolerance of scipy's integrator, as small as rounding: the fixed scales of `_sizes` control the error.
ROUNDING: Final = 3e-14
#: Rate at which the gap of the loop decays, over the scene's unit of time: 96 1/s in run 24.
FEEDBACK: Final = 6.0
#: Length of the spring that stands for another one in small vibrations, over the scene's unit of length.
FAR: Final = 1e4
#: Part of the way to the follower's end. If the integration stops beyond it, the slider has left the follower.
NEARLY: Final = 0.97


class DerivedSimulation(Simulation):
    """Advances the state of the described system, in units of the scene's own: its feedback is in the unit of time."""

    def __init__(self, mechanism: Mechanism, start: Start, modes: int, tolerance: float) -> None:
        began = time.perf_counter()
        self.units = Units.of(mechanism)
        self.mechanism, start = self.units.scene(mechanism), self.units.start(start)
        self.modes, self.tolerance, self.time = modes, tolerance, 0.0
        self.shapes = following(self.mechanism, modes)
        values = constants(self.mechanism)
        if not mechanism.crank_is_free:
            values["start_angle"] = start.crank_angle
        self.values = self.model().values(values)
        self.state = self._begin(start)
        self.sizes = self._sizes()
        self.setup_seconds = time.perf_counter() - began + self.shapes.seconds

    def model(self) -> Model:
        """The compiled equations with the shapes of this scene."""
        mechanism = self.mechanism
        spring = mechanism.acting_spring is not None
        return model(self.shapes.tables, self.modes, mechanism.slider.is_rigid, not mechanism.crank_is_free, mechanism.tip_body, spring)

    def advance(self, duration: float, output_step: float) -> Trajectory:
        """See `Simulation.advance`."""
        began, equations = time.perf_counter(), self.model()
        in_si = self.time + output_step * np.arange(round(duration / output_step) + 1, dtype=np.float64)
        times = in_si / self.units.time
        solution = solve_ivp(
            equations.rates, (times[0], times[-1]), self.state, "DOP853", times, args=(self.values,), rtol=ROUNDING,
            atol=self.tolerance * self.sizes,
        )  # fmt: skip
        place = equations.system.tables[0].index
        states = solution.y.T if len(solution.t) else self.state[None]
        beyond_end = states[:, place] > self.shapes.reach
        states = states[: max(int(np.argmax(beyond_end)), 1)] if beyond_end.any() else states
        rows = equations.observe(times[: len(states)], states, self.values)
        shown = {str(name): values.to_numpy(dtype=np.float64) for name, values in rows.items()}
        table = columns(self.mechanism, shown, self.mechanism.follower.material_damping)
        table = {"time": in_si[: len(states)]} | self.units.columns_in_si(table)
        trajectory = Trajectory(table, time.perf_counter() - began, {"right_hand_side_calls": float(solution.nfev)})
        self.state, self.time = states[-1], float(in_si[len(states) - 1])
        if len(states) < len(times):
            gone = beyond_end.any() or states[-1, place] > NEARLY * self.shapes.reach
            cause = "the slider has left the follower's end" if gone else "the integration does not get on"
            raise EngineFailure(self.time, cause, "try a slower crank, a stiffer or longer follower", trajectory)
        return trajectory

    def _begin(self, start: Start) -> Array:
        """The state closest to a start in which the loop is closed without a gap."""
        equations, mechanism, n = self.model(), self.mechanism, self.modes
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
        """The scale of each state's error. It is fixed, so that it never vanishes.

        Amplitudes: the scene's deflection. Follower angle: the angle that moves the follower's end by this deflection. Rates: the scale of
        the state times the lowest frequency of the shapes. The integrals of power have infinite scales: their errors are not controlled.
        """
        equations, scene = self.model(), self.mechanism
        beam, bends = scene.follower, deflection_scale(scene)
        size = {"crank_angle": 0.1, "follower_angle": bends / beam.length, "slider_position": SMALL * beam.length, "gap": SMALL * bends}
        sizes = np.array([size.get(each.name, bends * np.sqrt(beam.mass)) for each in equations.system.coordinates])
        rates = np.sqrt(self.shapes.family.squares_at(np.array([self.state[2]]), 0)[0, 0]) * sizes
        rates[0] = 0.1 * crank_pace(scene)
        return np.concatenate([sizes, rates[equations.equations.free], [np.inf, np.inf]])


def frequencies(mechanism: Mechanism, crank_angle: float, modes: int) -> Array:
    """Natural frequencies (Hz) of the model with the crank held, linearised by differentiation."""
    units = Units.of(mechanism)
    mechanism = units.scene(mechanism)
    if (spring := mechanism.acting_spring) is not None:  # one without force, so long that it keeps its direction across the follower
        place = _rigid_place(mechanism, crank_angle)["follower_angle"]
        anchor = mechanism.pivot_distance + np.exp(1j * place) * complex(spring.place_on(mechanism.follower.length), FAR)
        stiffness = stiffness_across(mechanism, crank_angle)
        spring = Spring(stiffness=stiffness, anchor=(anchor.real, anchor.imag), place=spring.place, free_length=FAR)
        mechanism = replace(mechanism, spring=spring)
    held = mechanism.acting_spring is not None
    still = model(following(mechanism, modes).tables, modes, mechanism.slider.is_rigid, False, spring=held)
    at_rest = dict.fromkeys(("gravity_1", "gravity_2", "force_1", "force_2", "slide_friction", "torque"), 0.0)
    at = {"crank_angle": crank_angle} | _rigid_place(mechanism, crank_angle)
    return np.asarray(natural_frequencies(still, at, ["crank_angle"], constants(mechanism) | at_rest)) / units.time


_MODELS: Final[dict[tuple[int, int, bool, bool, bool, bool], Model]] = {}


def model(tables: BeamTables, modes: int, rigid: bool, prescribed: bool, tip: Tip | None = None, spring: bool = False) -> Model:
    """The equations of a structure, compiled once; the scene's values are inputs, its shapes and a table of forces go into the tables."""
    forces = None if tip is None else tip.force_table
    key = (modes, tables.gauss_points, rigid, prescribed, forces is not None, spring)
    if key not in _MODELS:
        description = quick_return(tables, modes, rigid=rigid, prescribed=prescribed, tabulated=forces is not None, spring=spring)
        _MODELS[key] = Model(description, feedback=FEEDBACK)
    of_shapes, *of_force = _MODELS[key].system.tables
    of_shapes.put(tables.low, tables.step, tables.coefficients)
    for rows in of_force:
        assert tip is not None
        assert forces is not None
        assert isinstance(rows, ForceRows)
        rows.follow(forces, tip.force_scale)
    return _MODELS[key]


def _rigid_place(mechanism: Mechanism, crank_angle: float) -> dict[str, float]:
    """Follower's angle and slider's place of the straight follower."""
    motion = rigid_motion(mechanism, np.array(crank_angle), 0.0)
    return {"follower_angle": float(motion.follower_angle), "slider_position": float(motion.slider_position)}
