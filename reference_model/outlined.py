"""The beam's large inlined functions, compiled once for all models that leave the loop open."""

import numpy as np
from numpy.typing import NDArray

from reference_model.compilation import inside
from reference_model.dynamics import assemble
from reference_model.kinematics import Contact, Slider, centre_line
from reference_model.parameters import Parameters, Workspace

Array = NDArray[np.float64]


@inside
def fill_fields(p: Parameters, eta: Array, eta_rate: Array, w: Workspace) -> bool:
    """See `kinematics.centre_line`; on the model's own mesh."""
    return centre_line(p.tables, p.exact_geometry, eta, eta_rate, w)


@inside
def assemble_open(p: Parameters, c: Slider, k: Contact, q1_rate: float, eta: Array, eta_rate: Array, w: Workspace) -> None:
    """See `dynamics.assemble`."""
    assemble(p, c, k, q1_rate, eta, eta_rate, w)
