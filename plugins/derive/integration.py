"""Integrates the states of a model: steps of scipy's methods, and passages of singular positions between them."""

from collections.abc import Callable
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy import integrate

from quickreturn.plugins.derive.collocation import Passage
from quickreturn.plugins.derive.singular import Watch
from quickreturn.plugins.derive.units import DescriptionError

Array = NDArray[np.float64]
#: A function that gives the rate of the state at a time and a state.
Rates = Callable[[float, Array], Array]

METHODS: Final[dict[str, Any]] = {"DOP853": integrate.DOP853, "Radau": integrate.Radau}
#: Singular value of the loops below which a method that finds no step is stuck in a singular position.
STUCK: Final = 1e-3


def integrated(
    rates: Rates,
    y: Array,
    times: Array,
    tolerance: float,
    sizes: Array,
    method: str,
    watch: Watch,
    longest: float,
    name: str,
    ends: str = "",
    departure: Passage | None = None,
) -> tuple[Array, list[Passage], int]:
    """The states at given times, shape (times, len(y)), the passages, and the number of steps.

    Args:
        rates: of the state.
        y: state at time 0; the watch takes its first entries for that of the model.
        times: s, ascending from 0.
        tolerance: local error, relative to each state and to `sizes`.
        sizes: scale of each state's error.
        method: a name in METHODS.
        watch: of the loops.
        longest: s, longest step.
        name: of the system, for messages.
        ends: what else may have ended the motion, for messages.
        departure: the step with which the motion begins, away from a singular position.

    Raises:
        DescriptionError: an unknown method or tolerance, or the integration finds no step; the sentence says when.
    """
    if method not in METHODS:
        raise DescriptionError(f"method {method!r} is not known; take one of {', '.join(METHODS)}")
    if not 0.0 < tolerance < 1.0:
        raise DescriptionError(f"a tolerance of {tolerance:g} is not between 0 and 1")

    def begun(time: float, state: Array, first_step: float | None = None) -> Any:
        accuracy: Any = {"rtol": tolerance, "atol": tolerance * sizes, "max_step": longest}
        return METHODS[method](rates, time, state, times[-1], first_step=first_step, **accuracy)

    states, row, passages, time, steps = np.tile(y, (len(times), 1)), 1, list[Passage](), 0.0, 0
    if departure:
        passages, row = [departure], _filled(states, times, 1, departure.times[-1], departure.at)
        time, y = departure.times[-1], departure.states[-1]
    if row == len(times):
        return states, passages, steps
    solver = begun(time, y)
    while solver.status == "running" and row < len(times):
        before = solver.y
        with np.errstate(
            invalid="ignore", over="ignore", divide="ignore"
        ):  # where a motion ends, a step too far has rates that are no numbers
            message = solver.step()
        if solver.status == "failed":
            if watch.smallest < STUCK:
                watch.ends(solver.t, solver.y)
            raise DescriptionError(f"the integration of {name!r} gets stuck after {solver.t:g} s{ends}: {message}")
        if not watch.follows(solver.t, solver.y):
            solver = begun(solver.t_old, before, 0.5 * (solver.t - solver.t_old))
            continue
        there, steps = _lazily(solver.dense_output), steps + 1
        row = _filled(states, times, row, solver.t, there)
        passage = watch.passage(solver.t, solver.y, there, solver.t - solver.t_old)
        if passage:
            passages.append(passage)
            row = _filled(states, times, row, passage.times[-1], passage.at)
            if row < len(times):
                solver = begun(passage.times[-1], passage.states[-1])
    return states, passages, steps


def _lazily(make: Callable[[], Callable[[float], Array]]) -> Callable[[float], Array]:
    """A function that is made at its first call: between steps it costs evaluations of the rates."""
    made = cache(make)
    return lambda time: made()(time)


def _filled(states: Array, times: Array, row: int, until: float, at: Callable[[float], Array]) -> int:
    """The next row, after all up to a time have their states."""
    end = int(np.searchsorted(times, until, side="right"))
    for k in range(row, end):
        states[k] = at(times[k])
    return max(row, end)
