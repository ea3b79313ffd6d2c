"""Newton: N links on hinges of stiffness EI/h, 2 EI/h at the clamp. `python newton_hinges.py N`.

Newton computes in single precision, here on the processor. It is no dependency of this project:
`pip install newton`.
"""

import newton
import numpy as np
import warp as wp

from rod import GRAVITY, LENGTH, MASS_PER_LENGTH, STEP, STIFFNESS, TIMES, printed

wp.config.quiet = True


def let_go(pieces: int) -> np.ndarray:
    """Deflection of the end, m."""
    h = LENGTH / pieces
    mass, hinges, parent = MASS_PER_LENGTH * h, [], -1
    builder = newton.ModelBuilder(gravity=(0.0, -GRAVITY, 0.0))
    for k in range(pieces):
        turning = np.diag([mass * h**2 / 12.0] * 3).astype(np.float32)
        link = builder.add_link(
            mass=mass, inertia=wp.mat33(turning), com=wp.vec3(h / 2, 0.0, 0.0), lock_inertia=True
        )
        hinge = builder.add_joint_revolute(
            parent,
            link,
            axis=wp.vec3(0.0, 0.0, 1.0),
            parent_xform=wp.transform(wp.vec3(h if k else 0.0, 0.0, 0.0), wp.quat_identity()),
            stiffness=(1.0 if k else 2.0) * STIFFNESS / h,
            damping=0.0,
            armature=0.0,
            rest_q=0.0,
        )
        hinges.append(hinge)
        parent = link
    builder.add_articulation(hinges)
    model = builder.finalize(device="cpu")
    solver = newton.solvers.SolverFeatherstone(model, angular_damping=0.0)
    steps = int(np.ceil(STEP * 12.0 * np.sqrt(STIFFNESS / MASS_PER_LENGTH) / h**2))
    now, after, control, record = model.state(), model.state(), model.control(), []
    newton.eval_fk(model, now.joint_q, now.joint_qd, now)
    for _ in TIMES:
        record.append(h * np.sum(np.sin(np.cumsum(now.joint_q.numpy().astype(float)))))
        for _ in range(steps):
            now.clear_forces()
            solver.step(now, after, control, None, STEP / steps)
            now, after = after, now
    return np.array(record)


if __name__ == "__main__":
    printed(let_go)
