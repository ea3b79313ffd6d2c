"""Time integration by a compiled loop of Radau IIA, order 5 (`radau_loop`), for equations M(q, u) du/dt = f(q, u) of stiff mechanisms.

Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8; RADAU.md derives what differs: Newton's matrix comes from the
model's own mass, damping and stiffness, and residuals are forces.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from quickreturn.reference_model.entries import IMPLICIT_LOOP
from quickreturn.reference_model.integrate import FIRST_STEP, LEAST_STEP, Equations, Integration
from quickreturn.reference_model.native.memory import ComplexMatrix, ComplexVector, Cube, Matrix, Placed, Vector


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
