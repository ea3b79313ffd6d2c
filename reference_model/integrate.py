"""Time integration by compiled loops that know no model: a right-hand side, a state, error scales and an event.

Explicit (`dop853_loop`): DOP853 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.5), order 8, error
control by the embedded formulas of orders 5 and 3. Output rows within a step are interpolated from its stages. A step that needs a state in
which the loop cannot close is rejected like one with too large an error.

Implicit (`radau_loop`), for equations M(q, u) du/dt = f(q, u) of stiff mechanisms: Radau IIA, order 5 (Hairer and Wanner, part II, section
IV.8). RADAU.md derives what differs: Newton's matrix comes from the model's own mass, damping and stiffness, and residuals are forces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.entries import IMPLICIT_LOOP, LOOP
from quickreturn.reference_model.native.memory import ComplexMatrix, ComplexVector, Cube, Matrix, Placed, Vector

#: Stages of a step of DOP853; the rate at its end is the first stage of the next.
STAGES: Final = 12
#: How an integration ends.
REACHED_END, LEFT_FOLLOWER, STEP_TOO_SMALL, TOO_MANY_CALLS, NOT_A_NUMBER = range(5)


@dataclass(frozen=True)
class Integration:
    """What an integration delivered.

    Attributes:
        states: rows of the state vector on the output grid, as far as it was reached, shape (k, size of the state).
        status: one of the module's constants.
        end_time: s since the start of this integration, the last instant reached.
        calls: right-hand sides evaluated.
        next_step: step size (s) to continue with where the end was reached (0 for LSODA).
    """

    states: Array
    status: int
    end_time: float
    calls: int
    next_step: float


#: Size of the first step, and of the least, over the time of the motion: that of the output would make the rows change the steps.
FIRST_STEP: Final = 1e-3
LEAST_STEP: Final = 1e-11


@dataclass(frozen=True)
class Equations:
    """A right-hand side in compiled code, and its first arguments, by address.

    Attributes:
        function: address of the equations (see `reference_model.motion.equations.kernel`). They write dy/dt of a state, and return 0 where
            the state is impossible.
        parameters, workspace: addresses of its first two arguments.
        watched: slider position (m) and highest angular frequency (rad/s, 0 if unknown) of the state evaluated last; shape (2,), part of
            the workspace.
    """

    function: int
    parameters: int
    workspace: int
    watched: Array


def dop853(
    equations: Equations,
    y: Array,
    output_step: float,
    intervals: int,
    scales: Array,
    limit: float,
    pace: float,
    first_step: float = 0.0,
) -> Integration:
    """Integrate from the state `y` over `intervals` output steps with the compiled DOP853.

    Args:
        equations: the right-hand side.
        y: state at the start; not changed.
        output_step: grid of the output, s.
        intervals: number of output steps.
        scales: accepted local error of each controlled state, in its unit, shape (number of them,). The controlled states come first.
        limit: slider position at which the integration ends, m.
        pace: rate of the motion, 1/s, such as `constants.pace`, which gives the sizes of the first step and of the least.
        first_step: step size to begin with, s; 0 for `FIRST_STEP`.
    """
    size, controlled = len(y), len(scales)
    width = 4 * math.ceil(size / 4)  # four numbers take one register
    padded, precisions = np.zeros(width), np.zeros(width)
    padded[:size], precisions[:controlled] = y, 1.0 / scales
    states, scratch, K = np.zeros((intervals + 1, width)), np.zeros((2, width)), np.zeros((STAGES + 1, width))
    watched, end = equations.watched, np.empty(4)
    at = equations.function, equations.parameters, equations.workspace
    sizes = width, output_step, intervals, precisions.ctypes.data, controlled, limit, first_step or FIRST_STEP / pace, LEAST_STEP / pace
    status = LOOP(*at, watched.ctypes.data, padded.ctypes.data, *sizes, *(each.ctypes.data for each in (states, K, scratch, end)))
    rows, calls, (time, step) = int(end[0]), int(end[2]), end[1::2].tolist()
    return Integration(np.ascontiguousarray(states[:rows, :size]), status, time, calls, step)


@dataclass(frozen=True)
class Linearisation:
    """The linearised equations in compiled code, for the state that the equations evaluated last.

    Their unknowns are the accelerations of m speeds and the forces of the constraints, if there are any. A row of a constraint holds what
    its second derivative is made of.

    Attributes:
        linearise: address of a function of parameters, workspace, matrices and size. It writes mass, damping and stiffness to the
            matrices (3, size, size); columns of the forces stand in the stiffness (RADAU.md, equation 4).
        weigh: address of a function of parameters, workspace, accelerations (m,) and forces (size,). It writes the product of the mass
            matrix with the accelerations.
        speeds: m; the state begins with as many coordinates, whose rates the speeds are.
        first_speed: place of the first speed in the state.
        size: number of unknowns.
    """

    linearise: int
    weigh: int
    speeds: int
    first_speed: int
    size: int


class RadauRun(NamedTuple):
    """Constants and arrays of one integration, for N states, m speeds and e unknowns of the linearised equations."""

    function: int  # addresses, see `Equations` and `Linearisation`
    parameters: int
    workspace: int
    linearise: int
    weigh: int
    speeds: int  # m
    first_speed: int
    intervals: int
    output_step: float  # s
    limit: float  # m
    first_step: float  # s
    least_step: float  # s
    watched: Vector  # (2,) see `Equations`
    precisions: Vector  # (controlled,) one over the accepted local error
    y: Vector  # (N,) the state at the begin of the step
    rate: Vector  # (N,) its rate
    trial: Vector  # (N,) a stage's state, or the next one
    trial_rate: Vector  # (N,)
    Z: Matrix  # (3, N) increments of the stages from y
    Z_before: Matrix  # (3, N) those of the step before
    residuals: Matrix  # (3, N)
    forces: Matrix  # (3, e) the residuals of the speeds, as forces, and those of the constraints
    residual: Vector  # (N,) transformed for the real eigenvalue; then the change of the increments
    force: Vector  # (e,)
    complex_residual: ComplexVector  # (N,) likewise for the complex eigenvalue
    complex_force: ComplexVector  # (e,)
    matrices: Cube  # (3, e, e) mass, damping and stiffness
    factors: Matrix  # (e, e) of Newton's matrix for the real eigenvalue
    complex_factors: ComplexMatrix  # (e, e)
    contraction: Vector  # (1,) ratio of the last two changes in Newton's iteration
    states: Matrix  # (intervals + 1, N) rows of the output
    ended: Vector  # (4,) number of rows, last instant (s), right-hand sides, next step (s)


def radau(
    equations: Equations,
    linearisation: Linearisation,
    y: Vector,
    output_step: float,
    intervals: int,
    scales: Vector,
    limit: float,
    pace: float,
    first_step: float = 0.0,
) -> Integration:
    """Integrate from the state `y` over `intervals` output steps; arguments as of `integrate.dop853`, and the linearised equations."""
    N, e = len(y), linearisation.size
    vectors = {name: np.zeros(N) for name in ("rate", "trial", "trial_rate", "residual")}
    stages = {name: np.zeros((3, N)) for name in ("Z", "Z_before", "residuals")}
    run = RadauRun(
        function=equations.function,
        parameters=equations.parameters,
        workspace=equations.workspace,
        linearise=linearisation.linearise,
        weigh=linearisation.weigh,
        speeds=linearisation.speeds,
        first_speed=linearisation.first_speed,
        intervals=intervals,
        output_step=float(output_step),
        limit=float(limit),
        first_step=float(first_step or FIRST_STEP / pace),
        least_step=float(LEAST_STEP / pace),
        watched=equations.watched,
        precisions=1.0 / scales,
        y=np.array(y, dtype=float),
        **vectors,
        **stages,
        forces=np.zeros((3, e)),
        force=np.zeros(e),
        complex_residual=np.zeros(N, complex),
        complex_force=np.zeros(e, complex),
        matrices=np.zeros((3, e, e)),
        factors=np.zeros((e, e)),
        complex_factors=np.zeros((e, e), complex),
        contraction=np.zeros(1),
        states=np.zeros((intervals + 1, N)),
        ended=np.zeros(4),
    )
    status = IMPLICIT_LOOP(Placed(run).address)
    rows, time, calls, step = run.ended.tolist()
    return Integration(run.states[: int(rows)].copy(), status, time, int(calls), step)
