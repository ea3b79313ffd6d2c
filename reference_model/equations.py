"""The equations of motion of all models under one name, chosen by the type of the parameters: in Python and in compiled code."""

from typing import Any, Final

import numpy as np
from numba.extending import overload
from numpy.typing import NDArray

from reference_model import dynamics
from reference_model.clamped_dynamics import clamped_right_hand_side
from reference_model.clamped_parameters import ClampedParameters, ClampedWorkspace
from reference_model.compilation import OVERLOADED
from reference_model.moving_dynamics import moving_right_hand_side
from reference_model.moving_parameters import MovingParameters, MovingWorkspace
from reference_model.parameters import Parameters, Workspace
from reference_model.prescribed_base import OnBase, base_right_hand_side

AnyParameters = Parameters | MovingParameters | ClampedParameters | OnBase
AnyWorkspace = Workspace | MovingWorkspace | ClampedWorkspace

_FUNCTIONS: Final[dict[type, Any]] = {
    Parameters: dynamics.right_hand_side,
    MovingParameters: moving_right_hand_side,
    ClampedParameters: clamped_right_hand_side,
    OnBase: base_right_hand_side,
}


def right_hand_side(p: Any, w: Any, y: NDArray[np.float64], rate: NDArray[np.float64]) -> bool:
    """dy/dt of the model that `p` belongs to; see the `..._right_hand_side` of its module."""
    return _FUNCTIONS[type(p)](p, w, y, rate)


@overload(right_hand_side, jit_options=OVERLOADED)
def _compiled_right_hand_side(p: Any, w: Any, y: Any, rate: Any) -> Any:
    function = _FUNCTIONS.get(getattr(p, "instance_class", object))
    if function is None:
        return None

    def implementation(p: Any, w: Any, y: Any, rate: Any) -> Any:
        return function(p, w, y, rate)

    return implementation
