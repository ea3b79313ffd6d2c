"""The equations of motion of either model under one name, chosen by the type of the parameters: in Python and in compiled code."""

from typing import Any

import numpy as np
from numba import types
from numba.extending import overload
from numpy.typing import NDArray

from reference_model import dynamics
from reference_model.moving_dynamics import moving_right_hand_side
from reference_model.moving_parameters import MovingParameters, MovingWorkspace
from reference_model.parameters import Parameters, Workspace

AnyParameters = Parameters | MovingParameters
AnyWorkspace = Workspace | MovingWorkspace


def right_hand_side(p: Any, w: Any, y: NDArray[np.float64], rate: NDArray[np.float64]) -> bool:
    """dy/dt of the model that `p` belongs to; see `dynamics.right_hand_side` and `moving_dynamics.moving_right_hand_side`."""
    function = moving_right_hand_side if isinstance(p, MovingParameters) else dynamics.right_hand_side
    return function(p, w, y, rate)


@overload(right_hand_side, jit_options={"forceinline": True})
def _compiled_right_hand_side(p: Any, w: Any, y: Any, rate: Any) -> Any:
    if not isinstance(p, types.BaseNamedTuple):
        return None
    function = moving_right_hand_side if getattr(p, "instance_class", None) is MovingParameters else dynamics.right_hand_side

    def implementation(p: Any, w: Any, y: Any, rate: Any) -> Any:
        return function(p, w, y, rate)

    return implementation
