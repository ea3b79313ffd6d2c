"""The rod of these examples, and what each of their programs does: let it go from straight.

The rod is the library's case `cantilever-round`: round, of steel, clamped at one end. A program has
a function `let_go(pieces)` that returns the deflection of the end at each of `TIMES`, m.
"""

import math
import sys
from collections.abc import Callable
from typing import Final

import numpy as np

LENGTH: Final = 0.4  # m
RADIUS: Final = 2e-3  # m
MODULUS: Final = 210e9  # Pa
DENSITY: Final = 7850.0  # kg/m^3
GRAVITY: Final = 9.81  # m/s^2
STIFFNESS: Final = MODULUS * math.pi * RADIUS**4 / 4.0  # EI, N m^2
MASS_PER_LENGTH: Final = DENSITY * math.pi * RADIUS**2  # kg/m
STEP: Final = 1e-3  # of the record, s
TIMES: Final = STEP * np.arange(401)


def printed(let_go: Callable[[int], np.ndarray]) -> None:
    """Prints the record for the number of pieces on the command line, one value a line."""
    np.savetxt(sys.stdout, let_go(int(sys.argv[1])), fmt="%.12e")
