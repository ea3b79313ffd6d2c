"""The linearised equations of motion for the implicit integrator (RADAU.md, section 4)."""

import math

from quickreturn.reference_model.joint import CHORDS, LEVER, MULTIPLIER, ROLLERS
from quickreturn.reference_model.motion.equations import parameters_at, workspace_at
from quickreturn.reference_model.motion.inertia import friction_share
from quickreturn.reference_model.motion.layout import BeamParameters, BeamWorkspace
from quickreturn.reference_model.motion.plane import dot
from quickreturn.reference_model.motion.spring import at_spring, spring_stiffness
from quickreturn.reference_model.native.compilation import inner
from quickreturn.reference_model.native.memory import Matrix, Vector
from quickreturn.reference_model.native.pointers import matrix_at, numbers_at


@inner
def _add(matrix: Matrix, p: BeamParameters, factor: float, row: Vector) -> None:
    """Add the matrix of an element that acts along a row of partial rates."""
    for i in range(p.first, p.speeds):
        for j in range(p.first, p.speeds):
            matrix[i, j] += factor * row[i] * row[j]


@inner
def _linearise_beam(p: BeamParameters, w: BeamWorkspace, M: Matrix, D: Matrix, K: Matrix) -> None:
    """Masses, the beam's stiffness, and all linear dampings; the material's damping is in proportion to the stiffness."""
    for i in range(p.first):
        M[i, i] = 1.0  # a prescribed acceleration
    for i in range(p.first, p.speeds):
        for j in range(p.first, i + 1):
            M[i, j] = M[j, i] = w.M[i, j]
    for k in range(1, p.n + 1):
        K[k, k] = w.squares[k - 1]
        D[k, k] = p.bending_damping * w.squares[k - 1] + p.beam_damping / p.rhoA
    if p.first == 0:
        D[0, 0] += p.crank_damping - w.facts.torque_slope


@inner
def _linearise_forces(p: BeamParameters, w: BeamWorkspace, D: Matrix, K: Matrix) -> None:
    """The pivot's damping and friction, friction of the slider, and the spring that holds the follower."""
    f = w.facts
    pivot = p.base_damping
    if p.base_friction > 0.0:
        pivot += p.base_friction / p.base_friction_rate * (1.0 - friction_share(f.q2_rate, p.base_friction_rate) ** 2)
    if pivot > 0.0:
        _add(D, p, pivot, w.c)
    limit = p.friction_force + p.friction * abs(f.force)
    if limit > 0.0:
        _add(D, p, limit / p.friction_speed * (1.0 - friction_share(f.s_rate, p.friction_speed) ** 2), w.sigma)
    if p.is_held > 0:
        for k in range(p.speeds):
            w.response[k] = dot(f.spring_line, at_spring(w, w.V[k], p.tables.points))
        _add(K, p, spring_stiffness(f.spring_length, p.spring), w.response)
        _add(D, p, p.spring.damping, w.response)


@inner
def _linearise_rollers(p: BeamParameters, w: BeamWorkspace, M: Matrix, D: Matrix, K: Matrix) -> None:
    """The rollers of the joint that touch, and the joint's damping and inertia."""
    gap, rate = w.facts.gap, w.facts.gap_rate
    stiffness, damping = 0.0, p.joint_damping
    for side, begin, sign in ((p.plus, p.plus_from, 1.0), (p.minus, p.minus_from, -1.0)):
        if sign * gap > begin:
            stiffness += side * max(1.0 + sign * p.contact_loss * rate, 0.0)
            damping += side * p.contact_loss * (sign * gap - begin)
    _add(K, p, stiffness, w.row_of_gap)
    _add(D, p, damping, w.row_of_gap)
    _add(M, p, p.joint_inertia, w.row_of_gap)


@inner
def _linearise_constraint(p: BeamParameters, w: BeamWorkspace, M: Matrix, D: Matrix, K: Matrix) -> None:
    """The row of the gap, with its stabilization, and the column of the slider's force, with the friction in proportion to it."""
    m, rate = p.speeds, p.stabilization
    rubbing = 0.0
    if p.friction > 0.0:
        rubbing = math.copysign(p.friction, w.facts.force) * friction_share(w.facts.s_rate, p.friction_speed)
    for k in range(p.first, m):
        M[m, k], D[m, k], K[m, k] = w.row_of_gap[k], 2.0 * rate * w.row_of_gap[k], rate**2 * w.row_of_gap[k]
        K[k, m] = w.spread[k] + rubbing * w.sigma[k]


def linearise(parameters: int, workspace: int, matrices: int, size: int) -> int:
    """Write mass, damping and stiffness (3, size, size) of the state evaluated last, see `implicit.Linearisation`."""
    p, w = parameters_at(parameters), workspace_at(workspace)
    M, D, K = (
        matrix_at(matrices, size, size),
        matrix_at(matrices + 8 * size * size, size, size),
        matrix_at(matrices + 16 * size * size, size, size),
    )
    for i in range(size):
        for j in range(size):
            M[i, j] = D[i, j] = K[i, j] = 0.0
    _linearise_beam(p, w, M, D, K)
    _linearise_forces(p, w, D, K)
    if p.constraint == ROLLERS:
        _linearise_rollers(p, w, M, D, K)
    elif size > p.speeds:
        _linearise_constraint(p, w, M, D, K)
    return 1


def weigh(parameters: int, workspace: int, accelerations: int, forces: int) -> int:
    """Write the product of the present mass matrix with accelerations (m,), and behind it, with a constraint, that of the gap's row."""
    p, w = parameters_at(parameters), workspace_at(workspace)
    m, first = p.speeds, p.first
    a, force = numbers_at(accelerations, m), numbers_at(forces, m + 1)
    gap = 0.0
    for k in range(first, m):
        gap += w.row_of_gap[k] * a[k]
    shared = p.joint_inertia * gap if p.constraint == ROLLERS else 0.0
    for i in range(first):
        force[i] = a[i]
    for i in range(first, m):
        total = shared * w.row_of_gap[i]
        for j in range(first, i + 1):
            total += w.M[i, j] * a[j]
        for j in range(i + 1, m):
            total += w.M[j, i] * a[j]
        force[i] = total
    if p.constraint in (MULTIPLIER, LEVER, CHORDS):
        force[m] = gap
    return 1
