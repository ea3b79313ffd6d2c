"""What a time integration delivers, whatever its method."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

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

    states: NDArray[np.float64]
    status: int
    end_time: float
    calls: int
    next_step: float
