"""Integration by LSODA, called once per output step as in the thesis (section 5.2)."""

import warnings
from collections.abc import Callable

import numpy as np
import scipy  # whose parts are imported when they are used
from numpy.typing import NDArray

from quickreturn.reference_model.integration import LEFT_FOLLOWER, NOT_A_NUMBER, REACHED_END, STEP_TOO_SMALL, TOO_MANY_CALLS, Integration

Array = NDArray[np.float64]


def integrate_lsoda(
    equations: Callable[[Array, Array], bool],
    watched: Array,
    y: Array,
    output_step: float,
    intervals: int,
    scales: Array,
    limit: float,
    unseen: float,
) -> Integration:
    """States on a uniform grid.

    Args:
        equations: function that writes dy/dt of a state to its second argument; False for an impossible state.
        watched: array whose first entry is the slider position in the state evaluated last, m.
        y: state at the start; not changed.
        output_step: grid of the output, s.
        intervals: number of output steps.
        scales: accepted local error of each controlled state, in its unit. The controlled states come first.
        limit: slider position at which the integration ends, m.
        unseen: accepted local error of the energies, J: so large that they do not matter, because they are quadratures.
    """
    size = len(y)
    rate = np.empty(size)

    def fun(_: float, state: Array) -> Array:
        equations(state, rate)
        return rate

    errors = np.full(size, unseen)
    errors[: len(scales)] = scales
    times = output_step * np.arange(intervals + 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", scipy.integrate.ODEintWarning)
        states, info = scipy.integrate.odeint(
            fun, y, times, tfirst=True, rtol=1e-14, atol=errors, mxstep=100_000, full_output=True, printmessg=False
        )
    good, status, last = len(states), REACHED_END, intervals - 1
    if info["message"] != "Integration successful.":
        # odeint does not initialise what comes after the first output step whose end it did not reach
        last = int(np.argmax(info["tcur"] < times[1:] - 1e-9 * output_step))
        good, status = 1 + last, TOO_MANY_CALLS if info["message"].startswith("Excess work") else STEP_TOO_SMALL
    for row in range(good):
        if not (np.all(np.isfinite(states[row])) and equations(states[row], rate)):
            good, status = row, NOT_A_NUMBER
            break
        if watched[0] > limit:
            good, status = row, LEFT_FOLLOWER
            break
    return Integration(states[:good], status, times[max(good - 1, 0)], int(info["nfe"][last]), 0.0)
