"""The values of the problems that are no scenes of the project, in SI; `problem.md` of each folder prints them."""

from types import SimpleNamespace
from typing import Final

import numpy as np

from quickreturn.reference_model.arrays import Array

#: A table: `time` and the signals, each with one value a row.
Columns = dict[str, Array]

G: Final = 9.81
SAG: Final = SimpleNamespace(length=0.5, mass=0.2, bending=0.42, force=2.0)
DECAY: Final = SimpleNamespace(length=0.5, mass=0.2, bending=0.42, force=0.005, damping=0.4, material=2e-4, duration=1.5)
SPIN_UP: Final = SimpleNamespace(length=10.0, mass=1.2, bending=14e3, speed=6.0, ramp=15.0, duration=20.0)
PENDULUM: Final = SimpleNamespace(length=1.0, mass=0.3, bending=0.5, rate=5.0, duration=3.0)
HUB: Final = SimpleNamespace(inertia=0.05, radius=0.1, length=1.0, mass=0.3, bending=2.0, torque=2.0, period=1.0, duration=2.0)
BRIDGE: Final = SimpleNamespace(length=9.0, mass=200.0, bending=2e6, velocity=15.0, load=400.0, duration=0.6)
BEAD: Final = SimpleNamespace(length=1.0, rod=0.3, bead=0.1, stiffness=20.0, place=0.7, duration=5.0)
CRANK: Final = SimpleNamespace(crank=0.15, length=0.6, mass=0.2, bending=2.0, block=0.3, speed=12.0, ramp=0.5, duration=1.5)
FOUR_BAR: Final = SimpleNamespace(length=1.0, rod=1.0, rate=-1.0, duration=10.0)
#: Units of values; the others are numbers of a start or of a table.
UNITS: Final = {
    "length": "m", "mass": "kg/m", "bending": "N*m^2", "force": "N", "damping": "N*s/m^2", "material": "s", "speed": "1/s", "ramp": "s",
    "inertia": "kg*m^2", "radius": "m", "torque": "N*m", "period": "s", "velocity": "m/s", "load": "kg", "rod": "kg", "bead": "kg",
    "stiffness": "N/m", "crank": "m", "block": "kg",
}  # fmt: skip


def times(duration: float, rows: int) -> Array:
    """Times of `rows` rows after the first, s."""
    return np.linspace(0.0, duration, rows + 1)
