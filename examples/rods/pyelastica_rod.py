"""PyElastica: a Cosserat rod of N elements, its first one fixed. `python pyelastica_rod.py N`.

PyElastica is no dependency of this project: `pip install pyelastica`.
"""

import elastica as ea
import numpy as np

from rod import DENSITY, GRAVITY, LENGTH, MODULUS, RADIUS, STEP, TIMES, printed


class System(ea.BaseSystemCollection, ea.Constraints, ea.Forcing):
    """What the rod needs of PyElastica."""


def let_go(pieces: int) -> np.ndarray:
    """Deflection of the end, m."""
    along, normal = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    rod = ea.CosseratRod.straight_rod(
        pieces,
        np.zeros(3),
        along,
        normal,
        LENGTH,
        RADIUS,
        DENSITY,
        youngs_modulus=MODULUS,
        shear_modulus=MODULUS / 2.6,
    )
    system = System()
    system.append(rod)
    clamp = system.constrain(rod)
    clamp.using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    weight = np.array([0.0, -GRAVITY, 0.0])
    system.add_forcing_to(rod).using(ea.GravityForces, acc_gravity=weight)
    system.finalize()
    # a thin element shears fast, however long it is: this bounds the step, not the sound along it
    steps = int(np.ceil(STEP / (0.8 * RADIUS / np.sqrt(MODULUS / DENSITY))))
    stepper, time, record = ea.PositionVerlet(), 0.0, []
    for _ in TIMES:
        record.append(rod.position_collection[1, -1])
        for _ in range(steps):
            time = stepper.step(system, time, STEP / steps)
    return np.array(record)


if __name__ == "__main__":
    printed(let_go)
