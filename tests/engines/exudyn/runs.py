"""Runs of the Exudyn engine, a start with a bent follower, and an arm of any proportions."""

import numpy as np
from scipy.interpolate import PPoly

from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Trajectory, relative_error
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, Crank, Mechanism, PrescribedSpeed
from quickreturn.reference_model.tip import Tip
from tests.engines.scenes import run_24


def simulate(mechanism: Mechanism, duration: float, start: Start | None = None, output_step: float = 1e-3, **settings) -> Trajectory:
    """A run with 24 elements, and Newton's iteration to 1e-5, unless `settings` say otherwise."""
    chosen = ExudynSettings(**{"elements": 24, "newton_tolerance": 1e-5, **settings})
    prepared = ExudynEngine().prepare(mechanism, start or standard_start(mechanism), chosen)
    return prepared.advance(duration, output_step)


def bent_start() -> Start:
    """A quartic deflection of 26 mm at the tip, free of moment at both ends, and a rate of the same shape."""
    length = run_24().follower.length
    quartic = np.array([[-1.0], [2.0 * length], [0.0], [0.0], [0.0]]) / length**2  # x³ (2 L - x) / L²
    ends = np.array([0.0, length])
    return Start(2.0, 16.6, PPoly(0.1 * quartic, ends), PPoly(quartic, ends))


def arm(length: float, slenderness: float, width: float, speed: float, damping: float, tip: Tip | None = None) -> Mechanism:
    """A steel arm `slenderness` times as long as thick, its crank a fifth of it and turned at `speed` (rad/s)."""
    thickness = length / slenderness
    follower = Follower(
        length=length,
        mass_per_length=7850.0 * width * thickness,
        bending_stiffness=210e9 * width * thickness**3 / 12.0,
        thickness=thickness,
        width=width,
        damping=damping * 7850.0 * width * thickness,
        strain_gauges=(0.25 * length, 0.5 * length, 0.75 * length),
    )
    crank = Crank(length=0.2 * length, drive=PrescribedSpeed(speed=speed))
    return Mechanism(pivot_distance=0.54 * length, crank=crank, base=Base(), follower=follower, tip=tip)


def errors_of(mechanism: Mechanism, duration: float, modes: int, **settings) -> dict[str, float]:
    converged = ReferenceSettings(modes=modes, tolerance=1e-9)
    truth = run_once(ReferenceEngine(), mechanism, standard_start(mechanism), duration, 1e-3, converged).trajectory
    found = simulate(mechanism, duration, **settings)
    return {name: relative_error(found[name], truth[name]) for name in ESTIMATED}
