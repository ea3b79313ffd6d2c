"""Scratch arrays of the open loop besides those of the beam."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference_model.parameters import Workspace

Array = NDArray[np.float64]


class OpenWorkspace(NamedTuple):
    """Scratch of one evaluation with n shapes; never read across evaluations."""

    beam: Workspace
    slider: Array  # (1,) s, m: the beam's
    row: Array  # (n + 2,) G: rate of the gap per speed (q1, q2, eta)
    spread: Array  # (n + 2,) B: generalized force per unit of slider force, sign reversed
    factor: Array  # (n + 2, n + 2) Cholesky's factor of the mass matrix of the free speeds
    free: Array  # (n + 2,) their accelerations without slider force
    response: Array  # (n + 2,) their accelerations per unit of -F
    acceleration: Array  # (n + 2,) q1, q2, eta
    closed: Array  # (2 n + 4,) the state without q2, as the beam's observables read it


def open_workspace(beam: Workspace) -> OpenWorkspace:
    """Scratch arrays beside the workspace of the beam."""
    size = len(beam.Q)
    return OpenWorkspace(
        beam=beam,
        slider=beam.slider,
        row=np.zeros(size),
        spread=np.zeros(size),
        factor=np.zeros((size, size)),
        free=np.zeros(size),
        response=np.zeros(size),
        acceleration=np.zeros(size),
        closed=np.zeros(2 * size),
    )
