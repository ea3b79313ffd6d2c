"""Classical Runge-Kutta steps of the equations of motion in the crank angle (equation 10.3), compiled."""

from quickreturn.reference_model.native.pointers import call_equations, matrix_at, numbers_at


def steps_to(function: int, parameters: int, workspace: int, state: int, size: int, angle: float, parts: int, scratch: int) -> int:
    """Move a state, in place, to a crank angle (rad) by `parts` steps of equal angle; `poincare.turn_to` calls it.

    Args:
        function: address of the equations of motion.
        parameters: address of their parameters.
        workspace: address of their workspace.
        state: address of the state (size,), whose first entry is the crank angle.
        size: of the state.
        angle: where it ends, rad.
        parts: number of steps.
        scratch: address of memory (6, size): four stages, a trial state, and first in the last row the time (s) that passes.

    Returns:
        1; or 0 if a state on the way is impossible.
    """
    y, K = numbers_at(state, size), matrix_at(scratch, 6, size)
    h = (angle - y[0]) / parts
    elapsed = 0.0
    trial = K[4]
    for _ in range(parts):
        for stage in range(4):
            reach = 0.0 if stage == 0 else h if stage == 3 else 0.5 * h
            for i in range(size):
                trial[i] = y[i] + (reach * K[stage - 1, i] if stage > 0 else 0.0)
            if call_equations(function, parameters, workspace, trial.ctypes.data, K[stage].ctypes.data) == 0:
                return 0
            time_by_angle = 1.0 / K[stage, 0]
            elapsed += h * time_by_angle * (1.0 if stage in (0, 3) else 2.0) / 6.0
            for i in range(size):
                K[stage, i] *= time_by_angle
        for i in range(size):
            y[i] += h * (K[0, i] + 2.0 * K[1, i] + 2.0 * K[2, i] + K[3, i]) / 6.0
    y[0] = angle
    K[5, 0] = elapsed
    return 1
