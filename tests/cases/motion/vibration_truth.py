"""The first mode's frequency in a periodic steady state, without the fit and its time scale's corrections.

The first coordinate of shapes that follow the slider is the modal coordinate of the crank held still. Two small launches of it from the
start of a half, in deflection and in rate, each added to and subtracted from the steady motion, span every free vibration on that motion;
the phase of each advances by 2 pi times the mean frequency times the time. The mean over sixteen launch phases is the truth: their
scatter, 0.01 to 0.13 % in the thesis' runs and 0.37 % at worst in random scenes, divided by four is what it lacks.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.motion.cycle import CycleMeasures, measure_cycle
from quickreturn.cases.motion.marching import ROWS_AFTER, output_step, whole_cycles
from quickreturn.cases.motion.settling import Cycle
from quickreturn.cases.motion.time_scale import CHANNELS, TimeScale, time_scale
from quickreturn.engines.base import NoSteadyState
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.model import BeamModel

SETTINGS = ReferenceSettings(modes=5, tolerance=1e-7)
INTEGRATION = 1e-9
LAUNCH = 1e-3  # of the first coordinate at the farthest place, and at least 1e-7
LAUNCHES = 16


@dataclass(frozen=True)
class SteadyVibration:
    """A steady cycle, what is measured of it, and the true frequencies (Hz) with the scatter over launch phases, pre-return first."""

    cycle: Cycle
    measures: CycleMeasures
    truth: tuple[float, float]
    scatter: tuple[float, float]

    def z(self) -> tuple[Array, Array]:
        """Errors over claimed uncertainties of the channels' and of the consensus frequencies."""
        of_half = dict(zip(("pre", "post"), self.truth, strict=True))
        channels = [
            (m.first_mode_frequency - of_half[m.half]) / m.first_mode_frequency_uncertainty
            for m in self.measures.measures
            if m.first_mode_frequency is not None and m.first_mode_frequency_uncertainty is not None
        ]
        together = [
            (c.first_mode_frequency - of_half[c.half]) / c.uncertainty
            for c in self.measures.consensus
            if c.first_mode_frequency is not None and c.uncertainty is not None
        ]
        return np.array(channels), np.array(together)


def steady_vibration(mechanism: Mechanism) -> SteadyVibration | None:
    """Of a scene; None where its steady state is not found directly."""
    try:
        found = ReferenceEngine().steady_state(mechanism, standard_start(mechanism), SETTINGS)
    except NoSteadyState:
        return None
    if found is None or not found.stable:
        return None
    simulation, scale = found.simulation, time_scale(mechanism)
    assert scale is not None
    farthest = simulation.state.copy()
    step = output_step(mechanism)
    cycle = whole_cycles(simulation.advance(step * (math.ceil(found.period / step) + ROWS_AFTER), step))[0]
    turned = np.abs(cycle.crank_angle - cycle.crank_angle[0])
    half = float(CubicSpline(turned, cycle.time)(np.pi) - cycle.time[0])
    nearest = simulation.model.integrate(farthest, half, 1, INTEGRATION).states[-1]
    ends = (farthest, half), (nearest, float(cycle.time[-1] - cycle.time[0]) - half)
    truths, scatters = zip(*(_mean_frequency(simulation.model, scale, state, duration, step) for state, duration in ends), strict=True)
    measures = measure_cycle(scale, cycle.time, cycle.crank_angle, {name: cycle.channels[name] for name in CHANNELS})
    return SteadyVibration(cycle, measures, truths, scatters)


def _mean_frequency(model: BeamModel, scale: TimeScale, state: Array, duration: float, step: float) -> tuple[float, float]:
    """Mean over `duration` (s) from `state`, Hz, and its standard deviation over launch phases; recorded every `step` (s)."""
    size = max(LAUNCH * abs(state[1]), 1e-7)
    rows = math.ceil(duration / step) + ROWS_AFTER
    rate = model.shapes + 3
    launches = []
    for index, push in ((1, size), (rate, size * 2.0 * np.pi * float(scale.frequencies(state[0])[0]))):
        motions = []
        for sign in (1.0, -1.0):
            moved = state.copy()
            moved[index] += sign * push
            motions.append(model.integrate(moved, step, rows, INTEGRATION).states)
        change, omega = motions[0] - motions[1], 2.0 * np.pi * scale.frequencies(motions[0][:, 0])[:, 0]
        launches.append(np.array([change[:, 1], -change[:, rate] / omega]))
    time = step * np.arange(rows + 1)
    means = []
    for launch in 2.0 * np.pi * np.arange(LAUNCHES) / LAUNCHES:
        coordinate, quarter = np.cos(launch) * launches[0] + np.sin(launch) * launches[1]
        first, last = CubicSpline(time, np.unwrap(np.arctan2(quarter, coordinate)))([0.0, duration])
        means.append((last - first) / (2.0 * np.pi * duration))
    return float(np.mean(means)), float(np.std(means))
