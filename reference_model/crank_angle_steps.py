"""Classical Runge-Kutta steps of the equations of motion in the crank angle (equation 10.3), compiled."""

import math

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.machine.compilation import compiled
from quickreturn.reference_model.machine.pointers import call_equations


@compiled
def steps_to(
    function: int, parameters: int, workspace: int, y: NDArray[np.float64], angle: float, parts: int, K: NDArray[np.float64]
) -> float:
    """Move the state `y`, in place, to a crank angle (rad) by `parts` steps of equal angle; `poincare.turn_to` calls it.

    Args:
        function: address of the equations of motion.
        parameters: address of their parameters.
        workspace: address of their workspace.
        y: the state (n,); its first entry is the crank angle.
        angle: where it ends, rad.
        parts: number of steps.
        K: memory for four stages and a trial state (5, n).

    Returns:
        The time (s) that passes; nan if a state on the way is impossible.
    """
    size = len(y)
    h = (angle - y[0]) / parts
    elapsed = 0.0
    trial = K[4]
    for _ in range(parts):
        for stage in range(4):
            reach = 0.0 if stage == 0 else h if stage == 3 else 0.5 * h
            for i in range(size):
                trial[i] = y[i] + (reach * K[stage - 1, i] if stage > 0 else 0.0)
            if call_equations(function, parameters, workspace, trial.ctypes.data, K[stage].ctypes.data, 0) == 0:
                return math.nan
            time_by_angle = 1.0 / K[stage, 0]
            elapsed += h * time_by_angle * (1.0 if stage in (0, 3) else 2.0) / 6.0
            for i in range(size):
                K[stage, i] *= time_by_angle
        for i in range(size):
            y[i] += h * (K[0, i] + 2.0 * K[1, i] + 2.0 * K[2, i] + K[3, i]) / 6.0
    y[0] = angle
    return elapsed
