"""The array of numbers, as annotations name it."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
