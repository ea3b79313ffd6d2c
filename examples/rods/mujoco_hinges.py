"""MuJoCo: N links on hinges of stiffness EI/h, 2 EI/h at the clamp. `python mujoco_hinges.py N`."""

import mujoco
import numpy as np

from rod import GRAVITY, LENGTH, MASS_PER_LENGTH, STEP, STIFFNESS, TIMES, printed


def let_go(pieces: int) -> np.ndarray:
    """Deflection of the end, m."""
    h, body = LENGTH / pieces, ""
    mass = MASS_PER_LENGTH * h
    for k in reversed(range(pieces)):
        spring = (1 if k else 2) * STIFFNESS / h
        body = (
            f'<body pos="{h if k else 0} 0 0"><joint axis="0 -1 0" stiffness="{spring}"/>'
            f'<inertial pos="{h / 2} 0 0" mass="{mass}"'
            f' diaginertia="1e-9 {mass * h**2 / 12} {mass * h**2 / 12}"/>'
            + (f'<site name="end" pos="{h} 0 0"/>' if k == pieces - 1 else body)
            + "</body>"
        )
    # the fastest vibration, that of the joints, limits an explicit step
    step = STEP / np.ceil(STEP * 6.0 * np.sqrt(STIFFNESS / MASS_PER_LENGTH) / h**2)
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler balanceinertia="true"/><option integrator="RK4" timestep="{step}"'
        f' gravity="0 0 {-GRAVITY}"/><worldbody>{body}</worldbody></mujoco>'
    )
    data, record = mujoco.MjData(model), []
    for _ in TIMES:
        mujoco.mj_forward(model, data)
        record.append(data.site("end").xpos[2])
        mujoco.mj_step(model, data, round(STEP / step))
    return np.array(record)


if __name__ == "__main__":
    printed(let_go)
