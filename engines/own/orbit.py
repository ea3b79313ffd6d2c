"""The explicit model's periodic steady state, found directly."""

import time
from typing import Final

from engines.base import NoSteadyState, SteadyState
from engines.own.simulation import OwnSimulation
from reference_model.model import BeamModel
from reference_model.periodic import NoPeriodicOrbit, periodic_orbit
from reference_model.section_map import turn_to

#: Distance at which the search makes its last step, which leaves a tenth of it or less: what counts as settled when marching.
TOLERANCE: Final = 1e-3


def steady_state(simulation: OwnSimulation) -> SteadyState:
    """The steady state near the simulation's present state, of a model in the tangent's angle with a closed loop.

    Raises:
        NoSteadyState: the search did not converge.
    """
    model = simulation.model
    assert isinstance(model, BeamModel)
    turn_to(model, simulation.state.copy(), float(simulation.state[0]), 1)  # so that no time counts its compiling
    began = time.perf_counter()
    try:
        orbit = periodic_orbit(model, simulation.state, TOLERANCE, simulation.tolerance)
    except NoPeriodicOrbit as reason:
        raise NoSteadyState(str(reason)) from reason
    solve_seconds = time.perf_counter() - began
    return SteadyState(
        simulation=OwnSimulation(model, orbit.state, simulation.tolerance, simulation.setup_seconds),
        period=orbit.period,
        multipliers=tuple(complex(multiplier) for multiplier in orbit.multipliers),
        stable=orbit.stable,
        iterations=orbit.iterations,
        cycles_of_work=orbit.cycles_of_work,
        residual=orbit.residual,
        solve_seconds=solve_seconds,
    )
