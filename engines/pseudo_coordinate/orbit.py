"""The explicit model's periodic steady state, found directly."""

import time
from typing import Final

from engines.base import NoSteadyState, SteadyState
from engines.pseudo_coordinate.simulation import ExplicitSimulation
from reference_model.moving_model import MovingShapeModel
from reference_model.periodic import NoPeriodicOrbit, periodic_orbit
from reference_model.section_map import load_code

#: Distance at which the search makes its last step, which leaves a tenth of it or less: what counts as settled when marching.
TOLERANCE: Final = 1e-3


def steady_state(simulation: ExplicitSimulation) -> SteadyState | None:
    """The steady state near the simulation's present state; None where the model has no shapes that follow the slider.

    Raises:
        NoSteadyState: the search did not converge.
    """
    model = simulation.model
    if not isinstance(model, MovingShapeModel):
        return None
    load_code(model.parameters, simulation.state)
    began = time.perf_counter()
    try:
        orbit = periodic_orbit(model, simulation.state, TOLERANCE, simulation.tolerance)
    except NoPeriodicOrbit as reason:
        raise NoSteadyState(str(reason)) from reason
    solve_seconds = time.perf_counter() - began
    return SteadyState(
        simulation=ExplicitSimulation(model, orbit.state, simulation.tolerance, "DOP853", simulation.setup_seconds),
        period=orbit.period,
        multipliers=tuple(complex(multiplier) for multiplier in orbit.multipliers),
        stable=orbit.stable,
        iterations=orbit.iterations,
        cycles_of_work=orbit.cycles_of_work,
        residual=orbit.residual,
        solve_seconds=solve_seconds,
    )
