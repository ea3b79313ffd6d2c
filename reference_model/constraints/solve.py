"""Accelerations and slider force of the open loop, whatever the constraint (RIVALS.md, section 2)."""

import numpy as np
from numpy.typing import NDArray

from reference_model.compilation import inlined
from reference_model.constraints.workspace import OpenWorkspace
from reference_model.dynamics import factorize, substitute
from reference_model.parameters import Parameters

Array = NDArray[np.float64]


@inlined
def factor_mass(p: Parameters, w: OpenWorkspace) -> bool:
    """Factor of the free speeds' mass matrix: all of (q1, q2, eta), or without q1 where its speed is prescribed."""
    first = 0 if p.crank_is_free else 1
    size = p.n + 2 - first
    for a in range(size):
        for b in range(a + 1):
            w.factor[a, b] = w.beam.M[a + first, b + first]
    return factorize(w.factor, size)


@inlined
def ideal_force(p: Parameters, w: OpenWorkspace, wanted: float) -> tuple[bool, float]:
    """Slider force F (N) that gives row . accelerations = `wanted` (m/s^2), and the accelerations: equations R2.1 to R2.3.

    The index-1 form [M B; G 0] of the equations of motion, solved by elimination of the accelerations.
    """
    first = 0 if p.crank_is_free else 1
    size = p.n + 2 - first
    if not factor_mass(p, w):
        return False, 0.0
    for a in range(size):
        w.free[a] = w.beam.Q[a + first]
        w.response[a] = w.spread[a + first]
    substitute(w.factor, w.free, size)
    substitute(w.factor, w.response, size)
    excess, compliance = -wanted, 0.0
    for a in range(size):
        excess += w.row[a + first] * w.free[a]
        compliance += w.row[a + first] * w.response[a]
    # a spread force may lose its hold on the gap; with force and motion conjugate this is G M^-1 G > 0
    if not compliance > 0.0:
        return False, 0.0
    force = excess / compliance
    w.acceleration[0] = 0.0
    for a in range(size):
        w.acceleration[a + first] = w.free[a] - force * w.response[a]
    return True, force


@inlined
def given_force(p: Parameters, w: OpenWorkspace, force: float) -> bool:
    """Accelerations under a known slider force (N), equation R2.1."""
    first = 0 if p.crank_is_free else 1
    size = p.n + 2 - first
    if not factor_mass(p, w):
        return False
    for a in range(size):
        w.free[a] = w.beam.Q[a + first] - force * w.spread[a + first]
    substitute(w.factor, w.free, size)
    w.acceleration[0] = 0.0
    for a in range(size):
        w.acceleration[a + first] = w.free[a]
    return True


@inlined
def drive_torque(p: Parameters, w: OpenWorkspace, force: float) -> float:
    """Torque of the drive (N m): the constant one, or what the prescribed speed takes (equation R2.4)."""
    if p.crank_is_free:
        return p.torque
    torque = w.spread[0] * force - w.beam.Q[0]
    for a in range(p.n + 2):
        torque += w.beam.M[0, a] * w.acceleration[a]
    return torque
