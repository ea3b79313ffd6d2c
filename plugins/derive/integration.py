"""Integrates the states of a model by steps of scipy's methods."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy import integrate

from quickreturn.plugins.derive.compiled import CompiledEquations
from quickreturn.plugins.derive.singular import Watch
from quickreturn.plugins.derive.units import DescriptionError

Array = NDArray[np.float64]
#: A function that gives the rate of the state at a time, for a state and values of the parameters.
Rates = Callable[[float, Array, Array], Array]

METHODS: Final[dict[str, Any]] = {"DOP853": integrate.DOP853, "Radau": integrate.Radau}
#: Longest step of DOP853 times the rate of the feedback. At 6 the method is unstable; at 5 rates in rows between the ends of a step are off
#: by 2e-6 at a tolerance of 1e-9, at 3 by 3e-8.
LONGEST: Final = 3.0


def integrated(
    model: CompiledEquations, rates: Rates, y: Array, times: Array, p: Array, tolerance: float, sizes: Array, method: str
) -> tuple[Array, int]:
    """The states at given times, shape (times, len(y)), and the number of steps.

    Args:
        model: the compiled equations.
        rates: of the integrated state, of which that of the model is the first part.
        y: state at time 0.
        times: s, ascending from 0.
        p: values of the parameters, SI.
        tolerance: local error, relative to each state and to `sizes`.
        sizes: scale of each state's error.
        method: a name in METHODS.

    Raises:
        DescriptionError: an unknown method or tolerance, a singular position, or the integration finds no step; the sentence says when.
    """
    if method not in METHODS:
        raise DescriptionError(f"method {method!r} is not known; take one of {', '.join(METHODS)}")
    if not 0.0 < tolerance < 1.0:
        raise DescriptionError(f"a tolerance of {tolerance:g} is not between 0 and 1")
    system, e, watch = model.system, model.equations, Watch(model, p, y)
    longest = LONGEST / e.feedback if e.feedback and e.gap.numel() and method == "DOP853" else np.inf

    def begun(time: float, state: Array, first_step: float | None = None) -> Any:
        accuracy: Any = {"rtol": tolerance, "atol": tolerance * sizes, "max_step": longest}
        return METHODS[method](lambda t, y: rates(t, y, p), time, state, times[-1], first_step=first_step, **accuracy)

    states, row, steps = np.tile(y, (len(times), 1)), 1, 0
    if row == len(times):
        return states, steps
    solver = begun(0.0, y)
    while solver.status == "running" and row < len(times):
        before = solver.y
        # where a motion ends, a step too far has rates that are no numbers
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            message = solver.step()
        if solver.status == "failed":
            watch.stuck(solver.t, solver.y)
            ends = ", ".join(system.coordinates[table.index].name for table in system.tables)
            cause = f" ({ends} may have left its table)" if ends else ""
            raise DescriptionError(f"the integration of {system.name!r} gets stuck after {solver.t:g} s{cause}: {message}")
        if not watch.follows(solver.t, solver.y):
            solver = begun(solver.t_old, before, 0.5 * (solver.t - solver.t_old))
            continue
        steps, end = steps + 1, int(np.searchsorted(times, solver.t, side="right"))
        if end > row:  # evaluating between steps costs rates
            there = solver.dense_output()
            states[row:end] = [there(time) for time in times[row:end]]
            row = end
    return states, steps
