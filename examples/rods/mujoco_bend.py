"""MuJoCo 3: the plugin `mujoco.elasticity.cable` with its modulus `bend`, which 4.0 does not ship.

`bend` is Young's modulus, and the second moment of area is that of the capsules, so that a round
rod needs no number of its own. The first piece is fixed to its parent and does not bend: half of it
stands inside the clamp. Without that the sag of 5, 10, 20 pieces is 36, 19, 10 % too small.

    python mujoco_bend.py N
"""

import mujoco
import numpy as np

from rod import (
    DENSITY,
    GRAVITY,
    LENGTH,
    MASS_PER_LENGTH,
    MODULUS,
    RADIUS,
    STEP,
    STIFFNESS,
    TIMES,
    printed,
)


def let_go(pieces: int) -> np.ndarray:
    """Deflection of the end, m."""
    h = LENGTH / (pieces - 0.5)
    step = STEP / np.ceil(STEP * 6.0 * np.sqrt(STIFFNESS / MASS_PER_LENGTH) / h**2)
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><extension><plugin plugin="mujoco.elasticity.cable"/></extension>'
        f'<option integrator="RK4" timestep="{step}" gravity="0 0 {-GRAVITY}"/><worldbody>'
        f'<composite type="cable" curve="s" count="{pieces + 1} 1 1" size="{pieces * h}"'
        f' initial="none" offset="{-h / 2} 0 0"><plugin plugin="mujoco.elasticity.cable">'
        f'<config key="twist" value="{MODULUS / 100}"/><config key="bend" value="{MODULUS}"/>'
        '</plugin><joint kind="main" damping="0"/>'
        f'<geom type="cylinder" size="{RADIUS}" density="{DENSITY}" contype="0"/>'
        "</composite></worldbody></mujoco>"
    )
    # twist, which a plane motion does not have, is soft so that it does not bound the step
    data, record = mujoco.MjData(model), []
    last = model.nbody - 1
    for _ in TIMES:
        mujoco.mj_forward(model, data)
        record.append(data.xpos[last][2] + h * data.xmat[last].reshape(3, 3)[2, 0])
        mujoco.mj_step(model, data, round(STEP / step))
    return np.array(record)


if __name__ == "__main__":
    printed(let_go)
